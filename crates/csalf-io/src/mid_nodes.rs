//! Mid-side nodes: what a mesh of quadratic elements has besides its corners.
//!
//! ```text
//!     d────k────c      corners a b c d, then the middles of ab, bc, cd, da (, then the centre):
//!     │         │      the order of Abaqus, Nastran, Gmsh and VTK alike
//!     l    m    j
//!     │         │      a side on a curve that is known gets its middle on that curve, if the
//!     a────i────b      elements beside it stay valid; all others in the middle of the chord
//! ```
//!
//! 1. Sides of all elements, sorted by their vertices: each one node, numbered behind the vertices.
//! 2. Of sides in the edge sets of curved loops and scars: the point of the curve nearest to the middle of the chord
//!    (samples, then Newton's method on (c(t) - m) · c'(t) = 0). Of meshes in space, what the caller knows of its curves
//!    and surfaces.
//! 3. A quad whose Jacobian is not positive at all nodes and at the centre gets its sides straight again; in space, laid
//!    into its mean plane.
//!
//! Cost O(n log n), and the number of samples per side on a curve.

use csalf_geom::curve::Curve;
use csalf_geom::{Geometry, Point2, VertexId};
use csalf_mesh::{NamedSets, QuadMesh, SurfaceMesh, quality::space::laid};
use glam::DVec3;

/// Samples per smooth part of a curve. More: slower; fewer: the nearest part of a wriggling curve may be missed.
const SAMPLES: usize = 32;

/// Steps of Newton's method: it converges quadratically from the nearest sample.
const STEPS: usize = 12;

/// Ends of a chord may be this part of its length off the curve that its middle is put on. Larger: chords beside a curve
/// are bent; smaller: curves of files with gaps stay straight.
const OFF: f64 = 1e-4;

/// A middle farther from the chord than this part of its length is not taken: the curve found is another part.
const FARTHEST: f64 = 0.5;

/// The nodes of quadratic elements that are no corners.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MidNodes {
    /// The sides: smaller vertex first, sorted.
    sides: Vec<[u32; 2]>,
    /// Where the middle of each side lies; of plane meshes at z = 0.
    points: Vec<DVec3>,
    /// Per quad, if asked for: its centre.
    centres: Vec<DVec3>,
    n_vertices: usize,
    n_on_curves: usize,
}

fn key(a: VertexId, b: VertexId) -> [u32; 2] {
    [a.0.min(b.0), a.0.max(b.0)]
}

impl MidNodes {
    /// Middles of all sides, on chords. With `centres`, nine nodes per quad.
    pub fn new(mesh: &QuadMesh, centres: bool) -> Self {
        Self::of_plane(mesh, &[], centres)
    }

    /// Middles of all sides of a mesh in space; of those in `known` (side, place) there. `centre`, if nine nodes per quad
    /// are wanted, says where the centre of a quad belongs for which the element itself has it.
    pub fn in_space(
        mesh: &SurfaceMesh,
        known: &[([VertexId; 2], DVec3)],
        centre: Option<&dyn Fn(usize, DVec3) -> DVec3>,
    ) -> Self {
        let known: Vec<_> = known.iter().map(|&([a, b], p)| (key(a, b), p)).collect();
        Self::build(&mesh.points, &mesh.quads, &[], &known, centre)
    }

    /// Middles of all sides; of those in edge sets named like a loop or scar of `geometry`, on its curves.
    pub fn on_curves(mesh: &QuadMesh, sets: &NamedSets, geometry: &Geometry, centres: bool) -> Self {
        let mut wanted = Vec::new();
        for (name, edges, _) in geometry.chains() {
            let tracks: Vec<Track<'_>> = edges.iter().filter_map(|e| Track::new(&e.curve)).collect();
            if tracks.is_empty() {
                continue;
            }
            for (_, list) in sets.edges.iter().filter(|(n, _)| n == name) {
                for &[a, b] in list {
                    let (Some(&p), Some(&q)) = (mesh.points.get(a.index()), mesh.points.get(b.index()))
                    else {
                        continue;
                    };
                    if let Some(m) = nearest(&tracks, p, q) {
                        wanted.push((key(a, b), m));
                    }
                }
            }
        }
        Self::of_plane(mesh, &wanted, centres)
    }

