use super::*;
use crate::{HardPoint, Loop, LoopKind};
use proptest::prelude::*;

fn p(x: f64, y: f64) -> Point2 {
    Point2::new(x, y)
}

/// A rectangle with `n` segments on the horizontal and `m` on the vertical sides, counter-clockwise.
fn rectangle(lo: Point2, hi: Point2, n: usize, m: usize) -> Vec<Point2> {
    let at = |i: usize, j: usize| {
        p(lo.x + (hi.x - lo.x) * i as f64 / n as f64, lo.y + (hi.y - lo.y) * j as f64 / m as f64)
    };
    let bottom = (0..n).map(|i| at(i, 0));
    let right = (0..m).map(|j| at(n, j));
    let top = (1..=n).rev().map(|i| at(i, m));
    let left = (1..=m).rev().map(|j| at(0, j));
    bottom.chain(right).chain(top).chain(left).collect()
}

fn square() -> Domain {
    Domain::new(rectangle(p(0., 0.), p(4., 4.), 4, 4))
}

fn small(x: f64, y: f64) -> Vec<Point2> {
    rectangle(p(x, y), p(x + 1.0, y + 1.0), 1, 1)
}

fn build(d: &Domain) -> Arrangement {
    Arrangement::new(d, &CheckOptions::default()).unwrap_or_else(|e| panic!("{e:?}"))
}

/// Asserts that the only defect matches, and gives its message.
macro_rules! only {
    ($domain:expr, $pattern:pat $(if $guard:expr)?) => {{
        let defects = $domain.check();
        assert!(matches!(defects.as_slice(), [$pattern] $(if $guard)?), "{defects:#?}");
        defects[0].to_string()
    }};
}

#[test]
fn a_plain_square_is_one_region() {
    let d = square();
    let a = build(&d);
    assert_eq!(a.points, d.loops[0].nodes);
    assert_eq!(a.loops, [(0..16).collect::<Vec<u32>>()]);
    assert_eq!(a.regions, [Region { outer: (0..16).collect(), inner: vec![] }]);
    assert_eq!(a.area, 16.0);
}

#[test]
fn wrong_orientation_and_a_repeated_end_are_repaired_silently() {
    let mut d = square().with_hole(small(1., 1.));
    d.loops[0].nodes.reverse();
    let first = d.loops[0].nodes[0];
    d.loops[0].nodes.push(first);
    let a = build(&d);
    assert_eq!(a.loops[0].len(), 16);
    assert_eq!(a.points[a.loops[0][0] as usize], first, "starts at the same node");
    assert_eq!(a.area, 15.0);
    assert_eq!(a.loops[1], [4 + 12, 16 + 3, 16 + 2, 16 + 1], "the hole runs clockwise");
    assert_eq!(a.regions[0].inner.len(), 1);
}

#[test]
fn scars_hang_float_and_cut() {
    // Hangs on the right side (node 6 is (4, 2)).
    let a = build(&square().with_scar(vec![p(4., 2.), p(3., 2.), p(2.5, 2.)]));
    assert_eq!((a.regions.len(), a.regions[0].outer.len(), a.regions[0].inner.len()), (1, 20, 0));
    assert_eq!(a.scars[0][0], 6);
    // Floats.
    let a = build(&square().with_scar(vec![p(1., 2.), p(2., 2.), p(3., 2.)]));
    assert_eq!(a.regions[0].inner, [vec![16, 17, 18, 17]]);
    // Cuts in two.
    let a = build(&square().with_scar(vec![p(0., 2.), p(2., 2.), p(4., 2.)]));
    assert_eq!(a.regions.len(), 2);
    assert_eq!(a.regions.iter().map(Region::n_segments).collect::<Vec<_>>(), [10, 10]);
    assert_eq!(a.points.len(), 17);
    // Joins a hole to the outer loop: one walk.
    let a = build(&square().with_hole(small(1., 1.)).with_scar(vec![p(0., 1.), p(1., 1.)]));
    assert_eq!(a.regions.len(), 1);
    assert_eq!((a.regions[0].outer.len(), a.regions[0].inner.len()), (22, 0));
    // A closed scar is an interface: an inner walk and a region.
    let ring = vec![p(1., 1.), p(3., 1.), p(3., 3.), p(1., 3.), p(1., 1.)];
    let a = build(&square().with_scar(ring).with_point(p(2., 2.)).with_point(p(0.5, 0.5)));
    assert_eq!(a.regions.len(), 2);
    assert_eq!(a.regions[0].inner, [vec![21], vec![16, 19, 18, 17]]);
    assert_eq!(a.regions[1], Region { outer: vec![16, 17, 18, 19], inner: vec![vec![20]] });
}

