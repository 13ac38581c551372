//! One mesh out of the meshes of all faces, by prefix sums over the numbers of their nodes.
//!
//! ```text
//!   nodes on edges, those in use │ inner nodes of face 0 │ of face 1 │ ...      quads of face 0 │ of face 1 │ ...
//! ```
//!
//! No coordinates are compared, so that faces meshed in other processes give the same bytes.

use crate::brep::Model;
use crate::face::{MeshedFace, NodeName, NodeTable};
use crate::mesh::{FaceResult, NamedLoop};
use crate::report::{FaceFailure, LoopLayers, ModelMesh};
use csalf_geom::{QuadId, VertexId};
use csalf_mesh::quality::{FLAT, space::scaled_jacobian};
use csalf_surface::LayerSpec;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// All that the mesh is put together by, beside the faces: names and the nodes on edges.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Frame {
    /// Name of the model.
    pub(crate) name: String,
    /// Names of the faces, and of their loops; true if the caller asked for layers around it.
    pub(crate) faces: Vec<(String, Vec<(String, bool)>)>,
    /// Names of the edges.
    pub(crate) edges: Vec<String>,
    /// Names of the hard points.
    pub(crate) points: Vec<String>,
    /// Nodes on edges.
    pub(crate) table: NodeTable,
    /// What was said before any face was meshed.
    pub(crate) warnings: Vec<String>,
    /// Faces that cannot be meshed, known before.
    pub(crate) failures: Vec<FaceFailure>,
    /// False if no face can be meshed at all; the warnings or failures say why.
    pub(crate) able: bool,
}

impl Frame {
    /// The frame of a model, without nodes and loops.
    pub(crate) fn of(model: &Model, points: &[(String, DVec3)]) -> Self {
        Self {
            name: model.name.clone(),
            faces: model.faces.iter().map(|f| (f.name.clone(), Vec::new())).collect(),
            edges: model.edges.iter().map(|e| e.name.clone()).collect(),
            points: points.iter().map(|p| p.0.clone()).collect(),
            warnings: model.notes.clone(),
            ..Self::default()
        }
    }

    /// Gives the loops their names, in the order of faces and loops.
    pub(crate) fn name_loops(&mut self, loops: &[NamedLoop], layers: &[Vec<Option<LayerSpec>>]) {
        for l in loops {
            let asked = layers[l.face][l.loop_index].is_some();
            self.faces[l.face].1.push((l.name.clone(), asked));
        }
    }

    /// One mesh of faces in ascending order, each with its index.
    pub(crate) fn stitch(self, faces: impl IntoIterator<Item = (usize, FaceResult)>) -> ModelMesh {
        let mut out = ModelMesh { warnings: self.warnings, failures: self.failures, ..ModelMesh::default() };
        let faces: Vec<(usize, FaceResult)> = faces.into_iter().collect();
        // A node of an edge that only failed faces use is left out.
        let mut used = vec![false; self.table.points.len()];
        for n in faces.iter().filter_map(|f| f.1.as_ref().ok()).flat_map(|m| m.quads.iter().flatten()) {
            if let NodeName::Model(k) = n {
                used[*k as usize] = true;
            }
        }
        let mut number = vec![u32::MAX; used.len()];
        for (k, p) in self.table.points.iter().enumerate().filter(|(k, _)| used[*k]) {
            number[k] = out.mesh.points.len() as u32;
            out.mesh.points.push(*p);
        }
        for (f, result) in faces {
            match result {
                Ok(m) => add_face(f, &self.faces[f], &self.points, m, &number, &mut out),
                Err(failure) => out.failures.push(*failure),
            }
        }
        for (name, nodes) in self.edges.iter().zip(&self.table.of_edge) {
            let ids: Vec<u32> = nodes.iter().map(|&k| number[k as usize]).collect();
            let whole = ids.len() > 1 && ids.iter().all(|&k| k != u32::MAX);
            if whole {
                let sides = ids.windows(2).map(|w| [VertexId(w[0]), VertexId(w[1])]).collect();
                out.sets.edges.push((name.clone(), sides));
            }
        }
        out.count_sides();
        out
    }
}

/// Adds one face: its nodes, quads, sets and what it says. `number` are those of the nodes on edges.
fn add_face(
    f: usize,
    (face_name, loops): &(String, Vec<(String, bool)>),
    points: &[String],
    m: MeshedFace,
    number: &[u32],
    out: &mut ModelMesh,
) {
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
    out.sets.quads.push((face_name.clone(), (first_quad..n).map(id).collect()));
    let first_set = out.sets.quads.len();
    for (k, layer, quads) in &m.rings {
        let Some((name, _)) = loops.get(*k) else { continue };
        let quads = quads.iter().map(|q| id(first_quad + *q as usize)).collect();
        add_quads(&mut out.sets.quads, first_set, format!("{name}_layer{layer}"), quads);
    }
    for (k, asked, made, why) in m.layers {
        if let Some((name, true)) = loops.get(k) {
            out.layers.push(LoopLayers { name: name.clone(), asked, made, why });
        }
    }
    for &(point, k) in &m.hard {
        let node = own.get(k as usize).copied().filter(|v| *v != u32::MAX);
        let name = points.get(point);
        out.sets.nodes.extend(name.zip(node).map(|(n, v)| (n.clone(), vec![VertexId(v)])));
    }
    out.warnings.extend(m.warnings);
    say_folded(face_name, first_quad, out);
}

/// A warning if quads from the `first` on are not convex in their mean planes.
fn say_folded(face_name: &str, first: usize, out: &mut ModelMesh) {
    let quads = (first..out.mesh.quads.len()).map(|q| out.mesh.corners(QuadId::new(q)));
    let folded: Vec<DVec3> =
        quads.filter(|p| scaled_jacobian(*p) <= FLAT).map(|p| 0.25 * (p[0] + p[1] + p[2] + p[3])).collect();
    if let Some(at) = folded.first() {
        let n = folded.len();
        out.warnings.push(format!(
            "{face_name}: {n} quads are folded in space, the first at {:?}: the face is creased more sharply than quads of \
             this size can follow; mesh it with a smaller size, or mend the surface",
            at.to_array()
        ));
    }
}

/// Adds quads to the set of this name from the `first` on; the two loops of a seam have one name.
fn add_quads(sets: &mut Vec<(String, Vec<QuadId>)>, first: usize, name: String, quads: Vec<QuadId>) {
    match sets[first..].iter_mut().find(|s| s.0 == name) {
        Some(set) => set.1.extend(quads),
        None => sets.push((name, quads)),
    }
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
