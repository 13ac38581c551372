//! Which element has which side: for formats that name boundaries by element and side.

use crate::MeshView;
use csalf_geom::VertexId;
use csalf_mesh::QuadMesh;

/// A side of an element: vertices in its direction, element (quads first, then triangles), side from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Side {
    pub vertices: [u32; 2],
    pub element: usize,
    pub side: usize,
}

/// The sides of all elements, sorted by their vertices.
#[derive(Debug, Default)]
pub(crate) struct Sides {
    sorted: Vec<Side>,
}

impl Sides {
    pub(crate) fn new(mesh: &QuadMesh) -> Self {
        fn of<const K: usize>(element: usize, e: &[VertexId; K]) -> impl Iterator<Item = Side> + '_ {
            (0..K).map(move |side| Side { vertices: [e[side].0, e[(side + 1) % K].0], element, side })
        }
        let n = mesh.quads.len();
        let quads = mesh.quads.iter().enumerate().flat_map(|(i, q)| of(i, q));
        let triangles = mesh.triangles.iter().enumerate().flat_map(|(i, t)| of(n + i, t));
        let mut sorted: Vec<Side> = quads.chain(triangles).collect();
        sorted.sort_unstable();
        Self { sorted }
    }

    /// The side that runs from `a` to `b`.
    pub(crate) fn find(&self, a: u32, b: u32) -> Option<Side> {
        let k = self.sorted.partition_point(|s| s.vertices < [a, b]);
        self.sorted.get(k).filter(|s| s.vertices == [a, b]).copied()
    }

    /// The side between two vertices, in either direction.
    pub(crate) fn between(&self, [a, b]: [VertexId; 2]) -> Option<Side> {
        self.find(a.0, b.0).or_else(|| self.find(b.0, a.0))
    }

    /// All sides, sorted.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &Side> {
        self.sorted.iter()
    }

    /// True if no other element lies across.
    pub(crate) fn is_boundary(&self, s: &Side) -> bool {
        self.find(s.vertices[1], s.vertices[0]).is_none()
    }

    /// The boundary in patches, each side in one of them: edge sets by name, the first one wins; sides in none of them
    /// are the patch `boundary`.
    pub(crate) fn patches(&self, out: &MeshView<'_>) -> Vec<(String, Vec<Side>)> {
        let mut open: Vec<Side> = self.iter().filter(|s| self.is_boundary(s)).copied().collect();
        let mut patches = Vec::new();
        let mut taken = vec![false; open.len()];
        for (name, edges) in &out.sets.edges {
            let mut members = Vec::new();
            for &edge in edges {
                let Some(s) = self.between(edge) else { continue };
                if let Ok(k) = open.binary_search(&s)
                    && !std::mem::replace(&mut taken[k], true)
                {
                    members.push(s);
                }
            }
            if !members.is_empty() {
                patches.push((name.clone(), members));
            }
        }
        let mut left = taken.iter();
        open.retain(|_| !left.next().copied().unwrap_or(true));
        if !open.is_empty() {
            let mut name = String::from("boundary");
            while patches.iter().any(|(n, _)| *n == name) {
                name.push('_');
            }
            patches.push((name, open));
        }
        patches
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use csalf_geom::Point2;
    use csalf_mesh::NamedSets;

    #[test]
    fn every_side_of_the_boundary_is_in_one_patch() {
        let v = VertexId::new;
        let points = [(0., 0.), (1., 0.), (2., 0.), (0., 1.), (1., 1.), (2., 1.)].map(Point2::from).to_vec();
        let quads = vec![[v(0), v(1), v(4), v(3)], [v(1), v(2), v(5), v(4)]];
        let mesh = QuadMesh { points, quads, triangles: Vec::new() };
        let edges = vec![
            // One against its element, one inside the mesh.
            ("low".into(), vec![[v(1), v(0)], [v(1), v(2)], [v(1), v(4)]]),
            ("again".into(), vec![[v(0), v(1)], [v(2), v(5)]]),
        ];
        let sets = NamedSets { edges, ..NamedSets::default() };
        let out = MeshView { mesh: &mesh, heights: &[], sets: &sets, cell_data: &[], title: "" };
        let sides = Sides::new(&mesh);
        let patches = sides.patches(&out);
        let found: Vec<(&str, Vec<[u32; 2]>)> =
            patches.iter().map(|(n, l)| (n.as_str(), l.iter().map(|s| s.vertices).collect())).collect();
        assert_eq!(
            found,
            [
                ("low", vec![[0, 1], [1, 2]]),
                ("again", vec![[2, 5]]),
                ("boundary", vec![[3, 0], [4, 3], [5, 4]]),
            ]
        );
        let s = sides.between([v(5), v(2)]).unwrap();
        assert_eq!((s.vertices, s.element, s.side), ([2, 5], 1, 1));
    }
}
