//! How a caller follows a run and ends it early. Cooperative: the pipeline asks at its stages and at every contour
//! that it hands on, never inside one mesher, so a run may go on for a while after it was cancelled.

/// Watches one run of [`crate::mesh_watched`]. Methods are called from worker threads and must return at once. What
/// they do never changes a mesh; only whether there is one.
pub trait Watch: Sync {
    /// A stage begins: `check`, `size`, `fill`, `collect`, `clean`, `certify`. They come again if a mesh is made a
    /// second time by simpler means.
    fn stage(&self, name: &'static str) {
        let _ = name;
    }

    /// True if nobody wants the mesh any more.
    fn cancelled(&self) -> bool {
        false
    }
}

/// Nobody watches.
impl Watch for () {}
