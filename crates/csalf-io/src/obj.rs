//! Wavefront OBJ. Quad sets are groups (`g`), edge sets are lines (`l`) in groups; node sets are not kept.

use crate::{
    IoError, MeshData, MeshView, Place,
    builder::Builder,
    text::{Cursor, Num, one_line},
};
use std::io::Write;

const FORMAT: &str = "OBJ";

/// A name as a group: one word.
fn word(name: &str) -> String {
    one_line(name).replace(char::is_whitespace, "_")
}

/// Writes a mesh.
///
/// # Errors
/// [`IoError::Write`].
pub fn write(out: &MeshView<'_>, w: &mut dyn Write) -> Result<(), IoError> {
    writeln!(w, "# {}", one_line(out.title))?;
    for [x, y, z] in out.xyz() {
        let z = if z == 0.0 { "0".to_owned() } else { Num(z).to_string() };
        writeln!(w, "v {} {} {z}", Num(x), Num(y))?;
    }
    let mut groups = vec![Vec::new(); out.mesh.quads.len()];
    for (k, (_, quads)) in out.sets.quads.iter().enumerate() {
        for q in quads.iter().filter(|q| q.index() < out.mesh.quads.len()) {
            groups[q.index()].push(k);
        }
    }
    let mut last: Option<&[usize]> = None;
    for (q, mine) in out.mesh.quads.iter().zip(&groups) {
        if !out.sets.quads.is_empty() && last != Some(mine) {
            let names: Vec<String> = mine.iter().map(|&k| word(&out.sets.quads[k].0)).collect();
            let names = if names.is_empty() { "domain".to_owned() } else { names.join(" ") };
            writeln!(w, "g {names}")?;
            last = Some(mine);
        }
        writeln!(w, "f {} {} {} {}", q[0].0 + 1, q[1].0 + 1, q[2].0 + 1, q[3].0 + 1)?;
    }
    if !out.sets.quads.is_empty() && !out.mesh.triangles.is_empty() {
        writeln!(w, "g domain")?;
    }
    for t in &out.mesh.triangles {
        writeln!(w, "f {} {} {}", t[0].0 + 1, t[1].0 + 1, t[2].0 + 1)?;
    }
    for (name, edges) in &out.sets.edges {
        writeln!(w, "g {}", word(name))?;
        for e in edges {
            writeln!(w, "l {} {}", e[0].0 + 1, e[1].0 + 1)?;
        }
    }
    Ok(())
}

/// Reads the vertices, faces, lines and groups of a planar mesh.
///
/// # Errors
/// [`IoError::Syntax`]; [`IoError::Unsupported`] for faces of more than four corners and free-form geometry.
pub fn read(bytes: &[u8]) -> Result<MeshData, IoError> {
    let mut text = Cursor::new(bytes, FORMAT);
    let mut out = Builder::new(FORMAT, Place::Line);
    let mut groups: Vec<usize> = Vec::new();
    let mut n_lines = 0;
    while let Some(line) = text.line() {
        n_lines += 1;
        let fail = |m: String| IoError::syntax(FORMAT, Place::Line(n_lines), m);
        let line = String::from_utf8_lossy(line);
        let line = line.split('#').next().unwrap_or("");
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                let mut xyz = [0.0; 3];
                for (k, w) in words.take(3).enumerate() {
                    xyz[k] = w.parse().map_err(|_| fail(format!("{w:?} is not a coordinate")))?;
                }
                out.node(out.n_nodes() as u64 + 1, xyz, n_lines)?;
            }
            Some(kind @ ("f" | "l")) => {
                let mut corners = Vec::new();
                for w in words {
                    let index = w.split('/').next().unwrap_or("");
                    let i: i64 = index.parse().map_err(|_| fail(format!("{w:?} is not a vertex")))?;
                    // Negative numbers count back from the last vertex.
                    let i = if i < 0 { i + out.n_nodes() as i64 + 1 } else { i };
                    corners.push(u64::try_from(i).map_err(|_| fail(format!("there is no vertex {w}")))?);
                }
                let ok = if kind == "f" { matches!(corners.len(), 3 | 4) } else { corners.len() >= 2 };
                if !ok {
                    let message = format!("an element with {} corners", corners.len());
                    return Err(IoError::unsupported(FORMAT, Place::Line(n_lines), message));
                }
                for part in corners.windows(if kind == "f" { corners.len() } else { 2 }) {
                    let number = out.n_elements() as u64;
                    out.element(number, part, n_lines);
                    for &g in &groups {
                        out.element_sets[g].1.push(number);
                    }
                }
            }
            Some("g") => {
                groups.clear();
                for name in words.filter(|&n| n != "domain") {
                    let known = out.element_sets.iter().position(|s| s.0 == name);
                    groups.push(known.unwrap_or_else(|| {
                        out.element_sets.push((name.to_owned(), Vec::new()));
                        out.element_sets.len() - 1
                    }));
                }
            }
            Some("curv" | "surf" | "cstype") => {
                return Err(IoError::unsupported(FORMAT, Place::Line(n_lines), "free-form geometry"));
            }
            _ => {}
        }
    }
    out.finish()
}
