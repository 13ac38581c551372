use super::*;
use crate::LayerLaw;
use csalf_geom::predicates::{Meeting, meeting};
use csalf_mesh::validate::is_strictly_convex;
use csalf_sizemap::Uniform;
use proptest::prelude::*;
use std::f64::consts::TAU;

/// A region made by code: nodes and walks.
#[derive(Default)]
struct Shape {
    points: Vec<Point2>,
    walks: Vec<Walk>,
}

impl Shape {
    fn add(&mut self, kind: WalkKind, points: &[Point2]) -> &mut Self {
        let from = self.points.len() as u32;
        self.points.extend_from_slice(points);
        self.walks.push(Walk { nodes: (from..from + points.len() as u32).collect(), kind, asked: None });
        self
    }

    /// A scar of these nodes: out and back.
    fn add_scar(&mut self, points: &[Point2]) -> &mut Self {
        let from = self.points.len() as u32;
        let n = points.len() as u32;
        self.points.extend_from_slice(points);
        let nodes = (0..n).chain((1..n - 1).rev()).map(|i| from + i).collect();
        self.walks.push(Walk { nodes, kind: WalkKind::Scar, asked: None });
        self
    }

    fn ask(&mut self, walk: usize, count: usize, law: LayerLaw) -> &mut Self {
        self.walks[walk].asked = Some(LayerSpec { count, law, first: None });
        self
    }

    fn pave(&self, h: f64) -> Layers {
        let out = pave_layers(&LayerTask {
            points: &self.points,
            walks: &self.walks,
            size: &Uniform(h),
            tolerance: Tolerance::of_points(self.points.iter().copied()),
            rules: PavingRules::Corrected,
            defaults: true,
            partial: true,
        });
        self.check(&out);
        out
    }

    /// Everything that the driver guarantees.
    fn check(&self, out: &Layers) {
        let all: Vec<Point2> = self.points.iter().chain(&out.points).copied().collect();
        let at = |v: u32| all[v as usize];
        assert!(out.quads.iter().all(|q| is_strictly_convex(&q.map(at))), "a quad is not convex");
        assert_eq!(out.quads.len(), out.quad_layer.len());
        // Walks are covered by quads and fronts, once each; inside, every side has its twin.
        let cyclic = |w: &[u32]| (0..w.len()).map(|i| (w[i], w[(i + 1) % w.len()])).collect::<Vec<_>>();
        let mut inner: Vec<(u32, u32)> = out
            .quads
            .iter()
            .flat_map(|q| cyclic(q))
            .chain(out.fronts.iter().flat_map(|f| cyclic(f)))
            .collect();
        let mut want: Vec<(u32, u32)> = self.walks.iter().flat_map(|w| cyclic(&w.nodes)).collect();
        inner.retain(|e| e.0 != e.1);
        want.retain(|e| e.0 != e.1);
        // Interior sides come in pairs; what is left must be the walks. (A scar's sides are both in `want`.)
        want.sort_unstable();
        inner.sort_unstable();
        assert!(inner.windows(2).all(|w| w[0] != w[1]), "a side belongs to two");
        let lone: Vec<_> = inner
            .iter()
            .copied()
            .filter(|&(a, b)| inner.binary_search(&(b, a)).is_err() || want.binary_search(&(a, b)).is_ok())
            .collect();
        assert_eq!(lone, want, "walks and border differ");
        // Fronts are simple and apart.
        let sides: Vec<(u32, u32)> = out.fronts.iter().flat_map(|f| cyclic(f)).collect();
        for (i, &(a, b)) in sides.iter().enumerate() {
            for &(c, d) in &sides[..i] {
                let share = a == c || a == d || b == c || b == d;
                assert!(share || meeting(at(a), at(b), at(c), at(d)) == Meeting::Apart, "fronts meet");
            }
        }
        // Areas add up.
        let area = |w: &[u32]| polygon::signed_area(&w.iter().map(|&v| at(v)).collect::<Vec<_>>());
        let quads: f64 = out.quads.iter().map(|q| area(q)).sum();
        let fronts: f64 = out.fronts.iter().map(|f| area(f)).sum();
        let region: f64 = self.walks.iter().map(|w| area(&w.nodes)).sum();
        assert!((quads + fronts - region).abs() < 1e-9 * region.abs(), "{quads} + {fronts} against {region}");
        for (w, f) in self.walks.iter().zip(&out.fronts) {
            assert!(w.nodes.len() == 1 || w.nodes.len() % 2 == f.len() % 2, "parity changed");
        }
    }
}

fn circle(c: (f64, f64), r: f64, n: usize, clockwise: bool) -> Vec<Point2> {
    let sign = if clockwise { -1.0 } else { 1.0 };
    (0..n).map(|i| Point2::new(c.0, c.1) + Point2::from_angle(sign * TAU * i as f64 / n as f64) * r).collect()
}

