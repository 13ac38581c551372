//! Every mesh format: what is written is read back, and broken files are errors, never panics.

use csalf_geom::{Point2, QuadId, VertexId};
use csalf_io::{
    CellData, MeshData, MeshFormat, MidNodes, WriteOptions, read_mesh_bytes, write_mesh, write_mesh_with,
};
use csalf_mesh::{NamedSets, QuadMesh};
use proptest::prelude::*;

const READ: [MeshFormat; 6] = [
    MeshFormat::Vtu,
    MeshFormat::Msh41,
    MeshFormat::Msh22,
    MeshFormat::Inp,
    MeshFormat::Bdf,
    MeshFormat::Obj,
];

/// A grid of quads and one triangle at a corner, with coordinates of many digits and sets of every kind.
fn sample(nx: usize, ny: usize) -> MeshData {
    let v = |i: usize, j: usize| VertexId::new(j * (nx + 1) + i);
    let mut mesh = QuadMesh::default();
    for j in 0..=ny {
        for i in 0..=nx {
            mesh.points.push(Point2::new(i as f64 / 3.0 - 1e-7 * j as f64, j as f64 / 7.0 + 0.1 * i as f64));
        }
    }
    for j in 0..ny {
        for i in 0..nx {
            mesh.quads.push([v(i, j), v(i + 1, j), v(i + 1, j + 1), v(i, j + 1)]);
        }
    }
    mesh.points.push(Point2::new(-0.3, 1e-3));
    mesh.triangles.push([v(0, 0), v(0, 1), VertexId::new(mesh.points.len() - 1)]);
    let sets = NamedSets {
        nodes: vec![("spot".into(), vec![v(1, 1)])],
        edges: vec![("outer".into(), (0..nx).map(|i| [v(i, 0), v(i + 1, 0)]).collect())],
        quads: vec![("layer0".into(), (0..nx).map(QuadId::new).collect()), ("q".into(), vec![QuadId(1)])],
    };
    let values = (0..mesh.quads.len() + 1).map(|i| i as f64 / 9.0).collect();
    MeshData {
        mesh,
        heights: vec![],
        sets,
        cell_data: vec![CellData { name: "size".into(), values }],
        notes: vec![],
    }
}

fn written(format: MeshFormat, data: &MeshData) -> Vec<u8> {
    let mut out = Vec::new();
    write_mesh(format, &data.view("sample"), &mut out).unwrap();
    out
}

#[test]
fn meshes_come_back() {
    let data = sample(3, 2);
    for format in READ {
        let back = read_mesh_bytes(format, &written(format, &data)).unwrap();
        assert_eq!(back.notes, Vec::<String>::new(), "{format:?}");
        assert_eq!(back.mesh.quads, data.mesh.quads, "{format:?}");
        assert_eq!(back.mesh.triangles, data.mesh.triangles, "{format:?}");
        for (a, b) in back.mesh.points.iter().zip(&data.mesh.points) {
            if format == MeshFormat::Bdf {
                assert!(a.distance(*b) <= 1e-11 * b.length(), "{a} {b}");
            } else {
                assert_eq!(a.to_array().map(f64::to_bits), b.to_array().map(f64::to_bits), "{format:?}");
            }
        }
    }
}

/// The files themselves, to be looked at when a writer changes: other programs must read them.
#[test]
fn the_text_formats_are_as_reviewed() {
    let mut data = sample(2, 1);
    data.sets.nodes[0].1 = vec![VertexId(4)];
    for format in READ.into_iter().filter(|&f| f != MeshFormat::Vtu) {
        insta::assert_snapshot!(format.name(), String::from_utf8(written(format, &data)).unwrap());
    }
}

#[test]
fn sets_come_back_as_far_as_the_format_has_them() {
    let data = sample(3, 2);
    let read = |f| read_mesh_bytes(f, &written(f, &data)).unwrap();
    assert_eq!(read(MeshFormat::Vtu), data);
    assert_eq!(read(MeshFormat::Msh41).sets, data.sets);
    // Gmsh 2.2 keeps one group per element: quad 1 is in the first of its two sets only.
    let msh22 = read(MeshFormat::Msh22).sets;
    assert_eq!((&msh22.nodes, &msh22.edges), (&data.sets.nodes, &data.sets.edges));
    assert_eq!(msh22.quads, data.sets.quads[..1]);
    let outer: Vec<VertexId> = (0..4).map(VertexId).collect();
    for f in [MeshFormat::Inp, MeshFormat::Bdf] {
        let sets = read(f).sets;
        assert_eq!(sets.nodes, [data.sets.nodes[0].clone(), ("outer".into(), outer.clone())]);
        assert_eq!(sets.quads, data.sets.quads);
    }
    let obj = read(MeshFormat::Obj).sets;
    assert_eq!((obj.edges, obj.quads), (data.sets.edges, data.sets.quads));
}