    fn of_plane(mesh: &QuadMesh, wanted: &[([u32; 2], Point2)], centres: bool) -> Self {
        let points: Vec<DVec3> = mesh.points.iter().map(|p| p.extend(0.0)).collect();
        let wanted: Vec<_> = wanted.iter().map(|&(side, p)| (side, p.extend(0.0))).collect();
        let as_it_is: &dyn Fn(usize, DVec3) -> DVec3 = &|_, p| p;
        Self::build(&points, &mesh.quads, &mesh.triangles, &wanted, centres.then_some(as_it_is))
    }

    fn build(
        points: &[DVec3],
        quads: &[[VertexId; 4]],
        triangles: &[[VertexId; 3]],
        wanted: &[([u32; 2], DVec3)],
        centre: Option<&dyn Fn(usize, DVec3) -> DVec3>,
    ) -> Self {
        fn sides_of<const K: usize>(e: &[VertexId; K]) -> impl Iterator<Item = [u32; 2]> + '_ {
            (0..K).map(move |k| key(e[k], e[(k + 1) % K]))
        }
        let mut sides: Vec<[u32; 2]> =
            quads.iter().flat_map(sides_of).chain(triangles.iter().flat_map(sides_of)).collect();
        sides.sort_unstable();
        sides.dedup();
        let at = |v: u32| points.get(v as usize).copied().unwrap_or_default();
        let chord = |s: &[u32; 2]| at(s[0]).midpoint(at(s[1]));
        let mut out = Self {
            points: sides.iter().map(chord).collect(),
            sides,
            centres: Vec::new(),
            n_vertices: points.len(),
            n_on_curves: 0,
        };
        let mut curved = vec![false; out.sides.len()];
        for (side, p) in wanted {
            if let Ok(k) = out.sides.binary_search(side) {
                (out.points[k], curved[k]) = (*p, true);
            }
        }
        if !wanted.is_empty() {
            for q in quads {
                let ids: [usize; 4] = std::array::from_fn(|k| out.side(q[k], q[(k + 1) & 3]));
                let bad = || !is_valid(laid_flat(q.map(|v| at(v.0)), ids.map(|k| out.points[k])));
                if ids.iter().any(|&k| curved[k]) && bad() {
                    for k in ids {
                        (out.points[k], curved[k]) = (chord(&out.sides[k]), false);
                    }
                }
            }
        }
        out.n_on_curves = curved.iter().filter(|c| **c).count();
        if let Some(f) = centre {
            let centre = |(i, q): (usize, &[VertexId; 4])| f(i, out.centre(q.map(|v| at(v.0)), q));
            out.centres = quads.iter().enumerate().map(centre).collect();
        }
        out
    }

    /// The value of the serendipity element at its centre: (2 Σ middles - Σ corners) / 4.
    fn centre(&self, corners: [DVec3; 4], q: &[VertexId; 4]) -> DVec3 {
        let middles: DVec3 = (0..4).map(|k| self.points[self.side(q[k], q[(k + 1) & 3])]).sum();
        0.25 * (2.0 * middles - corners.iter().copied().sum::<DVec3>())
    }

    fn side(&self, a: VertexId, b: VertexId) -> usize {
        self.sides.binary_search(&key(a, b)).unwrap_or(0)
    }

    /// The node in the middle of a side: numbers go on behind the vertices.
    pub fn of(&self, a: VertexId, b: VertexId) -> VertexId {
        VertexId::new(self.n_vertices + self.side(a, b))
    }

    /// Where the middle of a side lies; `None` if there is no such side.
    pub fn point(&self, a: VertexId, b: VertexId) -> Option<DVec3> {
        self.sides.binary_search(&key(a, b)).ok().map(|k| self.points[k])
    }

    /// All nodes of quad number `i` with corners `q`: four corners, four middles, and the centre if there is one.
    pub fn quad(&self, i: usize, q: &[VertexId; 4]) -> Vec<VertexId> {
        let middles = (0..4).map(|k| self.of(q[k], q[(k + 1) & 3]));
        let centre =
            (!self.centres.is_empty()).then(|| VertexId::new(self.n_vertices + self.sides.len() + i));
        q.iter().copied().chain(middles).chain(centre).collect()
    }

    /// All nodes of a triangle: three corners, three middles.
    pub fn triangle(&self, t: &[VertexId; 3]) -> Vec<VertexId> {
        t.iter().copied().chain((0..3).map(|k| self.of(t[k], t[(k + 1) % 3]))).collect()
    }

    /// Positions, in the order of their numbers behind the vertices.
    pub fn points(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.points.iter().chain(&self.centres).copied()
    }

    /// Number of nodes behind the vertices.
    pub fn n_nodes(&self) -> usize {
        self.points.len() + self.centres.len()
    }

    /// True if quads have nine nodes.
    pub fn has_centres(&self) -> bool {
        !self.centres.is_empty()
    }

    /// The nodes of edges that follow each other, with their middles: a set for loads and supports.
    pub fn along(&self, edges: &[[VertexId; 2]]) -> Vec<VertexId> {
        let mut nodes: Vec<VertexId> = edges.iter().flat_map(|&[a, b]| [a, self.of(a, b), b]).collect();
        nodes.dedup();
        if nodes.len() > 1 && nodes.first() == nodes.last() {
            nodes.pop();
        }
        nodes
    }

    /// Number of middles that lie on a curve or surface, not on a chord.
    pub fn n_on_curves(&self) -> usize {
        self.n_on_curves
    }
}

