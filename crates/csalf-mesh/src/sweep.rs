//! Sweeps a planar quad mesh along a path into hexahedra.
//!
//! ```text
//!        ___________
//!       /__/__/__/ /|      level 2        the source keeps its nodes; every level is the source, moved along the path
//!      /__/__/__/ /||      level 1        and cut by the level's plane
//!     /__/__/__/ /|/       level 0: the source
//! ```
//!
//! The first leg's levels are parallel to the source, whatever its angle to it. At a bend, the level lies in the plane that
//! halves the angle, as in a mitred corner, and from there on square to the path: swept walls stay straight.

use crate::{NamedSets, QuadMesh};
use csalf_geom::{QuadId, VertexId};
use glam::DVec3;

/// A mesh of hexahedra.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HexMesh {
    /// Coordinates, level by level.
    pub points: Vec<DVec3>,
    /// Eight vertices: the quad below, then the quad above it, each counter-clockwise seen from above.
    pub hexes: Vec<[VertexId; 8]>,
    /// The sets of the source, swept, by name: hexahedra.
    pub sets: Vec<(String, Vec<u32>)>,
    /// Vertex sets: `source`, `target`, and one per edge set of the source (the wall swept from it).
    pub nodes: Vec<(String, Vec<VertexId>)>,
}

/// Why a mesh cannot be swept.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SweepError {
    /// Triangles would become wedges.
    #[error("the mesh has {0} triangles; only quads can be swept into hexahedra")]
    Triangles(usize),
    /// Fewer than two points, or two equal ones in a row, or one not finite.
    #[error("the path needs at least two points, none twice in a row")]
    Path,
    /// A level that is not between its neighbours.
    #[error("levels must ascend from 0 to 1")]
    Levels,
    /// The path lies in the plane of the mesh, or turns back, or bends so sharply that a level would cut through another.
    #[error(
        "a hexahedron of level {level} would be turned inside out: the path is too flat or bends too sharply"
    )]
    InsideOut {
        /// Counted from 1.
        level: usize,
    },
}

/// Sweeps `mesh` along `path`, which begins at any point and is moved to the mesh; `levels` are shares of the path's
/// length, ascending, the first 0, the last 1. Every bend of the path gets a level of its own. Cost O(quads × levels).
///
/// # Errors
/// [`SweepError`].
pub fn sweep(
    mesh: &QuadMesh,
    sets: &NamedSets,
    path: &[DVec3],
    levels: &[f64],
) -> Result<HexMesh, SweepError> {
    if !mesh.triangles.is_empty() {
        return Err(SweepError::Triangles(mesh.triangles.len()));
    }
    let steps: Vec<DVec3> = path.windows(2).map(|w| w[1] - w[0]).collect();
    let fine = |d: &DVec3| d.is_finite() && d.length() > 0.0;
    if steps.is_empty() || !steps.iter().all(fine) {
        return Err(SweepError::Path);
    }
    let ascend = levels.windows(2).all(|w| w[0] < w[1]);
    if levels.len() < 2 || !ascend || levels[0] != 0.0 || levels[levels.len() - 1] != 1.0 {
        return Err(SweepError::Levels);
    }
    // Only the part of the path's direction along the plane's normal makes volume.
    if steps[0].z == 0.0 {
        return Err(SweepError::InsideOut { level: 1 });
    }
    let upward = steps[0].z > 0.0;
    let n = mesh.points.len();
    let mut out = HexMesh::default();
    out.points.extend(mesh.points.iter().map(|p| p.extend(0.0)));
    // The path's own point on each level; the mesh's middle stands for the path's start.
    let (lo, hi) = csalf_geom::polygon::bounds(mesh.points.iter().copied()).unwrap_or_default();
    let shift = (0.5 * (lo + hi)).extend(0.0) - path[0];
    let stations = stations(&steps, levels, 0.5 * (hi - lo).length());
    for (level, s) in stations.iter().enumerate().skip(1) {
        let direction = steps[s.leg].normalize();
        let normal = plane_of(&steps, s);
        let through = path[s.leg] + direction * s.along + shift;
        let rate = direction.dot(normal);
        let from = out.points.len() - n;
        for k in from..from + n {
            let p = out.points[k];
            // Each vertex runs along its leg until it meets the plane of the level.
            let length = (through - p).dot(normal) / rate;
            if !(rate > 0.0 && length > 0.0) {
                return Err(SweepError::InsideOut { level });
            }
            out.points.push(p + direction * length);
        }
    }
    let n_levels = stations.len() - 1;
    let id = |level: usize, v: VertexId| VertexId((level * n) as u32 + v.0);
    for level in 0..n_levels {
        for q in &mesh.quads {
            // Against the normal, the quads are seen from the other side: below and above change places.
            let (low, high) = if upward { (level, level + 1) } else { (level + 1, level) };
            let [a, b, c, d] = *q;
            out.hexes.push([
                id(low, a),
                id(low, b),
                id(low, c),
                id(low, d),
                id(high, a),
                id(high, b),
                id(high, c),
                id(high, d),
            ]);
        }
    }
    let nq = mesh.quads.len();
    let swept = |quads: &[QuadId]| {
        (0..n_levels).flat_map(|l| quads.iter().map(move |q| (l * nq) as u32 + q.0)).collect()
    };
    out.sets = sets.quads.iter().map(|(name, quads)| (name.clone(), swept(quads))).collect();
    let all = |level: usize| (0..n as u32).map(|v| id(level, VertexId(v))).collect();
    out.nodes = vec![("source".into(), all(0)), ("target".into(), all(n_levels))];
    for (name, edges) in &sets.edges {
        let mut nodes: Vec<VertexId> = edges.iter().flatten().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        out.nodes.push((
            name.clone(),
            (0..=n_levels).flat_map(|l| nodes.iter().map(move |v| id(l, *v))).collect(),
        ));
    }
    Ok(out)
}

