//! `csalf check`: the quality report of any mesh that can be read, and a gate for scripts.

use crate::args::CheckArgs;
use crate::exit::Failure;
use crate::requirement::Met;
use crate::{files, json, say};
use csalf_geom::VertexId;
use csalf_io::MeshData;
use csalf_mesh::quality::{QualityReport, metrics};
use csalf_mesh::validate::{Expectation, MeshDefect, validate, validate_in_space};
use csalf_mesh::{QuadMesh, digest};
use serde_json::{Map, Value};

/// Most defects printed.
const MAX_DEFECTS: usize = 20;

/// Runs the command.
///
/// # Errors
/// [`Failure::Check`] if the mesh is broken or worse than asked for; [`Failure::Invalid`] and [`Failure::Files`] if
/// it cannot be read.
pub fn run(args: &CheckArgs, level: i32) -> Result<(), Failure> {
    super::with_json(args.json, check(args, level))
}

fn check(args: &CheckArgs, level: i32) -> Result<(), Failure> {
    let shown = files::shown(&args.mesh);
    let format = files::mesh_format(&args.mesh, args.format.as_deref())?;
    let data = files::read_mesh(&args.mesh, format)?;
    if level >= 0 {
        say::warnings(&shown, &data.notes);
    }
    let mesh = &data.mesh;
    if mesh.n_quads() + mesh.triangles.len() == 0 {
        return Err(Failure::Invalid { input: shown, defects: vec!["the mesh has no elements".into()] });
    }
    let in_space = !data.heights.is_empty();
    let mut findings = if in_space { defects_in_space(mesh, &data.heights) } else { defects(mesh) };
    // Figures need indices that exist; without them there is nothing to measure.
    let quality = in_range(mesh).then(|| {
        if in_space {
            QualityReport::in_space(mesh, &data.heights)
        } else {
            QualityReport::new(mesh, None, None)
        }
    });
    if let (Some(q), Some(bound)) = (&quality, args.min_sj)
        && (q.min_sj < bound || q.min_sj.is_nan())
    {
        findings.push(format!("the smallest scaled Jacobian is {:.4}, less than {bound}", q.min_sj));
    }
    let met: Vec<Met<'_>> = if quality.is_some() {
        args.require.iter().filter_map(|r| Some(r.hold(&metric(&data, &r.metric)?))).collect()
    } else {
        Vec::new()
    };
    findings.extend(met.iter().filter(|m| m.n_failed > 0).map(|m| unmet(m, &data)));
    if !args.json {
        match &quality {
            Some(q) if level >= 0 => say::out(q.to_string().trim_end())?,
            _ => {}
        }
    }
    if !findings.is_empty() {
        let n = findings.len();
        findings.truncate(MAX_DEFECTS);
        if n > MAX_DEFECTS {
            findings.push(format!("{} more", n - MAX_DEFECTS));
        }
        return Err(Failure::Check(findings.iter().map(|f| format!("{shown}: {f}")).collect()));
    }
    if args.json {
        let mut m = Map::new();
        m.insert("n_vertices".into(), mesh.n_vertices().into());
        m.insert("n_quads".into(), mesh.n_quads().into());
        m.insert("n_triangles".into(), mesh.triangles.len().into());
        m.insert("quality".into(), quality.map_or(Value::Null, |q| json::quality(&q, false)));
        m.insert("digest".into(), digest(mesh, &data.heights).into());
        if !met.is_empty() {
            m.insert("requirements".into(), met.iter().map(Met::entry).collect());
        }
        say::out(&json::success(m))?;
    }
    Ok(())
}

/// The values of a metric, of a plane mesh or in space.
pub(super) fn metric(data: &MeshData, name: &str) -> Option<Vec<f64>> {
    if data.heights.is_empty() {
        metrics::values(&data.mesh, name, None)
    } else {
        metrics::in_space(&data.mesh, &data.heights, name)
    }
}

/// What is not met, with the worst element and its place.
fn unmet(met: &Met<'_>, data: &MeshData) -> String {
    let mesh = &data.mesh;
    let mut s = format!("{}: not met by {} elements", met.requirement, met.n_failed);
    if let Some((element, value)) = met.worst {
        let (what, k) = match element.checked_sub(mesh.n_quads()) {
            None => ("quad", element),
            Some(t) => ("triangle", t),
        };
        let vs: &[VertexId] = if what == "quad" { &mesh.quads[k] } else { &mesh.triangles[k] };
        let middle = vs.iter().map(|v| mesh.points[v.index()]).sum::<csalf_geom::Point2>() / vs.len() as f64;
        let height = vs.iter().filter_map(|v| data.heights.get(v.index())).sum::<f64>() / vs.len() as f64;
        let z = if data.heights.is_empty() { String::new() } else { format!(", {height}") };
        s.push_str(&format!("; the worst is {what} {k} at ({}, {}{z}) with {value:.4}", middle.x, middle.y));
    }
    s
}

