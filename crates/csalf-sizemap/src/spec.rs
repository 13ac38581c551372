//! How a caller says which sizes he wants, before any field is built.

use csalf_geom::Point2;

/// A spot of another size: at distance d from `xy` the wanted length is
/// `h + clamp((d - radius) / falloff, 0, 1) * (far - h)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    /// Centre.
    pub xy: Point2,
    /// Edge length within `radius`.
    pub h: f64,
    /// Radius of the spot, >= 0.
    pub radius: f64,
    /// Distance over which the size goes over to the far one, > 0.
    pub falloff: f64,
}

/// Which size field to build for a domain.
#[derive(Clone, Debug, PartialEq, Default)]
pub enum SizeSpec {
    /// Node size is the mean of the two adjacent boundary segments; linear on the constrained Delaunay
    /// triangulation of the boundary nodes.
    #[default]
    Boundary,
    /// One length everywhere.
    Uniform {
        /// The length, > 0.
        h: f64,
    },
    /// The minimum of `far` and all sources.
    Sources {
        /// Length away from all sources, > 0.
        far: f64,
        /// The spots.
        sources: Vec<Source>,
    },
    /// Values on a triangulation of the caller's (read from `.vtu`, Gmsh `.pos`, arrays).
    Background {
        /// Nodes.
        points: Vec<Point2>,
        /// Three node indices per triangle, either orientation.
        triangles: Vec<[u32; 3]>,
        /// Wanted length per node, > 0.
        values: Vec<f64>,
    },
}
