//! From model to mesh.
//!
//! ```text
//!   Model ─▶ names of loops ─▶ sizes, counts, nodes of edges ─▶ faces, in parallel ─▶ one mesh by node numbers
//! ```

use crate::brep::{LoopFeature, Model, loop_features};
use crate::face::{Context, Hard, MeshedFace, NodeName, NodeTable, assign, mesh_one};
use crate::names::loop_matches;
use crate::plan::{EdgeNodes, Limits, Plan, SizeRules, plan};
use crate::report::{FaceFailure, LoopLayers, ModelMesh};
use csalf_core::Options;
use csalf_geom::{QuadId, VertexId};
use csalf_surface::LayerSpec;
use glam::DVec3;
use rayon::prelude::*;

/// Options of one run.
#[derive(Clone, Debug, Default)]
pub struct ModelOptions {
    /// Sizes; `None`: a fortieth of the model's diagonal, the rest by default.
    pub size: Option<SizeRules>,
    /// Layers by pattern of the loops' names (see [`loop_matches`]) or of `FACE/LOOP`; a later entry overrides an
    /// earlier one.
    pub layers: Vec<(String, LayerSpec)>,
    /// Sizes of the edges of loops, by the same patterns, whatever the curvature; a later entry overrides an earlier one.
    pub loop_sizes: Vec<(String, f64)>,
    /// Hard points (weld spots) in space: each becomes a node of the nearest face, in a node set of its name.
    pub points: Vec<(String, DVec3)>,
    /// Segments of edges that must not change, by pattern of names.
    pub counts: Vec<(String, usize)>,
    /// Options of the planar mesher. `threads` is the caller's business: the current rayon pool is used.
    pub mesher: Options,
}

/// Points closer than this share of the model's diagonal are on one surface, at one pole; what files carry.
const NEAR: f64 = 1e-6;

/// A model longer than this many sizes is a mistake in the units; its mesh would not fit into memory.
const MOST_SIZES: f64 = 1e5;
/// A hard point moved by more than this share of the diagonal is worth a word.
const FAR: f64 = 1e-3;

/// A loop of a face, by name.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedLoop {
    /// `hole1`, ... for full circles and slots; `inner1`, ... for other inner loops; `outer1`, ... for outer ones.
    pub name: String,
    /// The face.
    pub face: usize,
    /// The loop of the face.
    pub loop_index: usize,
    /// Its diameter, if it is a hole.
    pub diameter: Option<f64>,
}

/// Names of all loops of a model, in the order of faces and loops.
pub fn named_loops(model: &Model) -> Vec<NamedLoop> {
    let holes = loop_features(model);
    let hole_of = |f: usize, k: usize| -> Option<&LoopFeature> {
        let at = holes.partition_point(|h| (h.face, h.loop_index) < (f, k));
        holes.get(at).filter(|h| (h.face, h.loop_index) == (f, k))
    };
    let (mut n_inner, mut n_outer) = (0, 0);
    let mut out = Vec::new();
    for (f, face) in model.faces.iter().enumerate() {
        let outer = crate::brep::outer_loop(model, face);
        for k in 0..face.loops.len() {
            let (name, diameter) = match hole_of(f, k) {
                Some(h) => (h.name.clone(), Some(h.shape.diameter())),
                None if k == outer => {
                    n_outer += 1;
                    (format!("outer{n_outer}"), None)
                }
                None => {
                    n_inner += 1;
                    (format!("inner{n_inner}"), None)
                }
            };
            out.push(NamedLoop { name, face: f, loop_index: k, diameter });
        }
    }
    out
}

