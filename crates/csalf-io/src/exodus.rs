//! Exodus II (`.exo`, `.e`), written: one block of quads and one of triangles, node sets, side sets (of edge sets) and
//! element sets (of quad sets), all by name; classic netCDF with 64-bit offsets. With mid-side nodes the blocks are
//! QUAD8 or QUAD9 and TRI6; in space they are shells, SHELL4 to SHELL9, whose sides 1 and 2 are their faces. Source:
//! L. A. Schoof, V. R. Yarberry, *EXODUS II: A Finite Element Data Model*, SAND92-2137 (1994), and its later additions.

use crate::netcdf::{File, Values};
use crate::sides::Sides;
use crate::text::one_line;
use crate::{IoError, MeshView, MidNodes, Place, inp};
use std::io::Write;

const FORMAT: &str = "Exodus II";

/// Characters of a name, with the zero at its end.
const NAME: usize = 33;

/// Writes a mesh; with mid-side nodes quadratic elements.
///
/// # Errors
/// [`IoError::Write`]; [`IoError::Unsupported`] of more than 2³¹ nodes or corners.
pub fn write(out: &MeshView<'_>, mid: Option<&MidNodes>, w: &mut dyn Write) -> Result<(), IoError> {
    let mesh = out.mesh;
    let points: Vec<[f64; 3]> = out.all_xyz(mid).collect();
    // Of a shell, sides 1 and 2 are its faces.
    let (along, quad, triangle, first_side) = if out.heights.is_empty() {
        (&["x", "y"][..], "QUAD", "TRI", 0)
    } else {
        (&["x", "y", "z"][..], "SHELL", "TRISHELL", 2)
    };
    let (nq, nt) = (mesh.quads.len(), mesh.triangles.len());
    if i32::try_from(9 * nq + 6 * nt).is_err() || i32::try_from(points.len()).is_err() {
        return Err(IoError::unsupported(FORMAT, Place::Whole, "the mesh needs more than 31 bits"));
    }
    let mut f = File::default();
    f.attribute("api_version", Values::Float(vec![5.0]));
    f.attribute("version", Values::Float(vec![5.0]));
    f.attribute("floating_point_word_size", Values::Int(vec![8]));
    f.attribute("file_size", Values::Int(vec![1]));
    let title: String = one_line(out.title).chars().filter(char::is_ascii).take(80).collect();
    f.attribute("title", Values::Text(if title.is_empty() { b"mesh".to_vec() } else { title.into_bytes() }));
    let name = f.dimension("len_name", NAME);
    let time = f.dimension("time_step", 0);
    let axes = f.dimension("num_dim", along.len());
    let n_nodes = f.dimension("num_nodes", points.len());
    f.dimension("num_elem", nq + nt);

    let ids = |v: &[csalf_geom::VertexId]| v.iter().map(|v| v.0 as i32 + 1).collect::<Vec<i32>>();
    let mut blocks: Vec<(&str, String, usize, Vec<i32>)> = Vec::new();
    if nq > 0 {
        let k = mid.map_or(4, |m| if m.has_centres() { 9 } else { 8 });
        let nodes = mesh
            .quads
            .iter()
            .enumerate()
            .flat_map(|(i, q)| mid.map_or_else(|| ids(q), |m| ids(&m.quad(i, q))));
        blocks.push(("quads", format!("{quad}{k}"), k, nodes.collect()));
    }
    if nt > 0 {
        let k = if mid.is_some() { 6 } else { 3 };
        let nodes = mesh.triangles.iter().flat_map(|t| mid.map_or_else(|| ids(t), |m| ids(&m.triangle(t))));
        blocks.push(("triangles", format!("{triangle}{k}"), k, nodes.collect()));
    }
    let n_blocks = f.dimension("num_el_blk", blocks.len());
    f.variable("time_whole", &[time], None, Values::Double(Vec::new()));
    list(&mut f, "eb", &blocks.iter().map(|b| b.0).collect::<Vec<_>>(), n_blocks, name);
    for (k, axis) in along.iter().enumerate() {
        let values = points.iter().map(|p| p[k]).collect();
        f.variable(format!("coord{axis}"), &[n_nodes], None, Values::Double(values));
    }
    let names_of_axes = along.iter().flat_map(|a| padded(a)).collect();
    f.variable("coor_names", &[axes, name], None, Values::Text(names_of_axes));
    for (b, (_, kind, k, nodes)) in blocks.into_iter().enumerate() {
        let rows = f.dimension(format!("num_el_in_blk{}", b + 1), nodes.len() / k);
        let columns = f.dimension(format!("num_nod_per_el{}", b + 1), k);
        f.variable(
            format!("connect{}", b + 1),
            &[rows, columns],
            Some(("elem_type", &kind)),
            Values::Int(nodes),
        );
    }

    let node_sets = inp::node_sets(out, mid);
    sets(&mut f, ("num_node_sets", "ns"), &node_sets, name, |f, k, nodes: &Vec<u32>| {
        let n = f.dimension(format!("num_nod_ns{k}"), nodes.len());
        f.variable(
            format!("node_ns{k}"),
            &[n],
            None,
            Values::Int(nodes.iter().map(|&v| v as i32 + 1).collect()),
        );
    });
    let all = Sides::new(mesh);
    let sides: Vec<(String, Vec<crate::sides::Side>)> = out
        .sets
        .edges
        .iter()
        .map(|(name, edges)| (name.clone(), edges.iter().filter_map(|&e| all.between(e)).collect()))
        .collect();
    sets(&mut f, ("num_side_sets", "ss"), &sides, name, |f, k, sides: &Vec<crate::sides::Side>| {
        let n = f.dimension(format!("num_side_ss{k}"), sides.len());
        let ints = |g: &dyn Fn(&crate::sides::Side) -> usize| {
            Values::Int(sides.iter().map(|s| g(s) as i32 + 1).collect())
        };
        f.variable(format!("elem_ss{k}"), &[n], None, ints(&|s| s.element));
        f.variable(format!("side_ss{k}"), &[n], None, ints(&|s| s.side + first_side));
    });
    let quads: Vec<(String, Vec<u32>)> =
        out.sets.quads.iter().map(|(n, q)| (n.clone(), q.iter().map(|q| q.0).collect())).collect();
    sets(&mut f, ("num_elem_sets", "els"), &quads, name, |f, k, quads: &Vec<u32>| {
        let n = f.dimension(format!("num_ele_els{k}"), quads.len());
        f.variable(
            format!("elem_els{k}"),
            &[n],
            None,
            Values::Int(quads.iter().map(|&q| q as i32 + 1).collect()),
        );
    });
    f.write(w)
}

