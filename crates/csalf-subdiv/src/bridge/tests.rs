use super::*;
use csalf_geom::polygon::signed_area;
use csalf_sizemap::Uniform;

fn ring(c: (f64, f64), r: f64, n: usize, clockwise: bool) -> Vec<Point2> {
    (0..n)
        .map(|i| {
            let t = std::f64::consts::TAU * i as f64 / n as f64 * if clockwise { -1.0 } else { 1.0 };
            Point2::new(c.0 + r * t.cos(), c.1 + r * t.sin())
        })
        .collect()
}

struct Case {
    points: Vec<Point2>,
    walks: Vec<Vec<u32>>,
}

impl Case {
    fn new() -> Self {
        Self { points: vec![], walks: vec![] }
    }
    fn add(mut self, ring: Vec<Point2>) -> Self {
        let n = self.points.len() as u32;
        self.walks.push((n..n + ring.len() as u32).collect());
        self.points.extend(ring);
        self
    }
    fn run(&self, h: f64) -> Bridged {
        let flags = vec![NodeFlags::GEOMETRY; self.points.len()];
        let input = Walks { walks: &self.walks, points: &self.points, flags: &flags };
        bridge(input, &Uniform(h), self.points.len() as u32).expect("one region")
    }
}

/// What every bridged contour must satisfy: each walk segment once, each bridge segment once in each direction,
/// the area of the region.
fn check(case: &Case, b: &Bridged) {
    let c = &b.contour;
    let n = c.len();
    let mut segs: Vec<(u32, u32)> = (0..n).map(|i| (c.ids[i], c.ids[(i + 1) % n])).collect();
    segs.sort_unstable();
    let len = segs.len();
    segs.dedup();
    assert_eq!(segs.len(), len, "no directed segment occurs twice");
    let mut n_walk = 0;
    for w in case.walks.iter().filter(|w| w.len() > 1) {
        for i in 0..w.len() {
            let s = (w[i], w[(i + 1) % w.len()]);
            assert!(segs.binary_search(&s).is_ok(), "walk segment {s:?} is kept");
            n_walk += 1;
        }
    }
    assert_eq!(len, n_walk + 2 * (b.new_points.len() + case.walks.len() - 1));
    let area: f64 = case
        .walks
        .iter()
        .map(|w| signed_area(&w.iter().map(|&v| case.points[v as usize]).collect::<Vec<_>>()))
        .sum();
    assert!((signed_area(&c.points) - area).abs() < 1e-12 * area);
}

#[test]
fn holes_and_points_become_one_contour() {
    let case = Case::new()
        .add(ring((0., 0.), 10., 40, false))
        .add(ring((-4., 1.), 2., 12, true))
        .add(ring((4., 1.), 2., 13, true))
        .add(vec![Point2::new(0., -5.)])
        .add(vec![Point2::new(0.3, -5.5)])
        .add(vec![Point2::new(0., 5.)]);
    let b = case.run(1.0);
    check(&case, &b);
    assert_eq!(b.contour.len() % 2, (40 + 25) % 2);
}

#[test]
fn a_slit_is_bridged_at_the_right_occurrence() {
    let mut case = Case::new().add(ring((0., 0.), 5., 24, false));
    let base = case.points.len() as u32;
    case.points.extend([Point2::new(-1., 0.), Point2::new(0., 0.), Point2::new(1., 0.)]);
    case.walks.push(vec![base, base + 1, base + 2, base + 1]);
    let case = case.add(ring((0., 2.5), 0.7, 8, true)).add(ring((0., -2.5), 0.7, 8, true));
    let b = case.run(0.7);
    check(&case, &b);
}

#[test]
fn many_holes() {
    let mut case = Case::new().add(ring((0., 0.), 30., 100, false));
    for j in -5..5 {
        for i in -5..5 {
            case = case.add(ring((3.0 * i as f64 + 1.5, 3.0 * j as f64 + 1.5), 0.8, 10, true));
        }
    }
    check(&case, &case.run(0.5));
}

#[test]
fn walks_of_two_regions_are_refused() {
    let case = Case::new().add(ring((0., 0.), 1., 8, false)).add(ring((5., 0.), 1., 8, false));
    let flags = vec![NodeFlags::GEOMETRY; 16];
    let input = Walks { walks: &case.walks, points: &case.points, flags: &flags };
    assert!(matches!(bridge(input, &Uniform(1.0), 16), Err(BridgeError::Unreachable { walk: 1 })));
}
