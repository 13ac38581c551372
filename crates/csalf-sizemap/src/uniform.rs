//! One size everywhere.

use crate::{Hint, SizeField};
use csalf_geom::Point2;

/// The constant field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uniform(pub f64);

impl SizeField for Uniform {
    fn h(&self, _: Point2, _: &mut Hint) -> f64 {
        self.0
    }
    fn constant(&self) -> Option<f64> {
        Some(self.0)
    }
    fn range(&self) -> (f64, f64) {
        (self.0, self.0)
    }
}