#[test]
fn inner_walks_go_to_the_region_around_them() {
    // A frame of a closed scar; in it a hole; left of the hole, in its shadow, a floating scar and a point.
    let ring = vec![p(0.5, 0.5), p(3.5, 0.5), p(3.5, 3.5), p(0.5, 3.5), p(0.5, 0.5)];
    let d = square()
        .with_hole(small(1., 1.))
        .with_scar(ring)
        .with_scar(vec![p(2.2, 1.5), p(3., 1.5)])
        .with_point(p(3.2, 1.5))
        .with_point(p(3.8, 1.5));
    let a = build(&d);
    assert_eq!(a.regions.len(), 2);
    assert_eq!(a.regions[0].inner.iter().map(Vec::len).collect::<Vec<_>>(), [4, 1]);
    assert_eq!(a.regions[1].inner.iter().map(Vec::len).collect::<Vec<_>>(), [4, 2, 1]);
}

#[test]
fn nodes_within_the_merge_tolerance_are_shared() {
    let e = 1e-9;
    let d = square()
        .with_scar(vec![p(4. - e, 2. + e), p(3., 2.)])
        .with_scar(vec![p(3. + e, 2.), p(3., 3.)])
        .with_point(p(3., 3. + e))
        .with_point(p(1., 1.))
        .with_point(p(1., 1. + e));
    let a = build(&d);
    assert_eq!(a.points.len(), 16 + 2 + 1);
    assert_eq!(a.scars, [vec![6, 16], vec![16, 17]]);
    assert_eq!(a.hard_points, [17, 18, 18]);
    assert_eq!(a.points[6], p(4., 2.));
    assert_eq!(a.regions[0].inner, [vec![18]]);
}

#[test]
fn too_few_nodes() {
    only!(square().with_hole(vec![p(1., 1.), p(2., 2.)]), Defect::TooFewNodes { n_nodes: 2, .. });
    only!(square().with_scar(vec![p(1., 1.)]), Defect::ScarTooShort { n_nodes: 1, .. });
    let d = square().with_hole(vec![p(1., 1.), p(2., 2.), p(1., 1.)]);
    only!(d, Defect::TooFewNodes { n_nodes: 2, .. });
}

#[test]
fn not_finite_and_out_of_scale() {
    let mut d = square();
    d.loops[0].nodes[3].x = f64::NAN;
    only!(d, Defect::NotFinite { at } if at.index == 3 && at.name == "outer");
    let d = square().with_scar(vec![p(1., 1.), p(f64::INFINITY, 1.)]).with_point(p(0., f64::NEG_INFINITY));
    assert!(matches!(d.check().as_slice(), [Defect::NotFinite { .. }, Defect::NotFinite { .. }]));
    let mut d = square();
    d.loops[0].nodes[3].x = 1e200;
    only!(d, Defect::Scale { .. });
    let mut d = square();
    d.loops[0].nodes.iter_mut().for_each(|q| *q *= 1e-100);
    only!(d, Defect::Scale { .. });
}

#[test]
fn outer_loops_are_counted() {
    let mut d = square();
    d.loops[0].kind = LoopKind::Hole;
    only!(d, Defect::NoOuterLoop);
    only!(Domain::default(), Defect::NoOuterLoop);
    let mut d = square();
    d.loops.push(Loop { kind: LoopKind::Outer, name: "other".into(), nodes: small(9., 9.) });
    only!(d, Defect::SeveralOuterLoops { names } if names == &["outer", "other"]);
}

