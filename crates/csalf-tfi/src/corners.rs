//! Which nodes of a contour are its logical corners.
//!
//! ```text
//!    θ:   0 ......... 112 ......... 150 .................. 225 ....... 360
//!             sure         ambiguous        straight            refuse
//! ```
//!
//! 1. One pass without angles (products only) refuses contours with a reflex node, a slit tip or too many
//!    sure corners, and collects the corner candidates.
//! 2. A choice of corners costs `sum_corners ((θ-90)/90)² + sum_others ((θ-180)/90)²`. Making a node a
//!    corner changes that by `-(135 - θ)/45`, so the cost of a choice is a constant minus the gains of its
//!    corners.
//! 3. Choices: all sure corners with every subset of the best ambiguous ones; and every choice of four
//!    candidates whose opposite counts are equal (two pairs of antipodal candidates).
//!
//! Source: handbook 4.8 and 5.2, with squares in place of absolute values: a smooth arc of many small bends
//! is then no worse than a straight side. Cost: 5 ns per node if refused.

use crate::pattern::MAX_SIDES;
use csalf_geom::Point2;
use csalf_mesh::Contour;

/// Most candidates that are kept.
const MAX_CANDIDATES: usize = 16;
/// Most ambiguous candidates whose subsets are enumerated.
const MAX_AMBIGUOUS: usize = 5;
/// A smaller interior angle (degrees) is surely a corner.
const SURE: f64 = 112.0;
/// A larger interior angle (degrees) is surely none: the quad in it would have a scaled Jacobian under 0.5.
const LARGEST: f64 = 150.0;
/// A turn to the right whose sine is at most this counts as straight: rounding of nodes on a line.
const STRAIGHT: f64 = 1e-9;

/// A node that may be a corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Occurrence.
    pub at: u32,
    /// Interior angle, degrees.
    pub angle: f64,
}

/// One choice of corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interpretation {
    /// Number of corners, 0 to 6.
    pub n: usize,
    /// Occurrences of the corners, ascending.
    pub corners: [u32; MAX_SIDES],
    /// Misfit of the angles, lower is better.
    pub cost: f64,
    /// Smallest interior angle of a corner, degrees (180 without corners).
    pub sharpest: f64,
}

impl Interpretation {
    /// The interpretation that takes the occurrences with one wanted quad as corners; `None` if another has
    /// not two, or the corners are too many.
    pub fn given(wanted: &[u8]) -> Option<Self> {
        let mut out = Self { n: 0, corners: [0; MAX_SIDES], cost: 0.0, sharpest: 180.0 };
        for (i, &k) in wanted.iter().enumerate() {
            match k {
                1 if out.n < MAX_SIDES => {
                    out.corners[out.n] = i as u32;
                    out.n += 1;
                }
                2 => {}
                _ => return None,
            }
        }
        Some(out)
    }

    /// Numbers of segments from each corner to the next, on a contour of `len` nodes.
    pub fn sides(&self, len: usize) -> [u32; MAX_SIDES] {
        let mut s = [0; MAX_SIDES];
        for (k, side) in s.iter_mut().enumerate().take(self.n) {
            let next = if k + 1 < self.n { self.corners[k + 1] } else { self.corners[0] + len as u32 };
            *side = next - self.corners[k];
        }
        s
    }
}

/// What one pass over the contour tells.
#[derive(Clone, Debug)]
pub struct Survey {
    candidates: [Candidate; MAX_CANDIDATES],
    n_candidates: usize,
    /// `sum ((θ - 180)/90)²` over all nodes.
    straight_cost: f64,
    /// Sum of the bends of concave nodes, degrees.
    pub concave: f64,
    /// True if no interior angle is above 180 degrees (to rounding).
    pub convex: bool,
}

impl Survey {
    /// Surveys the contour; `None` if it cannot be one patch. `reflex` is the largest interior angle
    /// allowed, in degrees, 180 to 270.
    pub fn new(contour: &Contour, reflex: f64) -> Option<Self> {
        let n = contour.len();
        if n < 4 || n % 2 == 1 {
            return None;
        }
        let mut out = Self {
            candidates: [Candidate { at: 0, angle: 0.0 }; MAX_CANDIDATES],
            n_candidates: 0,
            straight_cost: 0.0,
            concave: 0.0,
            convex: true,
        };
        let cos_reflex = reflex.to_radians().cos();
        let cos_largest = LARGEST.to_radians().cos();
        let mut sure = 0;
        let p = &contour.points;
        let mut u = p[0] - p[n - 1];
        let mut lu = u.length_squared();
        for i in 0..n {
            let next = if i + 1 < n { i + 1 } else { 0 };
            let v = p[next] - p[i];
            let lv = v.length_squared();
            let ll = (lu * lv).sqrt();
            // Angle of turning: cross > 0 is a convex node; cosine of the interior angle is -dot.
            let (cross, dot) = (u.perp_dot(v), u.dot(v));
            if ll <= 0.0 {
                return None;
            }
            let cosine = -dot / ll;
            if cross <= 0.0 && cosine > cos_reflex {
                return None;
            }
            out.convex &= cross >= -STRAIGHT * ll;
            // (θ - 180)² for bends that are not corners, from the cosine: exact to the fourth order.
            let c = 2.0 * (1.0 + cosine);
            out.straight_cost += c * (1.0 + c / 12.0) * RADIANS_TO_RIGHT;
            if cross < 0.0 {
                out.concave += c.max(0.0).sqrt().to_degrees();
            }
            if cross > 0.0 && cosine > cos_largest {
                let angle = cross.atan2(-dot).to_degrees();
                // Replace the Taylor value by the exact one.
                let bend = (180.0 - angle) / 90.0;
                out.straight_cost += bend * bend - c * (1.0 + c / 12.0) * RADIANS_TO_RIGHT;
                sure += usize::from(angle <= SURE);
                if sure > MAX_SIDES {
                    return None;
                }
                out.insert(Candidate { at: i as u32, angle });
            }
            (u, lu) = (v, lv);
        }
        out.candidates[..out.n_candidates].sort_unstable_by_key(|c| c.at);
        Some(out)
    }