/// A bent curve and points on it.
struct Track<'a> {
    curve: &'a Curve,
    samples: Vec<(f64, Point2)>,
}

impl<'a> Track<'a> {
    /// `None` of a curve that is straight between its points.
    fn new(curve: &'a Curve) -> Option<Self> {
        if matches!(curve, Curve::Polyline(_)) {
            return None;
        }
        let (t0, t1) = curve.range();
        let mut ends = vec![t0];
        ends.extend(curve.breaks());
        ends.push(t1);
        let mut samples = vec![(t0, curve.start())];
        for w in ends.windows(2) {
            let inner = (1..=SAMPLES).map(|k| w[0] + (w[1] - w[0]) * k as f64 / SAMPLES as f64);
            samples.extend(inner.map(|t| (t, curve.eval(t).point)));
        }
        Some(Self { curve, samples })
    }

    /// The point near sample `t` where the curve is nearest to `m`.
    fn refine(&self, mut t: f64, m: Point2) -> Point2 {
        let (t0, t1) = self.curve.range();
        for _ in 0..STEPS {
            let c = self.curve.eval(t);
            let d = c.point - m;
            let slope = c.d1.length_squared() + d.dot(c.d2);
            if slope <= 0.0 {
                break;
            }
            let next = (t - d.dot(c.d1) / slope).clamp(t0, t1);
            if next == t {
                break;
            }
            t = next;
        }
        self.curve.eval(t).point
    }
}

