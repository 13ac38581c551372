//! Constrained Delaunay triangulations that are the same in every run.
//!
//! Spade's own bulk load of a constrained triangulation puts back the vertices that it skipped in the order of a randomly
//! seeded hash set; ties of cocircular points, and all numbers of faces and edges, then differ from run to run. Its bulk
//! load of the vertices alone keeps a list. So the vertices are loaded first, then the constraints one by one.

use csalf_geom::Point2;
use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, HasPosition, InsertionError, Triangulation as _};

/// A vertex that knows its number in the input.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    position: spade::Point2<f64>,
    /// Its number; `u32::MAX` of a vertex inserted later.
    pub index: u32,
}

impl Node {
    /// A vertex that is inserted later.
    pub fn new(p: Point2) -> Self {
        Self { position: spade::Point2::new(p.x, p.y), index: u32::MAX }
    }
}

impl HasPosition for Node {
    type Scalar = f64;

    fn position(&self) -> spade::Point2<f64> {
        self.position
    }
}

/// The triangulation.
pub type Cdt = ConstrainedDelaunayTriangulation<Node>;

/// A triangulation of the convex hull of some points.
#[derive(Clone, Debug)]
pub struct Constrained {
    /// The triangulation; vertices in spade's order.
    pub cdt: Cdt,
    /// The vertex of each point; of equal points only the last one counts.
    pub vertex: Vec<FixedVertexHandle>,
    /// The first of the constraints that could not be added, because they cross an earlier one.
    pub conflict: Option<[u32; 2]>,
    /// Per undirected edge of the triangulation: whether an odd number of the constraints run along it. Both sides of a
    /// slit make two, also where a vertex on it cuts them into parts.
    pub odd: Vec<bool>,
}

/// Triangulates points with some of their connections as edges. A coordinate that spade does not take because it is too
/// close to 0 is taken as 0. O(n log n).
///
/// # Errors
/// A coordinate that is not finite, or too large.
pub fn constrained(
    points: impl IntoIterator<Item = Point2>,
    edges: impl IntoIterator<Item = [u32; 2]>,
) -> Result<Constrained, InsertionError> {
    let flush = |x: f64| if x.abs() < spade::MIN_ALLOWED_VALUE { 0.0 } else { x };
    let node = |(i, p): (usize, Point2)| Node {
        position: spade::Point2::new(flush(p.x), flush(p.y)),
        index: i as u32,
    };
    let nodes: Vec<Node> = points.into_iter().enumerate().map(node).collect();
    let mut vertex = vec![FixedVertexHandle::from_index(0); nodes.len()];
    let mut cdt = Cdt::bulk_load(nodes)?;
    for v in cdt.vertices() {
        vertex[v.data().index as usize] = v.fix();
    }
    let mut conflict = None;
    // No vertex comes after this: an edge keeps its number, and one that is a constraint its ends.
    let mut odd = vec![false; cdt.num_undirected_edges()];
    for e in edges {
        let [a, b] = e.map(|i| vertex[i as usize]);
        if a == b {
            continue;
        }
        let parts = cdt.try_add_constraint(a, b);
        if parts.is_empty() {
            conflict = conflict.or(Some(e));
        }
        for part in parts {
            odd[part.as_undirected().index()] ^= true;
        }
    }
    Ok(Constrained { cdt, vertex, conflict, odd })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constraints_are_edges_and_crossings_are_told() {
        let p = [(0., 0.), (4., 0.), (4., 1.), (0., 1.), (2., 0.4)].map(Point2::from);
        let c = constrained(p, [[0, 2], [2, 0], [1, 3]]).unwrap();
        assert!(c.cdt.exists_constraint(c.vertex[0], c.vertex[2]));
        assert_eq!(c.conflict, Some([1, 3]));
        assert_eq!(c.cdt.num_vertices(), 5);
    }

    /// A slit whose sides are one long edge there and two short ones back, beside a loop side that a vertex cuts.
    #[test]
    fn parts_of_constraints_are_counted() {
        let p = [(0., 0.), (4., 0.), (4., 3.), (0., 3.), (1., 1.), (3., 1.), (2., 1.), (2., 0.)]
            .map(Point2::from);
        let c = constrained(p, [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 4]]).unwrap();
        let odd = |a: usize, b: usize| {
            let e = c.cdt.get_edge_from_neighbors(c.vertex[a], c.vertex[b]).unwrap();
            assert!(e.is_constraint_edge());
            c.odd[e.as_undirected().fix().index()]
        };
        for (a, b) in [(0, 7), (7, 1), (1, 2), (2, 3), (3, 0)] {
            assert!(odd(a, b), "{a} {b}");
        }
        assert!(!odd(4, 6) && !odd(6, 5));
        assert_eq!(c.odd.iter().filter(|&&o| o).count(), 5);
    }

    #[test]
    fn a_lattice_is_triangulated_the_same_way_every_time() {
        // Every square is a tie.
        let lattice = || (0..900).map(|i| Point2::new(f64::from(i % 30), f64::from(i / 30)));
        let faces = || {
            let c = constrained(lattice(), (0..29).map(|i| [i * 31, i * 31 + 31])).unwrap();
            let of =
                |f: spade::handles::FaceHandle<'_, _, Node, _, _, _>| f.vertices().map(|v| v.data().index);
            c.cdt.inner_faces().map(of).collect::<Vec<_>>()
        };
        let first = faces();
        for _ in 0..4 {
            assert_eq!(faces(), first);
        }
    }
}
