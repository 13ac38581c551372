//! Algorithm II: fills one contour by the members of the triad.
//!
//! ```text
//!   contour ──▶ member 1 ─refuses─▶ member 2 ─refuses─▶ ... ─▶ guaranteed fallback
//!                  │ patch
//!                  ├─ quads, new points: kept
//!                  └─ children: filled the same way, in parallel
//! ```
//!
//! New points get provisional ids from a shared counter while the recursion runs; [`Filled::collect`] then numbers
//! them in tree order, so that the mesh does not depend on the number of threads.

use crate::Watch;
use csalf_geom::{Point2, Tolerance, VertexId};
use csalf_mesh::{Contour, NodeFlags, Patch, RegionMesher, RegionTask};
use csalf_sizemap::{Hint, SizeField};
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

/// Trees of fewer quads are renumbered in place.
const PARALLEL_FROM: usize = 1 << 15;

/// Name of the guaranteed fallback.
pub(crate) const FALLBACK: &str = "fallback";

/// Contours smaller than this are not worth a task of their own.
const PARALLEL_MIN: usize = 64;

/// The members in the order in which they are asked.
pub struct Triad<'a> {
    members: &'a [Arc<dyn RegionMesher>],
    tolerance: Tolerance,
    next_id: AtomicU32,
    watch: &'a dyn Watch,
}

impl std::fmt::Debug for Triad<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Triad").field("members", &self.members).finish_non_exhaustive()
    }
}

/// What became of one contour: the patch of its own step in provisional ids, and its children.
#[derive(Debug, Default)]
pub struct Filled {
    first_id: u32,
    points: Vec<Point2>,
    quads: Vec<[u32; 4]>,
    children: Vec<Self>,
    /// Who took the contour; `None` for a result made elsewhere.
    member: Option<usize>,
    /// Contours that the guaranteed fallback filled in this step.
    n_fallbacks: usize,
}

/// No member took a contour.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("no member of the triad took the contour of {n_nodes} nodes at ({x}, {y})")]
pub struct Unfilled {
    /// Its size.
    pub n_nodes: usize,
    /// Its first node.
    pub x: f64,
    /// Its first node.
    pub y: f64,
}

impl<'a> Triad<'a> {
    /// A triad of the given members; the last one should be the guaranteed fallback. New points are numbered from
    /// `first_id` on, above all ids in the contours that will be given to [`Self::fill`].
    pub fn new(members: &'a [Arc<dyn RegionMesher>], tolerance: Tolerance, first_id: u32) -> Self {
        Self { members, tolerance, next_id: AtomicU32::new(first_id), watch: &() }
    }

    /// The same, giving up all contours once `watch` is cancelled.
    pub fn watched(self, watch: &'a dyn Watch) -> Self {
        Self { watch, ..self }
    }

    /// How many contours each member took in these trees; last, under the name "fallback", how many the guaranteed
    /// fallback filled, asked by the triad or within the step of another member.
    pub fn tally(&self, trees: &[Filled]) -> Vec<(&'static str, usize)> {
        let mut taken = vec![0; self.members.len()];
        let mut n_fallbacks = 0;
        let mut stack: Vec<&Filled> = trees.iter().collect();
        while let Some(f) = stack.pop() {
            if let Some(n) = f.member.and_then(|m| taken.get_mut(m)) {
                *n += 1;
            }
            n_fallbacks += f.n_fallbacks;
            stack.extend(&f.children);
        }
        let members = self.members.iter().map(|m| m.name()).zip(taken).filter(|m| m.0 != FALLBACK);
        members.chain([(FALLBACK, n_fallbacks)]).collect()
    }

    /// Reserves ids for `n` points made elsewhere (bridges, layers).
    pub fn reserve(&self, n: usize) -> u32 {
        self.next_id.fetch_add(n as u32, Ordering::Relaxed)
    }

    /// One more than the largest id given so far.
    pub fn id_bound(&self) -> usize {
        self.next_id.load(Ordering::Relaxed) as usize
    }