/// The polygon of these corners, every side in equal parts of about `h`.
fn polygon_of(corners: &[(f64, f64)], h: f64) -> Vec<Point2> {
    let c: Vec<Point2> = corners.iter().map(|&(x, y)| Point2::new(x, y)).collect();
    (0..c.len())
        .flat_map(|i| {
            let (a, b) = (c[i], c[(i + 1) % c.len()]);
            let n = (a.distance(b) / h).round().max(1.0) as usize;
            (0..n).map(move |k| a.lerp(b, k as f64 / n as f64))
        })
        .collect()
}

fn square(size: f64, h: f64) -> Vec<Point2> {
    polygon_of(&[(0., 0.), (size, 0.), (size, size), (0., size)], h)
}

#[test]
fn a_plate_with_a_round_hole_gets_its_default_layers() {
    let mut s = Shape::default();
    s.add(WalkKind::Outer, &square(20.0, 1.0)).add(WalkKind::Hole, &circle((10., 10.), 4.0, 24, true));
    s.ask(1, 2, LayerLaw::Auto);
    let out = s.pave(1.0);
    assert_eq!((out.reports[0].made, out.reports[1].made), (1, 2));
    assert_eq!(out.quads.len(), 76 + 2 * 24);
    assert_eq!(out.fronts[0].len(), 72);
    // Isotropic rings around a hole grow by (n + π)/(n - π).
    let q = (24.0 + TAU / 2.0) / (24.0 - TAU / 2.0);
    let r = |v: u32| (out.points[v as usize - s.points.len()] - Point2::new(10., 10.)).length();
    let chord = |r: f64| r * (TAU / 48.0).cos();
    for &v in &out.fronts[1] {
        assert!((chord(r(v)) / chord(4.0) - q * q).abs() < 0.02);
    }
    assert_eq!(out.ring_sizes.len(), 72 + 24);
}

#[test]
fn asked_thickness_is_kept() {
    for (law, f) in [
        (LayerLaw::Constant, [1.0, 1.0, 1.0, 1.0, 1.0]),
        (LayerLaw::Ramp, [1.0, 2.0, 3.0, 4.0, 5.0]),
        (LayerLaw::Fibonacci, [1.0, 1.0, 2.0, 3.0, 5.0]),
    ] {
        let mut s = Shape::default();
        s.add(WalkKind::Outer, &square(60.0, 3.0)).add(WalkKind::Hole, &circle((30., 30.), 8.0, 48, true));
        s.ask(1, 5, law);
        let out = s.pave(3.0);
        assert_eq!(out.reports[1].made, 5, "{:?}", out.reports[1]);
        assert!(out.reports[1].thickness_error < 1e-9);
        // Distance of the sides from the centre.
        let t0 = polygon::perimeter(&s.points[80..]) / 48.0;
        let side = 8.0 * (TAU / 96.0).cos();
        let reach = side + t0 * f.iter().sum::<f64>();
        for &v in &out.fronts[1] {
            let p = out.points[v as usize - s.points.len()] - Point2::new(30., 30.);
            assert!((p.length() * (TAU / 96.0).cos() / reach - 1.0).abs() < 1e-9);
        }
    }
}

#[test]
fn holes_that_meet_stop_each_other() {
    let mut s = Shape::default();
    s.add(WalkKind::Outer, &square(30.0, 1.0));
    s.add(WalkKind::Hole, &circle((12., 15.), 2.5, 16, true))
        .add(WalkKind::Hole, &circle((18., 15.), 2.5, 16, true));
    s.ask(1, 6, LayerLaw::Constant).ask(2, 6, LayerLaw::Constant);
    let out = s.pave(1.0);
    for r in &out.reports[1..] {
        assert!(r.made < 6 && r.stopped.is_some(), "{r:?}");
    }
}

#[test]
fn scars_get_rings_by_rule_and_points_if_asked() {
    let mut s = Shape::default();
    s.add(WalkKind::Outer, &square(20.0, 1.0));
    s.add_scar(&(0..5).map(|i| Point2::new(8.0 + f64::from(i), 14.0)).collect::<Vec<_>>());
    s.add(WalkKind::Point, &[Point2::new(10.0, 5.0)]);
    s.ask(2, 1, LayerLaw::Auto);
    let out = s.pave(1.0);
    assert!(out.reports.iter().all(|r| r.made == 1), "{:?}", out.reports);
    assert_eq!((out.fronts[1].len(), out.fronts[2].len()), (16, 8));
}

#[test]
fn a_front_does_not_swallow_a_point() {
    let mut s = Shape::default();
    s.add(WalkKind::Outer, &square(40.0, 2.0)).add(WalkKind::Hole, &circle((20., 20.), 5.0, 16, true));
    s.add(WalkKind::Point, &[Point2::new(27.1, 20.3)]);
    s.ask(1, 1, LayerLaw::Explicit(vec![6.0])).ask(2, 0, LayerLaw::Auto);
    let out = s.pave(2.0);
    assert_eq!(out.reports[1].made, 0, "the ring would cover the point");
}

#[test]
fn an_acute_corner_stays_open() {
    let mut s = Shape::default();
    s.add(WalkKind::Outer, &polygon_of(&[(0., 0.), (30., 0.), (30., 15.)], 1.0));
    let out = s.pave(1.0);
    assert!(!out.quads.is_empty(), "{:?}", out.reports);
    assert!(out.quads.iter().all(|q| !q.contains(&0)), "a layer entered the tip");
}

