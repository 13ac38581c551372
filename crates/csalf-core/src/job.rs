//! What is to be meshed.

use csalf_geom::{Domain, Point2, Tolerance};
use csalf_pave::LayerSpec;
use csalf_sizemap::{Extras, SizeError, SizeField, SizeSpec};
use std::sync::Arc;

/// A meshing job: the domain, the wanted sizes, the wanted layers. The program's own file format (JSON) reads and
/// writes exactly this.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Job {
    /// Short name, used for file names and reports.
    pub name: String,
    /// One sentence for people.
    pub about: String,
    /// Loops, scars and points.
    pub domain: Domain,
    /// Wanted sizes.
    pub size: SizeSpec,
    /// Layers by pattern of names (`hole0`, `hole*`, `outer`, `scar1`); a later entry overrides an earlier one.
    pub layers: Vec<(String, LayerSpec)>,
    /// Circle (x, y, r) over which the local quality tau_l is reported.
    pub local_region: Option<[f64; 3]>,
}

impl Job {
    /// The size field that the job asks for, with its growth bounded by `gradation`: to compare a mesh with. Cost
    /// O(n log n) in the boundary nodes.
    ///
    /// # Errors
    /// [`SizeError`] if the wanted sizes are invalid.
    pub fn size_field(&self, gradation: Option<f64>) -> Result<Arc<dyn SizeField>, SizeError> {
        let loops: Vec<Vec<Point2>> = self.domain.loops.iter().map(|l| l.nodes.clone()).collect();
        let sized = |p: &csalf_geom::HardPoint| Some((p.xy, p.size?));
        let points: Vec<(Point2, f64)> = self.domain.points.iter().filter_map(sized).collect();
        let tolerance = Tolerance::of_points(loops.iter().flatten().copied());
        csalf_sizemap::build(&self.size, &loops, &Extras { hard_points: &points, gradation }, tolerance)
    }

    /// Patterns of `layers` that match no loop, scar or point, in order.
    pub fn unmatched_layers(&self) -> Vec<&str> {
        let d = &self.domain;
        let loops = d.loops.iter().map(|l| l.name.as_str());
        let scars = d.scars.iter().map(|s| s.name.as_str());
        let names: Vec<&str> = loops.chain(scars).chain(d.points.iter().map(|p| p.name.as_str())).collect();
        let patterns = self.layers.iter().map(|(pattern, _)| pattern.as_str());
        patterns.filter(|p| !names.iter().any(|name| crate::region::matches(p, name))).collect()
    }
}
