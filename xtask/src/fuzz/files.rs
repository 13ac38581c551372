//! Sound files to begin with: a STEP file of the tests, and facets made by formula.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// A file without faults.
pub(super) struct Sound {
    /// Its name, with the extension.
    pub(super) name: String,
    pub(super) bytes: Vec<u8>,
    /// Lines and words, not bytes, are changed.
    pub(super) is_text: bool,
}

/// Points and triangles.
type Facets = (Vec<[f64; 3]>, Vec<[usize; 3]>);

/// All files, in a fixed order.
pub(super) fn sound(root: &Path, more: Option<&Path>) -> Result<Vec<Sound>, String> {
    let block = root.join("crates/csalf-step/tests/data/block.step");
    let text = |name: &str, bytes: Vec<u8>| Sound { name: name.into(), bytes, is_text: true };
    let read = |p: &Path| fs::read(p).map_err(|e| format!("{}: {e}", p.display()));
    let mut out = vec![text("block.step", read(&block)?)];
    for (name, facets) in [("box", block_facets()), ("tube", tube()), ("bumpy", bumpy()), ("ring", ring())] {
        out.push(text(&format!("{name}.obj"), obj(&facets)));
        out.push(text(&format!("{name}.stl"), stl_text(&facets)));
        out.push(text(&format!("{name}.ply"), ply(&facets)));
        out.push(Sound { name: format!("{name}_binary.stl"), bytes: stl_binary(&facets), is_text: false });
    }
    if let Some(dir) = more {
        let entries = fs::read_dir(dir).map_err(|e| format!("{}: {e}", dir.display()))?;
        let mut paths: Vec<_> = entries.flatten().map(|e| e.path()).collect();
        paths.sort();
        let known = |p: &Path| {
            let extension = p.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
            ["step", "stl", "obj", "ply"].contains(&extension.as_str())
        };
        for p in paths.iter().filter(|p| known(p)) {
            let name = p.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let bytes = read(p)?;
            let is_text = std::str::from_utf8(&bytes).is_ok();
            out.push(Sound { name, bytes, is_text });
        }
    }
    Ok(out)
}

/// A grid of points over (0, 1)², closed in the first direction, in both or in none.
fn grid(n: usize, m: usize, closed: [bool; 2], at: impl Fn(f64, f64) -> [f64; 3]) -> Facets {
    let (rows, columns) = (if closed[1] { m } else { m + 1 }, if closed[0] { n } else { n + 1 });
    let share = |k: usize, n: usize| k as f64 / n as f64;
    let points = (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j)));
    let points = points.map(|(i, j)| at(share(i, n), share(j, m))).collect();
    let id = |i: usize, j: usize| (j % rows) * columns + i % columns;
    let cells = (0..m).flat_map(|j| (0..n).map(move |i| (i, j)));
    let triangles = cells
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    (points, triangles)
}

fn tube() -> Facets {
    grid(12, 3, [true, false], |u, v| [(TAU * u).cos(), (TAU * u).sin(), 3.0 * v])
}

fn bumpy() -> Facets {
    grid(8, 6, [false, false], |u, v| [4.0 * u, 3.0 * v, 0.4 * (5.0 * u).sin() * (4.0 * v).cos()])
}

fn ring() -> Facets {
    grid(14, 8, [true, true], |u, v| {
        let d = 4.0 + 1.5 * (TAU * v).cos();
        [d * (TAU * u).cos(), d * (TAU * u).sin(), 1.5 * (TAU * v).sin()]
    })
}

/// A box of two triangles a side.
fn block_facets() -> Facets {
    let points = (0..8).map(|k| [k & 1, k >> 1 & 1, k >> 2].map(f64::from)).collect();
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    (points, sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
}

fn obj((points, triangles): &Facets) -> Vec<u8> {
    let mut s = String::new();
    for [x, y, z] in points {
        let _ = writeln!(s, "v {x} {y} {z}");
    }
    for [a, b, c] in triangles {
        let _ = writeln!(s, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    s.into_bytes()
}

fn ply((points, triangles): &Facets) -> Vec<u8> {
    let mut s = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        points.len(),
        triangles.len()
    );
    for [x, y, z] in points {
        let _ = writeln!(s, "{x} {y} {z}");
    }
    for [a, b, c] in triangles {
        let _ = writeln!(s, "3 {a} {b} {c}");
    }
    s.into_bytes()
}

fn stl_text((points, triangles): &Facets) -> Vec<u8> {
    let mut s = String::from("solid s\n");
    for t in triangles {
        s.push_str("facet normal 0 0 0\nouter loop\n");
        for [x, y, z] in t.map(|v| points[v]) {
            let _ = writeln!(s, "vertex {x} {y} {z}");
        }
        s.push_str("endloop\nendfacet\n");
    }
    s.push_str("endsolid s\n");
    s.into_bytes()
}

fn stl_binary((points, triangles): &Facets) -> Vec<u8> {
    let mut out = vec![0; 80];
    out.extend((triangles.len() as u32).to_le_bytes());
    for t in triangles {
        out.extend([0; 12]);
        out.extend(t.iter().flat_map(|&v| points[v]).flat_map(|x| (x as f32).to_le_bytes()));
        out.extend([0; 2]);
    }
    out
}
