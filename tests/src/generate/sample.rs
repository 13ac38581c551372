//! Nodes on outlines: equidistribution of a random size along the curve.

use super::outline::Outline;
use crate::Rng;
use csalf_geom::Point2;

/// Wanted segment length along a curve of length 1 (parameter t in [0, 1), cyclic), as a factor of the base length.
#[derive(Clone, Debug)]
pub enum Spacing {
    /// 1 everywhere.
    Even,
    /// Grows linearly with the distance from some places: (t, factor there, slope), never above 1.
    Spots(Vec<(f64, f64, f64)>),
    /// Jumps: (from t, factor), in order.
    Steps(Vec<(f64, f64)>),
    /// Multiplied by exp of noise with this amplitude, node by node.
    Noise(f64),
}

impl Spacing {
    /// A random spacing; `ratio`: largest over smallest length, 1 or more.
    pub fn random(rng: &mut Rng, ratio: f64) -> Self {
        if ratio < 1.5 {
            return Self::Even;
        }
        match rng.int(0, 5) {
            0..=2 => Self::Spots(
                (0..rng.int(1, 3))
                    .map(|_| (rng.unit(), 1.0 / rng.log(1.0, ratio), rng.log(0.1, 1.0)))
                    .collect(),
            ),
            3 => {
                let mut steps: Vec<_> =
                    (0..rng.int(1, 3)).map(|_| (rng.unit(), 1.0 / rng.log(1.0, ratio))).collect();
                steps.sort_by(|a, b| a.0.total_cmp(&b.0));
                Self::Steps(steps)
            }
            4 => Self::Noise(rng.real(0.05, 0.9)),
            _ => Self::Even,
        }
    }

    /// The factor at `t`; `base`: the base length as a share of the curve.
    fn at(&self, t: f64, base: f64, rng: &mut Rng) -> f64 {
        match self {
            Self::Even => 1.0,
            Self::Spots(spots) => spots.iter().fold(1.0, |f, &(s, least, slope)| {
                let d = (t - s).abs();
                f64::min(f, least + slope * d.min(1.0 - d) / base)
            }),
            Self::Steps(steps) => {
                // A short stretch of small steps, then back to 1.
                let inside = steps.iter().find(|s| t >= s.0 && t < s.0 + 12.0 * s.1 * base);
                inside.map_or(1.0, |s| s.1)
            }
            Self::Noise(a) => (a * rng.real(-1.0, 1.0)).exp(),
        }
    }
}

/// Gives a curve nodes about `h` apart, times the spacing's factor; corners become nodes. At most `most` nodes, else
/// `None`.
pub fn sample(
    outline: &Outline,
    h: f64,
    spacing: &Spacing,
    most: usize,
    rng: &mut Rng,
) -> Option<Vec<Point2>> {
    let n = outline.points.len();
    let total = csalf_geom::polygon::perimeter(&outline.points);
    let base = h / total;
    let first = outline.corner.iter().position(|&c| c).unwrap_or(0);
    let mut nodes = Vec::new();
    // One piece from corner to corner at a time: its small steps (end point, weight so far).
    let (mut s, mut weight) = (0.0, 0.0);
    let mut piece: Vec<(Point2, f64)> = vec![(outline.points[first], 0.0)];
    for k in 0..n {
        let (a, b) = (outline.points[(first + k) % n], outline.points[(first + k + 1) % n]);
        let length = a.distance(b);
        let mut done = 0.0;
        while done < length {
            let f = spacing.at((s + done) / total, base, rng).max(1e-4);
            let step = (0.25 * f * h).min(length - done);
            done += step;
            weight += step / (f * h);
            piece.push((a.lerp(b, (done / length).min(1.0)), weight));
            if piece.len() > 8 * most {
                return None;
            }
        }
        s += length;
        if k + 1 == n || outline.corner[(first + k + 1) % n] {
            cut(&piece, &mut nodes);
            if nodes.len() > most {
                return None;
            }
            weight = 0.0;
            piece = vec![(b, 0.0)];
        }
    }
    Some(nodes)
}

/// Puts nodes at equal weights on a piece, its end left out.
fn cut(piece: &[(Point2, f64)], nodes: &mut Vec<Point2>) {
    let weight = piece.last().map_or(0.0, |p| p.1);
    let n = weight.round().max(1.0) as usize;
    let mut k = 1;
    nodes.push(piece[0].0);
    for i in 1..n {
        let w = weight * i as f64 / n as f64;
        while k + 1 < piece.len() && piece[k].1 < w {
            k += 1;
        }
        let (a, b) = (piece[k - 1], piece[k]);
        nodes.push(a.0.lerp(b.0, ((w - a.1) / (b.1 - a.1)).clamp(0.0, 1.0)));
    }
}

/// A straight line of `n` segments from `a` to `b`, both ends exact.
pub fn line(a: Point2, b: Point2, n: usize) -> Vec<Point2> {
    let mut out: Vec<_> = (0..=n).map(|i| a.lerp(b, i as f64 / n as f64)).collect();
    (out[0], out[n]) = (a, b);
    out
}
