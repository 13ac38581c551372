//! Which front a node gets: by angle, by the quads already below it, and by trial where the angle leaves it open.
//!
//! ```text
//!   theta    45     60        105  120  135            205  216  235        295  308.6  320
//!   geometry  K | trial |  E   | trial  |      S         | trial  |     C     |  trial  |    R
//! ```
//!
//! 1. [`thresholds`]: k and k + 1 quads are equally good at theta = π k (k+1)/(2k+1): 120, 216, 308.6 degrees. At a
//!    node with m quads below the loop they shift so that m + k tends to 4.
//! 2. [`classify`]: thin layers turn convex corners into mitres; nodes of smooth curves are flat; sharp nodes are
//!    acute; the rest goes by the thresholds.
//! 3. Within a window about a threshold both fronts are built on the spot ([`trial`]) and the better is taken.
//!
//! Source: handbook 2.2 (a) to (g), after the paper's Table I and the row classification of paving.

use crate::Front;
use crate::place::{PavingRules, Site};
use csalf_geom::Point2;
use csalf_geom::angle::interior_angle;
use csalf_mesh::quality::scaled_jacobian;
use csalf_mesh::validate::is_strictly_convex;

/// Below this angle (degrees) a front is acute. Larger: more notches at sharp corners; smaller: thin tapered
/// quads there. Handbook 2.2 (g).
pub const ACUTE: f64 = 45.0;

/// Thinner than this share of the spacing a convex corner becomes a mitre (handbook 2.2 (f)).
pub const THIN: f64 = 0.7;

/// What is known of a node when its front is chosen.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Interior angle, radians, (0, 2π].
    pub theta: f64,
    /// Quads already at the node, on the far side of the loop.
    pub below: u8,
    /// The node belongs to the input geometry.
    pub geometry: bool,
    /// The node lies on a smooth curve: its neighbours turn as much as it does.
    pub smooth: bool,
    /// Thickness over tangential spacing, t / s.
    pub rho: f64,
}

/// The three angles, radians, at which 1|2, 2|3 and 3|4 quads are equally good at a node.
///
/// Geometry nodes: 120, 216, 308.6 degrees. Others: moved by 30 (m + k - 3.5) degrees where m = `below`; the
/// first is kept within 105 to 145 degrees (handbook 2.2 (c)).
pub fn thresholds(below: u8, geometry: bool) -> [f64; 3] {
    let base = [120.0, 216.0, 2160.0 / 7.0];
    let mut out = [0.0; 3];
    for (i, b) in base.into_iter().enumerate() {
        let k = i as f64 + 1.0;
        let shift = if geometry { 0.0 } else { 30.0 * (f64::from(below) + k - 3.5) };
        out[i] = b + shift;
    }
    out[0] = out[0].clamp(105.0, 145.0);
    // Three quads are never better than two below 205 degrees, nor four than three below 290.
    out[1] = out[1].max(205.0);
    out[2] = out[2].clamp(290.0, 354.0);
    out.map(f64::to_radians)
}

/// A front, and the other one that a trial may prefer.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Choice {
    /// The front by angle.
    pub front: Front,
    /// The front on the other side of a near threshold.
    pub rival: Option<Front>,
}

/// Front of a node by its angle alone, with the rival if the angle lies near a threshold (15 degrees between one
/// and two quads, 12 elsewhere). Cost O(1).
pub fn classify(v: &View) -> Choice {
    let deg = v.theta.to_degrees();
    let sure = |front| Choice { front, rival: None };
    if deg < ACUTE {
        return sure(Front::Acute);
    }
    if v.smooth && (130.0..=230.0).contains(&deg) {
        return sure(Front::Flat);
    }
    if v.rho < THIN && deg < 135.0 {
        // A mitre is the better corner of a thin layer from 60 degrees on; below, one quad may still do.
        return if deg >= 60.0 {
            sure(Front::Flat)
        } else {
            Choice { front: Front::Flat, rival: Some(Front::Right) }
        };
    }
    if deg < 60.0 {
        return Choice { front: Front::Right, rival: Some(Front::Acute) };
    }
    let th = thresholds(v.below, v.geometry);
    let k = 1 + th.iter().filter(|&&t| v.theta > t).count() as u8;
    let front = Front::of_quads(k, v.theta);
    // The corner of a part is a corner (handbook 2.2 (e)); on the geometry a clear corner needs no trial.
    if v.geometry && !v.smooth && deg < 110.0 {
        return sure(front);
    }
    let rival = (0..3u8).find_map(|i| {
        let window = if i == 0 { 15f64 } else { 12f64 }.to_radians();
        ((v.theta - th[i as usize]).abs() < window)
            .then(|| Front::of_quads(if k == i + 1 { i + 2 } else { i + 1 }, v.theta))
    });
    Choice { front, rival }
}

/// Builds the quads of front `front` at `p[3]` with the thickness `t` and returns their smallest scaled Jacobian,
/// -1 if one is not strictly convex. `p`: seven successive nodes of the loop, the front's in the middle; the
/// neighbours are taken as flat.
pub fn trial(p: &[Point2; 7], front: Front, t: f64) -> f64 {
    let site = |i: usize| Site::new(p[i - 1], p[i], p[i + 1], t);
    let here = site(3);
    let (qa, qc) = (site(2).flat(), site(4).flat());
    let worst = |quads: &[[Point2; 4]]| {
        quads
            .iter()
            .map(|q| if is_strictly_convex(q) { scaled_jacobian::value(q) } else { -1.0 })
            .fold(1.0, f64::min)
    };
    match front {
        // An acute front is what is left when a corner of quality 0.3 cannot be had.
        Front::Acute => 0.3,
        Front::Right | Front::Obtuse => {
            let k = here.corner();
            let (wa, wc) = (site(1).flat(), site(5).flat());
            worst(&[[p[2], p[3], p[4], k], [p[1], p[2], k, wa], [p[4], p[5], wc, k]])
        }
        Front::Flat => {
            let q = here.flat();
            worst(&[[p[2], p[3], q, qa], [p[3], p[4], qc, q]])
        }
        Front::RightReversal => {
            let [r, s, q] = here.right_reversal(PavingRules::Corrected);
            worst(&[[p[2], p[3], r, qa], [p[3], q, s, r], [p[3], p[4], qc, q]])
        }
        Front::Reversal => {
            let [r, s, m, u, q] = here.reversal(PavingRules::Corrected);
            worst(&[[p[2], p[3], r, qa], [p[3], m, s, r], [p[3], q, u, m], [p[3], p[4], qc, q]])
        }
    }
}

