//! The seam: one contour in, one step out.
//!
//! ```text
//!                    ┌ quads only               transfinite interpolation, patterns, closure stencils
//!   RegionTask ──▶ Patch ┤ quads + one child    loop-paving (a ring and what is left inside)
//!   (a contour)      └ children only            subdivision (a split line), above the seam size
//! ```
//!
//! A mesher is pure: it reads the task and returns a value. A failed step is dropped like any value, two meshers
//! can be compared on one contour, disjoint children can be meshed in parallel.

use csalf_geom::{Point2, Tolerance};
use csalf_sizemap::SizeField;

/// What is known of one node of a contour.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct NodeFlags(pub u8);

impl NodeFlags {
    /// The node belongs to the input (a loop, a scar, a hard point): it must not move.
    pub const GEOMETRY: Self = Self(1);
    /// The node belongs to a user layer: a neighbour may not edit the quads behind it.
    pub const LAYER: Self = Self(2);

    /// Both sets of flags.
    pub const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
    /// True if all flags of `other` are set.
    pub const fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

/// One closed contour, material on the left, as node **occurrences**: a node may occur more than once (the two
/// sides of a bridge or scar). All slices have one entry per occurrence, the same length n >= 3
/// (`wanted` may be empty).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contour {
    /// Where each occurrence lies.
    pub points: Vec<Point2>,
    /// Which node it is: equal ids are the same node. Opaque to meshers.
    pub ids: Vec<u32>,
    /// Wanted edge length at each occurrence.
    pub sizes: Vec<f64>,
    /// What is known of each node.
    pub flags: Vec<NodeFlags>,
    /// Number of quads wanted at each occurrence, where that is known from the mesh around: 1 at a logical
    /// corner, 2 on a side. Empty: the mesher decides by angles. If given, the nodes will be moved when the
    /// contour is filled: its angles do not count, and the quads of the patch need not be convex.
    pub wanted: Vec<u8>,
    /// With `wanted`: patches with more irregular vertices inside than this are of no use. `None`: any number is good.
    pub most_irregular: Option<u32>,
}

impl Contour {
    /// A contour of distinct geometry nodes 0..n, sizes all `h`: for tests and single use of one mesher.
    pub fn from_ring(points: &[Point2], h: f64) -> Self {
        Self {
            points: points.to_vec(),
            ids: (0..points.len() as u32).collect(),
            sizes: vec![h; points.len()],
            flags: vec![NodeFlags::GEOMETRY; points.len()],
            wanted: Vec::new(),
            most_irregular: None,
        }
    }

    /// Number of occurrences.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// True of no occurrences.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Adds one occurrence at the end.
    pub fn push(&mut self, point: Point2, id: u32, size: f64, flags: NodeFlags) {
        self.points.push(point);
        self.ids.push(id);
        self.sizes.push(size);
        self.flags.push(flags);
    }

    /// For every occurrence the first one of the same node. Cost O(n log n).
    pub fn first_occurrences(&self) -> Vec<u32> {
        let ids = &self.ids;
        let mut order: Vec<u32> = (0..ids.len() as u32).collect();
        order.sort_unstable_by_key(|&i| (ids[i as usize], i));
        let mut out = vec![0; ids.len()];
        for same in order.chunk_by(|&a, &b| ids[a as usize] == ids[b as usize]) {
            for &i in same {
                out[i as usize] = same[0];
            }
        }
        out
    }

    /// Interior angle at occurrence `i`, in (0, 2π]; 2π at a slit tip (both neighbours are one node).
    pub fn angle(&self, i: usize) -> f64 {
        let n = self.len();
        let (a, c) = ((i + n - 1) % n, (i + 1) % n);
        if self.ids[a] == self.ids[c] {
            return std::f64::consts::TAU;
        }
        csalf_geom::angle::interior_angle(self.points[a], self.points[i], self.points[c])
    }
}

/// Everything a mesher may read.
#[derive(Clone, Copy, Debug)]
pub struct RegionTask<'a> {
    /// The contour to be filled.
    pub contour: &'a Contour,
    /// How large the quads shall be.
    pub size: &'a dyn SizeField,
    /// Length thresholds of the run.
    pub tolerance: Tolerance,
}

