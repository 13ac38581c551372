//! The quads in space while they are being improved: positions, normals, and where each vertex sits on the
//! facets.

use crate::input::Projector;
use crate::locate::{Anchor, mix, nearest};
use crate::patch::Patch;
use glam::DVec3;

/// A surface point farther from its facet than this share of the facet's longest side is refused.
const FAR: f64 = 0.5;
/// A surface normal that turns by more than 60 degrees from the facet's is refused (handbook 9.6).
const TURNED: f64 = 0.5;

/// The facets and the surface beneath them.
#[derive(Debug)]
pub(crate) struct Ground<'a> {
    pub(crate) patch: &'a Patch,
    pub(crate) normals: Vec<DVec3>,
    /// The input's facets (the patch's may be parts of them).
    pub(crate) facets: &'a crate::Facets,
    pub(crate) surface: Option<&'a dyn Projector>,
}

impl Ground<'_> {
    /// Position and unit normal at a place on the facets, on the true surface if it answers; and whether it
    /// did.
    pub(crate) fn at(&self, a: Anchor) -> (DVec3, DVec3, bool) {
        let p = a.point(self.patch);
        let t = self.patch.triangles[a.facet as usize];
        let flat = self.patch.area_vector(a.facet).normalize_or_zero();
        let n = mix(t.map(|v| self.normals[v as usize]), a.bary).normalize_or(flat);
        let Some(surface) = self.surface else { return (p, n, true) };
        let parent = self.patch.parent[a.facet as usize];
        let corners = self.facets.triangles[parent as usize].map(|v| self.facets.points[v as usize]);
        let bary = if self.patch.triangles.len() == self.facets.triangles.len() {
            a.bary
        } else {
            barycentric(corners, p)
        };
        let longest = corners[0]
            .distance(corners[1])
            .max(corners[1].distance(corners[2]))
            .max(corners[2].distance(corners[0]));
        match surface.project(p, parent, bary) {
            Some(s) if surface.is_map() && s.point.is_finite() => (s.point, s.normal.normalize_or(n), true),
            Some(s)
                if s.point.is_finite()
                    && s.point.distance(p) <= FAR * longest
                    && s.normal.dot(n) >= TURNED * s.normal.length() =>
            {
                (s.point, s.normal.normalize_or(n), true)
            }
            _ => (p, n, false),
        }
    }

    /// The place on the facets near `p`.
    pub(crate) fn nearest(&self, from: Anchor, p: DVec3) -> Anchor {
        nearest(self.patch, from, p)
    }
}

fn barycentric([a, b, c]: [DVec3; 3], p: DVec3) -> [f64; 3] {
    let (u, v, d) = (b - a, c - a, p - a);
    let n = u.cross(v);
    let nn = n.length_squared();
    if nn <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let (w1, w2) = (d.cross(v).dot(n) / nn, u.cross(d).dot(n) / nn);
    [1.0 - w1 - w2, w1, w2]
}

/// A mesh of quads on the ground.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sheet {
    pub(crate) points: Vec<DVec3>,
    pub(crate) normals: Vec<DVec3>,
    pub(crate) anchors: Vec<Anchor>,
    pub(crate) fixed: Vec<bool>,
    pub(crate) quads: Vec<[u32; 4]>,
}
