//! STEP files to models and meshes; broken files to errors.

use csalf_model::brep::{FaceShape, HoleShape, loop_features};
use csalf_model::geometry::Surface;
use csalf_model::{LayerSpec, ModelOptions, SizeRules, check_and_snap, mesh_model};
use csalf_step::{StepError, read};
use glam::DVec2;

/// A face on an OFFSET_SURFACE of a B-spline surface, distance 0.5.
const OFFSET: &str = include_str!("data/offset.step");
const BLOCK: &str = include_str!("data/block.step");

#[test]
fn a_block_with_a_hole() {
    let mut model = read(BLOCK.as_bytes()).expect("a model");
    assert_eq!((model.faces.len(), model.edges.len(), model.vertices.len()), (7, 15, 10));
    assert_eq!((model.name.as_str(), model.bodies.len(), model.bodies[0].solid), ("block", 1, true));
    assert!(model.unit.to_ascii_lowercase().contains("met"), "{}", model.unit);
    let report = check_and_snap(&mut model);
    assert!(report.messages.is_empty(), "{:?}", report.messages);
    let holes = loop_features(&model);
    assert_eq!(holes.len(), 2);
    assert!(holes.iter().all(|h| h.shape == HoleShape::Circle { diameter: 12.0 }));
    let options = ModelOptions {
        size: Some(SizeRules::of(1.5)),
        layers: vec![("hole*".into(), LayerSpec { count: 2, ..LayerSpec::default() })],
        ..ModelOptions::default()
    };
    let mesh = mesh_model(&model, &options);
    assert!(mesh.failures.is_empty(), "{:?}", mesh.failures);
    assert_eq!((mesh.n_free_sides, mesh.n_branching_sides), (0, 0));
    assert!(mesh.layers.len() == 2 && mesh.layers.iter().all(|l| l.made == 2), "{:?}", mesh.layers);
    let names: Vec<&str> = mesh.sets.quads.iter().map(|s| s.0.as_str()).collect();
    assert!(["top", "bore", "hole1_layer1", "hole2_layer2"].iter().all(|n| names.contains(n)), "{names:?}");
}

/// Offsets of free-form surfaces are fitted: as far from the surface as the file says, along its normal.
#[test]
fn an_offset_surface_keeps_its_distance() {
    let surface = |text: &str| {
        let model = read(text.as_bytes()).expect("a model");
        assert!(model.notes.is_empty(), "{:?}", model.notes);
        let FaceShape::Surface(Surface::Nurbs(n), forward) = model.faces[0].shape.clone() else {
            panic!("free form")
        };
        (n, forward)
    };
    // The same face on the surface itself.
    let basis = OFFSET.replace("ADVANCED_FACE('',(#18),#39,", "ADVANCED_FACE('',(#18),#40,");
    assert_ne!(basis, OFFSET);
    let ((offset, a), (basis, b)) = (surface(OFFSET), surface(&basis));
    assert_eq!(a, b);
    let [u, v] = [0, 1].map(|k| basis.knots[k].range());
    for i in 0..=20 {
        for j in 0..=20 {
            let uv = DVec2::new(
                u[0] + (u[1] - u[0]) * f64::from(i) / 20.0,
                v[0] + (v[1] - v[0]) * f64::from(j) / 20.0,
            );
            let (s, p) = (basis.eval(uv), offset.eval(uv).point);
            let wanted = s.point + s.du.cross(s.dv).normalize() * 0.5;
            assert!(p.distance(wanted) < 2e-6, "{uv}: {p} and {wanted}");
        }
    }
    let mut model = read(OFFSET.as_bytes()).expect("a model");
    let report = check_and_snap(&mut model);
    assert!(report.messages.is_empty(), "{:?}", report.messages);
    let mesh = mesh_model(&model, &ModelOptions::default());
    assert!(mesh.failures.is_empty() && mesh.mesh.quads.len() > 100, "{:?}", mesh.failures);
}

/// A face on a surface that cannot be read is a failure of that face, and the others are meshed around it.
#[test]
fn faces_on_unknown_surfaces_are_told() {
    // An offset of itself.
    let text =
        BLOCK.replace("#180=CYLINDRICAL_SURFACE('',#179,6.000000);", "#180=OFFSET_SURFACE('',#180,1.0,.F.);");
    assert_ne!(text, BLOCK);
    let mut model = read(text.as_bytes()).expect("a model");
    let whole = read(BLOCK.as_bytes()).expect("a model");
    assert_eq!((model.faces.len(), model.edges.len()), (whole.faces.len(), whole.edges.len()));
    let unread: Vec<usize> =
        (0..model.faces.len()).filter(|&f| model.faces[f].shape == FaceShape::Unread).collect();
    check_and_snap(&mut model);
    let mesh = mesh_model(&model, &ModelOptions::default());
    assert_eq!(mesh.failures.iter().map(|f| f.face).collect::<Vec<_>>(), unread);
    assert!(!unread.is_empty() && mesh.failures[0].message.contains("not read"), "{:?}", mesh.failures);
    assert!(mesh.face_of_quad.iter().all(|f| !unread.contains(&(*f as usize))) && mesh.n_free_sides > 0);
}

#[test]
fn broken_files_are_errors() {
    assert!(matches!(read(b""), Err(StepError::Syntax(_))));
    assert!(matches!(read(b"ISO-10303-21;"), Err(StepError::Syntax(_))));
    let no_shell = BLOCK.replace("MANIFOLD_SOLID_BREP", "MANIFOLD_SOLID_BRAP");
    assert!(read(no_shell.as_bytes()).is_err());
}

/// Cut off, bytes changed, lines lost: an error or a model, and then a mesh with failures at most.
#[test]
fn mutated_files_never_panic() {
    let mut x = 1_u64;
    let mut next = |n: usize| {
        x = x.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (x >> 33) as usize % n.max(1)
    };
    let options = ModelOptions { size: Some(SizeRules::of(8.0)), ..ModelOptions::default() };
    for round in 0..60 {
        let mut bytes = BLOCK.as_bytes().to_vec();
        match round % 4 {
            0 => bytes.truncate(next(BLOCK.len())),
            1 => {
                for _ in 0..4 {
                    let at = next(bytes.len());
                    bytes[at] = b"0123456789.-#,()'TF"[next(19)];
                }
            }
            2 => {
                let mut lines: Vec<&str> = BLOCK.lines().collect();
                lines.remove(7 + next(lines.len() - 9));
                bytes = lines.join("\n").into_bytes();
            }
            _ => {
                // A number becomes another one.
                let lines: Vec<&str> = BLOCK.lines().collect();
                let at = 7 + next(lines.len() - 9);
                let changed = lines[at]
                    .replace("40.000000", "1E+300")
                    .replace("6.000000", "-6.0")
                    .replace(".T.", ".F.");
                bytes = BLOCK.replacen(lines[at], &changed, 1).into_bytes();
            }
        }
        if let Ok(mut model) = read(&bytes) {
            let tolerance = 1e-6 * model.diagonal();
            csalf_model::sew(&mut model, tolerance);
            check_and_snap(&mut model);
            let mesh = mesh_model(&model, &options);
            assert!(mesh.failures.len() <= model.faces.len());
        }
    }
}
