//! One face of the model: its loops in the parameters of its surface, a chart without seams or poles, facets on it,
//! and the mesh.

mod apex;
mod case;
mod chart;
mod closed;
mod cut;
mod facets;
mod mesh;
mod open;
mod patch;
mod points;
mod trim;

pub(crate) use mesh::{Context, MeshedFace, mesh_one};
pub(crate) use points::{Hard, assign};

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A node on the boundary of a face: of the model, or made for the face alone (on a cut).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(crate) enum NodeName {
    /// Node of a vertex or edge, by its number in the whole mesh.
    Model(u32),
    /// Node of this face only.
    Own(u32),
}

/// Nodes of all edges, by number.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct NodeTable {
    /// Positions.
    pub(crate) points: Vec<DVec3>,
    /// For each edge the numbers along it, both ends included.
    pub(crate) of_edge: Vec<Vec<u32>>,
    /// The number of each vertex of the model; `u32::MAX` if no edge or loop uses it.
    pub(crate) of_vertex: Vec<u32>,
}
