//! Doublet: an inner vertex with two quads is removed.
//!
//! ```text
//!        c                 c
//!      / | \             /   \
//!     e  v  b    ──▶    e     b       (v,a,b,c) + (v,c,e,a) ──▶ (a,b,c,e)
//!      \ | /             \   /
//!        a                 a
//! ```
//!
//! The two angles at v sum to 360 degrees, so one of the quads is never strictly convex: the change is
//! mandatory. Effect: v goes, a and c lose an edge each, one quad less. Source: handbook 6.3.

use super::{CleanOp, Edit, Site};
use csalf_geom::VertexId;

/// See the file's head.
#[derive(Clone, Copy, Debug)]
pub struct Doublet;

impl CleanOp for Doublet {
    fn name(&self) -> &'static str {
        "doublet"
    }

    fn find(&self, site: &Site<'_>) -> Vec<Edit> {
        let Site { mesh, topology, fixed, .. } = *site;
        let mut out = Vec::new();
        for v in 0..mesh.n_vertices() {
            let id = VertexId::new(v);
            if topology.n_quads_at(id) != 2
                || topology.on_boundary[v]
                || fixed.get(v).copied().unwrap_or(false)
            {
                continue;
            }
            let (h, g) = (topology.star(id)[0], topology.star(id)[1]);
            let corner = |h: u32, k: u32| mesh.quads[(h / 4) as usize][((h + k) & 3) as usize].0;
            let (a, b, c, e) = (corner(h, 1), corner(h, 2), corner(h, 3), corner(g, 2));
            // Two quads with the same four corners close a sphere; nothing can be made of them.
            if corner(g, 1) == c && corner(g, 3) == a && b != e {
                out.push(Edit {
                    remove: vec![h / 4, g / 4],
                    add: vec![[a, b, c, e]],
                    mandatory: true,
                    ..Edit::default()
                });
            }
        }
        out
    }
}
