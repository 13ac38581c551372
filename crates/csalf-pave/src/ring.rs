//! The ring of quads around a loop, as pure connectivity: fronts in, quads and new loop out; nothing to close.
//!
//! ```text
//!   first(i) .. last(i)            rays of node i, from the side of i-1 to the side of i+1
//!
//!   ---*------*------*---          edge i, neither end a corner:  (i, i+1, first(i+1), last(i))
//!      |      |      |             corner i (E):                  (i-1, i, i+1, last(i-1)), first(i+1) = last(i-1)
//!   -- i-1 -- i -- i+1 --          right reversal (C):            (i, ray2, ray1, ray0)
//!                                  reversal (R):                  that, and (i, ray4, ray3, ray2)
//! ```
//!
//! 1. [`settle`] decides what each node does, given which edges may be covered: corners at uncovered edges and
//!    nodes that may not end a chain give up their other edge, outward, until nothing changes.
//! 2. [`Ring::new`] numbers the rays in ring order; the two neighbours of a corner share one node.
//! 3. It writes the quads and the new loop. Nodes without a covered edge, and those at the ends of a covered
//!    chain, stay on the new loop.
//!
//! With all edges covered: n' = n + 2 C + 4 R - 2 E new nodes, n - E + C + 2 R quads. The parity of the loop is
//! always kept, also under partial cover. Cost O(n). Source: handbook 2.4.

use crate::Front;

/// What one node does in a ring.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Role {
    /// Neither edge is covered: the node stays on the new loop.
    Blocked,
    /// First node of a covered chain: one ray, and it stays on the new loop before it.
    Start,
    /// Last node of a covered chain: one ray, and it stays on the new loop after it.
    End,
    /// E: shares the node of its neighbours.
    Corner,
    /// S: one ray.
    Flat,
    /// C: three rays.
    RightReversal,
    /// R: five rays.
    Reversal,
}

impl Role {
    /// Number of rays.
    #[inline]
    pub const fn rays(self) -> usize {
        match self {
            Self::Blocked | Self::Corner => 0,
            Self::Start | Self::End | Self::Flat => 1,
            Self::RightReversal => 3,
            Self::Reversal => 5,
        }
    }
}

/// Decides the role of every node. `cover[i]` tells whether edge i → i+1 may get a quad and is narrowed to what
/// will; `may_end(i)` whether node i has room to be the end of a chain (handbook 2.6: at least 135 degrees).
/// Both slices have one entry per node. Cost O(n).
pub fn settle(fronts: &[Front], cover: &mut [bool], may_end: impl Fn(usize) -> bool) -> Vec<Role> {
    let n = fronts.len();
    let before = |i: usize| if i == 0 { n - 1 } else { i - 1 };
    let mut todo = Vec::new();
    for (i, front) in fronts.iter().enumerate() {
        if *front == Front::Acute {
            for e in [before(i), i] {
                cover[e] = false;
            }
        }
    }
    todo.extend((0..n).filter(|&i| cover[before(i)] != cover[i]));
    while let Some(i) = todo.pop() {
        let ends = cover[before(i)] != cover[i];
        if ends && (fronts[i].is_corner() || !may_end(i)) {
            let far = if cover[i] { (i + 1) % n } else { before(i) };
            cover[before(i)] = false;
            cover[i] = false;
            todo.push(far);
        }
    }
    (0..n)
        .map(|i| match (cover[before(i)], cover[i], fronts[i]) {
            (false, false, _) => Role::Blocked,
            (false, true, _) => Role::Start,
            (true, false, _) => Role::End,
            (true, true, Front::Flat | Front::Acute) => Role::Flat,
            (true, true, Front::Right | Front::Obtuse) => Role::Corner,
            (true, true, Front::RightReversal) => Role::RightReversal,
            (true, true, Front::Reversal) => Role::Reversal,
        })
        .collect()
}

/// Why there is no ring of these roles.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum NoRing {
    /// Nodes i and i + 1 are both corners: the caller has to peel or to demote one of them.
    #[error("nodes {0} and the next are both corners")]
    AdjacentCorners(usize),
    /// No edge is covered, or there is only one node.
    #[error("no edge is covered")]
    Nothing,
    /// Corners alternate with other nodes so closely that the ring would touch itself in one node.
    #[error("the ring would touch itself")]
    Pinched,
}

/// A ring in local names: `i < n` is node i of the loop, `n + k` is new node k, numbered in ring order.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Ring {
    /// Number of nodes of the old loop.
    pub n: usize,
    /// Number of new nodes.
    pub n_new: usize,
    /// Start of each node's slice in `rays`; n + 1 entries.
    pub ray_start: Vec<u32>,
    /// New node (0..n_new, without the offset n) of every ray, in ring order.
    pub rays: Vec<u32>,
    /// The quads, counter-clockwise, in ring order.
    pub quads: Vec<[u32; 4]>,
    /// For every quad the node whose front made it: i for the quad on edge i or at corner i.
    pub quad_node: Vec<u32>,
    /// The new loop, material on the left. One node where the ring fills everything around that node.
    pub new_loop: Vec<u32>,
}

