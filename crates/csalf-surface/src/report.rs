//! What came out of one face.

use glam::DVec3;

/// The quad mesh of one face.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FaceMesh {
    /// Positions in space. The first [`Self::nodes`] are the given ones, bit for bit.
    pub points: Vec<DVec3>,
    /// Unit normals of the surface at them, outwards.
    pub normals: Vec<DVec3>,
    /// Four vertices per quad, counter-clockwise seen from outside.
    pub quads: Vec<[u32; 4]>,
    /// Facet vertex of each of the first points: the nodes of the loops in the order given, then those of the
    /// scars, then the points, each once.
    pub nodes: Vec<u32>,
    /// The finished layers.
    pub rings: Vec<LayerRing>,
    /// How it went.
    pub report: FaceReport,
}

/// The quads of one layer around a loop.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LayerRing {
    /// Index of the loop.
    pub loop_index: usize,
    /// 1 for the layer at the loop.
    pub layer: usize,
    /// Its quads.
    pub quads: Vec<u32>,
}

/// How a face was brought into the plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Flattening {
    /// It lies in a plane.
    #[default]
    Plane,
    /// The caller's flat coordinates.
    Given,
    /// Unrolled without distortion.
    Unrolled,
    /// Least squares conformal map.
    Conformal,
    /// Convex (Tutte) map, then relaxed.
    Relaxed,
}

/// How one face was meshed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FaceReport {
    /// The flattening of the hardest chart.
    pub flattening: Flattening,
    /// Pieces that the face was cut into; 1: not cut.
    pub n_charts: usize,
    /// Ratio of the singular values of the flattening, at least 1, that 99 % of the area stay below.
    pub anisotropy: f64,
    /// Ratio of the largest to the smallest local scale of the flattening (99 % of the area).
    pub scale_range: f64,
    /// Largest difference (degrees) between the angle of the material at a vertex of a contour in space and
    /// in the plane, where the planar mesher sees it.
    pub max_angle_error: f64,
    /// Vertices for which the surface gave no usable point; they stay on their facet.
    pub n_unprojected: usize,
    /// Places that were meshed again across seams.
    pub n_healed: usize,
    /// Quality measured in space.
    pub quality: Quality3d,
    /// Per loop: layers asked, made, and why no more were made (empty if all were).
    pub layers: Vec<(usize, usize, String)>,
    /// Warnings of the planar mesher, in words.
    pub warnings: Vec<String>,
}

/// Quality of quads in space. Corner Jacobians are about the normal of the quad's mean plane, negative where
/// it is turned over against the surface. Of no quads: all 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Quality3d {
    /// Smallest scaled Jacobian, -1 to 1.
    pub min_sj: f64,
    /// Mean scaled Jacobian.
    pub mean_sj: f64,
    /// Harmonic mean of Jmin / Jmax, 0 to 1 (paper eq. 21, handbook 1.12), over the quads without flat
    /// corners.
    pub tau: f64,
    /// Largest warpage: distance of the corners from the mean plane over the mean side length.
    pub max_warpage: f64,
    /// Largest distance of a quad's centre from the facets, in model units.
    pub max_deviation: f64,
    /// Quads with a corner that is flat, concave or turned over.
    pub n_nonpositive: usize,
}
