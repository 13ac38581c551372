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

/// Thicknesses of the four layers round the hole as they are in the mesh, and the largest relative deviation from
/// their mean within a layer.
fn measured(law: LayerLaw) -> ([f64; 4], f64) {
    let spec = LayerSpec { count: 4, law: law.clone(), first: None };
    let done = mesh(&plate(spec), &Options::default()).expect("a plate with a hole is meshed");
    let hole = done.report.loops.iter().find(|l| l.name == "hole0").expect("the hole is reported");
    assert_eq!((hole.asked, hole.made), (4, 4), "{law:?}: {}", hole.stopped);
    let mut off = 0.0f64;
    let t = [1, 2, 3, 4].map(|k| {
        let (_, quads) =
            done.sets.quads.iter().find(|s| s.0 == format!("hole0_layer{k}")).expect("each layer is a set");
        let each: Vec<f64> = quads
            .iter()
            .map(|q| {
                let mut r = done.mesh.corners(*q).map(|p| p.length() * (PI / N as f64).cos());
                r.sort_by(f64::total_cmp);
                0.5 * (r[2] + r[3] - r[0] - r[1])
            })
            .collect();
        let mean = each.iter().sum::<f64>() / each.len() as f64;
        off = each.iter().fold(off, |m, t| m.max((t / mean - 1.0).abs()));
        mean
    });
    (t, off)
}

/// The laws whose thicknesses depend on the part: each layer is even to 2 %, and they grow as the law says.
#[test]
fn parabolic_and_auto_layers_keep_their_law_in_the_finished_mesh() {
    let n = N as f64;
    let side = 2.0 * (PI / n).sin();
    let (t, off) = measured(LayerLaw::Auto);
    assert!(off < 0.02, "{off}");
    // As thick as long at mid height: isotropic growth (n + π) / (n - π).
    let grow = (n + PI) / (n - PI);
    for (k, t) in t.iter().enumerate() {
        let want = side * n / (n - PI) * grow.powi(k as i32);
        assert!((t / want - 1.0).abs() < 0.02, "layer {k}: {t}, {want}");
    }
    let (t, off) = measured(LayerLaw::Parabolic);
    assert!(off < 0.02, "{off}");
    assert!((t[0] / side - 1.0).abs() < 0.02, "{t:?}");
    // t0 (1 + r i²), the last as thick as the wanted length where it ends: 1 at the plate's rim, `side` at the hole.
    let r = t[1] / t[0] - 1.0;
    for k in [2, 3] {
        let want = t[0] * (1.0 + r * (k * k) as f64);
        assert!((t[k] / want - 1.0).abs() < 0.02, "layer {k}: {t:?}");
    }
    let depth = t.iter().sum::<f64>();
    let h = side + (1.0 - side) * depth / 5.0;
    assert!((t[3] / h - 1.0).abs() < 0.25, "{t:?}, wanted there about {h}");
}

/// Straight sides: the distance of every layer from the sides of the outer square, away from its corners.
#[test]
fn layers_along_straight_sides_keep_their_thickness() {
    let spec = LayerSpec { count: 3, law: LayerLaw::Geometric(1.4), first: Some(0.2) };
    let mut job = plate(spec.clone());
    job.layers = vec![("outer".into(), spec)];
    let done = mesh(&job, &Options::default()).expect("a plate with a hole is meshed");
    let outer = done.report.loops.iter().find(|l| l.name == "outer").expect("the outer loop is reported");
    assert_eq!((outer.asked, outer.made), (3, 3), "{}", outer.stopped);
    let mut depth = 0.0;
    for k in 0..3 {
        let t = 0.2 * 1.4f64.powi(k);
        let (_, quads) = done
            .sets
            .quads
            .iter()
            .find(|s| s.0 == format!("outer_layer{}", k + 1))
            .expect("each layer is a set");
        for p in quads.iter().flat_map(|q| done.mesh.corners(*q)) {
            let d = 6.0 - p.x.abs().max(p.y.abs());
            let off = (d - depth).abs().min((d - depth - t).abs());
            assert!(off < 0.02 * t, "layer {k}: {p} lies {d} deep, not {depth} or {}", depth + t);
        }
        depth += t;
    }
}
