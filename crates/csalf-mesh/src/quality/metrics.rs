//! One number per element: quads first, then triangles.

use super::{Corners, angles, aspect, jacobian_ratio, scaled_jacobian, shape, skew, space};
use crate::{QuadMesh, SurfaceMesh};
use csalf_geom::{Point2, QuadId};
use csalf_sizemap::{Hint, SizeField};

/// Names of all metrics, in the order in which people are shown them.
pub const NAMES: [&str; 12] = [
    "scaled_jacobian",
    "shape",
    "skew",
    "aspect_ratio",
    "jacobian_ratio",
    "min_angle",
    "max_angle",
    "area",
    "edge_ratio",
    "min_edge",
    "warpage",
    "size_ratio",
];

/// How a metric is shown to people.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Name of the metric, one of [`NAMES`].
    pub name: &'static str,
    /// What people read.
    pub label: &'static str,
    /// Which values are good: `high`, `low`, or those near `one`.
    pub good: &'static str,
    /// Value at the lower end of the colour scale.
    pub low: f64,
    /// Value at the upper end.
    pub high: f64,
}

/// The metrics that interactive pages show, the most telling first.
pub const SCALES: [Scale; 7] = [
    Scale { name: "scaled_jacobian", label: "scaled Jacobian", good: "high", low: 0.0, high: 1.0 },
    Scale { name: "shape", label: "shape", good: "high", low: 0.0, high: 1.0 },
    Scale { name: "skew", label: "skew", good: "low", low: 0.0, high: 1.0 },
    Scale { name: "aspect_ratio", label: "aspect ratio", good: "low", low: 1.0, high: 4.0 },
    Scale { name: "min_angle", label: "smallest angle", good: "high", low: 0.0, high: 90.0 },
    Scale { name: "max_angle", label: "largest angle", good: "low", low: 90.0, high: 180.0 },
    Scale { name: "size_ratio", label: "size made / wanted", good: "one", low: 0.5, high: 2.0 },
];

/// How the metric is shown that only meshes in space have.
pub const WARPAGE: Scale = Scale { name: "warpage", label: "warpage", good: "low", low: 0.0, high: 0.2 };

/// The values of a metric; NaN where it is not defined (of triangles, or without a size field). `None` if there is no
/// such metric. Cost O(n), and one size query per element for `size_ratio`.
pub fn values(mesh: &QuadMesh, name: &str, field: Option<&dyn SizeField>) -> Option<Vec<f64>> {
    let nan = |_: &[Point2; 3]| f64::NAN;
    Some(match name {
        "scaled_jacobian" => each(mesh, scaled_jacobian::value, scaled_jacobian::of_triangle),
        "shape" => each(mesh, shape::value, nan),
        "skew" => each(mesh, skew::value, nan),
        "aspect_ratio" => each(mesh, aspect::value, |p| aspect::of_corners(&Corners::new(p))),
        "jacobian_ratio" => each(mesh, jacobian_ratio::value, nan),
        "min_angle" => each(mesh, |p| angles::min_max(p).0, |p| angles::min_max(p).0),
        "max_angle" => each(mesh, |p| angles::min_max(p).1, |p| angles::min_max(p).1),
        "area" => each(mesh, |p| Corners::new(p).area, |p| Corners::new(p).area),
        "edge_ratio" => each(mesh, |p| edge_ratio(p), |p| edge_ratio(p)),
        "min_edge" => each(mesh, |p| edges(p).0, |p| edges(p).0),
        "warpage" => each(mesh, |_| 0.0, |_| 0.0),
        "size_ratio" => {
            let Some(field) = field else {
                return Some(vec![f64::NAN; mesh.n_quads() + mesh.triangles.len()]);
            };
            let hint = std::cell::Cell::new(Hint::default());
            let ratio = |area: f64, centre: Point2| {
                let mut here = hint.get();
                let h = field.h(centre, &mut here);
                hint.set(here);
                area.max(0.0).sqrt() / h
            };
            each(
                mesh,
                |p| ratio(Corners::new(p).area, 0.25 * (p[0] + p[1] + p[2] + p[3])),
                |p| ratio(Corners::new(p).area, (p[0] + p[1] + p[2]) / 3.0),
            )
        }
        _ => return None,
    })
}

/// The values of a metric of a mesh in space, seen from above with the heights of its vertices: each element is laid
/// into its mean plane first; scaled Jacobians have the lengths in space. `None` if there is no such metric;
/// `size_ratio` is NaN. Cost O(n).
pub fn in_space(mesh: &QuadMesh, heights: &[f64], name: &str) -> Option<Vec<f64>> {
    let mut out = values(&space::laid_flat(mesh, heights), name, None)?;
    let value: fn([glam::DVec3; 4]) -> f64 = match name {
        "scaled_jacobian" => space::scaled_jacobian,
        "warpage" => space::warpage,
        _ => return Some(out),
    };
    for (x, q) in out.iter_mut().zip(&mesh.quads) {
        *x = value(q.map(|v| space::place(mesh, heights, v)));
    }
    Some(out)
}

/// Scaled Jacobian of each quad in space: the least over the corners, against the quad's mean normal.
pub fn scaled_jacobians(mesh: &SurfaceMesh) -> Vec<f64> {
    (0..mesh.quads.len()).map(|q| space::scaled_jacobian(mesh.corners(QuadId::new(q)))).collect()
}

/// Shortest and longest side.
fn edges(p: &[Point2]) -> (f64, f64) {
    let length = |k: usize| p[k].distance(p[(k + 1) % p.len()]);
    (0..p.len()).map(length).fold((f64::INFINITY, 0.0), |(lo, hi), l| (lo.min(l), hi.max(l)))
}

/// Longest over shortest side, 1 or more; infinite if one has no length. What most solvers call the aspect ratio.
fn edge_ratio(p: &[Point2]) -> f64 {
    let (shortest, longest) = edges(p);
    if shortest > 0.0 { longest / shortest } else { f64::INFINITY }
}

fn each(
    mesh: &QuadMesh,
    quad: impl Fn(&[Point2; 4]) -> f64,
    triangle: impl Fn(&[Point2; 3]) -> f64,
) -> Vec<f64> {
    let quads = mesh.quads.iter().map(|q| quad(&q.map(|v| mesh.points[v.index()])));
    let triangles = mesh.triangles.iter().map(|t| triangle(&t.map(|v| mesh.points[v.index()])));
    quads.chain(triangles).collect()
}
