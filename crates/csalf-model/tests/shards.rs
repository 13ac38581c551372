//! A model in shards gives the same mesh as in one piece; wrong sets of shards are refused, each by its name.

use csalf_model::shapes::{circle, closed_surface, extrude, rectangle};
use csalf_model::shard::{Shard, ShardError, Stitched, stitch};
use csalf_model::{LayerSpec, Model, ModelMesh, ModelOptions, Prepared, SizeRules, mesh_model};
use glam::{DVec2, DVec3};
use std::borrow::Cow;

fn plate() -> Model {
    let holes = [(2.0, 2.0, 0.7), (6.0, 3.0, 1.2), (9.0, 1.5, 0.5)];
    let mut outlines = vec![rectangle(11.0, 5.0)];
    outlines.extend(holes.map(|(x, y, r)| vec![circle(DVec2::new(x, y), r).reversed()]));
    extrude(&outlines, 1.0)
}

fn options(size: f64) -> ModelOptions {
    ModelOptions {
        size: Some(SizeRules::of(size)),
        layers: vec![("hole*".into(), LayerSpec { count: 2, ..LayerSpec::default() })],
        points: vec![("spot".into(), DVec3::new(4.0, 1.0, 1.1))],
        ..ModelOptions::default()
    }
}

fn named(shard: &Shard, name: &str) -> Shard {
    let mut copy = shard.clone();
    copy.name = name.into();
    copy
}

/// Shards, each through the bytes of its file.
fn shards(model: &Model, options: &ModelOptions, count: u32) -> Vec<Shard> {
    (1..=count)
        .map(|k| {
            // A process of its own prepares for itself.
            let shard = Prepared::new(Cow::Borrowed(model), options).shard(k, count, &()).unwrap();
            Shard::from_bytes(&format!("part{k}"), &shard.to_bytes().unwrap()).unwrap()
        })
        .collect()
}

fn same(a: &ModelMesh, b: &ModelMesh) {
    let bits = |m: &ModelMesh| -> Vec<[u64; 3]> {
        m.mesh.points.iter().map(|p| p.to_array().map(f64::to_bits)).collect()
    };
    assert_eq!(bits(a), bits(b));
    assert_eq!(a.mesh.quads, b.mesh.quads);
    assert_eq!(a.sets, b.sets);
    assert_eq!(a.face_of_quad, b.face_of_quad);
    assert_eq!(a.warnings, b.warnings);
    assert_eq!(a.layers, b.layers);
    assert_eq!((a.n_free_sides, a.n_branching_sides), (b.n_free_sides, b.n_branching_sides));
    let said = |m: &ModelMesh| -> Vec<_> {
        m.failures.iter().map(|f| (f.face, f.name.clone(), f.message.clone(), f.case.clone())).collect()
    };
    assert_eq!(said(a), said(b));
}

#[test]
fn shards_give_the_mesh_of_one_process() {
    let (model, options) = (plate(), options(0.4));
    let whole = mesh_model(&model, &options);
    assert!(whole.failures.is_empty() && !whole.layers.is_empty() && whole.sets.nodes.len() == 1);
    // More parts than faces: some are empty.
    for count in [1, 2, 3, 40] {
        let mut parts = shards(&model, &options, count);
        parts.reverse();
        let Stitched { name, faces, mesh } = stitch(parts).unwrap();
        assert_eq!((name.as_str(), faces.len()), ("extrusion", model.faces.len()));
        same(&whole, &mesh);
    }
}