/// Sets that are not empty: their list, then `each` with numbers from 1.
fn sets<T>(
    f: &mut File,
    (dimension, stem): (&str, &str),
    all: &[(String, Vec<T>)],
    name: usize,
    each: impl Fn(&mut File, usize, &Vec<T>),
) {
    let all: Vec<&(String, Vec<T>)> = all.iter().filter(|s| !s.1.is_empty()).collect();
    if all.is_empty() {
        return;
    }
    let n = f.dimension(dimension, all.len());
    list(f, stem, &all.iter().map(|s| s.0.as_str()).collect::<Vec<_>>(), n, name);
    for (k, (_, members)) in all.into_iter().enumerate() {
        each(f, k + 1, members);
    }
}

/// Status, numbers and names of blocks or sets.
fn list(f: &mut File, stem: &str, names: &[&str], n: usize, name: usize) {
    let count = names.len() as i32;
    f.variable(format!("{stem}_status"), &[n], None, Values::Int(vec![1; names.len()]));
    f.variable(format!("{stem}_prop1"), &[n], Some(("name", "ID")), Values::Int((1..=count).collect()));
    f.variable(
        format!("{stem}_names"),
        &[n, name],
        None,
        Values::Text(names.iter().flat_map(|n| padded(n)).collect()),
    );
}

/// A name with zeros behind it; what is too long is cut.
fn padded(name: &str) -> Vec<u8> {
    let mut out: Vec<u8> = one_line(name).bytes().take(NAME - 1).collect();
    out.resize(NAME, 0);
    out
}
