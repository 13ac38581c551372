//! The part of a mesh that a smoother works on, as a small mesh of its own.
//!
//! ```text
//!    o───o───o───o      v: free vertices, local ids 0 .. n_free, in the order of the mesh
//!    │   │   │   │      o: rim, fixed, local ids from n_free
//!    o───v───v───o      quads: all that touch a free vertex; outside nothing changes
//!    │   │   │   │
//!    o───o───o───o
//! ```
//!
//! 1. [`grow`]: free vertices within a number of rings around bad quads.
//! 2. [`components`]: those that share quads stay together.
//! 3. [`Region::new`]: local copy, targets and colours.

use super::has_corner_below;
use csalf_geom::{Point2, QuadId, VertexId, angle::interior_angle};
use csalf_mesh::{
    QuadMesh, QuadTopology,
    quality::{Corners, FLAT},
};
use csalf_sizemap::{Hint, SizeField};
use rayon::prelude::*;
use std::f64::consts::TAU;

const NONE: u32 = u32::MAX;

/// Below this many items the work is not worth handing to other threads.
pub(crate) const PARALLEL_FROM: usize = 4096;

/// Target angles are kept this far from 0 and 180 degrees (radians, 20 degrees). Smaller: sharper corners get
/// the angle they cannot avoid, but their weight 1/sin grows. Arbitrary.
const ANGLE_MARGIN: f64 = 0.35;

/// Largest factor between the wanted area of a quad and the mean area around it. Larger: sizes are pursued
/// where the number of quads cannot give them, at the cost of shape; 1: only evenness counts. Arbitrary.
const AREA_FACTOR: f64 = 2.0;

/// Wanted lengths of a quad's sides 0 and 2, and of its sides 1 and 3, where they are not the size field's:
/// the quads of layers. Sides are numbered as in the mesh: side k runs from corner k to corner k + 1.
pub type Boxes<'a> = &'a (dyn Fn(QuadId) -> Option<[f64; 2]> + Sync);

/// Maps from the mesh to a region, kept between regions so that each costs only its own size.
pub(crate) struct Scratch {
    vertex: Vec<u32>,
    quad: Vec<u32>,
}

impl Scratch {
    pub(crate) fn new(mesh: &QuadMesh) -> Self {
        Self { vertex: vec![NONE; mesh.n_vertices()], quad: vec![NONE; mesh.n_quads()] }
    }
}

/// A patch of a mesh with a fixed rim.
pub(crate) struct Region {
    /// Mesh id of each local vertex.
    pub(crate) vertices: Vec<u32>,
    pub(crate) n_free: usize,
    pub(crate) points: Vec<Point2>,
    pub(crate) quads: Vec<[u32; 4]>,
    /// Mesh id of each local quad.
    of_mesh: Vec<u32>,
    /// Per free vertex its local quads with its corner, `4 q + k`.
    star_start: Vec<u32>,
    star: Vec<u32>,
    /// Per local vertex: cosine of the target angle of its corners, and 1 / sine.
    pub(crate) angle: Vec<[f64; 2]>,
    /// Per local quad: 1 / target length of sides 0 and 2, and of sides 1 and 3.
    pub(crate) inverse: Vec<[f64; 2]>,
    /// Free vertices by colour: no two of a colour share a quad. Ascending within each.
    pub(crate) colours: Vec<Vec<u32>>,
}

/// True if `v` may move.
fn is_free(v: u32, topology: &QuadTopology, fixed: &[bool]) -> bool {
    let i = v as usize;
    !topology.on_boundary[i]
        && !fixed.get(i).copied().unwrap_or(false)
        && topology.n_quads_at(VertexId(v)) > 0
}

/// The free vertices of the quads `seeds` and of `rings` rings of quads around them, ascending.
pub(crate) fn grow(
    mesh: &QuadMesh,
    topology: &QuadTopology,
    fixed: &[bool],
    seeds: &[u32],
    rings: usize,
) -> Vec<u32> {
    let mut marked = vec![false; mesh.n_vertices()];
    let mut found: Vec<u32> = Vec::new();
    let mut add = |q: u32, found: &mut Vec<u32>| {
        for v in mesh.quads[q as usize] {
            if !std::mem::replace(&mut marked[v.index()], true) {
                found.push(v.0);
            }
        }
    };
    for &q in seeds {
        add(q, &mut found);
    }
    let mut from = 0;
    for _ in 0..rings {
        let to = found.len();
        for i in from..to {
            for &h in topology.star(VertexId(found[i])) {
                add(h / 4, &mut found);
            }
        }
        from = to;
    }
    found.retain(|&v| is_free(v, topology, fixed));
    found.sort_unstable();
    found
}

