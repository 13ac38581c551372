//! Where a mesh lies in its picture, and whether it can be drawn at all.

use super::scene::{BAR_WIDTH, Fill, MARGIN, MIN_HEIGHT, Scene};
use super::{FORMAT, Shade};
use crate::{IoError, MeshView, Place};
use csalf_geom::{Point2, polygon};

/// A mesh of more quads than this is drawn larger, without dots.
const MANY_QUADS: usize = 50_000;

/// Vertices that are there and at finite places, and a value per element to colour.
pub(super) fn check(out: &MeshView<'_>, shade: Option<&Shade<'_>>) -> Result<(), IoError> {
    let bad = |m: &str| Err(IoError::unsupported(FORMAT, Place::Whole, m));
    let mesh = out.mesh;
    let mut ids = mesh.quads.iter().flatten().chain(mesh.triangles.iter().flatten());
    if ids.any(|v| v.index() >= mesh.points.len()) {
        return bad("an element names a vertex that is not there");
    }
    if !out.xyz().flatten().all(f64::is_finite) {
        return bad("a vertex is not at a finite place");
    }
    if shade.is_some_and(|s| s.values.len() != mesh.quads.len() + mesh.triangles.len()) {
        return bad("the colours need one value per element");
    }
    Ok(())
}

/// The box of the vertices as seen, scaled into the picture.
#[derive(Debug)]
pub(super) struct Layout {
    /// Pixels per unit.
    pub scale: f64,
    /// So many elements that dots would cover them.
    pub many: bool,
    low: f64,
    high: f64,
    /// Width and height of the mesh.
    size: Point2,
    /// Height of mesh and bar.
    height: f64,
}

impl Layout {
    /// Of vertices (x to the right, y up) of a mesh of so many elements.
    pub(super) fn new(seen: impl Iterator<Item = Point2>, n_elements: usize) -> Result<Self, IoError> {
        let (lo, hi) = polygon::bounds(seen).unwrap_or((Point2::ZERO, Point2::ONE));
        let many = n_elements > MANY_QUADS;
        let side = if many { 1600.0 } else { 1000.0 };
        let extent = (hi - lo).max_element();
        if !extent.is_finite() {
            return Err(IoError::unsupported(FORMAT, Place::Whole, "a vertex is not at a finite place"));
        }
        let scale = if extent > 0.0 { side / extent } else { 1.0 };
        let size = (hi - lo) * scale;
        Ok(Self { scale, many, low: lo.x, high: hi.y, size, height: size.y.max(MIN_HEIGHT) })
    }

    /// The pixel of a vertex.
    pub(super) fn pixel(&self, p: Point2) -> [f64; 2] {
        let top = MARGIN + 0.5 * (self.height - self.size.y);
        [MARGIN + (p.x - self.low) * self.scale, top + (self.high - p.y) * self.scale]
    }

    /// The scene of these polygons, whose sides are so many pixels long on average, with the colour bar.
    pub(super) fn scene(&self, fills: Vec<Fill>, mean: f64, shade: Option<&Shade<'_>>) -> Scene {
        let mut scene = Scene {
            width: MARGIN + self.size.x + MARGIN + BAR_WIDTH,
            height: self.height + 2.0 * MARGIN,
            fills,
            line_width: if mean < 2.5 { 0.0 } else { (mean / 20.0).clamp(0.2, 0.8) },
            ..Scene::default()
        };
        scene.add_bar(MARGIN + self.size.x + 0.75 * MARGIN, self.height, shade);
        scene
    }
}