#[test]
fn walks_of_unknown_nodes_are_left_alone() {
    let walks = [Walk { nodes: vec![0, 1, 2, 9], kind: WalkKind::Outer, asked: None }];
    let out = pave_layers(&LayerTask {
        points: &square(1.0, 1.0),
        walks: &walks,
        size: &Uniform(1.0),
        tolerance: Tolerance::of_diagonal(1.4),
        rules: PavingRules::Corrected,
        defaults: true,
        partial: true,
    });
    assert_eq!((out.quads.len(), out.fronts), (0, vec![vec![0, 1, 2, 9]]));
}

#[test]
fn motion_scale_and_start_do_not_matter() {
    let make = |turn: f64, scale: f64, start: usize| {
        let mut s = Shape::default();
        let mut outer = polygon_of(&[(0., 0.), (20., 0.), (20., 9.), (9., 9.), (9., 20.), (0., 20.)], 1.0);
        let mut hole = circle((5., 5.), 1.2, 11, true);
        outer.rotate_left(start);
        hole.rotate_left(start % 11);
        let go = |p: &mut Point2| {
            *p = csalf_geom::angle::rotated(*p, turn) * scale + Point2::new(3.0, -7.0) * scale
        };
        outer.iter_mut().for_each(go);
        hole.iter_mut().for_each(go);
        s.add(WalkKind::Outer, &outer).add(WalkKind::Hole, &hole);
        let out = s.pave(scale);
        (out.quads.len(), out.fronts.iter().map(Vec::len).collect::<Vec<_>>(), out.reports)
    };
    let plain = make(0.0, 1.0, 0);
    assert!(plain.0 > 70, "{plain:?}");
    for (turn, scale, start) in [(0.3, 1.0, 0), (0.0, 1e-3, 0), (0.0, 1e6, 0), (2.0, 17.0, 13)] {
        let other = make(turn, scale, start);
        assert_eq!((plain.0, &plain.1), (other.0, &other.1), "turn {turn} scale {scale} start {start}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    /// Whatever is asked around whatever holes: the guarantees hold.
    #[test]
    fn random_regions_stay_valid(
        n_outer in 12usize..60, wobble in 0.0f64..0.35, holes in prop::collection::vec((0.0f64..TAU, 0.0f64..0.7, 3usize..20, 0.03f64..0.2), 0..5),
        count in 0usize..6, law in 0u8..6, first in prop::option::of(0.02f64..0.5), seed in 0u32..1000,
    ) {
        let mut s = Shape::default();
        let r = |i: usize| 1.0 + wobble * (f64::from((i as u32).wrapping_mul(2_654_435_761).wrapping_add(seed * 97) >> 16 & 0xff) / 255.0 - 0.5);
        let outer: Vec<Point2> = (0..n_outer).map(|i| Point2::from_angle(TAU * i as f64 / n_outer as f64) * r(i)).collect();
        s.add(WalkKind::Outer, &outer);
        let mut taken: Vec<(Point2, f64)> = Vec::new();
        for (angle, at, n, size) in holes {
            let c = Point2::from_angle(angle) * at;
            if c.length() + size > 0.75 || taken.iter().any(|t| t.0.distance(c) < t.1 + size + 0.01) {
                continue;
            }
            taken.push((c, size));
            s.add(WalkKind::Hole, &circle((c.x, c.y), size, n, true));
        }
        let law = [LayerLaw::Auto, LayerLaw::Constant, LayerLaw::Ramp, LayerLaw::Parabolic, LayerLaw::Fibonacci, LayerLaw::Geometric(1.3)][law as usize].clone();
        for (i, w) in s.walks.iter_mut().enumerate() {
            if !(seed as usize + i).is_multiple_of(3) {
                w.asked = Some(LayerSpec { count, law: law.clone(), first });
            }
        }
        s.pave(TAU / n_outer as f64);
    }
}

/// The paper's own placement gives valid rings too: harmonic thickness (eq. 2) and √2 diagonals (Table I).
#[test]
fn the_papers_rules_pave_as_well() {
    let mut s = Shape::default();
    s.add(WalkKind::Outer, &square(20.0, 1.0));
    s.add(WalkKind::Hole, &{
        let mut hole = polygon_of(&[(7., 7.), (13., 7.), (13., 13.), (7., 13.)], 1.0);
        hole.reverse();
        hole
    });
    let out = pave_layers(&LayerTask {
        points: &s.points,
        walks: &s.walks,
        size: &Uniform(1.0),
        tolerance: Tolerance::of_points(s.points.iter().copied()),
        rules: PavingRules::Paper,
        defaults: true,
        partial: false,
    });
    s.check(&out);
    assert_eq!((out.reports[0].made, out.reports[1].made), (1, 2), "{:?}", out.reports);
    // 24 fronts with four right reversals: 28 quads, then 32 fronts: 36.
    assert_eq!(out.quads.len(), 76 + 28 + 36);
}