/// Meshes a model. Faces that fail are reported and never lose the others. Deterministic, whatever the number of threads.
/// Cost: linear in the number of quads, but for the pairing of odd faces.
pub fn mesh_model(model: &Model, options: &ModelOptions) -> ModelMesh {
    let diagonal = model.diagonal();
    let rules = options.size.clone().unwrap_or_else(|| SizeRules::of_model(model));
    let mut out = ModelMesh { warnings: model.notes.clone(), ..ModelMesh::default() };
    if !(rules.size > 0.0 && rules.size.is_finite() && diagonal.is_finite()) || model.faces.is_empty() {
        out.warnings.push("the model has no face, or its size is not a positive number".into());
        return out;
    }
    if diagonal > MOST_SIZES * rules.size {
        let message =
            format!("the model is {:.1e} sizes long: the size is too small for it", diagonal / rules.size);
        let fail = |(face, f): (usize, &crate::brep::Face)| FaceFailure {
            face,
            name: f.name.clone(),
            message: message.clone(),
            case: None,
        };
        out.failures = model.faces.iter().enumerate().map(fail).collect();
        return out;
    }
    let loops = named_loops(model);
    say_unmatched(model, options, &rules, &loops, &mut out);
    let layers = layers_by_loop(model, options, &loops);
    let limits = limits(model, options, &layers, &loops);
    let plan = {
        let _span = tracing::info_span!("csalf.edges", n_edges = model.edges.len()).entered();
        plan(model, &rules, &limits)
    };
    say_plan(model, &plan, &mut out);
    let table = number_nodes(model, &plan.edges);
    let cx = Context {
        model,
        plan: &plan,
        table: &table,
        rules: &rules,
        options: &options.mesher,
        layers: &layers,
        tolerance: NEAR * diagonal,
    };
    let given: Vec<DVec3> = options.points.iter().map(|p| p.1).collect();
    let (hard, distances) = assign(&cx, &given);
    for ((name, _), d) in options.points.iter().zip(&distances) {
        if !d.is_finite() {
            out.warnings.push(format!("no face has the point {name} above or below it; it was left out"));
        } else if *d > FAR * diagonal {
            out.warnings.push(format!("the point {name} was moved by {d:.3e} to its face"));
        }
    }
    let faces: Vec<Result<MeshedFace, Box<FaceFailure>>> = {
        let _span = tracing::info_span!("csalf.faces", n_faces = model.faces.len()).entered();
        (0..model.faces.len())
            .into_par_iter()
            .map(|f| {
                let meshed = guarded(&cx, f, &hard[f]);
                tracing::debug!(target: "csalf::face", face = f, failed = meshed.is_err());
                meshed
            })
            .collect()
    };
    let names: Vec<&str> = options.points.iter().map(|p| p.0.as_str()).collect();
    stitch(model, &table, &Names { loops: &loops, layers: &layers, points: &names }, faces, &mut out);
    out
}

/// Meshes a face; a fault of ours that stops its work is a failure of this face, not of the others.
fn guarded(cx: &Context<'_>, f: usize, hard: &[Hard]) -> Result<MeshedFace, Box<FaceFailure>> {
    let work = std::panic::AssertUnwindSafe(|| mesh_one(cx, f, hard));
    std::panic::catch_unwind(work).unwrap_or_else(|_| {
        let name = cx.model.faces[f].name.clone();
        let message = "the mesher stopped at it, which is a fault of the mesher; please report it".to_owned();
        Err(Box::new(FaceFailure { face: f, name, message, case: None }))
    })
}

/// Layers asked for, per face and loop.
fn layers_by_loop(model: &Model, options: &ModelOptions, loops: &[NamedLoop]) -> Vec<Vec<Option<LayerSpec>>> {
    let mut layers: Vec<Vec<Option<LayerSpec>>> =
        model.faces.iter().map(|f| vec![None; f.loops.len()]).collect();
    for l in loops {
        let asked = options.layers.iter().rev().find(|(p, _)| is_meant(model, p, l));
        layers[l.face][l.loop_index] = asked.map(|(_, spec)| spec.clone());
    }
    layers
}

/// Whether a pattern means a loop: by its own name, or by `FACE/LOOP`.
fn is_meant(model: &Model, pattern: &str, l: &NamedLoop) -> bool {
    let long = || format!("{}/{}", model.faces[l.face].name, l.name);
    loop_matches(pattern, &l.name, l.diameter)
        || (pattern.contains('/') && loop_matches(pattern, &long(), l.diameter))
}

/// Patterns that nothing has a name for, one sentence each.
fn say_unmatched(
    model: &Model,
    options: &ModelOptions,
    rules: &SizeRules,
    loops: &[NamedLoop],
    out: &mut ModelMesh,
) {
    let named = |p: &str| loops.iter().any(|l| is_meant(model, p, l));
    let edge = |p: &str| model.edges.iter().any(|e| crate::names::matches(p, &e.name));
    let face = |p: &str| model.faces.iter().any(|f| crate::names::matches(p, &f.name));
    let mut say = |what: &str, kind: &str, pattern: &str, found: bool| {
        if !found {
            out.warnings.push(format!("{what} for '{pattern}': no {kind} has such a name"));
        }
    };
    options.layers.iter().for_each(|(p, _)| say("layers", "loop", p, named(p)));
    options.loop_sizes.iter().for_each(|(p, _)| say("a size", "loop", p, named(p)));
    options.counts.iter().for_each(|(p, _)| say("a count", "edge", p, edge(p)));
    rules.edges.iter().for_each(|(p, _)| say("a size", "edge", p, edge(p)));
    rules.faces.iter().for_each(|(p, _)| say("a size", "face", p, face(p)));
}

