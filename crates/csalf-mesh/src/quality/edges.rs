//! Half-edges of a mesh of quads and triangles, with everything that may be wrong with them counted.
//!
//! Unlike [`crate::QuadTopology`], which serves algorithms on all-quad meshes, this one also takes triangles
//! and broken meshes: it is what quality and validity are measured on. Half-edge `4 q + k` is side k of quad
//! q, `4 n_quads + 3 t + k` side k of triangle t.

use crate::QuadMesh;

/// No twin: the half-edge is on the boundary.
pub(crate) const NONE: u32 = u32::MAX - 1;
/// No twin: more than two elements share the edge.
pub(crate) const SHARED: u32 = u32::MAX;

/// Half-edges and vertex counts of a mesh.
pub(crate) struct HalfEdges {
    /// Vertex at the start of each half-edge.
    tail: Vec<u32>,
    n_quads: usize,
    /// The other half-edge of the edge, or [`NONE`], or [`SHARED`].
    pub(crate) twin: Vec<u32>,
    /// Half-edges out of each vertex: `star[star_start[v]..star_start[v + 1]]`, ascending.
    star_start: Vec<u32>,
    star: Vec<u32>,
    /// Edges at each vertex.
    pub(crate) valence: Vec<u32>,
    /// Triangles at each vertex.
    pub(crate) n_triangles_at: Vec<u32>,
    pub(crate) on_boundary: Vec<bool>,
    /// Number of edges.
    pub(crate) n_edges: usize,
    /// One half-edge of each edge with more than two elements.
    pub(crate) over_shared: Vec<u32>,
    /// One half-edge of each edge along which two elements run in the same direction.
    pub(crate) same_direction: Vec<u32>,
}

impl HalfEdges {
    /// Builds the half-edges in O(n). Every vertex index must be below the number of points.
    pub(crate) fn new(mesh: &QuadMesh) -> Self {
        let n = mesh.n_vertices();
        let n_quads = mesh.n_quads();
        let mut tail = Vec::with_capacity(4 * n_quads + 3 * mesh.triangles.len());
        tail.extend(mesh.quads.iter().flatten().map(|v| v.0));
        tail.extend(mesh.triangles.iter().flatten().map(|v| v.0));
        let n_half = tail.len();
        let mut star_start = vec![0u32; n + 1];
        for &a in &tail {
            star_start[a as usize + 1] += 1;
        }
        for i in 0..n {
            star_start[i + 1] += star_start[i];
        }
        let mut fill = star_start.clone();
        let mut star = vec![0u32; n_half];
        for (h, &a) in tail.iter().enumerate() {
            star[fill[a as usize] as usize] = h as u32;
            fill[a as usize] += 1;
        }
        let mut n_triangles_at = vec![0u32; n];
        for v in mesh.triangles.iter().flatten() {
            n_triangles_at[v.index()] += 1;
        }
        let mut out = Self {
            tail,
            n_quads,
            twin: vec![NONE; n_half],
            star_start,
            star,
            valence: vec![0; n],
            n_triangles_at,
            on_boundary: vec![false; n],
            n_edges: 0,
            over_shared: Vec::new(),
            same_direction: Vec::new(),
        };
        out.pair();
        out
    }

    /// Finds the twins. An edge a-b is handled once, at its first half-edge; the others have a
    /// twin by then.
    fn pair(&mut self) {
        let mut same = Vec::with_capacity(8);
        for h in 0..self.tail.len() as u32 {
            if self.twin[h as usize] != NONE {
                continue;
            }
            let (a, b) = (self.tail(h), self.head(h));
            same.clear();
            same.extend(self.out(a).iter().copied().filter(|&g| self.head(g) == b));
            if b != a {
                same.extend(self.out(b).iter().copied().filter(|&g| self.head(g) == a));
            }
            self.n_edges += 1;
            self.valence[a as usize] += 1;
            self.valence[b as usize] += 1;
            match same[..] {
                [_] => {
                    self.on_boundary[a as usize] = true;
                    self.on_boundary[b as usize] = true;
                }
                [g, k] => {
                    self.twin[g as usize] = k;
                    self.twin[k as usize] = g;
                    if self.tail(g) == self.tail(k) {
                        self.same_direction.push(g);
                    }
                }
                _ => {
                    for &g in &same {
                        self.twin[g as usize] = SHARED;
                    }
                    self.over_shared.push(h);
                }
            }
        }
    }

    /// Number of half-edges.
    pub(crate) fn len(&self) -> usize {
        self.tail.len()
    }

    #[inline]
    pub(crate) fn tail(&self, h: u32) -> u32 {
        self.tail[h as usize]
    }

    #[inline]
    pub(crate) fn head(&self, h: u32) -> u32 {
        self.tail[self.next(h) as usize]
    }

    /// The next half-edge around the element.
    #[inline]
    pub(crate) fn next(&self, h: u32) -> u32 {
        let q = 4 * self.n_quads as u32;
        if h < q {
            (h & !3) | ((h + 1) & 3)
        } else {
            let k = (h - q) % 3;
            h - k + (k + 1) % 3
        }
    }

    /// True if the half-edge belongs to a quad (not to a triangle).
    #[inline]
    pub(crate) fn is_quad(&self, h: u32) -> bool {
        (h as usize) < 4 * self.n_quads
    }

    /// The side across the quad of `h`, which must be a quad's.
    #[inline]
    pub(crate) fn opposite(h: u32) -> u32 {
        h ^ 2
    }

    /// Half-edges leaving vertex `v`, one per element at it.
    #[inline]
    pub(crate) fn out(&self, v: u32) -> &[u32] {
        &self.star[self.star_start[v as usize] as usize..self.star_start[v as usize + 1] as usize]
    }

    /// Number of elements at vertex `v`.
    #[inline]
    pub(crate) fn n_elements_at(&self, v: u32) -> usize {
        self.out(v).len()
    }

    /// The half-edges on the boundary, ascending.
    pub(crate) fn boundary(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.len() as u32).filter(|&h| self.twin[h as usize] == NONE)
    }
}
