use super::*;
use csalf_geom::{Point2, polygon::signed_area, predicates::*};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

fn p(x: f64, y: f64) -> Point2 {
    Point2::new(x, y)
}

fn min_sj(c: &Contour, patch: &Patch) -> f64 {
    let sj = |q: &[u32; 4]| {
        let v = q.map(|k| patch.point(c, k));
        let corner = |k: usize| {
            let (a, b) = (v[(k + 1) & 3] - v[k], v[(k + 3) & 3] - v[k]);
            a.perp_dot(b) / (a.length() * b.length())
        };
        (0..4).map(corner).fold(1.0, f64::min)
    };
    patch.quads.iter().map(sj).fold(1.0, f64::min)
}

/// Everything that the fallback promises; the area is compared to `1e-9` of it.
fn certify(c: &Contour) -> Result<Patch, String> {
    let patch = fill(c, Tolerance::of_points(c.points.iter().copied())).map_err(|e| e.to_string())?;
    let n = c.len() as u32;
    let mut area = 0.0;
    let mut sides = Vec::new();
    for q in &patch.quads {
        let v = q.map(|k| patch.point(c, k));
        for k in 0..4 {
            if !is_left(v[k], v[(k + 1) & 3], v[(k + 2) & 3]) {
                return Err(format!("quad {q:?} is not strictly convex"));
            }
            sides.push((q[k], q[(k + 1) & 3]));
        }
        area += signed_area(&v);
    }
    sides.sort_unstable();
    if sides.windows(2).any(|w| w[0] == w[1]) {
        return Err("an edge is run along twice in one direction".into());
    }
    let rim: Vec<_> = sides.iter().copied().filter(|&(a, b)| sides.binary_search(&(b, a)).is_err()).collect();
    let mut want: Vec<_> = (0..n).map(|i| (i, (i + 1) % n)).collect();
    want.sort_unstable();
    if rim != want {
        return Err(format!("rim is {rim:?}"));
    }
    let n_vertices = n as usize + patch.points.len();
    let n_edges = (sides.len() + rim.len()) / 2;
    if n_vertices + patch.quads.len() != n_edges + 1 {
        return Err("not a disk, or unused points".into());
    }
    let total = signed_area(&c.points);
    if (area - total).abs() > 1e-9 * total {
        return Err(format!("area {area} in place of {total}"));
    }
    Ok(patch)
}

fn ring(points: &[Point2]) -> Contour {
    Contour::from_ring(points, 1.0)
}

/// A contour whose equal points are equal nodes.
fn walk(points: &[Point2]) -> Contour {
    let mut c = ring(points);
    for i in 0..c.len() {
        c.ids[i] = (0..=i).find(|&j| c.points[j] == c.points[i]).unwrap_or(i) as u32;
    }
    c
}

struct Random(u64);
impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A random simple polygon: random points in random order, uncrossed by reversals.
fn two_opt(seed: u64, n: usize) -> Vec<Point2> {
    let mut r = Random(seed);
    let mut v: Vec<Point2> = (0..n).map(|_| p(r.unit(), r.unit())).collect();
    'again: loop {
        for i in 0..n {
            for j in i + 2..n {
                if i == 0 && j == n - 1 {
                    continue;
                }
                if meeting(v[i], v[i + 1], v[j], v[(j + 1) % n]) != Meeting::Apart {
                    v[i + 1..=j].reverse();
                    continue 'again;
                }
            }
        }
        break;
    }
    if signed_area(&v) < 0.0 {
        v.reverse();
    }
    v
}

/// Straight sides between the corners, each with `m` segments.
fn sides(corners: &[Point2], m: &[usize]) -> Vec<Point2> {
    let n = corners.len();
    let side = |i: usize| {
        let (a, b, m) = (corners[i], corners[(i + 1) % n], m[i % m.len()]);
        (0..m).map(move |k| a.lerp(b, k as f64 / m as f64))
    };
    (0..n).flat_map(side).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_polygons_are_filled(seed: u64, half in 2usize..31) {
        let c = ring(&two_opt(seed, 2 * half));
        prop_assert_eq!(certify(&c).err(), None);
    }
}

