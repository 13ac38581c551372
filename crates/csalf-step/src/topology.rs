//! Bodies, faces, edges and vertices of a STEP model; the assembly tree.

use crate::StepError;
use crate::geometry::{edge_curve, face_surface, vec3};
use csalf_model::Model;
use csalf_model::brep::{Body, Edge, EdgeUse, Face, FaceShape, Loop};
use csalf_model::geometry::{Frame, Motion};
use glam::DVec3;
use std::collections::BTreeMap;
use step_io::scene::{ProductDef, Scene, Shell};
use step_io::{Orientation, Report, StepModel};

/// Assemblies deeper than this run in a circle.
const DEPTH: usize = 32;
/// More instances than this are a mistake.
const INSTANCES: usize = 100_000;

pub(crate) fn read(step: &StepModel, report: &Report) -> Result<Model, StepError> {
    let scene = step.scene();
    let units = scene.units();
    let mut reader = Reader {
        step,
        radians: units.angle.as_ref().map_or(1.0, |u| u.to_si),
        parts: BTreeMap::new(),
        n_instances: 0,
    };
    let mut model = Model::default();
    let roots: Vec<ProductDef<'_>> = scene.root_definitions().collect();
    for root in &roots {
        if model.name.is_empty() {
            model.name = root.product().map(|p| p.name().to_owned()).unwrap_or_default();
        }
        reader.place(*root, &Motion::IDENTITY, "", 0, &mut model);
    }
    if model.faces.is_empty() {
        // Geometry that no product points to.
        let mut part = Part::new(step, reader.radians);
        part.all(&scene);
        model.add_instance(&part.model, &Motion::IDENTITY, "");
    }
    if model.faces.is_empty() {
        let dropped = report.dropped.len();
        let why =
            if dropped > 0 { format!(" ({dropped} entities could not be read)") } else { String::new() };
        return Err(StepError::NoFaces(why));
    }
    if !report.dropped.is_empty() {
        model.notes.push(format!("{} entities of the file could not be read", report.dropped.len()));
    }
    model.unit = units.length.map(|u| u.name).unwrap_or_default();
    unique_names(&mut model);
    Ok(model)
}

/// Gives each face and edge a name of its own: empty and repeated ones get their number.
fn unique_names(model: &mut Model) {
    let rename = |names: Vec<&mut String>, what: &str| {
        let mut times: BTreeMap<String, usize> = BTreeMap::new();
        for n in &names {
            *times.entry((**n).clone()).or_default() += 1;
        }
        for (k, n) in names.into_iter().enumerate() {
            let plain = n.trim().is_empty() || n.eq_ignore_ascii_case("none");
            if plain {
                *n = format!("{what}{}", k + 1);
            } else if times.get(n).is_some_and(|t| *t > 1) {
                *n = format!("{n}_{what}{}", k + 1);
            }
        }
    };
    rename(model.faces.iter_mut().map(|f| &mut f.name).collect(), "face");
    rename(model.edges.iter_mut().map(|e| &mut e.name).collect(), "edge");
}

struct Reader<'m> {
    step: &'m StepModel,
    radians: f64,
    /// Parts read so far, by the key of their definition.
    parts: BTreeMap<String, Model>,
    n_instances: usize,
}

impl<'m> Reader<'m> {
    /// Places a definition and all below it.
    fn place(&mut self, def: ProductDef<'m>, motion: &Motion, path: &str, depth: usize, into: &mut Model) {
        self.n_instances += 1;
        if depth > DEPTH || self.n_instances > INSTANCES {
            return;
        }
        let key = format!("{:?}", def.key());
        let step = self.step;
        let radians = self.radians;
        let part = self.parts.entry(key).or_insert_with(|| {
            let mut part = Part::new(step, radians);
            part.definition(&def);
            part.model
        });
        into.add_instance(part, motion, path);
        for occurrence in def.occurrences() {
            let Some(child) = occurrence.definition() else { continue };
            let moved = match occurrence.transform().and_then(|t| t.matrix()) {
                Some(m) => {
                    let column = |k: usize| DVec3::new(m[0][k], m[1][k], m[2][k]);
                    let to = Frame { origin: column(3), x: column(0), y: column(1), z: column(2) };
                    motion.after(&Motion { to })
                }
                None => *motion,
            };
            self.place(child, &moved, path, depth + 1, into);
        }
    }
}