/// Settles a choice by trial: the rival wins only if it is better by 0.05. Between two that differ by less the
/// flat front is preferred, then the corner, then the right reversal (handbook 2.2 (d)).
pub fn decide(choice: Choice, p: &[Point2; 7], t: f64) -> Front {
    let Some(rival) = choice.rival else { return choice.front };
    let rank = |f: Front| match f {
        Front::Flat => 0,
        Front::Right | Front::Obtuse => 1,
        Front::RightReversal => 2,
        Front::Reversal => 3,
        Front::Acute => 4,
    };
    let (a, b) = (trial(p, choice.front, t), trial(p, rival, t));
    if (a - b).abs() < 0.05 {
        if rank(rival) < rank(choice.front) { rival } else { choice.front }
    } else if b > a {
        rival
    } else {
        choice.front
    }
}

/// Marks the nodes of smooth curves: nodes that turn by less than 50 degrees and by no more than one and a half
/// times what their neighbours turn, or by less than 20 degrees. `points`: one per occurrence. Cost O(n).
pub fn smooth_nodes(points: &[Point2]) -> Vec<bool> {
    let n = points.len();
    let turn: Vec<f64> = (0..n)
        .map(|i| {
            interior_angle(points[(i + n - 1) % n], points[i], points[(i + 1) % n]) - std::f64::consts::PI
        })
        .collect();
    (0..n)
        .map(|i| {
            let t = turn[i];
            let near = [turn[(i + n - 1) % n], turn[(i + 1) % n]];
            let same = near.iter().map(|u| u * t.signum()).fold(f64::NEG_INFINITY, f64::max);
            t.abs() < 20f64.to_radians() || (t.abs() < 50f64.to_radians() && t.abs() <= 1.5 * same)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(deg: f64) -> View {
        View { theta: deg.to_radians(), below: 0, geometry: true, smooth: false, rho: 1.0 }
    }

    /// The table of intervals in handbook 2.2.
    #[test]
    fn intervals_of_the_paper_types() {
        let letters: String = [30., 50., 90., 118., 122., 180., 214., 218., 270., 307., 310., 360.]
            .iter()
            .map(|&d| classify(&view(d)).front.letter())
            .collect();
        assert_eq!(letters, "KEEESSSCCCRR");
        assert_eq!(classify(&view(118.)).rival, Some(Front::Flat));
        assert_eq!(classify(&view(50.)).rival, Some(Front::Acute));
        assert_eq!(classify(&view(180.)).rival, None);
        assert_eq!(classify(&view(225.)).rival, Some(Front::Flat));
    }

    /// Handbook 2.2 (c): thresholds of nodes with one, two and three quads below.
    #[test]
    fn connectivity_moves_the_thresholds() {
        let deg = |m| thresholds(m, false).map(|t| t.to_degrees().round());
        assert_eq!(deg(1), [105.0, 205.0, 324.0]);
        assert_eq!(deg(2), [105.0, 231.0, 354.0]);
        assert_eq!(deg(3)[0], 135.0);
    }

    #[test]
    fn thin_layers_mitre_their_corners() {
        assert_eq!(classify(&View { rho: 0.5, ..view(90.) }).front, Front::Flat);
        assert_eq!(classify(&View { rho: 1.0, ..view(90.) }).front, Front::Right);
    }

    #[test]
    fn coarse_circles_are_flat() {
        for n in [8, 12, 40] {
            let hole: Vec<_> =
                (0..n).map(|i| Point2::from_angle(-std::f64::consts::TAU * i as f64 / n as f64)).collect();
            assert!(smooth_nodes(&hole).iter().all(|&s| s), "{n}");
        }
        let square: Vec<_> =
            [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(x, y)| Point2::new(x, y)).to_vec();
        assert!(smooth_nodes(&square).iter().all(|&s| !s));
    }

    #[test]
    fn trials_prefer_what_the_table_says() {
        // Two straight sides meeting at an angle, unit spacing.
        let bent = |deg: f64| {
            let d = Point2::from_angle(deg.to_radians());
            [d * 3., d * 2., d, Point2::ZERO, Point2::X, Point2::X * 2., Point2::X * 3.]
        };
        assert!(trial(&bent(90.), Front::Right, 1.0) > 0.99);
        assert!(trial(&bent(90.), Front::Flat, 1.0) < 0.1);
        assert!(trial(&bent(90.), Front::Right, 0.5) < trial(&bent(90.), Front::Flat, 0.5));
        let c = Choice { front: Front::Right, rival: Some(Front::Flat) };
        assert_eq!(decide(c, &bent(100.), 1.0), Front::Right);
        assert_eq!(decide(c, &bent(130.), 1.0), Front::Flat);
        let c = Choice { front: Front::RightReversal, rival: Some(Front::Flat) };
        assert_eq!(decide(c, &bent(232.), 1.0), Front::RightReversal);
    }
}
