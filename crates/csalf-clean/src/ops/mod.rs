//! Local changes of topology, each an operation that finds its sites and says what it would change.

mod disks;
mod doublet;
mod singlet;

use csalf_geom::{Point2, VertexId};
use csalf_mesh::{QuadMesh, QuadTopology};

pub use disks::{Disk, MAX_RIM, disks};
pub use doublet::Doublet;
pub use singlet::Singlet;

/// What an operation may read.
#[derive(Clone, Copy, Debug)]
pub struct Site<'a> {
    /// The mesh.
    pub mesh: &'a QuadMesh,
    /// Its topology.
    pub topology: &'a QuadTopology,
    /// Per vertex: must not move or vanish. Boundary vertices count as fixed anyhow.
    pub fixed: &'a [bool],
    /// Edges that must stay (scars), the smaller vertex first, ascending.
    pub kept: &'a [[VertexId; 2]],
}

impl Site<'_> {
    /// True if the edge `a`-`b` must stay. Cost O(log n).
    pub fn keeps(&self, a: u32, b: u32) -> bool {
        self.kept.binary_search(&[VertexId(a.min(b)), VertexId(a.max(b))]).is_ok()
    }
}

/// One local change: these quads go, those come. Quads that come cover what the ones that go covered, with
/// the same rim in the same direction.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Edit {
    /// Quads that go.
    pub remove: Vec<u32>,
    /// Quads that come, counter-clockwise; `n_vertices + k` is new point k.
    pub add: Vec<[u32; 4]>,
    /// Where the new points start; smoothing places them.
    pub points: Vec<Point2>,
    /// True if the mesh cannot be valid without the change.
    pub mandatory: bool,
}

/// A kind of local change.
pub trait CleanOp: Sync + std::fmt::Debug {
    /// Stable name, for traces and reports.
    fn name(&self) -> &'static str;

    /// All changes of this kind that the mesh wants, in the order of their vertex. They may overlap: the
    /// driver applies those that do not. Cost O(n).
    fn find(&self, site: &Site<'_>) -> Vec<Edit>;
}
