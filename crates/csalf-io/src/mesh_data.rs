//! A mesh with its sets and values, as files hold it.

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
    /// The mesh.
    pub mesh: &'a QuadMesh,
    /// Its named groups.
    pub sets: &'a NamedSets,
    /// Values per element; formats that hold none leave them out.
    pub cell_data: &'a [CellData],
    /// One line for the head of the file.
    pub title: &'a str,
}

/// What a reader gives back.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct MeshData {
    /// The mesh.
    pub mesh: QuadMesh,
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
        MeshView { mesh: &self.mesh, sets: &self.sets, cell_data: &self.cell_data, title }
    }
}
