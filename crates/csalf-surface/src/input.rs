//! What is to be meshed: a triangulated patch, the nodes on its boundary, sizes, layers, the surface beneath.

use csalf_pave::LayerSpec;
use glam::{DVec2, DVec3};

/// A triangulated patch, consistently oriented (counter-clockwise seen from outside the material).
///
/// Its boundary is already discretised: every node of the quad mesh on a loop, scar or point is a vertex of
/// the facets, and scars run along sides of facets. The caller splits facets where needed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Facets {
    /// Vertices, in model units.
    pub points: Vec<DVec3>,
    /// Three vertices per facet.
    pub triangles: Vec<[u32; 3]>,
}

/// The mesh nodes along one closed boundary curve of the patch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FaceLoop {
    /// Facet vertices that are mesh nodes, in order along the curve, the first not repeated; either
    /// orientation. The boundary of the facets may have more vertices between them.
    pub nodes: Vec<u32>,
    /// Layers asked for around this loop; `None`: the mesher's own rule.
    pub layers: Option<LayerSpec>,
}

/// Wanted edge lengths, measured in space.
#[derive(Clone, Copy, Debug, Default)]
pub enum FaceSize<'a> {
    /// Carried into the face from the lengths of the segments of its loops. (The cheapest.)
    #[default]
    Boundary,
    /// One length everywhere, > 0.
    Uniform(f64),
    /// One length per facet vertex, > 0; linear on the facets.
    Vertices(&'a [f64]),
}

/// One face.
#[derive(Clone, Copy, Debug)]
pub struct FaceInput<'a> {
    /// The patch.
    pub facets: &'a Facets,
    /// All boundary loops of the patch, outer or hole, in any order; none of a closed surface. Their number
    /// of segments must be even in total.
    pub loops: &'a [FaceLoop],
    /// Chains of facet vertices inside that the mesh edges must follow, each successive pair a side of a
    /// facet.
    pub scars: &'a [Vec<u32>],
    /// Facet vertices inside that must be mesh vertices: hard points, weld spots, poles.
    pub points: &'a [u32],
    /// Wanted sizes.
    pub size: FaceSize<'a>,
    /// Flat coordinates per facet vertex that the caller knows to be good, such as the unrolled (u, v) of a
    /// cylinder or cone: lengths should be those in space, or all in one proportion locally. Used if they
    /// pass the tests that the flattenings of this crate must pass.
    pub flat: Option<&'a [DVec2]>,
    /// The true surface beneath the facets; `None` if the facets are all there is.
    pub surface: Option<&'a dyn Projector>,
}

/// A point of the true surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Where.
    pub point: DVec3,
    /// Unit normal, on the side that the facets' normals point to.
    pub normal: DVec3,
}

/// The true surface beneath the facets (of a CAD model).
pub trait Projector: Sync + std::fmt::Debug {
    /// The surface point nearest to `near`, which lies on facet `facet` at the barycentric coordinates `bary`
    /// (a start for iterations); `None` if there is none. Answers that are far off are refused by the caller.
    /// Pure.
    fn project(&self, near: DVec3, facet: u32, bary: [f64; 3]) -> Option<SurfacePoint>;

    /// True if [`Self::project`] follows from the place on the facet alone: a map, continuous from facet to facet. Its
    /// answers are then taken however coarse the facets are; those of a search are held against the facet.
    fn is_map(&self) -> bool {
        false
    }
}
