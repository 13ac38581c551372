//! Meshes one face: chart, facets, `csalf_surface`, and names for the nodes.

use super::chart::Chart;
use super::facets::{Beneath, ChartFacets, facets};
use super::open::{Opened, Sizing, open, open_sphere};
use super::points::Hard;
use super::trim::{UvLoop, UvNode, chain_nodes, trim_loop, without_seams};
use super::{NodeName, NodeTable, case, closed, patch, points};
use crate::brep::{Face, FaceShape, Model};
use crate::geometry::{Inverter, Surface, SurfacePoint};
use crate::plan::{Plan, SizeRules};
use crate::report::FaceFailure;
use csalf_core::{Job, Options};
use csalf_sizemap::SizeSpec;
use csalf_surface::{FaceInput, FaceLoop, FaceMesh, FaceSize, Facets, LayerSpec, mesh_face};
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A face of more quads is a mistake in the units; its mesh would not fit into memory.
const MOST_QUADS: f64 = 1e8;

/// All that the faces of one model share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Context<'a> {
    pub(crate) model: &'a Model,
    pub(crate) plan: &'a Plan,
    pub(crate) table: &'a NodeTable,
    pub(crate) rules: &'a SizeRules,
    pub(crate) options: &'a Options,
    /// Layers asked for, per face and loop.
    pub(crate) layers: &'a [Vec<Option<LayerSpec>>],
    /// How far apart points may be and still be one, length.
    pub(crate) tolerance: f64,
}

/// The mesh of one face.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct MeshedFace {
    /// Positions of the face's own nodes.
    pub(crate) own: Vec<DVec3>,
    /// Quads, counter-clockwise seen against the face's normal.
    pub(crate) quads: Vec<[NodeName; 4]>,
    /// Finished layers: loop of the face, number of the layer, quads.
    pub(crate) rings: Vec<(usize, usize, Vec<u32>)>,
    /// Per loop of the face: layers asked for, made, why not more.
    pub(crate) layers: Vec<(usize, usize, usize, String)>,
    /// Hard points: which of the given ones, and its number among the face's own nodes.
    pub(crate) hard: Vec<(usize, u32)>,
    /// What could not be done better, in words.
    pub(crate) warnings: Vec<String>,
}

/// Meshes the face with this index, with hard points.
pub(crate) fn mesh_one(
    cx: &Context<'_>,
    index: usize,
    hard: &[Hard],
) -> Result<MeshedFace, Box<FaceFailure>> {
    let meshed = mesh_shape(cx, index, hard)?;
    match collapsed(&meshed.quads) {
        None => Ok(meshed),
        Some(what) => {
            let message = format!(
                "{what}: edges of its boundary that lie within the tolerance ({:.3e}) were taken for one; the face is too thin \
                 for it",
                cx.tolerance
            );
            Err(failure(cx, index, message, None))
        }
    }
}

fn failure(cx: &Context<'_>, face: usize, message: String, case: Option<Job>) -> Box<FaceFailure> {
    Box::new(FaceFailure { face, name: cx.model.faces[face].name.clone(), message, case })
}

/// What is wrong with quads by the names of their nodes: a node twice in one, or three of them at one side. Cost: a look at
/// each; only sides with a node of the model, near the boundary, are sorted, since nodes of the face's own are never one.
fn collapsed(quads: &[[NodeName; 4]]) -> Option<&'static str> {
    let mut sides: Vec<[NodeName; 2]> = Vec::new();
    for q in quads {
        if (0..4).any(|k| (0..k).any(|j| q[j] == q[k])) {
            return Some("a quad passes one node of the model twice");
        }
        let ends = (0..4).map(|k| [q[k].min(q[(k + 1) % 4]), q[k].max(q[(k + 1) % 4])]);
        sides.extend(ends.filter(|s| s.iter().any(|n| matches!(n, NodeName::Model(_)))));
    }
    sides.sort_unstable();
    sides.windows(3).any(|w| w[0] == w[2]).then_some("three quads meet at one side")
}

