//! One face from facets to quads.

use crate::curved::curved;
use crate::plane::{self, Frame};
use crate::quality::measure;
use crate::{FaceError, FaceInput, FaceMesh, FaceSize, Flattening, LayerRing};
use csalf_core::{Job, MeshError, Meshed, Options};
use csalf_geom::{Defect, Domain, HardPoint, Loop, LoopKind, Point2, Scar};
use csalf_sizemap::SizeSpec;
use glam::DVec3;

/// Meshes one face with quads.
///
/// The given nodes come first and keep their bytes; the boundary of the mesh is the given segments, nothing
/// else. Deterministic. `options.threads` is ignored: the face is meshed in the caller's thread pool.
///
/// # Errors
/// [`FaceError`], with its place in space.
pub fn mesh_face(input: &FaceInput<'_>, options: &Options) -> Result<FaceMesh, FaceError> {
    check(input)?;
    match plane::frame(input.facets, longest_segment(input)) {
        Some(frame) if !input.loops.is_empty() => planar(input, &frame, options),
        _ => curved(input, options),
    }
}

/// Everything that would be out of range later.
fn check(input: &FaceInput<'_>) -> Result<(), FaceError> {
    let facets = input.facets;
    let n = facets.points.len() as u32;
    if facets.triangles.is_empty() {
        return Err(FaceError::NoArea);
    }
    let bad = |what, index| Err(FaceError::BadInput { what, index });
    if let Some(index) = facets.points.iter().position(|p| !p.is_finite()) {
        return bad("facet vertex", index);
    }
    if let Some(index) = facets.triangles.iter().position(|t| t.iter().any(|&v| v >= n)) {
        return bad("facet", index);
    }
    if let Some(index) = input.loops.iter().position(|l| l.nodes.len() < 3 || l.nodes.iter().any(|&v| v >= n))
    {
        return bad("loop", index);
    }
    if let Some(index) = input.scars.iter().position(|s| s.len() < 2 || s.iter().any(|&v| v >= n)) {
        return bad("scar", index);
    }
    if let Some(index) = input.points.iter().position(|&v| v >= n) {
        return bad("point", index);
    }
    let good = |h: f64| h > 0.0 && h.is_finite();
    match input.size {
        FaceSize::Uniform(h) if !good(h) => return bad("size", 0),
        FaceSize::Vertices(h) if h.len() != n as usize => return bad("size", h.len()),
        FaceSize::Vertices(h) => {
            if let Some(index) = h.iter().position(|&h| !good(h)) {
                return bad("size", index);
            }
        }
        _ => {}
    }
    if let Some(flat) = input.flat {
        if flat.len() != n as usize {
            return bad("flat coordinate", flat.len());
        }
        if let Some(index) = flat.iter().position(|p| !p.is_finite()) {
            return bad("flat coordinate", index);
        }
    }
    let n_segments: usize = input.loops.iter().map(|l| l.nodes.len()).sum();
    if !n_segments.is_multiple_of(2) {
        return Err(FaceError::Odd { n_segments });
    }
    Ok(())
}

/// The longest segment of the loops: an axis that turns with the part.
fn longest_segment(input: &FaceInput<'_>) -> DVec3 {
    let p = |v: u32| input.facets.points[v as usize];
    let mut best = DVec3::ZERO;
    for l in input.loops {
        for (i, &v) in l.nodes.iter().enumerate() {
            let d = p(l.nodes[(i + 1) % l.nodes.len()]) - p(v);
            if d.length_squared() > best.length_squared() {
                best = d;
            }
        }
    }
    best
}

/// The given nodes as facet vertices, each once: loops, scars, points.
pub(crate) fn given_nodes(input: &FaceInput<'_>) -> Vec<u32> {
    let mut seen = vec![false; input.facets.points.len()];
    let loops = input.loops.iter().flat_map(|l| &l.nodes);
    let all = loops.chain(input.scars.iter().flatten()).chain(input.points);
    all.copied().filter(|&v| !std::mem::replace(&mut seen[v as usize], true)).collect()
}