#[test]
fn repeated_and_coincident_nodes() {
    let mut d = square();
    d.loops[0].nodes.insert(4, p(4., 1e-9));
    d.loops[0].nodes.insert(9, p(4., 3.9));
    only!(d, Defect::RepeatedNode { first, second } if (first.index, second.index) == (4, 5));
    // Two nodes far apart along the loop: a pinch.
    let mut d = square();
    d.loops[0].nodes[2] = p(2., 4.);
    assert!(matches!(d.check()[0], Defect::RepeatedNode { ref first, .. } if first.index == 2));
    let d = square().with_hole(vec![p(2., 0.), p(3., 1.), p(2., 2.), p(1., 1.)]);
    let text =
        only!(d, Defect::CoincidentNodes { first, second } if first.index == 2 && second.name == "hole0");
    assert!(text.contains("outer [2] (2, 0)"), "{text}");
    let d = square().with_scar(vec![p(1., 1.), p(1., 1.), p(2., 2.)]);
    only!(d, Defect::RepeatedNode { first, second } if (first.index, second.index) == (0, 1));
}

#[test]
fn crossings_and_touchings() {
    // Self-intersection: the top runs below the bottom in the middle.
    let mut d = square();
    d.loops[0].nodes[10] = p(2., -1.);
    let found = d.check();
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(found.iter().all(|d| matches!(d, Defect::SelfIntersection { .. })));
    // A hole across the outer loop: two crossings, and nothing said of nesting.
    let d = square().with_hole(rectangle(p(3.5, 1.3), p(4.5, 1.6), 1, 1));
    let found = d.check();
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(matches!(&found[0], Defect::Crossing { x, .. } if *x == 4.0));
    // A node of a hole on a segment of the outer loop, exactly and nearly.
    for e in [0.0, 1e-9] {
        let d = square().with_hole(vec![p(1.5, e), p(2., 1.), p(1., 1.), p(1., 0.5)]);
        only!(d, Defect::Touching { node, segment } if node.name == "hole0" && segment.index == 1);
    }
    // Two scars that cross, not at a node; a scar ending on a segment.
    let d = square().with_scar(vec![p(1., 1.), p(3., 3.)]).with_scar(vec![p(1., 3.), p(3., 1.)]);
    only!(d, Defect::Crossing { first, second, .. } if first.name == "scar0" && second.name == "scar1");
    let d = square().with_scar(vec![p(1., 1.), p(3., 3.)]).with_scar(vec![p(1., 3.), p(2., 2.)]);
    only!(d, Defect::Touching { node, segment } if node.name == "scar1" && segment.name == "scar0");
    let d = square().with_scar(vec![p(3., 1.5), p(4., 1.5)]);
    only!(d, Defect::Touching { segment, .. } if segment.name == "outer" && segment.index == 5);
    // A scar that leaves the domain.
    let d = square().with_scar(vec![p(3., 1.5), p(5., 1.5)]);
    only!(d, Defect::Crossing { first, .. } if first.name == "outer");
}

#[test]
fn segments_along_each_other() {
    // A needle.
    let mut d = square();
    d.loops[0].nodes[2] = p(2., 6.);
    d.loops[0].nodes[10] = p(2., 5.);
    assert!(!d.check().is_empty());
    let mut d = square();
    d.loops[0].nodes.splice(2..2, [p(2., 0.5), p(1.5, 0.25)]);
    let found = d.check();
    assert!(found.iter().any(|d| matches!(d, Defect::Overlap { .. } | Defect::Touching { .. })), "{found:?}");
    let d = square().with_scar(vec![p(0., 1.), p(0., 2.)]);
    only!(d, Defect::Overlap { first, second } if first.name == "outer" && second.name == "scar0");
    let d = square().with_scar(vec![p(1., 1.), p(2., 1.)]).with_scar(vec![p(2., 1.), p(1., 1.)]);
    only!(d, Defect::Overlap { .. });
    let d = square().with_scar(vec![p(1., 1.), p(2., 1.), p(1.5, 1.)]);
    only!(d, Defect::Overlap { .. });
}