/// True if every element names vertices that exist.
fn in_range(mesh: &QuadMesh) -> bool {
    let n = mesh.n_vertices();
    mesh.quads.iter().flatten().chain(mesh.triangles.iter().flatten()).all(|v| v.index() < n)
}

/// What is wrong with a mesh of which only the mesh is known: its own boundary is taken as the wanted one.
pub fn defects(mesh: &QuadMesh) -> Vec<String> {
    let boundary = if in_range(mesh) { boundary(mesh) } else { Vec::new() };
    let expected = Expectation { nodes: &[], boundary: &boundary, scars: &[], points: &[], area: 0.0 };
    // A file may hold several parts; each adds two to the characteristic.
    let more = || 2 * (n_parts(mesh) as i64 - 1);
    let is_of_parts =
        |d: &MeshDefect| matches!(d, MeshDefect::Euler { got, wanted } if *got == wanted + more());
    validate(mesh, &expected).iter().filter(|d| !is_of_parts(d)).map(ToString::to_string).collect()
}

/// The same of a mesh in space: its open sides are no defects.
fn defects_in_space(mesh: &QuadMesh, heights: &[f64]) -> Vec<String> {
    validate_in_space(mesh, heights).iter().map(ToString::to_string).collect()
}

/// Number of parts that share no vertex. Indices must exist.
fn n_parts(mesh: &QuadMesh) -> usize {
    let mut parent: Vec<u32> = (0..mesh.n_vertices() as u32).collect();
    let find = |parent: &mut Vec<u32>, mut v: u32| {
        while parent[v as usize] != v {
            parent[v as usize] = parent[parent[v as usize] as usize];
            v = parent[v as usize];
        }
        v
    };
    let elements = mesh.quads.iter().map(|q| &q[..]).chain(mesh.triangles.iter().map(|t| &t[..]));
    let mut used = vec![false; mesh.n_vertices()];
    for e in elements {
        let a = find(&mut parent, e[0].0);
        for v in e {
            used[v.index()] = true;
            let b = find(&mut parent, v.0);
            parent[b as usize] = a;
        }
    }
    used.iter().enumerate().filter(|&(v, &used)| used && parent[v] as usize == v).count()
}

/// The edges that only one element has, in its direction.
pub fn boundary(mesh: &QuadMesh) -> Vec<[VertexId; 2]> {
    fn sides<const K: usize>(e: &[VertexId; K]) -> impl Iterator<Item = [VertexId; 2]> + '_ {
        (0..K).map(move |i| [e[i], e[(i + 1) % K]])
    }
    let all = mesh.quads.iter().flat_map(sides).chain(mesh.triangles.iter().flat_map(sides));
    let key = |e: &[VertexId; 2]| (e[0].min(e[1]), e[0].max(e[1]));
    let mut all: Vec<[VertexId; 2]> = all.collect();
    all.sort_by_key(key);
    all.chunk_by(|a, b| key(a) == key(b)).filter(|run| run.len() == 1).map(|run| run[0]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use csalf_geom::Point2;

    fn two_quads() -> QuadMesh {
        let v = VertexId::new;
        QuadMesh {
            points: [(0., 0.), (1., 0.), (2., 0.), (0., 1.), (1., 1.), (2., 1.)].map(Point2::from).to_vec(),
            quads: vec![[v(0), v(1), v(4), v(3)], [v(1), v(2), v(5), v(4)]],
            triangles: Vec::new(),
        }
    }

    #[test]
    fn a_sound_mesh_has_no_defects() {
        assert_eq!(boundary(&two_quads()).len(), 6);
        assert_eq!(defects(&two_quads()), Vec::<String>::new());
    }

    #[test]
    fn several_parts_are_no_defect() {
        let mut mesh = two_quads();
        let n = mesh.n_vertices();
        mesh.points.extend(mesh.points.clone().iter().map(|p| *p + Point2::new(5.0, 0.0)));
        mesh.quads.extend(mesh.quads.clone().iter().map(|q| q.map(|v| VertexId::new(v.index() + n))));
        assert_eq!((n_parts(&two_quads()), n_parts(&mesh)), (1, 2));
        assert_eq!(defects(&mesh), Vec::<String>::new());
    }

    #[test]
    fn broken_meshes_are_found() {
        let mut inverted = two_quads();
        inverted.quads[0].reverse();
        assert!(!defects(&inverted).is_empty());
        let mut wild = two_quads();
        wild.quads[1][2] = VertexId::new(99);
        assert!(!in_range(&wild));
        assert!(!defects(&wild).is_empty());
        let mut concave = two_quads();
        concave.points[4] = Point2::new(0.4, 0.2);
        concave.points[1] = Point2::new(0.4, 0.3);
        assert!(!defects(&concave).is_empty());
    }
}
