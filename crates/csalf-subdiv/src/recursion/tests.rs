use super::*;
use csalf_geom::polygon;
use csalf_mesh::quality::scaled_jacobian::value as scaled_jacobian;
use csalf_sizemap::Uniform;

fn rectangle(nx: usize, ny: usize) -> Vec<Point2> {
    let mut p = Vec::new();
    p.extend((0..nx).map(|i| Point2::new(i as f64, 0.0)));
    p.extend((0..ny).map(|i| Point2::new(nx as f64, i as f64)));
    p.extend((0..nx).map(|i| Point2::new((nx - i) as f64, ny as f64)));
    p.extend((0..ny).map(|i| Point2::new(0.0, (ny - i) as f64)));
    p
}

fn disk(n: usize) -> Vec<Point2> {
    let r = n as f64 / TAU;
    (0..n).map(|i| TAU * i as f64 / n as f64).map(|t| Point2::new(r * t.cos(), r * t.sin())).collect()
}

fn run(ring: &[Point2], h: f64) -> (Contour, Patch, Tally) {
    let contour = Contour::from_ring(ring, h);
    let size = Uniform(h);
    let task =
        RegionTask { contour: &contour, size: &size, tolerance: Tolerance::of_points(ring.iter().copied()) };
    let (patch, tally) =
        Subdivision::new(SplitRules::QUALITY).with_seam(100_000).mesh_with_tally(&task).expect("even");
    (contour, patch, tally)
}

fn check(contour: &Contour, patch: &Patch) {
    let area: f64 = patch
        .quads
        .iter()
        .map(|q| {
            let p = q.map(|v| patch.point(contour, v));
            assert!(scaled_jacobian(&p) > 0.0, "quad {q:?} is convex");
            polygon::signed_area(&p)
        })
        .sum();
    let want = polygon::signed_area(&contour.points);
    assert!((area - want).abs() < 1e-9 * want, "area {area} of {want}");
}

#[test]
fn a_square_gives_squares() {
    let (c, p, t) = run(&rectangle(12, 12), 1.0);
    check(&c, &p);
    assert_eq!(p.quads.len(), 144);
    assert_eq!(t.fallbacks, 0);
    for q in &p.quads {
        assert!(scaled_jacobian(&q.map(|v| p.point(&c, v))) > 1.0 - 1e-9);
    }
}

#[test]
fn disks_are_filled() {
    for n in [8, 16, 30, 48, 100] {
        let (c, p, t) = run(&disk(n), 1.0);
        check(&c, &p);
        assert_eq!(t.fallbacks, 0, "disk of {n} nodes");
    }
}

/// It came back as its own child, and the driver asked again without end.
#[test]
fn a_contour_that_crosses_itself_is_refused() {
    let ring: Vec<Point2> =
        [(0., 0.), (2., 2.), (3., 2.), (3., 0.), (2., 0.), (0., 2.), (-1., 2.), (-1., 0.)]
            .map(Point2::from)
            .to_vec();
    let contour = Contour::from_ring(&ring, 1.0);
    let tolerance = Tolerance::of_points(ring.iter().copied());
    let task = RegionTask { contour: &contour, size: &Uniform(1.0), tolerance };
    for seam in [16, 100] {
        let s = Subdivision::new(SplitRules::QUALITY).with_seam(seam);
        if let Ok(p) = s.mesh(&task) {
            assert!(p.quads.len() + p.children.len() > 1, "it made some progress");
        }
    }
}