#[test]
fn no_area() {
    let d = square().with_hole(vec![p(1., 1.), p(2., 2.), p(3., 3.), p(2.5, 2.5)]);
    only!(d, Defect::ZeroArea { name } if name == "hole0");
    let found = Domain::new(vec![p(1., 1.); 4]).check();
    assert!(found.iter().any(|d| matches!(d, Defect::ZeroArea { .. })), "{found:?}");
}

#[test]
fn nesting() {
    only!(square().with_hole(small(6., 1.)), Defect::Outside { at } if at.name == "hole0");
    let d = square().with_hole(rectangle(p(0.5, 0.5), p(3., 3.), 1, 1)).with_hole(small(1., 1.));
    only!(d, Defect::HoleInHole { inner, outer } if inner.name == "hole1" && outer == "hole0");
    let d = square().with_hole(rectangle(p(-1., -1.), p(5., 5.), 1, 1));
    only!(d, Defect::HoleAroundOuter { hole, .. } if hole == "hole0");
}

#[test]
fn scars_and_points_outside() {
    only!(square().with_scar(vec![p(6., 1.), p(7., 1.)]), Defect::Outside { at } if at.name == "scar0");
    only!(square().with_scar(vec![p(4., 1.), p(7., 1.)]), Defect::Outside { .. });
    let d = square().with_hole(small(1., 1.));
    // Across the hole, node to node; within the hole; from node to node outside a notch.
    only!(d.clone().with_scar(vec![p(1., 1.), p(2., 2.)]), Defect::Outside { .. });
    only!(d.clone().with_scar(vec![p(1.2, 1.2), p(1.4, 1.4)]), Defect::Outside { .. });
    let mut notch = square();
    notch.loops[0].nodes[2] = p(2., 2.);
    only!(notch.with_scar(vec![p(1., 0.), p(3., 0.)]), Defect::Outside { .. });
    only!(d.clone().with_point(p(1.5, 1.5)), Defect::Outside { at } if at.name == "point0");
    only!(d.clone().with_point(p(-1.5, 1.5)), Defect::Outside { .. });
    only!(d.clone().with_point(p(2., 1.5)), Defect::PointOnSegment { segment, .. } if segment.name == "hole0");
    only!(d.clone().with_point(p(2. + 1e-9, 1.5)), Defect::PointOnSegment { .. });
    assert_eq!(d.with_point(p(2.0001, 1.5)).check(), []);
}

#[test]
fn points_close_to_segments_are_noticed() {
    let d =
        square().with_point(p(2.5, 0.2)).with_point(p(2., 2.)).with_point(p(0.5, 0.31)).with_point(p(1., 0.));
    let a = build(&d);
    let [Notice::ClosePoint { point, segment, share }] = a.notices.as_slice() else {
        panic!("{:?}", a.notices)
    };
    assert_eq!((point.name.as_str(), segment.name.as_str(), segment.index), ("point0", "outer", 2));
    assert!((share - 0.2).abs() < 1e-15);
}

#[test]
fn sizes_of_points() {
    for size in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let mut d = square();
        d.points.push(HardPoint { name: "weld".into(), xy: p(1., 1.), size: Some(size) });
        only!(d, Defect::BadSize { at, .. } if at.name == "weld");
    }
}

#[test]
fn odd_total() {
    let mut d = square();
    d.loops[0].nodes.remove(1);
    let text = only!(d, Defect::OddTotal { n_segments: 15, .. });
    assert!(text.contains("(odd: outer)"), "{text}");
    assert!(Arrangement::new(&d, &CheckOptions { allow_odd: true, repair_parity: false }).is_ok());
    // Two odd loops make an even total.
    let d = d.with_hole(vec![p(1., 1.), p(2., 1.), p(1., 2.)]);
    assert_eq!(d.check(), []);
}

