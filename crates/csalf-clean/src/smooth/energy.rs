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
}

/// One corner, in lengths of its target.
struct Corner {
    e1: Point2,
    e2: Point2,
    /// cos and 1 / sin of the target angle.
    target: [f64; 2],
}

impl Corner {
    #[inline]
    fn d(&self) -> f64 {
        self.e1.perp_dot(self.e2)
    }
    #[inline]
    fn t(&self) -> f64 {
        (self.e1.length_squared() + self.e2.length_squared() - 2.0 * self.target[0] * self.e1.dot(self.e2))
            * self.target[1]
    }
}

/// The three corners that feel vertex k of a quad: its own, the next and the previous one's, each with the
/// factors by which its scaled edges follow the vertex.
#[inline]
fn corners_at(region: &Region, at: Point2, h: u32) -> [(Corner, f64, f64); 3] {
    let (q, k) = ((h / 4) as usize, (h & 3) as usize);
    let vs = &region.quads[q];
    let (vn, vo, vp) = (vs[(k + 1) & 3] as usize, vs[(k + 2) & 3] as usize, vs[(k + 3) & 3] as usize);
    let (n, o, p) = (region.points[vn], region.points[vo], region.points[vp]);
    let (m, l) = (region.inverse[q][k & 1], region.inverse[q][(k + 1) & 1]);
    let a = &region.angle;
    [
        (Corner { e1: m * (n - at), e2: l * (p - at), target: a[vs[k] as usize] }, -m, -l),
        (Corner { e1: l * (o - n), e2: m * (at - n), target: a[vn] }, 0.0, m),
        (Corner { e1: l * (at - p), e2: m * (o - p), target: a[vp] }, l, 0.0),
    ]
}

/// Value and derivatives of the energy of the corners around free vertex `v`, were it at `at`. Meaningful
/// only if `min_d` > 0.
#[inline]
pub(crate) fn local(region: &Region, v: u32, at: Point2, weights: Weights) -> Local {
    let lambda = weights.lambda;
    let mut out = Local { min_d: f64::INFINITY, ..Local::default() };
    for &h in region.star(v) {
        for (c, f1, f2) in corners_at(region, at, h) {
            let (d, t) = (c.d(), c.t());
            let r = 1.0 / d;
            let [cos, csc] = c.target;
            let g1 = (2.0 * csc) * (c.e1 - cos * c.e2);
            let g2 = (2.0 * csc) * (c.e2 - cos * c.e1);
            let dt = f1 * g1 + f2 * g2;
            let dd = f1 * Point2::new(c.e2.y, -c.e2.x) + f2 * Point2::new(-c.e1.y, c.e1.x);
            let kt = 2.0 * csc * (f1 * f1 + f2 * f2 - 2.0 * cos * f1 * f2);
            let s = 0.5 * (1.0 - lambda) * r;
            let f = s * t + 0.5 * lambda * (d + r);
            let fd = -s * t * r + 0.5 * lambda * (1.0 - r * r);
            let df = s * dt + fd * dd;
            // Second derivatives of F.
            let x = -s * r;
            let y = (2.0 * s * t + lambda * r) * r * r;
            let hxx = s * kt + 2.0 * x * dt.x * dd.x + y * dd.x * dd.x;
            let hxy = x * (dt.x * dd.y + dt.y * dd.x) + y * dd.x * dd.y;
            let hyy = s * kt + 2.0 * x * dt.y * dd.y + y * dd.y * dd.y;
            // Of the power of F.
            let w = f.powi(weights.power - 2);
            let (n, m) = (f64::from(weights.power) * w, f64::from(weights.power - 1));
            out.value += w * f * f;
            out.gradient += (n * f) * df;
            out.hessian[0] += n * (f * hxx + m * df.x * df.x);
            out.hessian[1] += n * (f * hxy + m * df.x * df.y);
            out.hessian[2] += n * (f * hyy + m * df.y * df.y);
            out.min_d = out.min_d.min(d);
        }
    }
    out
}