/// The point of the curves nearest to the middle of the chord from `p` to `q`, if it can belong to this chord.
fn nearest(tracks: &[Track<'_>], p: Point2, q: Point2) -> Option<Point2> {
    let m = p.midpoint(q);
    let mut best: Option<(f64, &Track<'_>, f64)> = None;
    for track in tracks {
        for &(t, s) in &track.samples {
            let d = s.distance_squared(m);
            if best.is_none_or(|b| d < b.0) {
                best = Some((d, track, t));
            }
        }
    }
    let (_, track, t) = best?;
    let found = track.refine(t, m);
    // Both ends must lie on this curve, or the chord belongs to a straight neighbour of it.
    let on_curve = |end: Point2| {
        let near = track.samples.iter().map(|s| (s.1.distance_squared(end), s.0));
        let start = near.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(t, |s| s.1);
        track.refine(start, end).distance(end) <= OFF * p.distance(q)
    };
    (found.distance(m) <= FARTHEST * p.distance(q) && on_curve(p) && on_curve(q)).then_some(found)
}

/// Four corners and four middles in the corners' mean plane; of a plane quad as they are.
fn laid_flat(c: [DVec3; 4], m: [DVec3; 4]) -> ([Point2; 4], [Point2; 4]) {
    let n = (c[2] - c[0]).cross(c[3] - c[1]);
    if n.x == 0.0 && n.y == 0.0 && n.z > 0.0 {
        return (c.map(DVec3::truncate), m.map(DVec3::truncate));
    }
    let [c0, c1, c2, c3, m0, m1, m2, m3] = laid(&[c[0], c[1], c[2], c[3], m[0], m[1], m[2], m[3]], n);
    ([c0, c1, c2, c3], [m0, m1, m2, m3])
}

/// True if the Jacobian of the serendipity element is positive at its eight nodes and at its centre. Source: the shape
/// functions of Zienkiewicz and Taylor, The Finite Element Method, volume 1, section 8.6 (5th edition).
fn is_valid((c, m): ([Point2; 4], [Point2; 4])) -> bool {
    const CORNERS: [(f64, f64); 4] = [(-1., -1.), (1., -1.), (1., 1.), (-1., 1.)];
    const AT: [(f64, f64); 9] =
        [(-1., -1.), (1., -1.), (1., 1.), (-1., 1.), (0., -1.), (1., 0.), (0., 1.), (-1., 0.), (0., 0.)];
    AT.iter().all(|&(x, y)| {
        let (mut dx, mut dy) = (Point2::ZERO, Point2::ZERO);
        for (p, (a, b)) in c.iter().zip(CORNERS) {
            dx += *p * (0.25 * a * (1.0 + b * y) * (2.0 * a * x + b * y));
            dy += *p * (0.25 * b * (1.0 + a * x) * (2.0 * b * y + a * x));
        }
        for (p, b) in [(m[0], -1.0), (m[2], 1.0)] {
            dx += p * (-x * (1.0 + b * y));
            dy += p * (0.5 * b * (1.0 - x * x));
        }
        for (p, a) in [(m[1], 1.0), (m[3], -1.0)] {
            dx += p * (0.5 * a * (1.0 - y * y));
            dy += p * (-y * (1.0 + a * x));
        }
        dx.perp_dot(dy) > 0.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quarter_ring(inner: f64, outer: f64) -> (QuadMesh, NamedSets, Geometry) {
        let v = VertexId::new;
        let at = |r: f64, t: f64| Point2::new(r * t.cos(), r * t.sin());
        let (a, b) = (0.0, std::f64::consts::FRAC_PI_4);
        let points = vec![at(inner, a), at(outer, a), at(outer, b), at(inner, b)];
        let mesh = QuadMesh { points, quads: vec![[v(0), v(1), v(2), v(3)]], triangles: Vec::new() };
        let sets = NamedSets { edges: vec![("hole0".into(), vec![[v(3), v(0)]])], ..NamedSets::default() };
        let geometry = Geometry::default().with_hole(vec![Curve::circle(Point2::ZERO, inner)]);
        (mesh, sets, geometry)
    }

    #[test]
    fn middles_lie_on_the_circle() {
        let (mesh, sets, geometry) = quarter_ring(1.0, 2.0);
        let m = MidNodes::on_curves(&mesh, &sets, &geometry, true);
        assert_eq!((m.n_nodes(), m.n_on_curves()), (5, 1));
        let nodes = m.quad(0, &mesh.quads[0]);
        assert_eq!(nodes.len(), 9);
        let points: Vec<Point2> =
            mesh.points.iter().copied().chain(m.points().map(DVec3::truncate)).collect();
        let at = |k: usize| points[nodes[k].index()];
        assert!((at(7).length() - 1.0).abs() < 1e-14, "on the hole");
        assert_eq!(at(4), Point2::new(1.5, 0.0));
        assert!((at(5).length() - 2.0).abs() > 0.1, "no curve is known there");
        assert!((at(8).length() - 1.5).abs() < 0.1);
    }

    #[test]
    fn a_side_that_would_fold_its_quad_stays_straight() {
        let (mut mesh, sets, geometry) = quarter_ring(1.0, 1.02);
        mesh.points[1] = Point2::new(1.02, 0.0);
        let m = MidNodes::on_curves(&mesh, &sets, &geometry, false);
        // The sagitta of a chord of 45 degrees is 0.076.
        assert_eq!(m.n_on_curves(), 0);
        assert_eq!(m.points().nth(1), Some(mesh.points[0].midpoint(mesh.points[3]).extend(0.0)));
    }

    /// A quad of a cylinder lying on its side, seen from its end: its round sides are bent, the others are not.
    #[test]
    fn middles_in_space_are_where_the_caller_says() {
        let v = VertexId::new;
        let at = |t: f64, x: f64| DVec3::new(x, t.cos(), t.sin());
        let points = vec![at(0.0, 0.0), at(0.5, 0.0), at(0.5, 1.0), at(0.0, 1.0)];
        let mesh = SurfaceMesh { points, quads: vec![[v(0), v(3), v(2), v(1)]] };
        let known = [([v(1), v(0)], at(0.25, 0.0)), ([v(2), v(3)], at(0.25, 1.0))];
        let lift = |q: usize, p: DVec3| {
            assert_eq!(q, 0);
            let r = DVec3::new(0.0, p.y, p.z).normalize();
            DVec3::new(p.x, r.y, r.z)
        };
        let m = MidNodes::in_space(&mesh, &known, Some(&lift));
        assert_eq!((m.n_nodes(), m.n_on_curves()), (5, 2));
        assert_eq!(m.point(v(0), v(1)), Some(at(0.25, 0.0)));
        assert_eq!(m.point(v(0), v(3)), Some(DVec3::new(0.5, 1.0, 0.0)));
        let centre = m.points().last().unwrap();
        assert!(centre.distance(at(0.25, 0.5)) < 1e-12, "{centre}");
        // A middle on the other side folds the quad: both sides are straight again.
        let m = MidNodes::in_space(&mesh, &[([v(0), v(1)], at(0.25, 1.5))], None);
        assert_eq!((m.n_nodes(), m.n_on_curves()), (4, 0));
    }

    #[test]
    fn a_straight_chord_beside_a_curve_is_left_alone() {
        let (mesh, sets, _) = quarter_ring(1.0, 2.0);
        let elsewhere = Geometry::default().with_hole(vec![Curve::circle(Point2::new(0.9, 0.4), 0.05)]);
        assert_eq!(MidNodes::on_curves(&mesh, &sets, &elsewhere, false).n_on_curves(), 0);
    }

    #[test]
    fn neighbours_share_their_middle() {
        let v = VertexId::new;
        let points = [(0., 0.), (1., 0.), (2., 0.), (0., 1.), (1., 1.), (2., 1.)].map(Point2::from).to_vec();
        let quads = vec![[v(0), v(1), v(4), v(3)]];
        let mesh = QuadMesh { points, quads, triangles: vec![[v(1), v(2), v(4)]] };
        let m = MidNodes::new(&mesh, false);
        assert_eq!(m.n_nodes(), 6);
        assert_eq!(m.quad(0, &mesh.quads[0])[5], m.triangle(&mesh.triangles[0])[5]);
        assert!(!m.has_centres());
    }
}