/// A level: the leg of the path that it ends, and the length along it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Station {
    leg: usize,
    along: f64,
    /// It stands at the end of its leg.
    at_end: bool,
}

/// Where the levels are, with one more at each bend. A level so near a bend that the bend's plane would cut it, within
/// `reach` of the path, is left out.
fn stations(steps: &[DVec3], levels: &[f64], reach: f64) -> Vec<Station> {
    let lengths: Vec<f64> = steps.iter().map(|d| d.length()).collect();
    let total: f64 = lengths.iter().sum();
    let mean = total / (levels.len() - 1) as f64;
    let mut out = vec![Station { leg: 0, along: 0.0, at_end: false }];
    // How far the plane of the bend behind leg k comes along the legs: reach times the tangent of half the angle.
    let cut = |k: usize| match (steps.get(k), steps.get(k + 1)) {
        (Some(a), Some(b)) => {
            let (a, b) = (a.normalize(), b.normalize());
            reach * (a - b).length() / (a + b).length()
        }
        _ => 0.0,
    };
    let mut start = 0.0;
    for (leg, &length) in lengths.iter().enumerate() {
        // Levels closer to an end of the leg than this share of the mean thickness would make flat hexahedra.
        const NEAR: f64 = 0.3;
        let clear = NEAR * mean.min(length);
        let begin = clear + leg.checked_sub(1).map_or(0.0, cut);
        let end = length - clear - cut(leg);
        let within = levels.iter().map(|s| s * total - start).filter(|a| *a > begin && *a < end);
        let last = leg + 1 == lengths.len();
        // The first and the last leg keep levels near the path's own ends: thin layers are wanted there.
        let near_start =
            levels.iter().map(|s| s * total - start).filter(|a| leg == 0 && *a > 0.0 && *a <= clear);
        let near_end =
            levels.iter().map(|s| s * total - start).filter(|a| last && *a >= length - clear && *a < length);
        let mut all: Vec<f64> = near_start.chain(within).chain(near_end).collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        // What rounding leaves of the path's end is the end.
        all.retain(|a| *a < length * (1.0 - f64::EPSILON * 8.0));
        out.extend(all.into_iter().map(|along| Station { leg, along, at_end: false }));
        out.push(Station { leg, along: length, at_end: true });
        start += length;
    }
    out
}

