//! Writes a small mesh in every format: `cargo run -p csalf-io --example all_formats -- DIR`.

use csalf_geom::{Point2, QuadId, VertexId};
use csalf_io::{CellData, IoError, MeshFormat, MeshView, write_mesh};
use csalf_mesh::{NamedSets, QuadMesh};
use std::path::PathBuf;

fn main() -> Result<(), IoError> {
    let dir = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| ".".into()));
    let side: usize = std::env::args().nth(2).and_then(|s| s.parse().ok()).unwrap_or(4);
    let (mesh, sets) = grid(side);
    let layer: Vec<f64> = (0..mesh.quads.len() + mesh.triangles.len()).map(|i| (i % 3) as f64).collect();
    let cell_data = [CellData { name: "layer".into(), values: layer }];
    let view =
        MeshView { mesh: &mesh, heights: &[], sets: &sets, cell_data: &cell_data, title: "a sheared grid" };
    for &format in MeshFormat::ALL {
        let path = dir.join(format!("grid_{}.{}", format.name(), format.extensions()[0]));
        let file = std::fs::File::create(&path).map_err(IoError::Write)?;
        write_mesh(format, &view, &mut std::io::BufWriter::new(file))?;
    }
    Ok(())
}

/// A grid of n by n quads, one corner quad replaced by a triangle, with sets of every kind.
fn grid(n: usize) -> (QuadMesh, NamedSets) {
    let v = |i: usize, j: usize| VertexId::new(j * (n + 1) + i);
    let at = |k: usize| {
        let (i, j) = ((k % (n + 1)) as f64, (k / (n + 1)) as f64);
        Point2::new(i / 3.0 + 0.1 * j, j / 7.0 - 0.02 * (i * j) / n as f64)
    };
    let mut mesh = QuadMesh { points: (0..(n + 1) * (n + 1)).map(at).collect(), ..QuadMesh::default() };
    for j in 0..n {
        for i in 0..n {
            if i + j + 2 < 2 * n {
                mesh.quads.push([v(i, j), v(i + 1, j), v(i + 1, j + 1), v(i, j + 1)]);
            }
        }
    }
    mesh.triangles.push([v(n - 1, n - 1), v(n, n - 1), v(n - 1, n)]);
    mesh.points.pop();
    let bottom = (0..n).map(|i| [v(i, 0), v(i + 1, 0)]).collect();
    let sets = NamedSets {
        nodes: vec![
            ("bottom".into(), (0..=n).map(|i| v(i, 0)).collect()),
            ("a corner".into(), vec![v(0, 0)]),
        ],
        edges: vec![("bottom".into(), bottom)],
        quads: vec![("row 0".into(), (0..n).map(QuadId::new).collect())],
    };
    (mesh, sets)
}