#[test]
fn failures_and_hopeless_models_come_through() {
    // A frozen odd face fails and leaves its flat boundary.
    let model = extrude(&[rectangle(4.0, 3.0)], 1.0);
    let counts = ["bottom0_0", "bottom0_1", "bottom0_2", "bottom0_3"];
    let counts = counts.iter().zip([5, 4, 4, 4]).map(|(n, k)| ((*n).to_owned(), k)).collect();
    let odd = ModelOptions { counts, ..options(0.5) };
    let whole = mesh_model(&model, &odd);
    assert!(!whole.failures.is_empty());
    same(&whole, &stitch(shards(&model, &odd, 3)).unwrap().mesh);
    for (model, size) in [(Model::default(), 1.0), (plate(), 1e-9), (plate(), -1.0)] {
        let whole = mesh_model(&model, &options(size));
        assert!(whole.mesh.quads.is_empty());
        same(&whole, &stitch(shards(&model, &options(size), 2)).unwrap().mesh);
    }
    let ball =
        csalf_model::geometry::Surface::Sphere { frame: csalf_model::geometry::Frame::WORLD, radius: 1.0 };
    let whole = mesh_model(&closed_surface(ball.clone()), &options(0.3));
    assert!(whole.failures.is_empty());
    same(&whole, &stitch(shards(&closed_surface(ball), &options(0.3), 2)).unwrap().mesh);
}

#[test]
fn parts_cover_all_faces_and_are_balanced() {
    let (model, options) = (plate(), options(0.1));
    let prepared = Prepared::new(Cow::Borrowed(&model), &options);
    let parts = prepared.parts(3);
    let mut all: Vec<usize> = parts.concat();
    all.sort_unstable();
    assert_eq!(all, (0..model.faces.len()).collect::<Vec<_>>());
    // The two caps have most quads: they are in different parts.
    let caps = [model.faces.len() - 2, model.faces.len() - 1];
    assert!(!parts.iter().any(|p| p.contains(&caps[0]) && p.contains(&caps[1])));
    assert!(prepared.shard(0, 3, &()).is_none() && prepared.shard(4, 3, &()).is_none());
}

#[test]
fn wrong_sets_of_shards_are_refused() {
    let model = plate();
    let parts = shards(&model, &options(0.8), 4);
    let refused = |s: Vec<Shard>| stitch(s).unwrap_err();
    assert_eq!(refused(vec![]), [ShardError::Nothing]);
    let missing = |first, last| ShardError::Missing { first, last, count: 4 };
    assert_eq!(refused(vec![parts[1].clone()]), [missing(1, 1), missing(3, 4)]);
    assert_eq!(missing(3, 4).to_string(), "shards 3 to 4 of 4 missing");
    let twice = [parts.clone(), vec![named(&parts[2], "copy")]].concat();
    let copy = ShardError::Duplicate { index: 3, first: "part3".into(), second: "copy".into() };
    assert_eq!(refused(twice), [copy]);
    // Another size, another model, another number of parts.
    let mut other = plate();
    other.faces[3].name = "renamed".into();
    for strange in [
        shards(&model, &options(0.7), 4)[1].clone(),
        shards(&other, &options(0.8), 4)[1].clone(),
        shards(&model, &options(0.8), 5)[1].clone(),
    ] {
        let mixed = vec![parts[0].clone(), named(&strange, "x"), parts[2].clone()];
        assert_eq!(refused(mixed), [ShardError::Foreign { name: "x".into(), other: "part1".into() }]);
    }
}

#[test]
fn damaged_files_are_refused() {
    let prepared_model = plate();
    let bytes = shards(&prepared_model, &options(0.8), 2)[0].to_bytes().unwrap();
    let read = |b: &[u8]| Shard::from_bytes("f", b).unwrap_err();
    assert_eq!(read(b"solid part"), ShardError::NotAShard { name: "f".into() });
    assert_eq!(read(b""), ShardError::NotAShard { name: "f".into() });
    let mut newer = bytes.clone();
    newer[12] = 9;
    assert_eq!(read(&newer), ShardError::Version { name: "f".into(), found: 9, known: 1 });
    let damaged = |b: &[u8]| matches!(read(b), ShardError::Damaged { .. });
    for n in [5, 14, 30, 41, bytes.len() - 1] {
        assert!(damaged(&bytes[..n]), "{n}");
    }
    // Every single byte counts.
    for at in (16..bytes.len()).step_by(97) {
        let mut b = bytes.clone();
        b[at] ^= 0x10;
        assert!(damaged(&b), "{at}");
    }
    assert!(damaged(&[bytes.as_slice(), b"x"].concat()));
}