fn mesh_shape(cx: &Context<'_>, index: usize, hard: &[Hard]) -> Result<MeshedFace, Box<FaceFailure>> {
    let face = &cx.model.faces[index];
    let fail = |message: String, case: Option<Job>| failure(cx, index, message, case);
    match &face.shape {
        FaceShape::Unread => Err(fail("its surface is of a kind that is not read".into(), None)),
        FaceShape::Facets(p) => patch::mesh_patch(cx, index, p, hard).map_err(|m| fail(m, None)),
        FaceShape::Surface(surface, forward) => {
            let uses = without_seams(&face.loops, surface);
            // A loop of a vertex alone is the apex of a cone; of a sphere or torus, a mere point of its seam.
            let has_apex = face.loops.iter().any(|l| l.vertex.is_some() && l.uses.is_empty());
            if uses.is_empty() && !(has_apex && matches!(surface, Surface::Cone { .. } | Surface::Nurbs(_))) {
                return closed::mesh_closed(cx, face, surface, *forward).map_err(|m| fail(m, None));
            }
            let inverter = Inverter::new(surface);
            let mut opened = open_face(cx, face, &inverter, *forward).map_err(|m| fail(m, None))?;
            let n_quads = expected_quads(&opened);
            if n_quads > MOST_QUADS {
                return Err(fail(
                    format!("its size asks for {n_quads:.1e} quads; choose a larger one"),
                    None,
                ));
            }
            let hard = points::add(&mut opened, &inverter, hard);
            let faceted =
                facets(&opened, *forward).map_err(|m| fail(m, Some(case::of_chart(face, &opened))))?;
            mesh_chart(cx, index, &opened, &faceted)
                .map(|m| MeshedFace { hard, ..m })
                .map_err(|m| fail(m, Some(case::of_chart(face, &opened))))
        }
    }
}

/// Quads that the segments on the boundary ask for, about: the area in the chart over that of a segment's square.
fn expected_quads(opened: &Opened<'_>) -> f64 {
    let (mut area, mut length, mut n) = (0.0, 0.0, 0);
    for (_, l) in &opened.loops {
        let q: Vec<DVec2> = l.iter().map(|n| n.q).collect();
        area += csalf_geom::polygon::signed_area(&q);
        length += (0..q.len()).map(|i| q[i].distance(q[(i + 1) % q.len()])).sum::<f64>();
        n += q.len();
    }
    let segment = length / n as f64;
    if segment > 0.0 { area.abs() / (segment * segment) } else { 0.0 }
}

/// The face's loops in a chart.
pub(super) fn open_face<'a>(
    cx: &Context<'_>,
    face: &Face,
    inverter: &Inverter<'a>,
    forward: bool,
) -> Result<Opened<'a>, String> {
    let surface = inverter.surface();
    let edges = &cx.plan.edges;
    let trims: Vec<UvLoop> = without_seams(&face.loops, surface)
        .iter()
        .map(|(source, uses)| {
            let nodes = chain_nodes(cx.model, edges, cx.table, uses);
            trim_loop(inverter, &nodes, *source, forward, cx.tolerance)
        })
        .filter(|l| !l.nodes.is_empty())
        .collect();
    if let Some(opened) = open_sphere(surface, &trims) {
        return Ok(opened);
    }
    let apex = face.loops.iter().find_map(|l| l.vertex.filter(|_| l.uses.is_empty())).and_then(|v| {
        let number = cx.table.of_vertex[v];
        let point = *cx.table.points.get(number as usize)?;
        Some(UvNode { name: NodeName::Model(number), uv: DVec2::ZERO, point })
    });
    let most = cx.rules.of_face(&face.name);
    let at = |s: &SurfacePoint| cx.rules.for_curvature(s.max_curvature(), most);
    let least = if cx.rules.per_turn > 0.0 { cx.rules.min_size.min(most) } else { most };
    open(surface, trims, apex, &Sizing { at: &at, least, gradation: cx.rules.gradation })
}

