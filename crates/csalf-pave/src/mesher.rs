//! Loop-paving behind the seam: one ring on a contour, and what is left inside as the one child.
//!
//! 1. The contour must be a fat one: area over perimeter above 1.5 wanted edges (handbook 3.3).
//! 2. One ring by rule is built and tested as in the layer driver, against the contour itself.
//! 3. The ring's quads and the new loop are returned; parity is kept, so the child is even.

use crate::PavingRules;
use crate::build::{LoopState, NEW, Order, build};
use crate::evaluate::{self, Others, Stop};
use crate::index::{Index, Segment};
use crate::laws::Thickness;
use csalf_geom::polygon;
use csalf_mesh::{Appraisal, Contour, Patch, Refusal, RegionMesher, RegionTask};
use csalf_sizemap::Hint;

/// The loop-paving member of the triad.
#[derive(Clone, Copy, Debug, Default)]
pub struct LoopPaver {
    /// Placement formulas.
    pub rules: PavingRules,
}

/// Least area over perimeter, in wanted edges, of a contour that is paved (handbook 3.3).
const FAT: f64 = 1.5;

fn state_of(c: &Contour) -> LoopState {
    let n = c.len();
    LoopState {
        // Occurrences of one node share the name of the first.
        nodes: c.first_occurrences(),
        points: c.points.clone(),
        below: vec![0; n],
        open: vec![true; n],
        geometry: vec![true; n],
    }
}

impl LoopPaver {
    fn fat(task: &RegionTask<'_>) -> bool {
        let c = task.contour;
        let mean = c.sizes.iter().sum::<f64>() / c.len().max(1) as f64;
        polygon::signed_area(&c.points) > FAT * mean * polygon::perimeter(&c.points)
    }
}

impl RegionMesher for LoopPaver {
    fn name(&self) -> &'static str {
        "pave"
    }

    /// A ring adds no irregular vertex but at corners; the figures are those of the ring alone, not of the child.
    fn appraise(&self, task: &RegionTask<'_>) -> Option<Appraisal> {
        let n = task.contour.len();
        (n >= 8 && Self::fat(task)).then_some(Appraisal {
            min_sj: 0.5,
            mean_sj: 0.95,
            n_irregular: 0,
            n_quads: n as u32,
            size_error: 1.1,
            worst_size_error: 1.4,
        })
    }

    fn mesh(&self, task: &RegionTask<'_>) -> Result<Patch, Refusal> {
        let c = task.contour;
        let n = c.len();
        if n < 8 || !Self::fat(task) {
            return Err(Refusal::NotApplicable);
        }
        let state = state_of(c);
        let refusal = |stop: Stop| match stop {
            Stop::Short | Stop::Narrow => Refusal::NotApplicable,
            Stop::FarFromSize | Stop::UnevenFronts | Stop::Thick | Stop::Fine | Stop::Growth => Refusal::Size,
            _ => Refusal::Quality,
        };
        evaluate::before(&state, task.size, self.rules, &mut Hint::default()).map_err(refusal)?;
        let order = Order {
            thickness: Thickness::Isotropic(1.0),
            user: false,
            whole: false,
            rules: self.rules,
            field: task.size,
            caps: None,
            banned: None,
        };
        let ring = build(&state, &order, &c.points).map_err(|f| refusal(f.stop))?;
        if !ring.full {
            return Err(Refusal::Quality);
        }
        let mut sides = Vec::with_capacity(n + ring.next.nodes.len());
        for (points, proposed) in [(&c.points, false), (&ring.next.points, true)] {
            for (i, &a) in points.iter().enumerate() {
                let b = points[if i + 1 == points.len() { 0 } else { i + 1 }];
                sides.push(Segment { a, b, owner: 0, at: i as u32, proposed });
            }
        }
        let index = Index::new(&sides);
        let name = |v: u32| if v >= NEW { v - NEW + n as u32 } else { v };
        let patch = Patch {
            quads: ring.quads.iter().map(|q| q.map(name)).collect(),
            children: vec![ring.next.nodes.iter().map(|&v| name(v)).collect()],
            n_fallbacks: 0,
            points: ring.points.clone(),
        };
        let others = Others { index: &index, own: 0, committed: &[false], gap: 1.2 };
        let corners = |k: usize| patch.quads[k].map(|v| patch.point(c, v));
        evaluate::against(&ring, &state, &others, corners).map_err(|f| refusal(f.stop))?;
        evaluate::after(&state, &ring, true).map_err(|f| refusal(f.stop))?;
        debug_assert!(patch.children[0].len() % 2 == n % 2, "a ring keeps the parity");
        Ok(patch)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use csalf_geom::{Point2, Tolerance};
    use csalf_sizemap::Uniform;

    fn pave(points: &[Point2], h: f64) -> Result<Patch, Refusal> {
        let contour = Contour::from_ring(points, h);
        let tolerance = Tolerance::of_points(points.iter().copied());
        LoopPaver::default().mesh(&RegionTask { contour: &contour, size: &Uniform(h), tolerance })
    }

    #[test]
    fn a_fat_contour_gets_one_ring() {
        let disc: Vec<Point2> =
            (0..40).map(|i| Point2::from_angle(std::f64::consts::TAU * f64::from(i) / 40.0) * 6.4).collect();
        let p = pave(&disc, 1.0).expect("a disc can be paved");
        assert_eq!((p.quads.len(), p.points.len(), p.children.len()), (40, 40, 1));
        assert_eq!(p.children[0], (40..80).collect::<Vec<u32>>());
        let area = |q: &[Point2]| polygon::signed_area(q);
        let quads: f64 = p
            .quads
            .iter()
            .map(|q| area(&q.map(|v| if v < 40 { disc[v as usize] } else { p.points[v as usize - 40] })))
            .sum();
        assert!((quads + area(&p.points) - area(&disc)).abs() < 1e-9);
    }

    #[test]
    fn a_thin_contour_is_left_to_others() {
        let strip: Vec<Point2> = (0..20)
            .map(|i| Point2::new(f64::from(i), 0.0))
            .chain((0..20).rev().map(|i| Point2::new(f64::from(i), 2.0)))
            .collect();
        assert_eq!(pave(&strip, 1.0), Err(Refusal::NotApplicable));
    }
}