/// Corners, elements and sets as of the first order; what lies between is left out, and that is said.
#[test]
fn elements_of_second_order_come_back_straight() {
    let data = sample(3, 2);
    for (format, centres) in [
        (MeshFormat::Vtu, false),
        (MeshFormat::Vtu, true),
        (MeshFormat::Msh41, false),
        (MeshFormat::Msh41, true),
        (MeshFormat::Msh22, true),
        (MeshFormat::Inp, false),
        (MeshFormat::Bdf, false),
        (MeshFormat::Bdf, true),
    ] {
        let mid = MidNodes::new(&data.mesh, centres);
        let how = WriteOptions { mid: Some(&mid), ..WriteOptions::default() };
        let mut bytes = Vec::new();
        write_mesh_with(format, &data.view("sample"), &how, &mut bytes).unwrap();
        let back = read_mesh_bytes(format, &bytes).unwrap();
        let first = read_mesh_bytes(format, &written(format, &data)).unwrap();
        assert_eq!((&back.mesh, &back.cell_data), (&first.mesh, &first.cell_data), "{format:?}");
        assert_eq!(back.sets.quads, first.sets.quads, "{format:?}");
        assert_eq!(back.sets.nodes, first.sets.nodes, "{format:?}");
        let said = format!("{} nodes between corners", mid.n_nodes());
        assert!(back.notes.len() == 1 && back.notes[0].starts_with(&said), "{format:?}: {:?}", back.notes);
    }
}

/// Blank fields stand for nodes that are not there; a node that is a corner elsewhere stays.
#[test]
fn middles_may_be_missing_or_shared() {
    let grid = |k: u32, x: f64, y: f64| format!("GRID,{k},,{x},{y},0.\n");
    let nodes: String =
        [(1, 0., 0.), (2, 2., 0.), (3, 2., 1.), (4, 0., 1.), (5, 1., 0.), (6, 1., -1.), (7, 0., -1.)]
            .map(|(k, x, y)| grid(k, x, y))
            .concat();
    let text = format!("BEGIN BULK\n{nodes}CQUAD8,1,1,1,2,3,4,5,\n,,,\nCQUAD4,2,1,7,6,5,1\nENDDATA\n");
    let back = read_mesh_bytes(MeshFormat::Bdf, text.as_bytes()).unwrap();
    assert_eq!(back.mesh.quads, [[0, 1, 2, 3], [6, 5, 4, 0]].map(|q| q.map(VertexId)));
    assert_eq!((back.mesh.points.len(), back.notes.len()), (7, 0));
}

#[test]
fn an_empty_mesh_is_written_and_read() {
    let data = MeshData::default();
    for format in READ {
        let back = read_mesh_bytes(format, &written(format, &data)).unwrap();
        assert_eq!(back.mesh, data.mesh, "{format:?}");
    }
}

#[test]
fn meshes_in_space_come_back() {
    let mut data = sample(3, 2);
    data.heights = (0..data.mesh.n_vertices()).map(|i| f64::from(i as u32).sin()).collect();
    for format in READ {
        let back = read_mesh_bytes(format, &written(format, &data)).unwrap();
        assert_eq!(back.mesh.quads, data.mesh.quads, "{format:?}");
        assert_eq!(back.heights.len(), data.heights.len(), "{format:?}");
        for (a, b) in back.heights.iter().zip(&data.heights) {
            assert!(
                (a - b).abs() <= if format == MeshFormat::Bdf { 1e-11 } else { 0.0 },
                "{format:?} {a} {b}"
            );
        }
        let e = back.planar(format.name()).unwrap_err();
        assert!(e.to_string().contains("not planar"), "{e}");
    }
}

#[test]
fn nodes_that_are_not_there_are_told() {
    let e = read_mesh_bytes(MeshFormat::Obj, b"v 0 0 0\nv 1 0 0\nf 1 2 3\n").unwrap_err();
    assert!(e.to_string().contains("line 3") && e.to_string().contains("node 3"), "{e}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Cut off, with bytes changed or taken out: a value or an error, never a panic.
    #[test]
    fn broken_files_do_not_panic(
        which in 0usize..6,
        cut in 0.0f64..1.0,
        changes in prop::collection::vec((0.0f64..1.0, any::<u8>()), 0..6),
        remove in 0usize..4,
    ) {
        let mut bytes = written(READ[which], &sample(2, 2));
        for (at, byte) in changes {
            let k = (at * bytes.len() as f64) as usize;
            bytes[k] = byte;
        }
        let k = (cut * bytes.len() as f64) as usize;
        if remove == 0 { bytes.truncate(k) } else { bytes.drain(k..(k + remove).min(bytes.len())); }
        let _ = read_mesh_bytes(READ[which], &bytes);
    }

    /// Any bytes at all.
    #[test]
    fn noise_does_not_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        for format in READ {
            let _ = read_mesh_bytes(format, &bytes);
        }
    }
}
