//! A mesh in space as a scene: seen along one direction, far elements first.
//!
//! ```text
//!        up                 eye: from the front, the right and above
//!        │   ╱ away         depth of an element: of its centre along the eye's direction
//!        │  ╱               light: from above and behind the eye; elements turned away from it are darker
//!        └──── right
//! ```
//!
//! 1. Turn all points.
//! 2. Leave out what a closed surface hides: elements whose outer side looks away from the eye.
//! 3. Sort the others by depth, the farthest first; equal depths keep their order.
//! 4. One fill for each run of elements of the same colour, with the thick sides of its elements over it.
//!
//! Elements of very different sizes that overlap in the picture may be drawn in the wrong order: it is a picture, not a
//! proof. Cost O(n log n).

use super::Shade;
use super::layout::Layout;
use super::scene::{Fill, Rgb, STEPS, Scene, bin, bin_of, colour_of_bin};
use crate::{IoError, MeshView};
use csalf_geom::{Point2, VertexId};
use csalf_mesh::quality::metrics;
use glam::DVec3;

/// Where the eye is, seen from the mesh.
const EYE: [f64; 3] = [0.55, -0.70, 0.46];
/// Where the light is.
const LIGHT: [f64; 3] = [0.25, -0.40, 0.88];
/// Brightness of elements along the light's rays; those across them have 1.
const DARK: f64 = 0.62;
/// Steps of brightness: more make more fills.
const LEVELS: f64 = 12.0;

/// The scene of a mesh that is checked.
pub(super) fn scene(out: &MeshView<'_>, shade: Option<&Shade<'_>>) -> Result<Scene, IoError> {
    let (mesh, sets) = (out.mesh, out.sets);
    let elements: Vec<&[_]> =
        mesh.quads.iter().map(|q| &q[..]).chain(mesh.triangles.iter().map(|t| &t[..])).collect();
    let points: Vec<DVec3> = out.xyz().map(DVec3::from_array).collect();
    let eye = DVec3::from_array(EYE).normalize();
    let right = DVec3::Z.cross(eye).normalize();
    let up = eye.cross(right);
    let seen: Vec<Point2> = points.iter().map(|p| Point2::new(p.dot(right), p.dot(up))).collect();
    let layout = Layout::new(seen.iter().copied(), elements.len())?;
    let at = |v: usize| layout.pixel(seen[v]);

    let quality = metrics::in_space(mesh, out.heights, "scaled_jacobian").unwrap_or_default();
    let mut range = vec![0usize; elements.len()];
    for (k, (_, quads)) in sets.quads.iter().filter(|s| s.0.contains("_layer")).enumerate() {
        quads.iter().filter(|q| q.index() < mesh.quads.len()).for_each(|q| range[q.index()] = 1 + k % 2);
    }
    let (thick, closed) = thick_sides(out);
    let corner = |e: &[VertexId], i: usize| points[e[i.min(e.len() - 1)].index()];
    let normal = |e: &[VertexId]| (corner(e, 2) - corner(e, 0)).cross(corner(e, 3) - corner(e, 1));
    // Positive if the normals look outwards: six times the volume.
    let outwards = elements.iter().map(|e| (corner(e, 0) + corner(e, 2)).dot(normal(e))).sum::<f64>();
    let hidden = |e: &[VertexId]| closed && normal(e).dot(eye) * outwards < 0.0;
    let depth = |e: &[VertexId]| e.iter().map(|v| points[v.index()].dot(eye)).sum::<f64>() / e.len() as f64;
    let mut order: Vec<(f64, usize)> = elements.iter().map(|e| depth(e)).zip(0..).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut fills: Vec<Fill> = Vec::new();
    let mut drawn = 0.0;
    for (_, k) in order {
        let e = elements[k];
        if hidden(e) {
            continue;
        }
        let plain = match shade {
            Some(s) => bin_of(s.values[k], s),
            None if k >= mesh.quads.len() => 1 + 3 * STEPS,
            None => bin(quality[k], range[k]),
        };
        let colour = lit(colour_of_bin(plain), normal(e));
        if fills.last().is_none_or(|f| f.colour != colour) {
            fills.push(Fill { colour, polygons: Vec::new(), lines: Vec::new() });
        }
        let Some(fill) = fills.last_mut() else { continue };
        fill.polygons.push(std::array::from_fn(|i| at(e[i.min(e.len() - 1)].index())));
        for i in 0..e.len() {
            let (a, b) = (e[i].0, e[(i + 1) % e.len()].0);
            let line = [at(a as usize), at(b as usize)];
            drawn += (line[0][0] - line[1][0]).hypot(line[0][1] - line[1][1]);
            if thick.binary_search(&[a.min(b), a.max(b)]).is_ok() {
                fill.lines.push(line);
            }
        }
    }
    let n_drawn = fills.iter().map(|f| f.polygons.len()).sum::<usize>();
    let mean = drawn / (4 * n_drawn.max(1)) as f64;
    let outline_width = if layout.many || mean < 4.0 { 0.8 } else { 1.4 };
    Ok(Scene { outline_width, ..layout.scene(fills, mean, shade) })
}

/// The sides of edge sets, and those that do not lie between two elements; sorted. And whether all lie between two: a closed
/// surface, if its elements are turned the same way.
fn thick_sides(out: &MeshView<'_>) -> (Vec<[u32; 2]>, bool) {
    let key = |a: u32, b: u32| [a.min(b), a.max(b)];
    let quads = out.mesh.quads.iter().flat_map(|q| (0..4).map(|k| key(q[k].0, q[(k + 1) % 4].0)));
    let triangles = out.mesh.triangles.iter().flat_map(|t| (0..3).map(|k| key(t[k].0, t[(k + 1) % 3].0)));
    let mut sides: Vec<[u32; 2]> = quads.chain(triangles).collect();
    sides.sort_unstable();
    let mut thick: Vec<[u32; 2]> =
        sides.chunk_by(|a, b| a == b).filter(|same| same.len() != 2).map(|same| same[0]).collect();
    let closed = thick.is_empty();
    thick.extend(out.sets.edges.iter().flat_map(|(_, e)| e).map(|[a, b]| key(a.0, b.0)));
    thick.sort_unstable();
    (thick, closed)
}

/// A colour in the light that falls on an element of this normal, from either side.
fn lit(colour: Rgb, normal: DVec3) -> Rgb {
    let facing = normal.normalize_or_zero().dot(DVec3::from_array(LIGHT).normalize()).abs();
    let brightness = DARK + (1.0 - DARK) * (facing * LEVELS).round() / LEVELS;
    colour.map(|c| (f64::from(c) * brightness).round() as u8)
}