fn mesh_chart(
    cx: &Context<'_>,
    index: usize,
    opened: &Opened<'_>,
    faceted: &ChartFacets,
) -> Result<MeshedFace, String> {
    let face = &cx.model.faces[index];
    let chart: Chart<'_> = opened.chart;
    let FaceShape::Surface(surface, forward) = &face.shape else { return Err("not a surface".into()) };
    let loops: Vec<FaceLoop> = faceted
        .loops
        .iter()
        .map(|(source, nodes)| FaceLoop { nodes: nodes.clone(), layers: layers_of(cx, index, *source) })
        .collect();
    let beneath = Beneath { chart, corners: &faceted.corners, forward: *forward };
    let sizes = match surface {
        Surface::Plane(_) | Surface::Cylinder { .. } => Vec::new(),
        _ => vertex_sizes(cx, face, &faceted.facets, &loops, &|v| {
            let q = faceted.flat.get(v).map(|q| if *forward { *q } else { DVec2::new(q.y, q.x) });
            q.map_or(0.0, |q| chart.eval(q).max_curvature())
        }),
    };
    let input = FaceInput {
        facets: &faceted.facets,
        loops: &loops,
        scars: &[],
        points: &faceted.points,
        size: if sizes.is_empty() { FaceSize::Boundary } else { FaceSize::Vertices(&sizes) },
        flat: (chart.is_good() && !faceted.flat.is_empty()).then_some(&faceted.flat),
        surface: Some(&beneath),
    };
    let sources: Vec<usize> = faceted.loops.iter().map(|l| l.0).collect();
    match mesh_face(&input, cx.options) {
        Ok(mesh) => Ok(name_nodes(&mesh, &faceted.names, &sources, opened.n_own)),
        Err(e) if !faceted.flat.is_empty() => {
            // The chart itself is a plane that the face can be meshed in, if a poor one.
            in_chart(cx, opened, faceted, &sizes, &loops, *forward)
                .map(|mut m| {
                    m.warnings
                        .push(format!("{}: meshed in the parameters of its surface, since {e}", face.name));
                    m
                })
                .map_err(|second| format!("{e}; in the parameters of its surface: {second}"))
        }
        Err(e) => Err(e.to_string()),
    }
    .map(|m| with_own(m, opened, *forward))
}

/// Puts the positions of nodes made for the face (on a cut, an apex) before those of the mesh, and the cap behind its
/// quads.
fn with_own(mut m: MeshedFace, opened: &Opened<'_>, forward: bool) -> MeshedFace {
    let nodes = opened.loops.iter().flat_map(|l| &l.1).chain(&opened.points).map(|n| (n.name, n.point));
    for (name, point) in nodes.chain(opened.cap.iter().map(|c| (c.apex, c.point))) {
        if let NodeName::Own(k) = name
            && let Some(p) = m.own.get_mut(k as usize)
        {
            *p = point;
        }
    }
    for mut q in opened.cap.iter().flat_map(|c| &c.quads).copied() {
        if !forward {
            q.reverse();
        }
        m.quads.push(q);
    }
    m
}

/// Layers asked for around a loop.
pub(super) fn layers_of(cx: &Context<'_>, face: usize, source: usize) -> Option<LayerSpec> {
    cx.layers.get(face).and_then(|l| l.get(source)).cloned().flatten()
}

/// Sizes at facet vertices: on the boundary what its segments have, inside what curvature asks for, the growth limited.
pub(super) fn vertex_sizes(
    cx: &Context<'_>,
    face: &Face,
    facets: &Facets,
    loops: &[FaceLoop],
    curvature: &dyn Fn(usize) -> f64,
) -> Vec<f64> {
    let most = cx.rules.of_face(&face.name);
    let n = facets.points.len();
    let p = |v: u32| facets.points[v as usize];
    let mut h: Vec<f64> = (0..n).map(|v| cx.rules.for_curvature(curvature(v), most)).collect();
    let mut sums = vec![(0.0, 0.0); n];
    for l in loops {
        for i in 0..l.nodes.len() {
            let (a, b) = (l.nodes[i], l.nodes[(i + 1) % l.nodes.len()]);
            let length = p(a).distance(p(b));
            for v in [a, b] {
                sums[v as usize].0 += length;
                sums[v as usize].1 += 1.0;
            }
        }
    }
    for (h, (sum, count)) in h.iter_mut().zip(sums) {
        if count > 0.0 {
            *h = sum / count;
        }
    }
    let mut next: Vec<Vec<u32>> = vec![Vec::new(); n];
    for t in &facets.triangles {
        for k in 0..3 {
            next[t[k] as usize].extend([t[(k + 1) % 3], t[(k + 2) % 3]]);
        }
    }
    let mut heap: BinaryHeap<(Reverse<u64>, u32)> =
        (0..n as u32).map(|v| (Reverse(h[v as usize].to_bits()), v)).collect();
    while let Some((Reverse(bits), v)) = heap.pop() {
        if bits != h[v as usize].to_bits() {
            continue;
        }
        for &w in &next[v as usize] {
            let most = h[v as usize] + cx.rules.gradation * p(v).distance(p(w));
            if most < h[w as usize] {
                h[w as usize] = most;
                heap.push((Reverse(most.to_bits()), w));
            }
        }
    }
    h
}