/// A plane face: no map but a rotation.
fn planar(input: &FaceInput<'_>, frame: &Frame, options: &Options) -> Result<FaceMesh, FaceError> {
    let facets = input.facets;
    let flat = |v: u32| frame.flat(facets.points[v as usize]);
    let size = match input.size {
        FaceSize::Boundary => SizeSpec::Boundary,
        FaceSize::Uniform(h) => SizeSpec::Uniform { h },
        FaceSize::Vertices(h) => match constant(h) {
            Some(h) => SizeSpec::Uniform { h },
            None => SizeSpec::Background {
                points: facets.points.iter().map(|&p| frame.flat(p)).collect(),
                triangles: facets.triangles.clone(),
                values: h.to_vec(),
            },
        },
    };
    let nodes = given_nodes(input);
    let job = job(input, &flat, size);
    let meshed = mesh(&job, options).map_err(|e| of_planar(input, e))?;
    let mut points = Vec::with_capacity(meshed.mesh.points.len());
    points.extend(nodes.iter().map(|&v| facets.points[v as usize]));
    points.extend(meshed.mesh.points.iter().skip(nodes.len()).map(|&p| frame.lift(p)));
    let mut out = FaceMesh {
        normals: vec![frame.normal; points.len()],
        points,
        quads: meshed.mesh.quads.iter().map(|q| q.map(|v| v.0)).collect(),
        nodes,
        ..FaceMesh::default()
    };
    out.report.flattening = Flattening::Plane;
    out.report.n_charts = 1;
    (out.report.anisotropy, out.report.scale_range) = (1.0, 1.0);
    out.report.quality = measure(&out.points, &out.quads, |_| frame.normal);
    report_layers(input, &meshed, &mut out);
    Ok(out)
}

/// The one size of a list.
pub(crate) fn constant(h: &[f64]) -> Option<f64> {
    let first = *h.first()?;
    h.iter().all(|&x| x == first).then_some(first)
}

/// The planar job of an uncut face. Loops are named `l0`, `l1`, ...
fn job(input: &FaceInput<'_>, flat: &dyn Fn(u32) -> Point2, size: SizeSpec) -> Job {
    let loops: Vec<Vec<Point2>> =
        input.loops.iter().map(|l| l.nodes.iter().map(|&v| flat(v)).collect()).collect();
    let area = |l: &Vec<Point2>| csalf_geom::polygon::signed_area(l).abs();
    let outer = (0..loops.len()).max_by(|&i, &j| area(&loops[i]).total_cmp(&area(&loops[j])).then(j.cmp(&i)));
    let mut job = Job { size, ..Job::default() };
    for (k, nodes) in loops.into_iter().enumerate() {
        let kind = if Some(k) == outer { LoopKind::Outer } else { LoopKind::Hole };
        job.domain.loops.push(Loop { kind, name: format!("l{k}"), nodes });
        if let Some(spec) = &input.loops[k].layers {
            job.layers.push((format!("l{k}"), spec.clone()));
        }
    }
    add_interior(&mut job.domain, input.scars, input.points, flat);
    job
}

/// Adds scars `s0`, ... and points `p0`, ... to a domain.
fn add_interior(domain: &mut Domain, scars: &[Vec<u32>], points: &[u32], flat: &dyn Fn(u32) -> Point2) {
    for (k, s) in scars.iter().enumerate() {
        domain.scars.push(Scar { name: format!("s{k}"), nodes: s.iter().map(|&v| flat(v)).collect() });
    }
    for (k, &v) in points.iter().enumerate() {
        domain.points.push(HardPoint { name: format!("p{k}"), xy: flat(v), size: None });
    }
}

/// The planar mesher, in this thread pool, all quads, the boundary as given.
pub(crate) fn mesh(job: &Job, options: &Options) -> Result<Meshed, MeshError> {
    let options = Options { threads: 0, allow_triangles: false, repair_parity: false, ..options.clone() };
    csalf_core::mesh(job, &options)
}

/// Rings and warnings of an uncut face.
fn report_layers(input: &FaceInput<'_>, meshed: &Meshed, out: &mut FaceMesh) {
    let loop_of = |name: &str| name.strip_prefix('l').and_then(|k| k.parse::<usize>().ok());
    out.report.layers = vec![(0, 0, String::new()); input.loops.len()];
    for r in &meshed.report.loops {
        if let Some(slot) = loop_of(&r.name).and_then(|k| out.report.layers.get_mut(k)) {
            *slot = (r.asked, r.made, r.stopped.clone());
        }
    }
    for (name, quads) in &meshed.sets.quads {
        let Some((l, n)) = name.split_once("_layer") else { continue };
        if let (Some(loop_index), Ok(layer)) = (loop_of(l), n.parse()) {
            out.rings.push(LayerRing { loop_index, layer, quads: quads.iter().map(|q| q.0).collect() });
        }
    }
    out.report.warnings.extend(meshed.report.warnings.iter().map(ToString::to_string));
}

