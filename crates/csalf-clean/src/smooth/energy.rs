//! Shape and size energy of quad corners.
//!
//! ```text
//!        prev               A = [e1 e2] is compared with its target W: lengths a, b and angle alpha.
//!         │ e2              T = A W^-1 (a shear of A),  D = det T,  t = tr(T'T)
//!         │                 shape  f = t / (2 D)           >= 1, = 1 if A is the target, turned and scaled
//!   corner└───── next       size   g = (D + 1/D) / 2       >= 1, = 1 if the area is the target's
//!            e1             F = (1 - lambda) f + lambda g,     E = sum over the corners of F^p, p = 2 or more
//! ```
//!
//! With e1' = e1 / a, e2' = e2 / b: D = e1' x e2' and t = (|e1'|² + |e2'|² - 2 cos(alpha) e1'.e2') /
//! sin(alpha), when W is scaled to area a b. As a function of one vertex T is affine, so f is quadratic over
//! linear and g a sum of convex functions: **E is convex where all D > 0**, and Newton's method is safe. The
//! power draws on the worst corners more than on the mean.
//!
//! For tangled meshes D in the denominators is replaced by chi(D, eps) = (D + sqrt(D² + eps²)) / 2 > 0.
//!
//! Source: handbook 7.3; Knupp 2001; Garanzha et al. 2021 for the regularisation.

use super::lanes::Lanes;
use super::region::Region;
use csalf_geom::Point2;

/// What the energy of a corner is made of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weights {
    /// Share of size, 0 to 1.
    pub(crate) lambda: f64,
    /// Power of F, 2 or more: the larger, the more the worst corners count.
    pub(crate) power: i32,
}

/// Energy, gradient and Hessian (xx, xy, yy) as a function of one vertex.
#[derive(Clone, Copy, Default)]
pub(crate) struct Local {
    pub(crate) value: f64,
    pub(crate) gradient: Point2,
    pub(crate) hessian: [f64; 3],
    /// Smallest D of the corners.
    pub(crate) min_d: f64,
    /// One over the square of the smallest scaled Jacobian of the corners.
    pub(crate) worst: f64,
    /// How fast corners turn: the largest sum of 1 / length² over the edges of a corner that follow the vertex.
    pub(crate) turn: f64,
}

/// The three corners that feel vertex k of a quad, one per lane: its own, the next and the previous one's, in lengths of
/// their targets. The fourth lane is a square, which costs nothing (`real` is 0 there).
struct Feeling {
    x1: Lanes,
    y1: Lanes,
    x2: Lanes,
    y2: Lanes,
    /// Factors by which the scaled edges follow the vertex.
    f1: Lanes,
    f2: Lanes,
    /// Cosine and 1 / sine of the target angle.
    cos: Lanes,
    csc: Lanes,
}

impl Feeling {
    #[inline(always)]
    fn new(region: &Region, at: Point2, h: u32) -> Self {
        let (q, k) = ((h / 4) as usize, (h & 3) as usize);
        let vs = &region.quads[q];
        let (vn, vo, vp) = (vs[(k + 1) & 3] as usize, vs[(k + 2) & 3] as usize, vs[(k + 3) & 3] as usize);
        let (n, o, p) = (region.points[vn], region.points[vo], region.points[vp]);
        let (m, l) = (region.inverse[q][k & 1], region.inverse[q][(k + 1) & 1]);
        let [[c0, s0], [c1, s1], [c2, s2]] =
            [region.angle[vs[k] as usize], region.angle[vn], region.angle[vp]];
        // Own: n - at, p - at. Next: o - n, at - n. Previous: at - p, o - p.
        let (a, b, c, d) = (m * (n - at), l * (p - at), l * (o - n), m * (o - p));
        Self {
            x1: Lanes::new([a.x, c.x, -b.x, 1.0]),
            y1: Lanes::new([a.y, c.y, -b.y, 0.0]),
            x2: Lanes::new([b.x, -a.x, d.x, 0.0]),
            y2: Lanes::new([b.y, -a.y, d.y, 1.0]),
            f1: Lanes::new([-m, 0.0, l, 0.0]),
            f2: Lanes::new([-l, m, 0.0, 0.0]),
            cos: Lanes::new([c0, c1, c2, 0.0]),
            csc: Lanes::new([s0, s1, s2, 1.0]),
        }
    }
    #[inline(always)]
    fn d(&self) -> Lanes {
        self.x1 * self.y2 - self.y1 * self.x2
    }
    /// Squares of the lengths of the edges.
    #[inline(always)]
    fn lengths(&self) -> [Lanes; 2] {
        [self.x1 * self.x1 + self.y1 * self.y1, self.x2 * self.x2 + self.y2 * self.y2]
    }
    #[inline(always)]
    fn t(&self, [l1, l2]: [Lanes; 2]) -> Lanes {
        (l1 + l2 - 2.0 * self.cos * (self.x1 * self.x2 + self.y1 * self.y2)) * self.csc
    }
}