#[test]
fn odd_regions_and_their_cure() {
    let d = square().with_scar(vec![p(0., 1.), p(2.5, 1.2), p(4., 2.)]);
    let found = d.check();
    assert_eq!(found.len(), 2, "{found:?}");
    for defect in &found {
        let Defect::OddRegion { cure, n_segments, .. } = defect else { panic!("{defect:?}") };
        assert_eq!(n_segments % 2, 1);
        assert_eq!(cure, &[Place { name: "scar0".into(), index: 0, x: 0.0, y: 1.0 }], "the longest segment");
    }
    let repair = CheckOptions { allow_odd: false, repair_parity: true };
    let a = Arrangement::new(&d, &repair).unwrap();
    assert_eq!(a.added_nodes, [(0, 17)]);
    assert_eq!(a.points[17], p(1.25, 1.1));
    assert_eq!(a.scars[0], [15, 17, 16, 6]);
    assert!(a.regions.iter().all(|r| r.n_segments() % 2 == 0));
    // With an odd total nothing on the scars can help all regions.
    let mut d = square().with_scar(vec![p(0., 1.), p(4., 1.)]);
    d.loops[0].nodes.remove(1);
    let found = d.check();
    assert!(
        matches!(found.as_slice(), [Defect::OddTotal { .. }, Defect::OddRegion { cure, .. }] if cure.is_empty())
    );
    assert!(Arrangement::new(&d, &repair).is_err());
}

#[test]
fn all_defects_are_reported_at_once() {
    let mut d = square()
        .with_hole(small(6., 1.))
        .with_hole(vec![p(1., 1.), p(2., 2.)])
        .with_hole(small(0.5, 0.5))
        .with_hole(vec![p(0.7, 0.7), p(1.2, 0.8), p(0.8, 1.2)])
        .with_scar(vec![p(9., 9.), p(8., 8.)])
        .with_point(p(f64::NAN, 0.))
        .with_point(p(1.5, 0.));
    d.points[1].size = Some(-1.0);
    let names: Vec<_> =
        d.check().iter().map(|d| format!("{d:?}").split(' ').next().unwrap_or("").to_owned()).collect();
    assert_eq!(
        names,
        [
            "TooFewNodes",
            "Outside",
            "HoleInHole",
            "Outside",
            "NotFinite",
            "BadSize",
            "PointOnSegment",
            "OddTotal"
        ]
    );
}

#[test]
fn a_garbled_loop_gives_a_bounded_list() {
    let mut s = 1u64;
    let mut next = || {
        s = s.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (s >> 11) as f64 / (1u64 << 53) as f64
    };
    let d = Domain::new((0..3000).map(|_| p(next(), next())).collect());
    let found = d.check();
    assert!(found.len() <= 1002 && matches!(found.last(), Some(Defect::More { .. })), "{}", found.len());
}

/// Ten thousand holes: a guard against tests of all pairs, which would take minutes.
#[test]
fn many_holes() {
    let k = 100;
    let mut d = Domain::new(rectangle(p(0., 0.), p(k as f64, k as f64), k, k));
    for c in 0..k * k {
        let m = p((c / k) as f64 + 0.5, (c % k) as f64 + 0.5);
        let nodes = (0..10).map(|i| Point2::from_angle(std::f64::consts::TAU * i as f64 / 10.0) * 0.3 + m);
        let nodes = nodes.collect();
        d.loops.push(Loop { kind: LoopKind::Hole, name: format!("hole{c}"), nodes });
    }
    let a = build(&d);
    assert_eq!((a.regions.len(), a.regions[0].inner.len()), (1, k * k));
}

/// A random valid domain on a k by k lattice: holes, points and floating scars in the cells, and scars along the
/// lattice lines.
#[derive(Clone, Debug)]
struct Lattice {
    k: usize,
    cells: Vec<u8>,
    lines: Vec<bool>,
    jitter: Vec<(f64, f64)>,
}

fn lattice() -> impl Strategy<Value = Lattice> {
    (1usize..7).prop_flat_map(|k| {
        let n = 2 * k * (k + 1);
        (
            Just(k),
            prop::collection::vec(0u8..6, k * k),
            prop::collection::vec(prop::bool::weighted(0.4), n),
            prop::collection::vec((-0.1..0.1, -0.1..0.1), (k + 1) * (k + 1)),
        )
            .prop_map(|(k, cells, lines, jitter)| Lattice { k, cells, lines, jitter })
    })
}

impl Lattice {
    fn node(&self, i: usize, j: usize) -> Point2 {
        let on_rim = |a: usize| a == 0 || a == self.k;
        let (dx, dy) = self.jitter[i * (self.k + 1) + j];
        let inner = !on_rim(i) && !on_rim(j);
        p(i as f64, j as f64) + if inner { p(dx, dy) } else { Point2::ZERO }
    }

