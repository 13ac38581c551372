//! Elements of second order on a model: what the command and the Python package share.

use csalf_io::MidNodes;
use csalf_model::{Model, ModelMesh, Shapes};
use glam::DVec3;

/// The nodes between the vertices of a mesh of `model`, on its curves and surfaces as far as the elements stay valid;
/// with `centres`, nine nodes per quad.
pub fn of_model(model: &Model, meshed: &ModelMesh, centres: bool) -> MidNodes {
    let shapes = Shapes::new(model);
    let on_surface: &dyn Fn(usize, DVec3) -> DVec3 = &|q, p| shapes.centre(meshed, q, p);
    MidNodes::in_space(&meshed.mesh, &shapes.middles(meshed), centres.then_some(on_surface))
}
