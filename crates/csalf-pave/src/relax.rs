//! Ring relaxation that keeps the thickness.
//!
//! The isoparametric smoother of the paper, run on a closed ring one quad thick, averages offset *vectors*: its
//! limit is one vector for all nodes, so the ring of a hole is translated instead of offset. Here thickness and
//! direction are smoothed apart, on flat nodes only, near what each node wants. Source: handbook 3.5.

use csalf_geom::Point2;

/// Three rounds of (1, 2, 1)/4 over the thicknesses `t` of a closed loop, each node kept within 1.3 of its target.
/// Nodes with `free[i]` false stay. All slices have one entry per node. Cost O(n).
pub fn smooth_thickness(t: &mut [f64], free: &[bool]) {
    let n = t.len();
    if n < 3 {
        return;
    }
    let target = t.to_vec();
    let mut old = vec![0.0; n];
    for _ in 0..3 {
        old.copy_from_slice(t);
        for i in 0..n {
            if free[i] {
                let (a, c) =
                    (old[if i == 0 { n - 1 } else { i - 1 }], old[if i + 1 == n { 0 } else { i + 1 }]);
                t[i] = (0.25 * (a + 2.0 * old[i] + c)).clamp(target[i] / 1.3, target[i] * 1.3);
            }
        }
    }
}

/// Three rounds over the directions of the rays `q[i] - b[i]`: each turns towards the mean of twice its own
/// bisector and its neighbours' directions, by no more than 15 degrees, and slides so that its offset along the
/// bisector stays. Nodes with `free[i]` false keep their ray. Cost O(n).
pub fn smooth_directions(b: &[Point2], q: &mut [Point2], free: &[bool]) {
    let n = b.len();
    if n < 3 {
        return;
    }
    let bisector: Vec<Point2> = (0..n).map(|i| (q[i] - b[i]).normalize_or_zero()).collect();
    let mut dir = bisector.clone();
    let mut old = dir.clone();
    for _ in 0..3 {
        old.copy_from_slice(&dir);
        for i in 0..n {
            if free[i] {
                let (a, c) = (if i == 0 { n - 1 } else { i - 1 }, if i + 1 == n { 0 } else { i + 1 });
                dir[i] = (2.0 * bisector[i] + old[a] + old[c]).normalize_or_zero();
            }
        }
    }
    let widest = 15f64.to_radians();
    for i in 0..n {
        if !free[i] || dir[i] == Point2::ZERO || bisector[i] == Point2::ZERO {
            continue;
        }
        let angle = bisector[i].angle_to(dir[i]).clamp(-widest, widest);
        let l = b[i].distance(q[i]) / angle.cos();
        q[i] = b[i] + csalf_geom::angle::rotated(bisector[i], angle) * l;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The trap of handbook 3.5: a smoothed ring of a hole must stay a ring around it.
    #[test]
    fn a_round_ring_stays_where_it_is() {
        let n = 24;
        let b: Vec<Point2> =
            (0..n).map(|i| Point2::from_angle(-std::f64::consts::TAU * i as f64 / n as f64)).collect();
        let mut q: Vec<Point2> = b.iter().map(|p| *p * 1.3).collect();
        let want = q.clone();
        smooth_directions(&b, &mut q, &vec![true; n]);
        assert!(q.iter().zip(&want).all(|(a, b)| a.distance(*b) < 1e-12));
        let mut t = vec![0.3; n];
        smooth_thickness(&mut t, &vec![true; n]);
        assert!(t.iter().all(|t| (t - 0.3).abs() < 1e-12));
    }

    #[test]
    fn thickness_evens_out_within_limits() {
        let mut t: Vec<f64> = (0..16).map(|i| if i % 2 == 0 { 1.0 } else { 2.0 }).collect();
        smooth_thickness(&mut t, &[true; 16]);
        assert!((t[0] - 1.3).abs() < 1e-12 && (t[1] - 2.0 / 1.3).abs() < 1e-12);
    }
}