    fn domain(&self) -> Domain {
        let k = self.k;
        let mut d = Domain::new(rectangle(p(0., 0.), p(k as f64, k as f64), k, k));
        for (c, &kind) in self.cells.iter().enumerate() {
            let m = p((c / k) as f64 + 0.5, (c % k) as f64 + 0.5);
            d = match kind {
                1 => d.with_hole(vec![m + p(0.2, 0.), m + p(0., 0.2), m + p(-0.2, 0.), m + p(0., -0.2)]),
                2 => d.with_hole(vec![m + p(0.2, 0.), m + p(0., 0.2), m + p(-0.2, -0.1)]),
                3 => d.with_point(m).with_point(m + p(0.1, 0.1)),
                4 => d.with_scar(vec![m + p(-0.2, 0.), m, m + p(0.2, 0.2)]),
                _ => d,
            };
        }
        let mut n = 0;
        for i in 0..=k {
            for j in 0..k {
                if i > 0 && i < k && self.lines[n] {
                    d = d.with_scar(vec![self.node(i, j), self.node(i, j + 1)]);
                }
                if i > 0 && i < k && self.lines[n + 1] {
                    let (a, b) = (self.node(j, i), self.node(j + 1, i));
                    d = d.with_scar(vec![b, a.lerp(b, 0.25), a]);
                }
                n += 2;
            }
        }
        d
    }
}

const ODD: CheckOptions = CheckOptions { allow_odd: true, repair_parity: false };

fn walk_points(a: &Arrangement, w: &[u32]) -> Vec<Point2> {
    w.iter().map(|&v| a.points[v as usize]).collect()
}