/// Gives an error of the planar mesher its place in space.
fn of_planar(input: &FaceInput<'_>, error: MeshError) -> FaceError {
    let place = match &error {
        MeshError::Invalid(defects) => defects.iter().find_map(|d| match d {
            Defect::RepeatedNode { first: p, .. }
            | Defect::CoincidentNodes { first: p, .. }
            | Defect::SelfIntersection { first: p, .. }
            | Defect::Crossing { first: p, .. }
            | Defect::Overlap { first: p, .. }
            | Defect::Touching { node: p, .. }
            | Defect::Outside { at: p }
            | Defect::PointOnSegment { point: p, .. } => Some(p),
            _ => None,
        }),
        _ => None,
    };
    let at = place.and_then(|p| {
        let (kind, k) = p.name.split_at_checked(1)?;
        let k: usize = k.parse().ok()?;
        let v = match kind {
            "l" => *input.loops.get(k)?.nodes.get(p.index)?,
            "s" => *input.scars.get(k)?.get(p.index)?,
            _ => *input.points.get(k)?,
        };
        input.facets.points.get(v as usize).copied()
    });
    FaceError::Planar { at, error: Box::new(error) }
}

/// The same of a piece of a face: the coordinates mean nothing to the caller, the place is near the piece.
pub(crate) fn of_planar_piece(at: DVec3, error: MeshError) -> FaceError {
    FaceError::Planar { at: Some(at), error: Box::new(error) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FaceLoop, Facets};

    /// A square of side n in a slanted plane, two facets per cell.
    fn slanted(n: u32) -> (Facets, FaceLoop) {
        let (u, v) = (DVec3::new(2.0, 1.0, 2.0) / 3.0, DVec3::new(-2.0, 2.0, 1.0) / 3.0);
        let at = |i: u32, j: u32| j * (n + 1) + i;
        let mut f = Facets::default();
        for j in 0..=n {
            for i in 0..=n {
                f.points.push(DVec3::new(7.0, 8.0, 9.0) + f64::from(i) * u + f64::from(j) * v);
            }
        }
        for j in 0..n {
            for i in 0..n {
                f.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                f.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        let nodes = (0..n)
            .map(|i| at(i, 0))
            .chain((0..n).map(|j| at(n, j)))
            .chain((0..n).map(|i| at(n - i, n)))
            .chain((0..n).map(|j| at(0, n - j)));
        let l = FaceLoop { nodes: nodes.collect(), layers: None };
        (f, l)
    }

    fn input<'a>(facets: &'a Facets, loops: &'a [FaceLoop]) -> FaceInput<'a> {
        FaceInput {
            facets,
            loops,
            scars: &[],
            points: &[],
            size: FaceSize::Boundary,
            flat: None,
            surface: None,
        }
    }

    #[test]
    fn a_slanted_square_is_a_grid() {
        let (f, l) = slanted(6);
        let m = mesh_face(&input(&f, std::slice::from_ref(&l)), &Options::default()).expect("a square");
        assert_eq!((m.quads.len(), m.points.len()), (36, 49));
        assert_eq!(m.nodes, l.nodes);
        for (k, &v) in m.nodes.iter().enumerate() {
            assert_eq!(m.points[k], f.points[v as usize]);
        }
        let n = DVec3::new(-1.0, -2.0, 2.0) / 3.0;
        for q in &m.quads {
            let [a, b, c, d] = q.map(|v| m.points[v as usize]);
            assert!((c - a).cross(d - b).dot(n) > 1.99, "{a} {b} {c} {d}");
        }
    }

    #[test]
    fn odd_loops_and_bad_indices_are_errors() {
        let (f, mut l) = slanted(2);
        l.nodes.remove(1);
        let e = mesh_face(&input(&f, std::slice::from_ref(&l)), &Options::default());
        assert!(matches!(e, Err(FaceError::Odd { n_segments: 7 })));
        l.nodes[0] = 99;
        let e = mesh_face(&input(&f, std::slice::from_ref(&l)), &Options::default());
        assert!(matches!(e, Err(FaceError::BadInput { what: "loop", index: 0 })));
    }
}
