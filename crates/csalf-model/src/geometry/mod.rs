//! Curves and surfaces: evaluation and inversion.

mod curve;
mod frame;
mod invert;
mod nurbs;
mod offset;
mod surface;
#[cfg(test)]
mod tests;

pub use curve::{Curve, CurvePoint, Polyline};
pub use frame::{Frame, Motion};
pub use invert::Inverter;
pub use nurbs::{Knots, MAX_DEGREE, NurbsCurve, NurbsSurface};
pub use surface::{Surface, SurfacePoint};
