//! From model to mesh.
//!
//! ```text
//!   Model ─▶ names of loops ─▶ sizes, counts, nodes of edges ─▶ faces, in parallel ─▶ one mesh by node numbers
//! ```

use crate::brep::{LoopFeature, Model, loop_features};
use crate::face::{Context, Hard, MeshedFace, NodeTable, assign, mesh_one};
use crate::names::loop_matches;
use crate::plan::{EdgeNodes, Limits, Plan, SizeRules, plan};
use crate::report::{FaceFailure, ModelMesh};
use crate::stitch::Frame;
use csalf_core::{Options, Watch};
use csalf_surface::LayerSpec;
use glam::DVec3;
use rayon::prelude::*;
use std::borrow::Cow;

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
    Prepared::new(Cow::Borrowed(model), options).mesh()
}

/// A model whose edges are discretised: from here on each face is on its own, on one machine or on many (see
/// [`crate::shard`]).
#[derive(Debug)]
pub struct Prepared<'a> {
    pub(crate) model: Cow<'a, Model>,
    pub(crate) options: ModelOptions,
    pub(crate) rules: SizeRules,
    pub(crate) plan: Plan,
    /// What the mesh is put together by.
    pub(crate) frame: Frame,
    /// Layers asked for, per face and loop.
    layers: Vec<Vec<Option<LayerSpec>>>,
    /// Hard points per face.
    hard: Vec<Vec<Hard>>,
    tolerance: f64,
}

impl<'a> Prepared<'a> {
    /// Sizes, counts and nodes of all edges, and which hard point belongs to which face.
    pub fn new(model: Cow<'a, Model>, options: &ModelOptions) -> Self {
        let diagonal = model.diagonal();
        let rules = options.size.clone().unwrap_or_else(|| SizeRules::of_model(&model));
        let mut prepared = Self {
            frame: Frame::of(&model, &options.points),
            model,
            options: options.clone(),
            rules,
            plan: Plan::default(),
            layers: Vec::new(),
            hard: Vec::new(),
            tolerance: NEAR * diagonal,
        };
        if prepared.is_hopeless(diagonal) {
            return prepared;
        }
        prepared.frame.able = true;
        let model = &*prepared.model;
        let loops = named_loops(model);
        say_unmatched(model, options, &prepared.rules, &loops, &mut prepared.frame.warnings);
        prepared.layers = layers_by_loop(model, options, &loops);
        let limits = limits(model, options, &prepared.layers, &loops);
        prepared.plan = {
            let _span = tracing::info_span!("csalf.edges", n_edges = model.edges.len()).entered();
            plan(model, &prepared.rules, &limits)
        };
        let warnings = &mut prepared.frame.warnings;
        say_plan(model, &prepared.plan, warnings);
        prepared.frame.table = number_nodes(model, &prepared.plan.edges);
        prepared.frame.name_loops(&loops, &prepared.layers);
        prepared.place_points(diagonal);
        prepared
    }

    /// True if there is nothing to mesh; the frame then has the reason.
    fn is_hopeless(&mut self, diagonal: f64) -> bool {
        let size = self.rules.size;
        if !(size > 0.0 && size.is_finite() && diagonal.is_finite()) || self.model.faces.is_empty() {
            let why = "the model has no face, or its size is not a positive number";
            self.frame.warnings.push(why.into());
            return true;
        }
        if diagonal <= MOST_SIZES * size {
            return false;
        }
        let message =
            format!("the model is {:.1e} sizes long: the size is too small for it", diagonal / size);
        let fail = |(face, f): (usize, &crate::brep::Face)| FaceFailure {
            face,
            name: f.name.clone(),
            message: message.clone(),
            case: None,
        };
        self.frame.failures = self.model.faces.iter().enumerate().map(fail).collect();
        true
    }

    /// Gives each hard point to its face.
    fn place_points(&mut self, diagonal: f64) {
        let given: Vec<DVec3> = self.options.points.iter().map(|p| p.1).collect();
        let (hard, distances) = assign(&self.context(), &given);
        self.hard = hard;
        for ((name, _), d) in self.options.points.iter().zip(&distances) {
            let words = if !d.is_finite() {
                format!("no face has the point {name} above or below it; it was left out")
            } else if *d > FAR * diagonal {
                format!("the point {name} was moved by {d:.3e} to its face")
            } else {
                continue;
            };
            self.frame.warnings.push(words);
        }
    }

    fn context(&self) -> Context<'_> {
        Context {
            model: &self.model,
            plan: &self.plan,
            table: &self.frame.table,
            rules: &self.rules,
            options: &self.options.mesher,
            layers: &self.layers,
            tolerance: self.tolerance,
        }
    }

    /// Meshes these faces, in parallel; the results are in the order of `faces`. Faces that begin after `watch` said so
    /// are failures.
    pub(crate) fn mesh_faces(&self, faces: &[usize], watch: &dyn Watch) -> Vec<FaceResult> {
        let _span = tracing::info_span!("csalf.faces", n_faces = faces.len()).entered();
        let cx = self.context();
        let none = Vec::new();
        let one = |&f: &usize| {
            if watch.cancelled() {
                let (name, message) = (self.model.faces[f].name.clone(), "cancelled".to_owned());
                return Err(Box::new(FaceFailure { face: f, name, message, case: None }));
            }
            let meshed = guarded(&cx, f, self.hard.get(f).unwrap_or(&none));
            tracing::debug!(target: "csalf::face", face = f, failed = meshed.is_err());
            meshed
        };
        faces.par_iter().map(one).collect()
    }

    /// Number of faces.
    pub fn n_faces(&self) -> usize {
        self.model.faces.len()
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Meshes all faces.
    pub fn mesh(&self) -> ModelMesh {
        self.mesh_watched(&())
    }

    /// The same; `watch` is asked before each face whether to go on. A run that was cancelled has failures.
    pub fn mesh_watched(&self, watch: &dyn Watch) -> ModelMesh {
        let n = if self.frame.able { self.model.faces.len() } else { 0 };
        let faces: Vec<usize> = (0..n).collect();
        let meshed = self.mesh_faces(&faces, watch);
        self.frame.clone().stitch(faces.into_iter().zip(meshed))
    }
}

/// What came of a face.
pub(crate) type FaceResult = Result<MeshedFace, Box<FaceFailure>>;

/// Meshes a face; a fault of ours that stops its work is a failure of this face, not of the others.
fn guarded(cx: &Context<'_>, f: usize, hard: &[Hard]) -> FaceResult {
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
    warnings: &mut Vec<String>,
) {
    let named = |p: &str| loops.iter().any(|l| is_meant(model, p, l));
    let edge = |p: &str| model.edges.iter().any(|e| crate::names::matches(p, &e.name));
    let face = |p: &str| model.faces.iter().any(|f| crate::names::matches(p, &f.name));
    let mut say = |what: &str, kind: &str, pattern: &str, found: bool| {
        if !found {
            warnings.push(format!("{what} for '{pattern}': no {kind} has such a name"));
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
fn say_plan(model: &Model, plan: &Plan, warnings: &mut Vec<String>) {
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
        warnings.push(format!("the number of segments around {faces} is odd; {cure}"));
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
