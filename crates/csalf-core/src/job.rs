//! What is to be meshed.

use csalf_geom::Domain;
use csalf_pave::LayerSpec;
use csalf_sizemap::SizeSpec;

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
