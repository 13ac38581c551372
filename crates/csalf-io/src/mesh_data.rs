//! A mesh with its sets and values, as files hold it.

use crate::{IoError, MidNodes, Place};
use csalf_mesh::{NamedSets, QuadMesh};

/// One number per element: quads first, then triangles.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct CellData {
    /// Name in the file.
    pub name: String,
    /// One value per element.
    pub values: Vec<f64>,
}

/// What a writer is given.
#[derive(Clone, Copy, Debug)]
pub struct MeshView<'a> {
    /// The mesh; of one in space (`csalf_mesh::SurfaceMesh::split`), seen from above.
    pub mesh: &'a QuadMesh,
    /// Third coordinate of each vertex; empty: the mesh lies in the plane z = 0.
    pub heights: &'a [f64],
    /// Its named groups.
    pub sets: &'a NamedSets,
    /// Values per element; formats that hold none leave them out.
    pub cell_data: &'a [CellData],
    /// One line for the head of the file.
    pub title: &'a str,
}

impl MeshView<'_> {
    /// The three coordinates of every vertex.
    pub(crate) fn xyz(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        let height = |i: usize| self.heights.get(i).copied().unwrap_or(0.0);
        self.mesh.points.iter().enumerate().map(move |(i, p)| [p.x, p.y, height(i)])
    }

    /// The same, then those of mid-side nodes.
    pub(crate) fn all_xyz<'b>(&'b self, mid: Option<&'b MidNodes>) -> impl Iterator<Item = [f64; 3]> + 'b {
        self.xyz().chain(mid.into_iter().flat_map(MidNodes::points).map(|p| p.to_array()))
    }
}

/// What a reader gives back.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct MeshData {
    /// The mesh; of one in space, seen from above.
    pub mesh: QuadMesh,
    /// Third coordinate of each vertex; empty: the mesh lies in a plane z = constant.
    pub heights: Vec<f64>,
    /// Its named groups, as far as the format has them.
    pub sets: NamedSets,
    /// Values per element.
    pub cell_data: Vec<CellData>,
    /// What was left out or repaired, one sentence each.
    pub notes: Vec<String>,
}

impl MeshData {
    /// The same, as a writer takes it.
    pub fn view<'a>(&'a self, title: &'a str) -> MeshView<'a> {
        let (heights, sets, cell_data) = (&self.heights, &self.sets, &self.cell_data);
        MeshView { mesh: &self.mesh, heights, sets, cell_data, title }
    }

    /// The same, for callers that know only the plane. `format`: for the message.
    ///
    /// # Errors
    /// [`IoError::Unsupported`] if the mesh is not planar.
    pub fn planar(self, format: &'static str) -> Result<Self, IoError> {
        if self.heights.is_empty() {
            return Ok(self);
        }
        let z = || self.heights.iter().copied();
        let (lo, hi) = (z().fold(f64::INFINITY, f64::min), z().fold(f64::NEG_INFINITY, f64::max));
        let message = format!("the mesh is not planar: z runs from {lo} to {hi}");
        Err(IoError::unsupported(format, Place::Whole, message))
    }
}