/// 1 for corners, 0 for the lane that fills up.
#[inline(always)]
fn real() -> Lanes {
    Lanes::new([1.0, 1.0, 1.0, 0.0])
}

/// f to the power of `weights.power` - 2.
#[inline(always)]
fn reduced_power(f: Lanes, weights: Weights) -> Lanes {
    // Those in use are worth a branch: a call per lane else.
    let square = f * f;
    match weights.power {
        4 => square,
        8 => square * square * square,
        power => f.powi(power - 2),
    }
}

/// Value and derivatives of the energy of the corners around free vertex `v`, were it at `at`. Meaningful
/// only if `min_d` > 0. Cost about 20 ns per quad.
#[inline(always)]
pub(crate) fn local(region: &Region, v: u32, at: Point2, weights: Weights) -> Local {
    let lambda = weights.lambda;
    let one = Lanes::splat(1.0);
    let zero = Lanes::splat(0.0);
    let real = real();
    let (mut value, mut gx, mut gy, mut hxx, mut hxy, mut hyy) = (zero, zero, zero, zero, zero, zero);
    let mut min_d = Lanes::splat(f64::INFINITY);
    let (mut worst, mut turn) = (zero, zero);
    for &h in region.star(v) {
        let c = Feeling::new(region, at, h);
        let [l1, l2] = c.lengths();
        let (d, t) = (c.d(), c.t([l1, l2]));
        let r = d.recip();
        let inverse = l1 * l2 * (r * r);
        worst = worst.max(inverse);
        let (x1, y1, x2, y2, f1, f2) = (c.x1, c.y1, c.x2, c.y2, c.f1, c.f2);
        turn = turn.max((f1 * f1 * l2 + f2 * f2 * l1) * (l1 * l2).recip());
        let csc = 2.0 * c.csc;
        let (dtx, dty) = (
            csc * (f1 * (x1 - c.cos * x2) + f2 * (x2 - c.cos * x1)),
            csc * (f1 * (y1 - c.cos * y2) + f2 * (y2 - c.cos * y1)),
        );
        let (ddx, ddy) = (f1 * y2 - f2 * y1, f2 * x1 - f1 * x2);
        let kt = csc * (f1 * f1 + f2 * f2 - 2.0 * c.cos * f1 * f2);
        let s = (0.5 * (1.0 - lambda)) * r;
        let st = s * t;
        let f = st + (0.5 * lambda) * (d + r);
        let fd = (0.5 * lambda) * (one - r * r) - st * r;
        let (dfx, dfy) = (s * dtx + fd * ddx, s * dty + fd * ddy);
        // Second derivatives of F.
        let x = s * r;
        let y = (2.0 * st + lambda * r) * r * r;
        let k = s * kt;
        let xx = k - 2.0 * x * dtx * ddx + y * ddx * ddx;
        let xy = y * ddx * ddy - x * (dtx * ddy + dty * ddx);
        let yy = k - 2.0 * x * dty * ddy + y * ddy * ddy;
        // Of the power of F.
        let w = reduced_power(f, weights) * real;
        let m = f64::from(weights.power - 1);
        let wf = w * f;
        value = value + wf * f;
        gx = gx + wf * dfx;
        gy = gy + wf * dfy;
        hxx = hxx + w * (f * xx + m * dfx * dfx);
        hxy = hxy + w * (f * xy + m * dfx * dfy);
        hyy = hyy + w * (f * yy + m * dfy * dfy);
        min_d = min_d.min(d);
    }
    let n = f64::from(weights.power);
    Local {
        value: value.sum(),
        gradient: n * Point2::new(gx.sum(), gy.sum()),
        hessian: [n * hxx.sum(), n * hxy.sum(), n * hyy.sum()],
        min_d: min_d.least(),
        worst: worst.largest(),
        turn: turn.largest(),
    }
}

/// Energy of the corners around `v`, were it at `at`, and whether their scaled Jacobians, squared with their sign, are
/// all above `floor` (below 1). The energy is infinite if a corner is not positive.
#[inline(always)]
pub(crate) fn trial(region: &Region, v: u32, at: Point2, weights: Weights, floor: f64) -> (f64, bool) {
    let lambda = weights.lambda;
    let real = real();
    let mut value = Lanes::splat(0.0);
    let mut least = Lanes::splat(f64::INFINITY);
    let mut above = Lanes::splat(f64::INFINITY);
    for &h in region.star(v) {
        let c = Feeling::new(region, at, h);
        let d = c.d();
        let [l1, l2] = c.lengths();
        let f = ((0.5 * (1.0 - lambda)) * c.t([l1, l2]) + (0.5 * lambda) * (d * d + Lanes::splat(1.0)))
            * d.recip();
        value = value + reduced_power(f, weights) * real * f * f;
        least = least.min(d);
        above = above.min(d * d.abs() - floor * (l1 * l2));
    }
    (if least.least() > 0.0 { value.sum() } else { f64::INFINITY }, above.least() > 0.0)
}