/// Regions as point lists.
fn region_points(a: &Arrangement) -> Vec<(Vec<Point2>, Vec<Vec<Point2>>)> {
    let walk = |w: &Vec<u32>| walk_points(a, w);
    a.regions.iter().map(|r| (walk(&r.outer), r.inner.iter().map(walk).collect())).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn counts_and_areas_add_up(l in lattice()) {
        let d = l.domain();
        let a = Arrangement::new(&d, &ODD).map_err(|e| TestCaseError::fail(format!("{e:?}")))?;
        // Euler: faces of a planar graph = E - V + C + 1; one is outside, one in each hole.
        let mut root: Vec<usize> = (0..a.points.len()).collect();
        let mut components = a.points.len();
        let mut n_edges = 0;
        let mut unite = |u: u32, v: u32| {
            n_edges += 1;
            let find = |root: &[usize], mut i: usize| { while root[i] != i { i = root[i]; } i };
            let (i, j) = (find(&root, u as usize), find(&root, v as usize));
            if i != j { root[i] = j; components -= 1; }
        };
        for w in &a.loops {
            for i in 0..w.len() { unite(w[i], w[(i + 1) % w.len()]); }
        }
        for s in &a.scars {
            for w in s.windows(2) { unite(w[0], w[1]); }
        }
        let n_holes = d.loops.len() - 1;
        prop_assert_eq!(a.regions.len() + a.points.len() + n_holes, n_edges + components);
        // Every loop edge bounds one region, every scar edge two or one twice.
        let n_loop: usize = d.loops.iter().map(|l| l.nodes.len()).sum();
        let n_scar: usize = d.scars.iter().map(|s| s.nodes.len() - 1).sum();
        let total: usize = a.regions.iter().map(Region::n_segments).sum();
        prop_assert_eq!(total, n_loop + 2 * n_scar);
        // Every node is in some walk.
        let mut seen = vec![false; a.points.len()];
        let mut area = 0.0;
        for r in &a.regions {
            let outer = signed_area(&walk_points(&a, &r.outer));
            prop_assert!(outer > 0.0);
            area += outer;
            for w in &r.inner {
                let inner = signed_area(&walk_points(&a, w));
                prop_assert!(inner <= 1e-12);
                area += inner;
                // Inside the outer walk, by an independent test.
                let q = a.points[w[0] as usize];
                let outer = walk_points(&a, &r.outer);
                prop_assert_eq!(crate::polygon::locate(&outer, q), crate::polygon::Side::Inside);
            }
            for &v in r.inner.iter().flatten().chain(&r.outer) { seen[v as usize] = true; }
        }
        prop_assert!(seen.iter().all(|s| *s));
        prop_assert!((area - a.area).abs() < 1e-9 * a.area);
    }

    #[test]
    fn start_orientation_and_scale_do_not_matter(l in lattice(), turn in 0usize..40, e in -20i32..20) {
        let d = l.domain();
        let a = Arrangement::new(&d, &ODD).map_err(|e| TestCaseError::fail(format!("{e:?}")))?;
        let mut other = d.clone();
        let f = 2f64.powi(e);
        for (i, l) in other.loops.iter_mut().enumerate() {
            let n = l.nodes.len();
            l.nodes.rotate_left((turn + i) % n);
            if (turn + i) % 2 == 0 { l.nodes.reverse(); }
            l.nodes.iter_mut().for_each(|q| *q *= f);
        }
        for s in &mut other.scars {
            s.nodes.iter_mut().for_each(|q| *q *= f);
            if turn % 2 == 0 { s.nodes.reverse(); }
        }
        other.points.iter_mut().for_each(|q| q.xy *= f);
        let b = Arrangement::new(&other, &ODD).map_err(|e| TestCaseError::fail(format!("{e:?}")))?;
        let scaled: Vec<_> = region_points(&a).into_iter().map(|(o, i)| {
            let s = |w: Vec<Point2>| w.into_iter().map(|q| q * f).collect::<Vec<_>>();
            (s(o), i.into_iter().map(s).collect::<Vec<_>>())
        }).collect();
        prop_assert_eq!(scaled, region_points(&b));
    }

    #[test]
    fn repair_makes_all_regions_even(l in lattice()) {
        let mut d = l.domain();
        // An even total, by one more node on the first side if need be.
        let total: usize = d.loops.iter().map(|l| l.nodes.len()).sum();
        if total % 2 == 1 {
            d.loops[0].nodes.insert(1, p(0.5, 0.0));
        }
        let strict = Arrangement::new(&d, &CheckOptions::default());
        let repaired = Arrangement::new(&d, &CheckOptions { repair_parity: true, allow_odd: false });
        let repaired = repaired.map_err(|e| TestCaseError::fail(format!("{e:?}")))?;
        prop_assert!(repaired.regions.iter().all(|r| r.n_segments() % 2 == 0));
        match strict {
            Ok(a) => prop_assert_eq!(a, repaired),
            Err(defects) => {
                prop_assert!(!repaired.added_nodes.is_empty());
                for d in &defects {
                    prop_assert!(matches!(d, Defect::OddRegion { cure, .. } if !cure.is_empty()), "{:?}", d);
                }
            }
        }
    }

    #[test]
    fn garbage_never_panics(
        loops in prop::collection::vec(prop::collection::vec((0i32..6, 0i32..6), 0..9), 0..4),
        scars in prop::collection::vec(prop::collection::vec((0i32..6, 0i32..6), 0..6), 0..4),
        points in prop::collection::vec((0i32..6, 0i32..6), 0..4),
    ) {
        let q = |v: &(i32, i32)| p(f64::from(v.0), f64::from(v.1));
        let mut d = Domain::default();
        for (i, l) in loops.iter().enumerate() {
            let nodes = l.iter().map(q).collect();
            d = if i == 0 { Domain::new(nodes) } else { d.with_hole(nodes) };
        }
        for s in &scars { d = d.with_scar(s.iter().map(q).collect()); }
        for v in &points { d = d.with_point(q(v)); }
        let found = d.check();
        prop_assert!(found.iter().all(|d| !d.to_string().is_empty()));
        if let Ok(a) = Arrangement::new(&d, &ODD) {
            let area: f64 = a.regions.iter().map(|r| {
                signed_area(&walk_points(&a, &r.outer))
                    + r.inner.iter().map(|w| signed_area(&walk_points(&a, w))).sum::<f64>()
            }).sum();
            prop_assert!((area - a.area).abs() < 1e-9 * a.area);
        }
    }
}