/// The normal of a level's plane: of the first leg the source's, at a bend half way, else the leg's own direction.
fn plane_of(steps: &[DVec3], s: &Station) -> DVec3 {
    let of_leg = |k: usize| if k == 0 { DVec3::Z * steps[0].z.signum() } else { steps[k].normalize() };
    match steps.get(s.leg + 1) {
        Some(next) if s.at_end => (steps[s.leg].normalize() + next.normalize()).normalize_or_zero(),
        _ => of_leg(s.leg),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use csalf_geom::Point2;

    fn square() -> (QuadMesh, NamedSets) {
        let mut m = QuadMesh::default();
        for j in 0..3 {
            for i in 0..3 {
                m.points.push(Point2::new(f64::from(i), f64::from(j)));
            }
        }
        for j in 0..2 {
            for i in 0..2 {
                let at = |i: u32, j: u32| VertexId(3 * j + i);
                m.quads.push([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        let mut sets = NamedSets::default();
        sets.quads.push(("left".into(), vec![QuadId(0), QuadId(2)]));
        sets.edges.push(("low".into(), vec![[VertexId(0), VertexId(1)], [VertexId(1), VertexId(2)]]));
        (m, sets)
    }

    /// Volume of a hexahedron with flat sides: six tetrahedra.
    fn volume(m: &HexMesh) -> f64 {
        let tets = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]];
        let of = |h: &[VertexId; 8]| {
            let p = h.map(|v| m.points[v.index()]);
            tets.iter()
                .map(|t| (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).dot(p[t[3]] - p[t[0]]) / 6.0)
                .sum::<f64>()
        };
        m.hexes.iter().map(of).sum()
    }

    #[test]
    fn straight_up_down_and_slanted() {
        let (m, sets) = square();
        for (d, exact) in [(DVec3::Z * 3.0, 12.0), (-DVec3::Z * 3.0, 12.0), (DVec3::new(1.0, 0.5, 3.0), 12.0)]
        {
            let h = sweep(&m, &sets, &[DVec3::ONE, DVec3::ONE + d], &[0.0, 0.2, 0.5, 1.0]).expect("a sweep");
            assert_eq!((h.points.len(), h.hexes.len()), (36, 12));
            assert!((volume(&h) - exact).abs() < 1e-12, "{}", volume(&h));
            assert!(h.points[27].distance(m.points[0].extend(0.0) + d) < 1e-12);
            assert_eq!(h.sets[0].1, [0, 2, 4, 6, 8, 10]);
            assert_eq!(h.nodes[2].1.len(), 12);
        }
    }

    #[test]
    fn a_mitred_bend_keeps_the_section() {
        let (m, sets) = square();
        let path = [DVec3::ZERO, DVec3::Z * 5.0, DVec3::new(5.0, 0.0, 5.0)];
        let levels: Vec<f64> = (0..=10).map(|k| f64::from(k) / 10.0).collect();
        let h = sweep(&m, &sets, &path, &levels).expect("a sweep");
        // Both legs are as long in the middle of the section as the path.
        assert!((volume(&h) - 4.0 * 10.0).abs() < 1e-9, "{}", volume(&h));
        let end = &h.points[h.points.len() - 9..];
        assert!(end.iter().all(|p| (p.x - 6.0).abs() < 1e-12), "{end:?}");
    }

    #[test]
    fn what_cannot_be_swept_is_an_error() {
        let (mut m, sets) = square();
        let up = [DVec3::ZERO, DVec3::Z];
        assert_eq!(sweep(&m, &sets, &up[..1], &[0.0, 1.0]), Err(SweepError::Path));
        assert_eq!(sweep(&m, &sets, &up, &[0.0, 0.5, 0.5, 1.0]), Err(SweepError::Levels));
        assert!(matches!(
            sweep(&m, &sets, &[DVec3::ZERO, DVec3::X], &[0.0, 1.0]),
            Err(SweepError::InsideOut { .. })
        ));
        let back = [DVec3::ZERO, DVec3::Z, DVec3::new(0.1, 0.0, 0.0)];
        assert!(matches!(sweep(&m, &sets, &back, &[0.0, 0.5, 1.0]), Err(SweepError::InsideOut { .. })));
        m.triangles.push([VertexId(0), VertexId(1), VertexId(2)]);
        assert_eq!(sweep(&m, &sets, &up, &[0.0, 1.0]), Err(SweepError::Triangles(1)));
    }
}
