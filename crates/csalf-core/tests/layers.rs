//! Layers that the user asked for keep their thickness through the whole pipeline (to 2 %, measured on the mesh).

use csalf_core::{Job, Options, mesh};
use csalf_geom::{Domain, Point2};
use csalf_pave::{LayerLaw, LayerSpec};
use std::f64::consts::{PI, TAU};

const N: usize = 64;

/// A plate of side 12 with a hole of radius 1.
fn plate(spec: LayerSpec) -> Job {
    let corner = [(-6., -6.), (6., -6.), (6., 6.), (-6., 6.)].map(Point2::from);
    let outer = (0..48).map(|i| corner[i / 12].lerp(corner[(i / 12 + 1) % 4], (i % 12) as f64 / 12.0));
    let hole = (0..N).map(|i| Point2::from_angle(-TAU * i as f64 / N as f64));
    Job {
        domain: Domain::new(outer.collect()).with_hole(hole.collect()),
        layers: vec![("hole0".into(), spec)],
        ..Job::default()
    }
}

#[test]
fn asked_thickness_is_kept_in_the_finished_mesh() {
    let t0 = 0.08;
    let laws: [(LayerLaw, [f64; 4]); 5] = [
        (LayerLaw::Constant, [1.0, 1.0, 1.0, 1.0]),
        (LayerLaw::Ramp, [1.0, 2.0, 3.0, 4.0]),
        (LayerLaw::Fibonacci, [1.0, 1.0, 2.0, 3.0]),
        (LayerLaw::Geometric(1.3), [1.0, 1.3, 1.69, 2.197]),
        (LayerLaw::Explicit(vec![0.08, 0.12, 0.08, 0.2]), [1.0, 1.5, 1.0, 2.5]),
    ];
    for (law, factors) in laws {
        let spec = LayerSpec { count: 4, law: law.clone(), first: Some(t0) };
        let done = mesh(&plate(spec), &Options::default()).expect("a plate with a hole is meshed");
        let hole = done.report.loops.iter().find(|l| l.name == "hole0").expect("the hole is reported");
        assert_eq!((hole.asked, hole.made), (4, 4), "{law:?}: {}", hole.stopped);
        // The rings are regular polygons: their inscribed radii differ by the thickness.
        let mut inner = (PI / N as f64).cos();
        for (k, factor) in factors.iter().enumerate() {
            let name = format!("hole0_layer{}", k + 1);
            let (_, quads) = done.sets.quads.iter().find(|s| s.0 == name).expect("each layer is a set");
            assert_eq!(quads.len(), N);
            let radii = quads.iter().flat_map(|q| done.mesh.corners(*q)).map(|p| p.length());
            let (mut lo, mut hi) = (f64::INFINITY, f64::INFINITY);
            let outer = inner + t0 * factor;
            for r in radii.map(|r| r * (PI / N as f64).cos()) {
                // Every node lies on one of the two polygons.
                let (a, b) = ((r - inner).abs(), (r - outer).abs());
                assert!(a.min(b) <= 0.01 * t0 * factor, "{law:?}, layer {k}: {r} is off {inner} and {outer}");
                if a < b { lo = lo.min(a) } else { hi = hi.min(b) }
            }
            assert!(lo.is_finite() && hi.is_finite(), "both sides are there");
            inner = outer;
        }
    }
}