/// True if the scaled Jacobians, squared with their sign, of the corners around `v` are all above `floor`, were it at
/// `at`.
#[inline(always)]
pub(crate) fn is_above(region: &Region, v: u32, at: Point2, floor: f64) -> bool {
    let mut above = Lanes::splat(f64::INFINITY);
    for &h in region.star(v) {
        let c = Feeling::new(region, at, h);
        let d = c.d();
        let [l1, l2] = c.lengths();
        above = above.min(d * d.abs() - floor * (l1 * l2));
    }
    above.least() > 0.0
}

/// Smallest scaled Jacobian of the corners around `v`, were it at `at`, squared with its sign; -1 where an
/// edge has no length.
#[inline(always)]
pub(crate) fn worst_corner(region: &Region, v: u32, at: Point2) -> f64 {
    let mut worst = f64::INFINITY;
    for &h in region.star(v) {
        let c = Feeling::new(region, at, h);
        let d = c.d();
        let [l1, l2] = c.lengths();
        let (d, l) = (d.to_array(), (l1 * l2).to_array());
        for (d, l) in d.into_iter().zip(l).take(3) {
            worst = worst.min(if l > 0.0 { d * d.abs() / l } else { -1.0 });
        }
    }
    worst
}

/// Regularised energy of all corners of the region with the free vertices at `x`, sum of F (not squared), its
/// gradient by the free vertices into `gradient`, and the smallest D. `eps` is positive. Cost about 20 ns per quad.
pub(crate) fn regularised(
    region: &Region,
    x: &[Point2],
    lambda: f64,
    eps: f64,
    gradient: &mut [Point2],
) -> (f64, f64) {
    gradient.fill(Point2::ZERO);
    let at = |v: u32| x.get(v as usize).copied().unwrap_or_else(|| region.points[v as usize]);
    let (one, half) = (Lanes::splat(1.0), Lanes::splat(0.5));
    let (square, four_by_square) = (Lanes::splat(eps * eps), Lanes::splat(4.0 / (eps * eps)));
    let (mut value, mut min_d) = (Lanes::splat(0.0), Lanes::splat(f64::INFINITY));
    for (vs, inverse) in region.quads.iter().zip(&region.inverse) {
        let [a, b, c, d] = vs.map(at);
        let (ab, bc, cd, da) = (b - a, c - b, d - c, a - d);
        // Lane k: corner k, between its side and the one before.
        let [m, l] = [0, 1].map(|k| Lanes::new([inverse[k], inverse[1 - k], inverse[k], inverse[1 - k]]));
        let (x1, y1) = (m * Lanes::new([ab.x, bc.x, cd.x, da.x]), m * Lanes::new([ab.y, bc.y, cd.y, da.y]));
        let (x2, y2) =
            (l * Lanes::new([-da.x, -ab.x, -bc.x, -cd.x]), l * Lanes::new([-da.y, -ab.y, -bc.y, -cd.y]));
        let target = vs.map(|v| region.angle[v as usize]);
        let [cos, csc] = [0, 1].map(|k| Lanes::new(target.map(|t| t[k])));
        let d = x1 * y2 - y1 * x2;
        let t = (x1 * x1 + y1 * y1 + x2 * x2 + y2 * y2 - 2.0 * cos * (x1 * x2 + y1 * y2)) * csc;
        let root = (d * d + square).sqrt();
        // For D < 0 the form without cancellation.
        let sum = half * (d.abs() + root);
        let inverse_chi = d.where_negative(sum * four_by_square, sum.recip());
        let f_chi = 0.5 * ((1.0 - lambda) * t + lambda * (d * d + one));
        value = value + f_chi * inverse_chi;
        min_d = min_d.min(d);
        let by_t = ((1.0 - lambda) * csc) * inverse_chi;
        // The slope of chi is chi / root.
        let by_d = (lambda * d - f_chi * root.recip()) * inverse_chi;
        let e1x = (m * (by_t * (x1 - cos * x2) + by_d * y2)).to_array();
        let e1y = (m * (by_t * (y1 - cos * y2) - by_d * x2)).to_array();
        let e2x = (l * (by_t * (x2 - cos * x1) - by_d * y1)).to_array();
        let e2y = (l * (by_t * (y2 - cos * y1) + by_d * x1)).to_array();
        for k in 0..4 {
            let (before, after) = ((k + 3) & 3, (k + 1) & 3);
            if let Some(g) = gradient.get_mut(vs[k] as usize) {
                g.x += e1x[before] + e2x[after] - e1x[k] - e2x[k];
                g.y += e1y[before] + e2y[after] - e1y[k] - e2y[k];
            }
        }
    }
    (value.sum(), min_d.least())
}