/// What one step made, in local names: `i < n` is occurrence i of the contour, `n + k` is new point k.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Patch {
    /// Coordinates of new points.
    pub points: Vec<Point2>,
    /// New quads, counter-clockwise, in local names.
    pub quads: Vec<[u32; 4]>,
    /// Contours that are still to be filled, in local names, material on the left, each of even length.
    pub children: Vec<Vec<u32>>,
    /// How many contours within this step were filled by the guaranteed fallback.
    pub n_fallbacks: usize,
}

impl Patch {
    /// The point of a local name.
    #[inline]
    pub fn point(&self, contour: &Contour, name: u32) -> Point2 {
        let n = contour.len();
        if (name as usize) < n { contour.points[name as usize] } else { self.points[name as usize - n] }
    }
}

/// Forecast of what a mesher would make of a contour.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Appraisal {
    /// Expected smallest scaled Jacobian, -1 to 1.
    pub min_sj: f64,
    /// Expected mean scaled Jacobian, -1 to 1.
    pub mean_sj: f64,
    /// Number of irregular inner vertices.
    pub n_irregular: u32,
    /// Expected number of quads.
    pub n_quads: u32,
    /// Geometric mean of max(r, 1/r) over the cells, r = sqrt(area)/h; 1 is perfect.
    pub size_error: f64,
    /// Largest max(r, 1/r).
    pub worst_size_error: f64,
}

/// How a mesher would fill a contour, in numbers of its own: what [`RegionMesher::foresee`] found, so that
/// [`RegionMesher::mesh_by`] need not find it again.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Recipe {
    /// Known to the mesher alone.
    pub words: [u32; Self::WORDS],
}

impl Recipe {
    /// Size of a recipe.
    pub const WORDS: usize = 20;
}

/// Why a mesher did not take a contour. Not an error: another member will.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum Refusal {
    /// The contour is not of a kind that this mesher fills (corners, counts, convexity).
    #[error("the contour is not of a kind that this mesher fills")]
    NotApplicable,
    /// It could be filled, but with quads below the accepted quality.
    #[error("the quads would be of too low a quality")]
    Quality,
    /// It could be filled, but with sizes too far from the field.
    #[error("the quads would be too far from the wanted size")]
    Size,
}

/// A member of the triad (or a fallback): loop-paving, subdivision, transfinite interpolation.
pub trait RegionMesher: Send + Sync + std::fmt::Debug {
    /// Stable name, for traces, reports and the command line.
    fn name(&self) -> &'static str;

    /// Cheap forecast of [`Self::mesh`]; `None` if it would surely refuse. Pure.
    fn appraise(&self, task: &RegionTask<'_>) -> Option<Appraisal>;

    /// A guess, cheaper than [`Self::appraise`], of how badly the contour would be filled: 0 is perfect, above 1 it is
    /// hardly worth a try; `None` if the mesher would surely refuse. For ranking only. Pure.
    fn glance(&self, task: &RegionTask<'_>) -> Option<f64> {
        self.appraise(task).map(|a| 1.0 - a.mean_sj)
    }

    /// [`Self::appraise`] with the way to do it. Pure.
    fn foresee(&self, task: &RegionTask<'_>) -> Option<(Appraisal, Recipe)> {
        self.appraise(task).map(|a| (a, Recipe::default()))
    }

    /// [`Self::mesh`] after [`Self::foresee`] of the same contour gave this recipe: mostly the same, but cheaper.
    ///
    /// # Errors
    /// As [`Self::mesh`].
    fn mesh_by(&self, task: &RegionTask<'_>, _recipe: &Recipe) -> Result<Patch, Refusal> {
        self.mesh(task)
    }

    /// One step. The quads and children of the patch cover the contour exactly, every contour segment belongs to
    /// exactly one of them, all quads are strictly convex (a mesher may be told otherwise, where the mesh will be
    /// untangled), all children have even length and are smaller than the
    /// contour (in area or in nodes).
    ///
    /// # Errors
    /// A [`Refusal`]: the mesher leaves this contour to others.
    fn mesh(&self, task: &RegionTask<'_>) -> Result<Patch, Refusal>;
}

#[cfg(test)]
mod tests {
    use super::Contour;

    #[test]
    fn ids_become_first_occurrences() {
        let of = |ids: &[u32]| Contour { ids: ids.to_vec(), ..Contour::default() }.first_occurrences();
        assert_eq!(of(&[7, 3, 7, 9, 3]), [0, 1, 0, 3, 1]);
        assert_eq!(of(&[]), [0u32; 0]);
    }
}