    fn insert(&mut self, c: Candidate) {
        if self.n_candidates < MAX_CANDIDATES {
            self.candidates[self.n_candidates] = c;
            self.n_candidates += 1;
            return;
        }
        let worst = (0..MAX_CANDIDATES)
            .max_by(|&i, &j| self.candidates[i].angle.total_cmp(&self.candidates[j].angle))
            .unwrap_or(0);
        if self.candidates[worst].angle > c.angle {
            self.candidates[worst] = c;
        }
    }

    /// The candidates, by occurrence.
    pub fn candidates(&self) -> &[Candidate] {
        &self.candidates[..self.n_candidates]
    }

    /// The interpretation that takes the candidates of a bit set as corners.
    fn choose(&self, set: u32) -> Interpretation {
        let mut out =
            Interpretation { n: 0, corners: [0; MAX_SIDES], cost: self.straight_cost, sharpest: 180.0 };
        for (k, c) in self.candidates().iter().enumerate() {
            if set >> k & 1 == 1 && out.n < MAX_SIDES {
                out.corners[out.n] = c.at;
                out.n += 1;
                out.cost -= (135.0 - c.angle) / 45.0;
                out.sharpest = out.sharpest.min(c.angle);
            }
        }
        out
    }

    /// Calls `visit` with every interpretation worth a thought. At most 32 + 28 of them.
    pub fn interpretations(&self, len: usize, visit: &mut dyn FnMut(Interpretation)) {
        let list = self.candidates();
        let mut sure = 0u32;
        let mut ambiguous: [(f64, usize); MAX_CANDIDATES] = [(0.0, 0); MAX_CANDIDATES];
        let mut n_ambiguous = 0;
        for (k, c) in list.iter().enumerate() {
            if c.angle <= SURE {
                sure |= 1 << k;
            } else {
                ambiguous[n_ambiguous] = (c.angle, k);
                n_ambiguous += 1;
            }
        }
        let ambiguous = &mut ambiguous[..n_ambiguous];
        ambiguous.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let m = n_ambiguous.min(MAX_AMBIGUOUS);
        let mut few = sure;
        for bits in 0..1u32 << m {
            let set = (0..m).fold(sure, |s, k| if bits >> k & 1 == 1 { s | 1 << ambiguous[k].1 } else { s });
            if set.count_ones() as usize <= MAX_SIDES {
                visit(self.choose(set));
            }
        }
        (0..m).for_each(|k| few |= 1 << ambiguous[k].1);
        // Antipodal pairs: two of them are the corners of a mappable rectangle.
        let half = (len / 2) as u32;
        let mut pairs = [(0u32, 0u32); MAX_CANDIDATES];
        let mut n_pairs = 0;
        for (i, a) in list.iter().enumerate() {
            if let Some(j) = list[i + 1..].iter().position(|b| b.at - a.at == half) {
                pairs[n_pairs] = (1 << i | 1 << (i + 1 + j), 0);
                n_pairs += 1;
            }
        }
        for i in 0..n_pairs {
            for j in i + 1..n_pairs {
                let set = pairs[i].0 | pairs[j].0;
                // Those within the subsets above were visited.
                if set & sure == sure && set & !few != 0 {
                    visit(self.choose(set));
                }
            }
        }
    }
}

/// (2/π)²: squared radians to squared right angles.
const RADIANS_TO_RIGHT: f64 = 4.0 * std::f64::consts::FRAC_1_PI * std::f64::consts::FRAC_1_PI;

/// Position at real index `at` (>= 0) along the closed polygon.
pub fn along(points: &[Point2], at: f64) -> Point2 {
    let n = points.len();
    let i = at as usize;
    let f = at - i as f64;
    let a = points[i % n];
    if f <= 0.0 { a } else { a.lerp(points[(i + 1) % n], f) }
}
