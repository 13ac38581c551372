//! Coloured sweeps: one vertex at a time, in an order that does not depend on the number of threads.
//!
//! Vertices of one colour share no quad, so moving them together is the same as one after the other. Settled
//! vertices are skipped: those that nothing has moved near since they were last visited.
//!
//! Source: handbook 7.5.

use super::region::Region;
use csalf_geom::Point2;
use rayon::prelude::*;

/// Colours of fewer vertices are done in place: handing them to other threads costs as much as 50 steps.
const PARALLEL_FROM: usize = 512;
/// Vertices per task, at least.
const PER_TASK: usize = 128;

/// When each vertex last moved noticeably.
pub(crate) struct Sweeps {
    /// Number of the sweep in which the vertex moved last; 0 at the start.
    moved_at: Vec<u32>,
    now: u32,
    /// A move is noticed if it is longer than this share of the target length.
    tolerance: f64,
}

impl Sweeps {
    pub(crate) fn new(region: &Region, tolerance: f64) -> Self {
        Self { moved_at: vec![0; region.vertices.len()], now: 0, tolerance }
    }

    /// Makes every vertex unsettled again.
    pub(crate) fn unsettle(&mut self) {
        self.moved_at.fill(self.now);
    }

    /// One sweep over all vertices that are not settled: `step` says where a vertex should go (or its own
    /// place). Returns how many moved noticeably.
    pub(crate) fn run(&mut self, region: &mut Region, step: impl Fn(&Region, u32) -> Point2 + Sync) -> usize {
        self.now += 1;
        let mut n_moved = 0;
        let colours = std::mem::take(&mut region.colours);
        let mut goals: Vec<(Point2, bool)> = Vec::new();
        for list in &colours {
            if list.len() < PARALLEL_FROM {
                for &v in list {
                    if self.is_open(region, v) {
                        let goal = step(region, v);
                        let noticed = self.is_noticed(region, v, goal);
                        n_moved += usize::from(self.place(region, v, goal, noticed));
                    }
                }
            } else {
                let (this, shared) = (&*self, &*region);
                list.par_iter()
                    .with_min_len(PER_TASK)
                    .map(|&v| {
                        if this.is_open(shared, v) {
                            let goal = step(shared, v);
                            (goal, this.is_noticed(shared, v, goal))
                        } else {
                            (shared.points[v as usize], false)
                        }
                    })
                    .collect_into_vec(&mut goals);
                for (&v, &(goal, noticed)) in list.iter().zip(&goals) {
                    n_moved += usize::from(self.place(region, v, goal, noticed));
                }
            }
        }
        region.colours = colours;
        n_moved
    }

    /// True if a vertex of the quads of `v`, or `v` itself, moved since `v` was last visited.
    fn is_open(&self, region: &Region, v: u32) -> bool {
        region.star(v).iter().any(|&h| {
            region.quads[(h / 4) as usize].iter().any(|&w| self.moved_at[w as usize] + 1 >= self.now)
        })
    }

    /// True if that is a move worth telling the vertices around.
    fn is_noticed(&self, region: &Region, v: u32, goal: Point2) -> bool {
        let inverse = region.inverse[(region.star(v)[0] / 4) as usize][0];
        region.points[v as usize].distance(goal) * inverse > self.tolerance
    }

    fn place(&mut self, region: &mut Region, v: u32, goal: Point2, noticed: bool) -> bool {
        region.points[v as usize] = goal;
        if noticed {
            self.moved_at[v as usize] = self.now;
        }
        noticed
    }
}