/// Energy of the corners around `v`, were it at `at`, and their smallest scaled Jacobian, squared with its
/// sign. The energy is infinite if a corner is not positive.
#[inline]
pub(crate) fn trial(region: &Region, v: u32, at: Point2, weights: Weights) -> (f64, f64) {
    let lambda = weights.lambda;
    let (mut value, mut worst) = (0.0, f64::INFINITY);
    let mut positive = true;
    for &h in region.star(v) {
        for (c, _, _) in corners_at(region, at, h) {
            let d = c.d();
            positive &= d > 0.0;
            let (l1, l2) = (c.e1.length_squared(), c.e2.length_squared());
            let f = (0.5 * (1.0 - lambda) * c.t() + 0.5 * lambda * (d * d + 1.0)) / d;
            value += f.powi(weights.power);
            let s = d * d.abs() / (l1 * l2);
            worst = if s < worst { s } else { worst };
        }
    }
    (if positive { value } else { f64::INFINITY }, worst)
}

/// Smallest scaled Jacobian of the corners around `v`, were it at `at`, squared with its sign; -1 where an
/// edge has no length.
#[inline]
pub(crate) fn worst_corner(region: &Region, v: u32, at: Point2) -> f64 {
    let mut worst = f64::INFINITY;
    for &h in region.star(v) {
        for (c, _, _) in corners_at(region, at, h) {
            let d = c.d();
            let l = c.e1.length_squared() * c.e2.length_squared();
            worst = worst.min(if l > 0.0 { d * d.abs() / l } else { -1.0 });
        }
    }
    worst
}

/// Regularised energy of all corners of the region with the free vertices at `x`, sum of F (not squared), its
/// gradient by the free vertices into `gradient`, and the smallest D.
pub(crate) fn regularised(
    region: &Region,
    x: &[Point2],
    lambda: f64,
    eps: f64,
    gradient: &mut [Point2],
) -> (f64, f64) {
    gradient.fill(Point2::ZERO);
    let (mut value, mut min_d) = (0.0, f64::INFINITY);
    let at = |v: u32| x.get(v as usize).copied().unwrap_or_else(|| region.points[v as usize]);
    for (vs, inverse) in region.quads.iter().zip(&region.inverse) {
        let p = vs.map(at);
        for k in 0..4 {
            let (m, l) = (inverse[k & 1], inverse[(k + 1) & 1]);
            let (n, b) = ((k + 1) & 3, (k + 3) & 3);
            let target = region.angle[vs[k] as usize];
            let c = Corner { e1: m * (p[n] - p[k]), e2: l * (p[b] - p[k]), target };
            let (d, t) = (c.d(), c.t());
            let root = (d * d + eps * eps).sqrt();
            // The second form has no cancellation for D < 0.
            let chi = if d >= 0.0 { 0.5 * (d + root) } else { 0.5 * eps * eps / (root - d) };
            let dchi = if root > 0.0 { 0.5 + 0.5 * d / root } else { 0.5 };
            let size = d * d + 1.0;
            value += 0.5 * ((1.0 - lambda) * t + lambda * size) / chi;
            let ft = 0.5 * (1.0 - lambda) / chi;
            let fd = -0.5 * ((1.0 - lambda) * t + lambda * size) * dchi / (chi * chi) + lambda * d / chi;
            let [cos, csc] = target;
            let d1 = m * ((ft * 2.0 * csc) * (c.e1 - cos * c.e2) + fd * Point2::new(c.e2.y, -c.e2.x));
            let d2 = l * ((ft * 2.0 * csc) * (c.e2 - cos * c.e1) + fd * Point2::new(-c.e1.y, c.e1.x));
            for (v, g) in [(vs[n], d1), (vs[b], d2), (vs[k], -d1 - d2)] {
                if let Some(s) = gradient.get_mut(v as usize) {
                    *s += g;
                }
            }
            min_d = min_d.min(d);
        }
    }
    (value, min_d)
}