/// Splits free vertices (ascending) into sets that share no quad, each ascending, ordered by their first
/// vertex.
pub(crate) fn components(mesh: &QuadMesh, topology: &QuadTopology, free: &[u32]) -> Vec<Vec<u32>> {
    let mut open = vec![false; mesh.n_vertices()];
    for &v in free {
        open[v as usize] = true;
    }
    let mut out = Vec::new();
    for &s in free {
        if !std::mem::replace(&mut open[s as usize], false) {
            continue;
        }
        let mut c = vec![s];
        let mut i = 0;
        while i < c.len() {
            for &h in topology.star(VertexId(c[i])) {
                for v in mesh.quads[(h / 4) as usize] {
                    if std::mem::replace(&mut open[v.index()], false) {
                        c.push(v.0);
                    }
                }
            }
            i += 1;
        }
        c.sort_unstable();
        out.push(c);
    }
    out
}

impl Region {
    /// The region of these free vertices (ascending). Cost O(region).
    pub(crate) fn new(mesh: &QuadMesh, topology: &QuadTopology, free: &[u32], scratch: &mut Scratch) -> Self {
        let mut vertices = free.to_vec();
        for (i, &v) in free.iter().enumerate() {
            scratch.vertex[v as usize] = i as u32;
        }
        let mut of_mesh: Vec<u32> = Vec::with_capacity(free.len() + free.len() / 4 + 8);
        let mut star_start = Vec::with_capacity(free.len() + 1);
        let mut star = Vec::with_capacity(4 * free.len());
        star_start.push(0);
        for &v in free {
            for &h in topology.star(VertexId(v)) {
                let q = &mut scratch.quad[(h / 4) as usize];
                if *q == NONE {
                    *q = of_mesh.len() as u32;
                    of_mesh.push(h / 4);
                }
                star.push(4 * *q + (h & 3));
            }
            star_start.push(star.len() as u32);
        }
        let mut quads = Vec::with_capacity(of_mesh.len());
        for &q in &of_mesh {
            quads.push(mesh.quads[q as usize].map(|v| {
                let l = &mut scratch.vertex[v.index()];
                if *l == NONE {
                    *l = vertices.len() as u32;
                    vertices.push(v.0);
                }
                *l
            }));
        }
        for &v in &vertices {
            scratch.vertex[v as usize] = NONE;
        }
        for &q in &of_mesh {
            scratch.quad[q as usize] = NONE;
        }
        let points = vertices.iter().map(|&v| mesh.points[v as usize]).collect();
        let target = |&v: &u32| target_angle(mesh, topology, VertexId(v));
        let angle = if vertices.len() < PARALLEL_FROM {
            vertices.iter().map(target).collect()
        } else {
            vertices.par_iter().with_min_len(1024).map(target).collect()
        };
        let mut out = Self {
            n_free: free.len(),
            vertices,
            points,
            inverse: vec![[1.0; 2]; quads.len()],
            quads,
            of_mesh,
            star_start,
            star,
            angle,
            colours: Vec::new(),
        };
        out.colour();
        out
    }

    /// The quads of free vertex `v`, as `4 q + corner`.
    #[inline]
    pub(crate) fn star(&self, v: u32) -> &[u32] {
        &self.star[self.star_start[v as usize] as usize..self.star_start[v as usize + 1] as usize]
    }

    /// The corners of quad `q`.
    #[inline]
    pub(crate) fn corners(&self, q: usize) -> [Point2; 4] {
        self.quads[q].map(|v| self.points[v as usize])
    }

    /// Sets the target lengths from the size field at the quad centres, within [`AREA_FACTOR`] of the mean
    /// area around. One size query per quad.
    pub(crate) fn set_sizes(&mut self, size: &dyn SizeField) {
        let mut around = vec![[0.0f64; 2]; self.vertices.len()];
        for (q, vs) in self.quads.iter().enumerate() {
            let area = self.area(q).abs();
            for &v in vs {
                around[v as usize][0] += area;
                around[v as usize][1] += 1.0;
            }
        }
        self.inverse = self.per_quad(|q, hint| {
            let h = self.wanted(q, size, hint);
            let mean = |v: &u32| around[*v as usize][0] / around[*v as usize][1];
            let mean = 0.25 * self.quads[q].iter().map(mean).sum::<f64>();
            let area = (h * h).clamp(mean / AREA_FACTOR, mean * AREA_FACTOR);
            // A patch without any area has no scale of its own.
            [if area > 0.0 { 1.0 / area.sqrt() } else { 1.0 / h }; 2]
        });
    }

