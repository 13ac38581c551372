//! Bilinear transfinite interpolation of one block, with the parameters blended from the arc lengths of all
//! four sides.
//!
//! ```text
//!        top(i)                 u(i,j), v(i,j): where the line u_bot(i)-u_top(i) meets the line
//!     ┌────●────┐               v_left(j)-v_right(j) in the unit square (Soni's form)
//! left│    │    │right          P = (1-v) bot + v top + (1-u) left + u right - bilinear(corners)
//! (j) ●────┼────● (j)
//!     └────●────┘
//!        bot(i)
//! ```
//!
//! Source: handbook 5.1; Soni 1985 for the blended parameters. Cost: a few multiplications and one division per inner node.

use csalf_geom::Point2;

/// One side of a block: positions from its first to its last node and normalised arc lengths (0 to 1).
#[derive(Clone, Debug, Default)]
pub struct Side {
    /// Positions.
    pub points: Vec<Point2>,
    /// Names of the nodes in the patch under construction.
    pub names: Vec<u32>,
    /// Normalised arc length of each node.
    pub t: Vec<f64>,
}

impl Side {
    /// Empties the side.
    pub fn clear(&mut self) {
        self.points.clear();
        self.names.clear();
        self.t.clear();
    }

    /// Fills in the arc lengths. A side of length zero is divided evenly.
    pub fn measure(&mut self) {
        self.t.clear();
        let mut l = 0.0;
        let n = self.points.len();
        for i in 0..n {
            if i > 0 {
                l += self.points[i].distance(self.points[i - 1]);
            }
            self.t.push(l);
        }
        if l > 0.0 {
            let k = 1.0 / l;
            self.t.iter_mut().for_each(|t| *t *= k);
        } else {
            let m = n.saturating_sub(1).max(1) as f64;
            self.t.iter_mut().enumerate().for_each(|(i, t)| *t = i as f64 / m);
        }
    }
}

/// Writes the inner nodes of the block row by row (`j = 1..b`, in each `i = 1..a`) to `out`. `bot` and
/// `top` run along i, `left` and `right` along j; opposite sides have equal numbers of nodes and are
/// measured.
pub fn interpolate(bot: &Side, top: &Side, left: &Side, right: &Side, out: &mut Vec<Point2>) {
    let (a, b) = (bot.points.len() - 1, left.points.len() - 1);
    let (p00, pa0, p0b, pab) = (bot.points[0], bot.points[a], top.points[0], top.points[a]);
    out.reserve((a.max(1) - 1) * (b.max(1) - 1));
    for j in 1..b {
        let (l, r) = (left.points[j], right.points[j]);
        let (v0, dv) = (left.t[j], right.t[j] - left.t[j]);
        let sides = bot.points[1..a].iter().zip(&top.points[1..a]).zip(bot.t[1..a].iter().zip(&top.t[1..a]));
        for ((&pb, &pt), (&u0, &u1)) in sides {
            let du = u1 - u0;
            let u = (u0 + v0 * du) / (1.0 - du * dv);
            let v = v0 + u * dv;
            let (cu, cv) = (1.0 - u, 1.0 - v);
            let corners = (p00 * cu + pa0 * u) * cv + (p0b * cu + pab * u) * v;
            out.push(pb * cv + pt * v + l * cu + r * u - corners);
        }
    }
}