/// Names for all nodes of a face's mesh.
pub(super) fn name_nodes(
    mesh: &FaceMesh,
    names: &[Option<NodeName>],
    sources: &[usize],
    n_own: u32,
) -> MeshedFace {
    let mut out = MeshedFace { own: vec![DVec3::ZERO; n_own as usize], ..MeshedFace::default() };
    let mut of: Vec<NodeName> = Vec::with_capacity(mesh.points.len());
    for (i, p) in mesh.points.iter().enumerate() {
        let given = mesh.nodes.get(i).and_then(|&v| names.get(v as usize).copied().flatten());
        of.push(given.unwrap_or_else(|| {
            out.own.push(*p);
            NodeName::Own(out.own.len() as u32 - 1)
        }));
    }
    out.quads = mesh.quads.iter().map(|q| q.map(|v| of[v as usize])).collect();
    let source = |k: usize| sources.get(k).copied().unwrap_or(k);
    out.rings = mesh.rings.iter().map(|r| (source(r.loop_index), r.layer, r.quads.clone())).collect();
    out.layers = mesh
        .report
        .layers
        .iter()
        .enumerate()
        .map(|(k, (asked, made, why))| (source(k), *asked, *made, why.clone()))
        .collect();
    out.warnings.clone_from(&mesh.report.warnings);
    out
}

/// Meshes the face in its chart and evaluates the surface at the nodes.
fn in_chart(
    cx: &Context<'_>,
    opened: &Opened<'_>,
    faceted: &ChartFacets,
    sizes: &[f64],
    loops: &[FaceLoop],
    forward: bool,
) -> Result<MeshedFace, String> {
    let mut job = case::job_of(opened);
    if !sizes.is_empty() {
        job.size = chart_sizes(faceted, sizes, forward);
    }
    let sources: Vec<usize> = faceted.loops.iter().map(|l| l.0).collect();
    for (k, l) in loops.iter().enumerate() {
        if let Some(spec) = &l.layers {
            job.layers.push((format!("l{k}"), spec.clone()));
        }
    }
    let options = Options { threads: 0, allow_triangles: false, repair_parity: false, ..cx.options.clone() };
    let meshed = csalf_core::mesh(&job, &options).map_err(|e| e.to_string())?;
    let given: Vec<NodeName> =
        opened.loops.iter().flat_map(|l| &l.1).chain(&opened.points).map(|n| n.name).collect();
    let mut mesh = FaceMesh {
        points: meshed.mesh.points.iter().map(|q| opened.chart.eval(*q).point).collect(),
        quads: meshed.mesh.quads.iter().map(|q| q.map(|v| v.0)).collect(),
        nodes: (0..given.len() as u32).collect(),
        ..FaceMesh::default()
    };
    if !forward {
        mesh.quads.iter_mut().for_each(|q| q.reverse());
    }
    let names: Vec<Option<NodeName>> = given.into_iter().map(Some).collect();
    Ok(name_nodes(&mesh, &names, &sources, opened.n_own))
}

/// Sizes in space, as lengths in the chart: times the root of the ratio of areas around each vertex.
fn chart_sizes(faceted: &ChartFacets, sizes: &[f64], forward: bool) -> SizeSpec {
    let facets = &faceted.facets;
    let mut areas = vec![(0.0, 0.0); sizes.len()];
    let mut triangles = facets.triangles.clone();
    for (t, c) in facets.triangles.iter().zip(&faceted.corners) {
        let p = t.map(|v| facets.points[v as usize]);
        let in_space = (p[1] - p[0]).cross(p[2] - p[0]).length();
        let in_chart = (c[1] - c[0]).perp_dot(c[2] - c[0]).abs();
        for v in t {
            areas[*v as usize].0 += in_chart;
            areas[*v as usize].1 += in_space;
        }
    }
    let scale =
        |(chart, space): (f64, f64)| if chart > 0.0 && space > 0.0 { (chart / space).sqrt() } else { 1.0 };
    let values = sizes.iter().zip(areas).map(|(h, a)| h * scale(a)).collect();
    let mirror = |q: &DVec2| if forward { *q } else { DVec2::new(q.y, q.x) };
    if !forward {
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    SizeSpec::Background { points: faceted.flat.iter().map(mirror).collect(), triangles, values }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn collapsed_faces_are_found() {
        let node = NodeName::Model;
        let quad = |a, b, c, d| [node(a), node(b), node(c), node(d)];
        assert_eq!(collapsed(&[quad(0, 1, 2, 3), quad(1, 4, 5, 2)]), None);
        assert!(collapsed(&[quad(0, 1, 0, 3)]).is_some_and(|w| w.contains("twice")));
        let three = [quad(0, 1, 2, 3), quad(1, 0, 4, 5), quad(0, 1, 6, 7)];
        assert!(collapsed(&three).is_some_and(|w| w.contains("one side")));
    }
}