    /// Sets the target lengths from the size field, scaled so that the targets fill the region: for tangled
    /// regions, whose single areas mean nothing. One size query per quad.
    pub(crate) fn set_sizes_to_fill(&mut self, size: &dyn SizeField) {
        let wanted = self.per_quad(|q, hint| self.wanted(q, size, hint));
        let total: f64 = (0..self.quads.len()).map(|q| self.area(q)).sum();
        let asked: f64 = wanted.iter().map(|h| h * h).sum();
        let scale = if total > 0.0 { (asked / total).sqrt() } else { 1.0 };
        self.inverse = wanted.into_iter().map(|h| [scale / h; 2]).collect();
    }

    /// Replaces the targets of the quads for which `boxes` has lengths.
    pub(crate) fn set_boxes(&mut self, boxes: Boxes<'_>) {
        for (inverse, &q) in self.inverse.iter_mut().zip(&self.of_mesh) {
            if let Some([s, t]) = boxes(QuadId(q))
                && s > 0.0
                && t > 0.0
            {
                *inverse = [1.0 / s, 1.0 / t];
            }
        }
    }

    /// Signed area of quad `q`.
    fn area(&self, q: usize) -> f64 {
        let p = self.corners(q);
        0.5 * (p[2] - p[0]).perp_dot(p[3] - p[1])
    }

    /// The wanted length at the centre of quad `q`.
    fn wanted(&self, q: usize, size: &dyn SizeField, hint: &mut Hint) -> f64 {
        let p = self.corners(q);
        size.h(0.25 * (p[0] + p[1] + p[2] + p[3]), hint)
    }

    /// `f` of every quad, in parallel if there are many. A hint does not change a result.
    fn per_quad<T: Send>(&self, f: impl Fn(usize, &mut Hint) -> T + Sync) -> Vec<T> {
        let n = self.quads.len();
        if n < PARALLEL_FROM {
            let mut hint = Hint::default();
            (0..n).map(|q| f(q, &mut hint)).collect()
        } else {
            (0..n).into_par_iter().with_min_len(1024).map_init(Hint::default, |hint, q| f(q, hint)).collect()
        }
    }

    /// Smallest scaled Jacobian of the quads of the region.
    pub(crate) fn min_scaled(&self) -> f64 {
        let n = self.quads.len();
        let of = |q: usize| Corners::new(&self.corners(q)).min_scaled();
        if n < PARALLEL_FROM {
            return (0..n).map(of).fold(f64::INFINITY, f64::min);
        }
        let parts = (0..n).into_par_iter().with_min_len(1024);
        parts.map(of).reduce(|| f64::INFINITY, f64::min)
    }

    /// True if a corner of quad `q` is concave or flat.
    pub(crate) fn is_bad(&self, q: usize) -> bool {
        has_corner_below(&self.corners(q), FLAT)
    }

    /// Greedy colouring in the order of the local ids. A vertex that finds no colour among 64 (valence over
    /// 21) stays without one, and so at its place.
    fn colour(&mut self) {
        let mut of = vec![u8::MAX; self.n_free];
        for v in 0..self.n_free as u32 {
            let mut taken = 0u64;
            for &h in self.star(v) {
                for w in self.quads[(h / 4) as usize] {
                    if let Some(&c) = of.get(w as usize)
                        && c < 64
                    {
                        taken |= 1 << c;
                    }
                }
            }
            let c = taken.trailing_ones() as usize;
            if c < 64 {
                of[v as usize] = c as u8;
                if c >= self.colours.len() {
                    self.colours.resize(c + 1, Vec::new());
                }
                self.colours[c].push(v);
            }
        }
    }

    /// Writes the free vertices back.
    pub(crate) fn write_back(&self, mesh: &mut QuadMesh) {
        for (&v, &p) in self.vertices[..self.n_free].iter().zip(&self.points) {
            mesh.points[v as usize] = p;
        }
    }
}

/// Cosine and 1 / sine of the angle that each of the corners at `v` should have: the full turn, or the
/// interior angle of the boundary, over the number of quads.
fn target_angle(mesh: &QuadMesh, topology: &QuadTopology, v: VertexId) -> [f64; 2] {
    let d = topology.n_quads_at(v);
    let mut total = TAU;
    if topology.on_boundary[v.index()] {
        // Where the boundary passes twice, there is no telling the quads of one pass from those of the other.
        total = match topology.boundary_neighbours(v, &mesh.quads) {
            Some([a, c]) => {
                interior_angle(mesh.points[a.index()], mesh.points[v.index()], mesh.points[c.index()])
            }
            None => d as f64 * TAU / 4.0,
        };
    }
    let (s, c) = (total / d.max(1) as f64).clamp(ANGLE_MARGIN, TAU / 2.0 - ANGLE_MARGIN).sin_cos();
    [c, 1.0 / s]
}