/// Found by the property below: at 2^-19 a squared length met a constant of spade's.
#[test]
fn a_small_polygon_is_filled_like_a_large_one() {
    let a = two_opt(1_120_377_361_331_635_019, 24);
    let quads = |f: f64| certify(&ring(&a.iter().map(|&q| q * f).collect::<Vec<_>>())).map(|p| p.quads);
    let whole = quads(1.0);
    assert!(whole.is_ok());
    assert!([-16, -19, -30, 19].iter().all(|&e| quads(2f64.powi(e)) == whole));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn scaling_by_powers_of_two_changes_nothing(seed: u64, half in 2usize..16, exponent in -20i32..=20) {
        let a = two_opt(seed, 2 * half);
        let f = 2f64.powi(exponent);
        let b: Vec<Point2> = a.iter().map(|&q| q * f).collect();
        let (pa, pb) = (certify(&ring(&a)), certify(&ring(&b)));
        prop_assert!(pa.is_ok() && pb.is_ok(), "{:?} {:?}", pa.err(), pb.err());
        let (pa, pb) = (pa.unwrap_or_default(), pb.unwrap_or_default());
        prop_assert_eq!(&pa.quads, &pb.quads);
        prop_assert!(pa.points.iter().zip(&pb.points).all(|(&u, &v)| u * f == v));
    }

    #[test]
    fn moved_and_turned_polygons_are_filled(seed: u64, half in 2usize..16, turn in 0.0..TAU, far in 0.0..1e3) {
        let a = two_opt(seed, 2 * half);
        let move_ = |q: Point2| csalf_geom::angle::rotated(q, turn) + p(far, -0.7 * far);
        let b: Vec<Point2> = a.iter().map(|&q| move_(q)).collect();
        prop_assert_eq!(certify(&ring(&b)).err(), None);
    }

    #[test]
    fn stars_are_filled(seed: u64, half in 2usize..40, depth in 0.001..1.0) {
        let mut r = Random(seed);
        let n = 2 * half;
        let v: Vec<Point2> = (0..n)
            .map(|i| Point2::from_angle(TAU * i as f64 / n as f64) * (depth + (1.0 - depth) * r.unit()))
            .collect();
        prop_assert_eq!(certify(&ring(&v)).err(), None);
    }

    /// A polygon with random slits: from a node to random visible points, as doubled edges.
    #[test]
    fn random_slits_are_filled(seed: u64, half in 3usize..16, n_slits in 1usize..6) {
        let mut v = two_opt(seed, 2 * half);
        let mut r = Random(!seed);
        let mut made = 0;
        for _ in 0..400 {
            let q = p(r.unit(), r.unit());
            let i = (r.unit() * v.len() as f64) as usize;
            let n = v.len();
            let clear = (0..n).all(|k| {
                let (a, b) = (v[k], v[(k + 1) % n]);
                if a == v[i] || b == v[i] {
                    !on_segment(a, b, q) && !on_segment(v[i], q, if a == v[i] { b } else { a })
                } else {
                    meeting(a, b, v[i], q) == Meeting::Apart
                }
            });
            // The slit must leave into the angle of this very occurrence.
            let (u, w) = (v[(i + 1) % n] - v[i], v[(i + n - 1) % n] - v[i]);
            let full = if u == w { TAU } else { csalf_geom::angle::interior_angle(v[i] + w, v[i], v[i] + u) };
            let t = csalf_geom::angle::turn(u, q - v[i]);
            if clear && t > 1e-6 && t < full - 1e-6 {
                let (b, m) = (v[i], v[i].lerp(q, 0.5));
                let doubled: Vec<Point2> = if made % 2 == 0 { vec![q, b] } else { vec![m, q, m, b] };
                v.splice(i + 1..i + 1, doubled);
                made += 1;
                if made == n_slits {
                    break;
                }
            }
        }
        prop_assume!(made > 0);
        prop_assert_eq!(certify(&walk(&v)).err(), None);
    }
}

#[test]
fn the_count_is_6n_minus_6_without_inner_points_and_wedges() {
    // Handbook A.18: n = 8.
    let v: Vec<Point2> = (0..8).map(|i| Point2::from_angle(TAU * i as f64 / 8.0)).collect();
    let patch = ring::fill(&ring(&v), false, false).unwrap();
    assert_eq!(patch.quads.len(), 42);
}

#[test]
fn needles_down_to_a_hundredth_of_a_degree() {
    for degrees in [5.0, 1.0, 0.1, 0.01] {
        for m in [1usize, 2, 5, 50] {
            let tip = PI * degrees / 180.0;
            let v = sides(&[p(0., 0.), p(1., 0.), Point2::from_angle(tip)], &[m, 2, m]);
            assert_eq!(certify(&ring(&v)).err(), None, "{degrees} degrees, {m} segments");
            // The same needle as a notch.
            let far = [p(0., 0.), Point2::from_angle(tip), p(-2., 3.), p(-2., -3.), p(1., 0.)];
            let v = sides(&far, &[m, 3, 4, 3, m]);
            assert_eq!(certify(&ring(&v)).err(), None, "notch of {degrees} degrees, {m} segments");
        }
    }
}

