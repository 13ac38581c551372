//! What came of a model.

use csalf_core::Job;
use csalf_mesh::{NamedSets, SurfaceMesh};
use serde::{Deserialize, Serialize};

/// A face without a mesh.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FaceFailure {
    /// Which face.
    pub face: usize,
    /// Its name.
    pub name: String,
    /// Why, in words.
    pub message: String,
    /// Its flat boundary as a job of the planar mesher, if it came so far.
    #[serde(with = "crate::shard::case")]
    pub case: Option<Job>,
}

/// Layers around one loop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoopLayers {
    /// Name of the loop.
    pub name: String,
    /// Layers asked for.
    pub asked: usize,
    /// Layers made.
    pub made: usize,
    /// Why not more; empty if all were made.
    pub why: String,
}

/// The mesh of a model.
#[derive(Clone, Debug, Default)]
pub struct ModelMesh {
    /// One conforming mesh of all faces that could be meshed.
    pub mesh: SurfaceMesh,
    /// Faces and layers as quad sets, edges as edge sets, named after the model.
    pub sets: NamedSets,
    /// The face of each quad.
    pub face_of_quad: Vec<u32>,
    /// Faces without a mesh.
    pub failures: Vec<FaceFailure>,
    /// Layers of loops for which any were asked.
    pub layers: Vec<LoopLayers>,
    /// What could not be done better, and what was repaired, in words.
    pub warnings: Vec<String>,
    /// Sides of quads that belong to one quad only.
    pub n_free_sides: usize,
    /// Sides that belong to three quads or more.
    pub n_branching_sides: usize,
}

impl ModelMesh {
    /// Counts the sides of one quad and those of three and more. Cost O(n log n).
    pub fn count_sides(&mut self) {
        let mut sides: Vec<[u32; 2]> = Vec::with_capacity(4 * self.mesh.quads.len());
        for q in &self.mesh.quads {
            for k in 0..4 {
                let (a, b) = (q[k].0, q[(k + 1) % 4].0);
                sides.push([a.min(b), a.max(b)]);
            }
        }
        sides.sort_unstable();
        (self.n_free_sides, self.n_branching_sides) = (0, 0);
        for run in sides.chunk_by(|a, b| a == b) {
            match run.len() {
                1 => self.n_free_sides += 1,
                2 => {}
                _ => self.n_branching_sides += 1,
            }
        }
    }
}
