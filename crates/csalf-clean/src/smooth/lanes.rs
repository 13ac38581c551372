//! Four numbers at a time. Every operation is that of IEEE 754 on each number, so the bits are the same on all machines.

use std::ops::{Add, Mul, Sub};
use wide::f64x4;

/// Four numbers, of which the kernels use one per corner of a quad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lanes(f64x4);

impl Lanes {
    #[inline(always)]
    pub(crate) fn new(x: [f64; 4]) -> Self {
        Self(f64x4::from(x))
    }
    #[inline(always)]
    pub(crate) fn splat(x: f64) -> Self {
        Self(f64x4::splat(x))
    }
    #[inline(always)]
    pub(crate) fn to_array(self) -> [f64; 4] {
        self.0.to_array()
    }
    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        Self(self.0.abs())
    }
    #[inline(always)]
    pub(crate) fn recip(self) -> Self {
        Self(f64x4::ONE / self.0)
    }
    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }
    /// `a` where the number is negative, else `b`.
    #[inline(always)]
    pub(crate) fn where_negative(self, a: Self, b: Self) -> Self {
        Self(self.0.simd_lt(f64x4::ZERO).select(a.0, b.0))
    }
    /// Each number to the power of `n`.
    pub(crate) fn powi(self, n: i32) -> Self {
        let [a, b, c, d] = self.to_array();
        Self::new([a.powi(n), b.powi(n), c.powi(n), d.powi(n)])
    }
    /// The smaller of each pair; of a NaN in `self` the other.
    #[inline(always)]
    pub(crate) fn min(self, o: Self) -> Self {
        Self(self.0.simd_lt(o.0).select(self.0, o.0))
    }
    /// The larger of each pair; of a NaN in `self` the other.
    #[inline(always)]
    pub(crate) fn max(self, o: Self) -> Self {
        Self(self.0.simd_gt(o.0).select(self.0, o.0))
    }
    #[inline(always)]
    pub(crate) fn largest(self) -> f64 {
        let [a, b, c, d] = self.to_array();
        let max = |x: f64, y: f64| if x > y { x } else { y };
        max(max(a, c), max(b, d))
    }
    #[inline(always)]
    pub(crate) fn sum(self) -> f64 {
        let [a, b, c, d] = self.to_array();
        (a + c) + (b + d)
    }
    #[inline(always)]
    pub(crate) fn least(self) -> f64 {
        let [a, b, c, d] = self.to_array();
        let min = |x: f64, y: f64| if x < y { x } else { y };
        min(min(a, c), min(b, d))
    }
}

impl Add for Lanes {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self(self.0 + o.0)
    }
}

impl Sub for Lanes {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self(self.0 - o.0)
    }
}

impl Mul for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self(self.0 * o.0)
    }
}

impl Mul<Lanes> for f64 {
    type Output = Lanes;
    #[inline(always)]
    fn mul(self, o: Lanes) -> Lanes {
        Lanes::splat(self) * o
    }
}