#[test]
fn walls_that_nearly_touch() {
    for gap in [1e-2, 1e-4, 1e-6, 1e-9] {
        let v = sides(&[p(0., 0.), p(1., 0.), p(1., gap), p(0., gap)], &[10, 1, 7, 2]);
        assert_eq!(certify(&ring(&v)).err(), None, "channel of {gap}");
        let c = [p(0., 0.), p(2., 0.), p(2., 1.), p(1. + gap, 1.), p(1., gap), p(1. - gap, 1.), p(0., 1.)];
        let v = sides(&c, &[9, 3, 5, 4, 4, 5, 4]);
        assert_eq!(certify(&ring(&v)).err(), None, "notch to {gap} of the floor");
    }
}

#[test]
fn collinear_nodes_on_turned_sides_and_size_ratios() {
    for k in 0..50 {
        let turn = 0.37 * k as f64;
        let corners = [p(0., 0.), p(3., 0.), p(3., 1.), p(0., 1.)];
        let corners = corners.map(|q| csalf_geom::angle::rotated(q, turn) + p(17.3, -4.1));
        let v = sides(&corners, &[30, 1, 30, 1]);
        assert_eq!(certify(&ring(&v)).err(), None, "square turned by {turn}");
        let v = sides(&[corners[0], corners[1], corners[2]], &[21, 1, 4]);
        assert_eq!(certify(&ring(&v)).err(), None, "triangle turned by {turn}");
    }
    // Segments from 1 to 1e-4 on one side.
    let mut v = vec![p(0., 0.), p(1., 0.), p(1., 1.), p(0., 1.)];
    v.splice(1..1, (0..40).map(|i| p(1e-4 * 1.25f64.powi(i), 0.0)));
    assert_eq!(certify(&ring(&v)).err(), None);
}

#[test]
fn combs_and_spirals() {
    let mut comb = vec![p(0., -1.), p(20., -1.)];
    for i in (0..20).rev() {
        let x = i as f64;
        comb.extend([p(x + 1.0, 0.), p(x + 0.9, 5.), p(x + 0.6, 5.), p(x + 0.5, 0.)]);
    }
    assert_eq!(certify(&ring(&comb)).err(), None);
    let turn = |r: f64| move |i: usize| Point2::from_angle(0.2 * i as f64) * (1.0 + r + 0.05 * i as f64);
    let mut spiral: Vec<Point2> = (0..150).map(turn(0.3)).collect();
    spiral.extend((0..150).rev().map(turn(0.0)));
    assert_eq!(certify(&ring(&spiral)).err(), None);
}

#[test]
fn slits_bridges_and_pinched_nodes() {
    // Slits from the side, of one and two segments; tips at both parities.
    let v = [p(0., 0.), p(2., 0.), p(4., 0.), p(4., 4.), p(2., 4.), p(0., 4.)];
    let mut slit = v.to_vec();
    slit.splice(2..2, [p(2., 1.), p(2., 0.)]);
    assert_eq!(certify(&walk(&slit)).err(), None);
    slit.splice(3..3, [p(2., 2.), p(1., 2.), p(2., 2.), p(3., 2.), p(2., 2.), p(2., 1.)]);
    assert_eq!(certify(&walk(&slit)).err(), None);
    // A hole on a bridge: square in square, then a round hole of 3 to 30 nodes.
    for m in 3..30 {
        let n = if m % 2 == 0 { 4 } else { 5 };
        let outer: Vec<Point2> =
            (0..n).map(|i| Point2::from_angle(TAU * i as f64 / n as f64) * 3.0).collect();
        let hole: Vec<Point2> = (0..m).map(|i| Point2::from_angle(-TAU * i as f64 / m as f64)).collect();
        let mut v = vec![outer[0]];
        v.extend(&hole);
        v.extend([hole[0], outer[0]]);
        v.extend(&outer[1..]);
        assert_eq!(certify(&walk(&v)).err(), None, "hole of {m}");
        // And a bridged hard point from the hole.
        let mut w = v.clone();
        w.splice(2..2, [hole[0] * 1.2 - p(0.0, 0.3), hole[0]]);
        assert_eq!(certify(&walk(&w)).err(), None, "hole of {m} and a point");
    }
    // A hole that touches the outer loop in a node.
    let v = [p(0., 0.), p(4., 0.), p(4., 4.), p(0., 4.), p(0., 0.), p(1., 2.), p(2., 2.), p(2., 1.)];
    assert_eq!(certify(&walk(&v)).err(), None);
}

