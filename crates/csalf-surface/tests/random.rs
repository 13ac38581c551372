//! Properties of random faces.

mod shapes;

use csalf_core::Options;
use csalf_surface::{DVec3, FaceError, FaceInput, FaceLoop, FaceSize, Facets, Flattening, mesh_face};
use proptest::prelude::*;

fn input<'a>(facets: &'a Facets, loops: &'a [FaceLoop]) -> FaceInput<'a> {
    FaceInput { facets, loops, scars: &[], points: &[], size: FaceSize::Boundary, flat: None, surface: None }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// A cylinder over any curve that turns gently is unrolled without distortion.
    #[test]
    fn generalised_cylinders_are_isometric(turns in prop::collection::vec(-0.25f64..0.25, 12), h in 0.5f64..2.0) {
        let mut at = vec![DVec3::ZERO];
        let mut angle = 0.0f64;
        for t in &turns {
            angle += t;
            let p = at[at.len() - 1] + 0.2 * DVec3::new(angle.cos(), angle.sin(), 0.0);
            at.push(p);
        }
        let n = (h / 0.2).round() as u32;
        let f = shapes::grid(12, n, (false, false), |s, t| {
            at[(12.0 * s).round() as usize] + DVec3::new(0.0, 0.0, h * t)
        });
        let l = shapes::boundary(&f, 1);
        let m = mesh_face(&input(&f, &l), &Options::default()).expect("a sound face");
        prop_assert!(matches!(m.report.flattening, Flattening::Unrolled | Flattening::Plane));
        prop_assert!(m.report.anisotropy < 1.0 + 1e-6 && m.report.scale_range < 1.0 + 1e-6);
        prop_assert_eq!(m.report.quality.n_nonpositive, 0);
    }

    /// A rough patch is meshed, or refused with an error; what is meshed conforms (the certificate) and
    /// covers the area.
    #[test]
    fn rough_patches_are_meshed_or_refused(
        z in prop::collection::vec(-1.0f64..1.0, 81),
        rough in 0.0f64..0.6,
        closed in 0usize..3,
    ) {
        let f = shapes::grid(8, 8, (closed > 0, closed > 1), |s, t| {
            let k = (8.0 * t).round() as usize * 9 + (8.0 * s).round() as usize;
            let (a, b) = (std::f64::consts::TAU * s, std::f64::consts::TAU * t);
            let bump = 0.3 * rough * z[k];
            match closed {
                0 => DVec3::new(s, t, bump),
                1 => DVec3::new((1.0 + bump) * a.cos(), (1.0 + bump) * a.sin(), 3.0 * t),
                _ => {
                    let r = 3.0 + (1.0 + bump) * b.cos();
                    DVec3::new(r * a.cos(), r * a.sin(), (1.0 + bump) * b.sin())
                }
            }
        });
        let l = shapes::boundary(&f, 1);
        let i = FaceInput { size: if closed == 2 { FaceSize::Uniform(0.5) } else { FaceSize::Boundary }, ..input(&f, &l) };
        let m = mesh_face(&i, &Options::default());
        if let Ok(m) = &m {
            prop_assert!(m.quads.len() > 4);
        } else {
            prop_assert!(rough > 0.05, "{:?}", m);
        }
    }

    /// Broken facets never panic.
    #[test]
    fn mutated_facets_do_not_panic(
        hits in prop::collection::vec((0usize..128, 0usize..3, 0u32..100), 0..6),
        moves in prop::collection::vec((0usize..81, -2.0f64..2.0), 0..6),
        drop in prop::collection::vec(0usize..128, 0..3),
    ) {
        let mut f = shapes::grid(8, 8, (false, false), |s, t| DVec3::new(s, t, 0.3 * (5.0 * s).sin() * t));
        let l = shapes::boundary(&f, 1);
        for (t, k, v) in hits {
            f.triangles[t][k] = v;
        }
        for (v, d) in moves {
            f.points[v] += DVec3::new(d, -d, 0.5 * d);
        }
        for t in drop {
            if t < f.triangles.len() {
                f.triangles.swap_remove(t);
            }
        }
        let made = mesh_face(&input(&f, &l), &Options::default());
        let ours = matches!(made, Err(FaceError::Internal { .. }));
        prop_assert!(!ours, "{:?}", made);
    }
}

/// A corner drawn out to a spike, found by the test above: a cut along it leaves no room for two quads side by side, and
/// that is no fault of ours.
#[test]
fn both_sides_of_a_cut_in_one_quad_are_told() {
    let mut f = shapes::grid(8, 8, (false, false), |s, t| DVec3::new(s, t, 0.3 * (5.0 * s).sin() * t));
    let l = shapes::boundary(&f, 1);
    for (v, d) in [(64, -1.6521438680217309), (35, 0.7041467967564622)] {
        f.points[v] += DVec3::new(d, -d, 0.5 * d);
    }
    match mesh_face(&input(&f, &l), &Options::default()) {
        Ok(m) => assert_eq!(m.report.quality.n_nonpositive, 0),
        Err(e) => assert!(matches!(e, FaceError::TooThin { at } if at.x < 0.0), "{e:?}"),
    }
}