/// Least counts, frozen counts and sizes of edges.
fn limits(
    model: &Model,
    options: &ModelOptions,
    layers: &[Vec<Option<LayerSpec>>],
    loops: &[NamedLoop],
) -> Limits {
    /// Segments of a closed edge, and of one with layers around it.
    const CLOSED: usize = 4;
    const LAYERED: usize = 8;
    let mut least: Vec<usize> = model.edges.iter().map(|e| if e.is_closed() { CLOSED } else { 1 }).collect();
    for (face, layers) in model.faces.iter().zip(layers) {
        for (l, spec) in face.loops.iter().zip(layers) {
            let layered = spec.as_ref().is_some_and(|s| s.count > 0);
            let n = l.uses.len().max(1);
            for u in l.uses.iter().filter(|_| layered) {
                let curved = !matches!(model.edges[u.edge].curve, crate::geometry::Curve::Line { .. });
                if curved {
                    least[u.edge] = least[u.edge].max(LAYERED.div_ceil(n));
                }
            }
        }
    }
    let count = |e: &crate::brep::Edge| {
        let named = options.counts.iter().rev().find(|(p, _)| crate::names::matches(p, &e.name));
        named.map(|(_, n)| *n)
    };
    let mut sizes = vec![None; model.edges.len()];
    for l in loops.iter().filter(|_| !options.loop_sizes.is_empty()) {
        let asked = options.loop_sizes.iter().rev().find(|(p, _)| is_meant(model, p, l));
        for u in asked.iter().flat_map(|_| &model.faces[l.face].loops[l.loop_index].uses) {
            sizes[u.edge] = asked.map(|a| a.1);
        }
    }
    Limits { least, frozen: model.edges.iter().map(count).collect(), sizes }
}

/// What the plan could not do, in words.
fn say_plan(model: &Model, plan: &Plan, out: &mut ModelMesh) {
    for bad in &plan.infeasible {
        let names = |list: &[usize], name: &dyn Fn(usize) -> String| {
            const SHOWN: usize = 5;
            let mut words: Vec<String> = list.iter().take(SHOWN).map(|&i| name(i)).collect();
            if list.len() > SHOWN {
                words.push(format!("{} more", list.len() - SHOWN));
            }
            words.join(", ")
        };
        let faces = names(&bad.faces, &|f| model.faces[f].name.clone());
        let edges = names(&bad.frozen, &|e| model.edges[e].name.clone());
        let cure = if bad.frozen.is_empty() {
            "no edge of it is free to change".to_owned()
        } else {
            format!("one segment more or less on one of its fixed edges would cure it: {edges}")
        };
        out.warnings.push(format!("the number of segments around {faces} is odd; {cure}"));
    }
}

/// Numbers the nodes: vertices in use, then the inner nodes of edges, in their orders.
fn number_nodes(model: &Model, edges: &[EdgeNodes]) -> NodeTable {
    let mut table = NodeTable { of_vertex: vec![u32::MAX; model.vertices.len()], ..NodeTable::default() };
    let of_loops = model.faces.iter().flat_map(|f| &f.loops).filter_map(|l| l.vertex);
    let of_edges = model.edges.iter().zip(edges).filter(|(_, n)| n.count() > 0).flat_map(|(e, _)| e.ends);
    let mut used = vec![false; model.vertices.len()];
    of_loops.chain(of_edges).for_each(|v| used[v] = true);
    for v in (0..used.len()).filter(|v| used[*v]) {
        table.of_vertex[v] = table.points.len() as u32;
        table.points.push(model.vertices[v].point);
    }
    for (e, nodes) in model.edges.iter().zip(edges) {
        let n = nodes.count();
        let mut numbers = Vec::with_capacity(n + 1);
        if n > 0 {
            numbers.push(table.of_vertex[e.ends[0]]);
            for p in &nodes.points[1..n] {
                numbers.push(table.points.len() as u32);
                table.points.push(*p);
            }
            numbers.push(table.of_vertex[e.ends[1]]);
        }
        table.of_edge.push(numbers);
    }
    table
}

/// What the sets are named after.
struct Names<'a> {
    loops: &'a [NamedLoop],
    /// Layers asked for by the caller, per face and loop.
    layers: &'a [Vec<Option<LayerSpec>>],
    points: &'a [&'a str],
}