impl Ring {
    /// Builds the ring of `roles` (from [`settle`]).
    ///
    /// # Errors
    /// [`NoRing`]: adjacent corners, nothing covered, a ring that would touch itself.
    pub fn new(roles: &[Role]) -> Result<Self, NoRing> {
        let n = roles.len();
        let covered = |i: usize| !matches!(roles[i], Role::Blocked | Role::End);
        if n < 2 || !(0..n).any(covered) {
            return Err(NoRing::Nothing);
        }
        if n < 4 && roles.contains(&Role::Corner) {
            return Err(NoRing::Pinched);
        }
        let next = |i: usize| if i + 1 == n { 0 } else { i + 1 };
        if let Some(i) = (0..n).find(|&i| roles[i] == Role::Corner && roles[next(i)] == Role::Corner) {
            return Err(NoRing::AdjacentCorners(i));
        }
        let mut r = Self { n, ..Self::default() };
        r.ray_start.reserve(n + 1);
        r.rays.reserve(n + 8);
        let (mut fresh, mut glue) = (0u32, false);
        for role in roles {
            r.ray_start.push(r.rays.len() as u32);
            for _ in 0..role.rays() {
                if !(glue && fresh > 0) {
                    fresh += 1;
                }
                r.rays.push(fresh - 1);
                glue = false;
            }
            glue |= *role == Role::Corner;
        }
        r.ray_start.push(r.rays.len() as u32);
        if (glue || roles[0] == Role::Corner) && fresh > 1 {
            // A corner at the seam of the numbering: its two neighbours share the first node.
            fresh -= 1;
            for ray in r.rays.iter_mut().rev().take_while(|ray| **ray == fresh) {
                *ray = 0;
            }
        }
        r.n_new = fresh as usize;
        if (0..n).any(|i| roles[i].rays() > 1 && r.first(i) == r.last(i)) {
            return Err(NoRing::Pinched);
        }
        r.write_quads(roles);
        r.write_loop(roles);
        Ok(r)
    }

    /// Names of the rays of node `i`, in order.
    pub fn rays_of(&self, i: usize) -> impl ExactSizeIterator<Item = u32> + '_ {
        let s = self.ray_start[i] as usize..self.ray_start[i + 1] as usize;
        self.rays[s].iter().map(|k| self.n as u32 + k)
    }

    fn first(&self, i: usize) -> u32 {
        self.n as u32 + self.rays[self.ray_start[i] as usize]
    }

    fn last(&self, i: usize) -> u32 {
        self.n as u32 + self.rays[self.ray_start[i + 1] as usize - 1]
    }

    fn write_quads(&mut self, roles: &[Role]) {
        let n = self.n;
        self.quads.reserve(n + 4);
        self.quad_node.reserve(n + 4);
        for i in 0..n {
            let j = if i + 1 == n { 0 } else { i + 1 };
            let k = if i == 0 { n - 1 } else { i - 1 };
            let mut emit = |q: [u32; 4]| {
                self.quads.push(q);
                self.quad_node.push(i as u32);
            };
            let b = i as u32;
            let s = self.ray_start[i] as usize;
            let ray = |m: usize| n as u32 + self.rays[s + m];
            match roles[i] {
                Role::Blocked | Role::End => continue,
                Role::Corner => {
                    let shared = n as u32 + self.rays[self.ray_start[k + 1] as usize - 1];
                    emit([k as u32, b, j as u32, shared]);
                    continue;
                }
                Role::RightReversal => emit([b, ray(2), ray(1), ray(0)]),
                Role::Reversal => {
                    emit([b, ray(2), ray(1), ray(0)]);
                    emit([b, ray(4), ray(3), ray(2)]);
                }
                Role::Start | Role::Flat => {}
            }
            if roles[j] != Role::Corner {
                let q = [b, j as u32, self.first(j), self.last(i)];
                self.quads.push(q);
                self.quad_node.push(b);
            }
        }
    }

    fn write_loop(&mut self, roles: &[Role]) {
        let mut out: Vec<u32> = Vec::with_capacity(self.n_new + 8);
        let mut push = |v: u32| {
            if out.last() != Some(&v) {
                out.push(v);
            }
        };
        for (i, role) in roles.iter().enumerate() {
            if matches!(role, Role::Blocked | Role::Start) {
                push(i as u32);
            }
            self.rays_of(i).for_each(&mut push);
            if *role == Role::End {
                push(i as u32);
            }
        }
        while out.len() > 1 && out.first() == out.last() {
            out.pop();
        }
        self.new_loop = out;
    }

    /// The ring around an isolated hard point (a loop of one node): four rays 90 degrees apart, new nodes 0, 2, 4,
    /// 6, and four diagonal nodes 1, 3, 5, 7; four quads. The material is all around, so the new loop runs
    /// clockwise. Handbook 2.4.
    pub fn around_point() -> Self {
        Self {
            n: 1,
            n_new: 8,
            ray_start: vec![0, 8],
            rays: (0..8).collect(),
            quads: vec![[0, 3, 2, 1], [0, 5, 4, 3], [0, 7, 6, 5], [0, 1, 8, 7]],
            quad_node: vec![0; 4],
            new_loop: (1..9).collect(),
        }
    }
}

#[cfg(test)]
pub(crate) mod tests;