#[test]
fn what_is_not_a_contour_is_refused() {
    let fill = |v: &[Point2]| fill(&walk(v), Tolerance::of_points(v.iter().copied())).map(|_| ());
    let sq = [p(0., 0.), p(1., 0.), p(1., 1.), p(0., 1.)];
    assert_eq!(fill(&sq[..3]), Err(FallbackError::TooFewNodes { n_nodes: 3 }));
    let five = [sq[0], sq[1], sq[2], sq[3], p(-0.5, 0.5)];
    assert_eq!(fill(&five), Err(FallbackError::Odd { n_nodes: 5 }));
    assert!(matches!(fill(&[sq[3], sq[2], sq[1], sq[0]]), Err(FallbackError::NotSimple { .. })));
    assert!(matches!(fill(&[sq[0], sq[2], sq[1], sq[3]]), Err(FallbackError::Crossing { .. })));
    assert!(matches!(fill(&[sq[0], sq[1], sq[1], sq[2]]), Err(FallbackError::Coincident { .. })));
    assert!(matches!(fill(&[sq[0], sq[1], p(f64::NAN, 0.), sq[3]]), Err(FallbackError::NotFinite { at: 2 })));
    // All on one line; a doubled segment only; twice around.
    assert!(fill(&[p(0., 0.), p(1., 0.), p(2., 0.), p(3., 0.)]).is_err());
    assert!(fill(&[sq[0], sq[1], sq[0], sq[1]]).is_err());
    assert!(fill(&[sq[0], sq[1], sq[2], sq[3], sq[0], sq[1], sq[2], sq[3]]).is_err());
    // A segment through a node.
    assert!(fill(&[p(0., 0.), p(2., 0.), p(2., 2.), p(1., 0.)]).is_err());
    // Two squares in one node are two contours.
    let two = [p(0., 0.), p(1., 0.), p(1., 1.), p(2., 1.), p(2., 2.), p(1., 2.), p(1., 1.), p(0., 1.)];
    assert!(matches!(fill(&two), Err(FallbackError::NotSimple { .. })));
    // Two nodes in one place with different ids.
    let mut c = walk(&two);
    c.ids[6] = 77;
    let r = super::fill(&c, Tolerance::of_diagonal(1.0));
    assert_eq!(r.err(), Some(FallbackError::Coincident { a: 2, b: 6 }));
}

#[test]
fn quality_is_bearable_in_round_contours() {
    for n in [8usize, 16, 60, 200] {
        let v: Vec<Point2> = (0..n).map(|i| Point2::from_angle(TAU * i as f64 / n as f64)).collect();
        let c = ring(&v);
        let patch = certify(&c).unwrap();
        assert!(min_sj(&c, &patch) > 0.1, "{n}: {} with {} quads", min_sj(&c, &patch), patch.quads.len());
    }
}

#[test]
fn simple_contours_of_few_nodes_get_a_stencil() {
    let square = ring(&[p(0., 0.), p(1., 0.), p(1., 1.), p(0., 1.)]);
    assert_eq!(certify(&square).unwrap().quads, [[0, 1, 2, 3]]);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn either_choice_of_odd_nodes_works(seed: u64, half in 2usize..20, flip: bool, inner: bool) {
        let c = ring(&two_opt(seed, 2 * half));
        prop_assert_eq!(ring::fill(&c, inner, flip).err(), None);
    }

    #[test]
    fn odd_polygons_get_one_triangle(seed: u64, half in 1usize..20) {
        let n = 2 * half + 1;
        let c = ring(&two_opt(seed, n));
        let odd = fill_odd(&c, Tolerance::of_diagonal(1.0));
        prop_assert!(odd.is_ok(), "{:?}", odd);
        let OddPatch { triangle, patch } = odd.unwrap_or_default();
        let [a, b, d] = triangle.map(|i| c.points[i as usize]);
        prop_assert!(is_left(a, b, d));
        let mut area = 0.5 * (b - a).perp_dot(d - a);
        let mut sides: Vec<_> = (0..3).map(|k| (triangle[k], triangle[(k + 1) % 3])).collect();
        for q in &patch.quads {
            let v = q.map(|k| patch.point(&c, k));
            prop_assert!((0..4).all(|k| is_left(v[k], v[(k + 1) & 3], v[(k + 2) & 3])));
            area += signed_area(&v);
            sides.extend((0..4).map(|k| (q[k], q[(k + 1) & 3])));
        }
        sides.sort_unstable();
        let rim: Vec<_> =
            sides.iter().copied().filter(|&(a, b)| sides.binary_search(&(b, a)).is_err()).collect();
        let mut want: Vec<_> = (0..n as u32).map(|i| (i, (i + 1) % n as u32)).collect();
        want.sort_unstable();
        prop_assert_eq!(rim, want);
        prop_assert!((area - signed_area(&c.points)).abs() < 1e-9);
    }
}