/// One mesh of all faces, by the names of their nodes.
fn stitch(
    model: &Model,
    table: &NodeTable,
    given: &Names<'_>,
    faces: Vec<Result<MeshedFace, Box<FaceFailure>>>,
    out: &mut ModelMesh,
) {
    // A node of an edge that only failed faces use is left out.
    let mut used = vec![false; table.points.len()];
    for m in faces.iter().flatten() {
        for n in m.quads.iter().flatten() {
            if let NodeName::Model(k) = n {
                used[*k as usize] = true;
            }
        }
    }
    let mut number = vec![u32::MAX; table.points.len()];
    for (k, p) in table.points.iter().enumerate().filter(|(k, _)| used[*k]) {
        number[k] = out.mesh.points.len() as u32;
        out.mesh.points.push(*p);
    }
    let mut loop_at = 0;
    for (f, result) in faces.into_iter().enumerate() {
        let face = &model.faces[f];
        let names = &given.loops[loop_at..loop_at + face.loops.len()];
        loop_at += face.loops.len();
        let m = match result {
            Ok(m) => m,
            Err(failure) => {
                out.failures.push(*failure);
                continue;
            }
        };
        let first_quad = out.mesh.quads.len();
        let own = own_numbers(&m, &mut out.mesh.points);
        out.mesh.quads.extend(m.quads.iter().map(|q| {
            q.map(|n| match n {
                NodeName::Model(k) => VertexId(number[k as usize]),
                NodeName::Own(k) => VertexId(own[k as usize]),
            })
        }));
        let n = out.mesh.quads.len();
        out.face_of_quad.extend(std::iter::repeat_n(f as u32, n - first_quad));
        let id = |q: usize| QuadId(q as u32);
        out.sets.quads.push((face.name.clone(), (first_quad..n).map(id).collect()));
        let first_set = out.sets.quads.len();
        for (k, layer, quads) in &m.rings {
            let Some(l) = names.get(*k) else { continue };
            let quads = quads.iter().map(|q| id(first_quad + *q as usize)).collect();
            add_quads(&mut out.sets.quads, first_set, format!("{}_layer{layer}", l.name), quads);
        }
        let by_user = |k: usize| given.layers[f].get(k).is_some_and(Option::is_some);
        for (k, asked, made, why) in m.layers.into_iter().filter(|l| by_user(l.0)) {
            let name = names.get(k).map_or_else(|| format!("{} loop {k}", face.name), |l| l.name.clone());
            out.layers.push(LoopLayers { name, asked, made, why });
        }
        for &(point, k) in &m.hard {
            let node = own.get(k as usize).copied().filter(|v| *v != u32::MAX);
            let name = given.points.get(point);
            out.sets.nodes.extend(name.zip(node).map(|(n, v)| ((*n).to_owned(), vec![VertexId(v)])));
        }
        out.warnings.extend(m.warnings);
    }
    for (e, nodes) in model.edges.iter().zip(&table.of_edge) {
        let ids: Vec<u32> = nodes.iter().map(|&k| number[k as usize]).collect();
        let whole = ids.len() > 1 && ids.iter().all(|&k| k != u32::MAX);
        if whole {
            let sides = ids.windows(2).map(|w| [VertexId(w[0]), VertexId(w[1])]).collect();
            out.sets.edges.push((e.name.clone(), sides));
        }
    }
    count_sides(out);
}

/// Numbers for the face's own nodes that its quads use; the others are left out.
fn own_numbers(m: &MeshedFace, points: &mut Vec<DVec3>) -> Vec<u32> {
    let mut used = vec![false; m.own.len()];
    for n in m.quads.iter().flatten() {
        if let NodeName::Own(k) = n {
            used[*k as usize] = true;
        }
    }
    m.own
        .iter()
        .zip(used)
        .map(|(p, used)| {
            if !used {
                return u32::MAX;
            }
            points.push(*p);
            points.len() as u32 - 1
        })
        .collect()
}

/// Adds quads to the set of this name from the `first` on; the two loops of a seam have one name.
fn add_quads(sets: &mut Vec<(String, Vec<QuadId>)>, first: usize, name: String, quads: Vec<QuadId>) {
    match sets[first..].iter_mut().find(|s| s.0 == name) {
        Some(set) => set.1.extend(quads),
        None => sets.push((name, quads)),
    }
}

/// Counts sides of one quad and of three and more.
fn count_sides(out: &mut ModelMesh) {
    let mut sides: Vec<[u32; 2]> = Vec::with_capacity(4 * out.mesh.quads.len());
    for q in &out.mesh.quads {
        for k in 0..4 {
            let (a, b) = (q[k].0, q[(k + 1) % 4].0);
            sides.push([a.min(b), a.max(b)]);
        }
    }
    sides.sort_unstable();
    for run in sides.chunk_by(|a, b| a == b) {
        match run.len() {
            1 => out.n_free_sides += 1,
            2 => {}
            _ => out.n_branching_sides += 1,
        }
    }
}