    /// Fills a contour completely, with quads as large as `size` says.
    ///
    /// # Errors
    /// [`Unfilled`] if every member refuses some sub-contour, or the watch is cancelled.
    pub fn fill(&self, contour: &Contour, size: &dyn SizeField) -> Result<Filled, Unfilled> {
        // Meshers see ids that do not depend on the order in which the threads took theirs: the first occurrence.
        let shown = Contour { ids: contour.first_occurrences(), ..contour.clone() };
        let task = RegionTask { contour: &shown, size, tolerance: self.tolerance };
        for (k, member) in self.members.iter().enumerate() {
            if self.watch.cancelled() {
                break;
            }
            match member.mesh(&task) {
                // A step that leaves something nobody can fill was a bad one: it is dropped.
                Ok(patch) => match self.commit(contour, patch, size) {
                    Ok(filled) => return Ok(Filled { member: Some(k), ..filled }),
                    Err(e) => tracing::debug!(member = member.name(), n_nodes = contour.len(), %e, "dropped"),
                },
                Err(refusal) => {
                    tracing::trace!(member = member.name(), n_nodes = contour.len(), %refusal, "refused");
                }
            }
        }
        let p = contour.points.first().copied().unwrap_or_default();
        Err(Unfilled { n_nodes: contour.len(), x: p.x, y: p.y })
    }

    fn commit(&self, contour: &Contour, patch: Patch, size: &dyn SizeField) -> Result<Filled, Unfilled> {
        let n = contour.len() as u32;
        let first_id = self.reserve(patch.points.len());
        let id = |name: u32| if name < n { contour.ids[name as usize] } else { first_id + name - n };
        let mut hint = Hint::default();
        let child_contours: Vec<Contour> = patch
            .children
            .iter()
            .map(|names| {
                let mut c = Contour::default();
                for &name in names {
                    if name < n {
                        let i = name as usize;
                        c.push(contour.points[i], contour.ids[i], contour.sizes[i], contour.flags[i]);
                    } else {
                        let p = patch.points[(name - n) as usize];
                        c.push(p, id(name), size.h(p, &mut hint), NodeFlags::default());
                    }
                }
                c
            })
            .collect();
        let mut quads = patch.quads;
        for q in &mut quads {
            *q = q.map(id);
        }
        let children = if child_contours.iter().map(Contour::len).sum::<usize>() >= PARALLEL_MIN {
            child_contours.par_iter().map(|c| self.fill(c, size)).collect::<Result<Vec<_>, _>>()?
        } else {
            child_contours.iter().map(|c| self.fill(c, size)).collect::<Result<Vec<_>, _>>()?
        };
        let n_fallbacks = patch.n_fallbacks;
        Ok(Filled { first_id, points: patch.points, quads, children, member: None, n_fallbacks })
    }
}

impl Filled {
    /// A result made elsewhere (bridges, layers): points `first_id ..` and quads, without children.
    pub fn leaf(first_id: u32, points: Vec<Point2>, quads: Vec<[u32; 4]>) -> Self {
        Self { first_id, points, quads, ..Self::default() }
    }

    /// Number of quads, with all children.
    pub fn n_quads(&self) -> usize {
        self.quads.len() + self.children.iter().map(Self::n_quads).sum::<usize>()
    }

    /// Writes the trees of all regions, in order, after `n_fixed` points that are there already: points in tree
    /// order, quads in tree order in final numbers. `id_bound`: one more than the largest provisional id. Also
    /// returns the final number of each provisional id.
    pub fn collect(
        trees: &[Self],
        points: &mut Vec<Point2>,
        id_bound: usize,
    ) -> (Vec<[VertexId; 4]>, Vec<u32>) {
        let n_fixed = points.len();
        let mut number: Vec<u32> = (0..id_bound as u32).collect();
        let mut n_quads = 0;
        let mut order: Vec<&Self> = Vec::new();
        let mut stack: Vec<&Self> = trees.iter().rev().collect();
        while let Some(f) = stack.pop() {
            order.push(f);
            n_quads += f.quads.len();
            stack.extend(f.children.iter().rev());
        }
        for f in &order {
            let first = f.first_id as usize;
            for (n, to) in number[first..first + f.points.len()].iter_mut().zip(points.len() as u32..) {
                *n = to;
            }
            points.extend_from_slice(&f.points);
        }
        debug_assert!(
            number[..n_fixed].iter().enumerate().all(|(i, &n)| i == n as usize),
            "fixed nodes keep ids"
        );
        let mut quads = Vec::with_capacity(n_quads);
        for f in &order {
            let renumbered = |q: &[u32; 4]| q.map(|v| VertexId(number[v as usize]));
            if f.quads.len() < PARALLEL_FROM {
                quads.extend(f.quads.iter().map(renumbered));
            } else {
                quads.par_extend(f.quads.par_iter().with_min_len(PARALLEL_FROM / 4).map(renumbered));
            }
        }
        (quads, number)
    }
}