/// One part being read.
struct Part<'m> {
    step: &'m StepModel,
    radians: f64,
    model: Model,
    vertices: BTreeMap<String, usize>,
    edges: BTreeMap<String, Option<usize>>,
}

impl<'m> Part<'m> {
    fn new(step: &'m StepModel, radians: f64) -> Self {
        Self { step, radians, model: Model::default(), vertices: BTreeMap::new(), edges: BTreeMap::new() }
    }

    fn definition(&mut self, def: &ProductDef<'m>) {
        let name = def.product().map(|p| p.name().to_owned()).unwrap_or_default();
        let bodies: Vec<_> = def.solids().collect();
        for solid in bodies {
            let name = if solid.name().trim().is_empty() { &name } else { solid.name() }.to_owned();
            let shells: Vec<_> = solid.outer().into_iter().chain(solid.voids()).collect();
            self.body(name, true, shells);
        }
        for s in def.surface_models() {
            let name = if s.name().trim().is_empty() { &name } else { s.name() }.to_owned();
            self.body(name, false, s.shells().collect());
        }
    }

    fn all(&mut self, scene: &'m Scene<'m>) {
        for solid in scene.all_solids() {
            let shells: Vec<_> = solid.outer().into_iter().chain(solid.voids()).collect();
            self.body(solid.name().to_owned(), true, shells);
        }
        for s in scene.all_surface_models() {
            self.body(s.name().to_owned(), false, s.shells().collect());
        }
    }

    fn body(&mut self, name: String, solid: bool, shells: Vec<(Shell<'m>, Orientation)>) {
        let mut body = Body { name, faces: Vec::new(), solid };
        for (shell, orientation) in shells {
            for face in shell.faces() {
                body.faces.push(self.face(&face, orientation == Orientation::Reversed));
            }
        }
        self.model.bodies.push(body);
    }

    fn face(&mut self, face: &step_io::scene::Face<'m>, turned: bool) -> usize {
        let forward = (face.orientation() == Orientation::Forward) != turned;
        let mut loops = Vec::new();
        for bound in face.bounds() {
            let along = (bound.orientation() == Orientation::Forward) != turned;
            let mut l = Loop { uses: Vec::new(), vertex: bound.vertex().and_then(|v| self.vertex(&v)) };
            for (edge, orientation) in bound.oriented_edges() {
                if let Some(edge) = self.edge(&edge) {
                    l.uses.push(EdgeUse { edge, forward: (orientation == Orientation::Forward) == along });
                }
            }
            if !along {
                l.uses.reverse();
            }
            loops.push(l);
        }
        let color = face.color().or_else(|| face.solid().and_then(|s| s.color()));
        let color = color.map(|c| [c.red, c.green, c.blue]);
        let shape = face_surface(self.step, face, self.radians)
            .map_or(FaceShape::Unread, |(surface, kept)| FaceShape::Surface(surface, forward == kept));
        self.model.faces.push(Face { name: face.name().to_owned(), shape, loops, color });
        self.model.faces.len() - 1
    }

    fn vertex(&mut self, vertex: &step_io::scene::Vertex<'m>) -> Option<usize> {
        let key = format!("{:?}", vertex.key());
        if let Some(&v) = self.vertices.get(&key) {
            return Some(v);
        }
        let point = vec3(vertex.point()?.xyz());
        let v = self.model.add_vertex(point);
        self.vertices.insert(key, v);
        Some(v)
    }

    fn edge(&mut self, edge: &step_io::scene::Edge<'m>) -> Option<usize> {
        let key = format!("{:?}", edge.key());
        if let Some(&e) = self.edges.get(&key) {
            return e;
        }
        let index = self.new_edge(edge);
        if index.is_none() {
            self.model.notes.push(format!("{key} was left out: its curve or its vertices are not read"));
        }
        self.edges.insert(key, index);
        index
    }

    fn new_edge(&mut self, edge: &step_io::scene::Edge<'m>) -> Option<usize> {
        let (a, b) = (self.vertex(&edge.start()?)?, self.vertex(&edge.end()?)?);
        let ends = [a, b].map(|v| self.model.vertices[v].point);
        let (curve, range) = edge_curve(self.step, edge, ends)?;
        self.model.edges.push(Edge { name: String::new(), curve, range, ends: [a, b], tolerance: 0.0 });
        Some(self.model.edges.len() - 1)
    }
}
