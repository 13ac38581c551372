//! Four numbers at a time, in plain Rust: the compiler makes vector instructions of it.

use std::array::from_fn;
use std::ops::{Add, Mul, Sub};

/// Four numbers, of which the kernels use one per corner of a quad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lanes(pub(crate) [f64; 4]);

impl Lanes {
    #[inline(always)]
    pub(crate) fn splat(x: f64) -> Self {
        Self([x; 4])
    }
    #[inline(always)]
    pub(crate) fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self(from_fn(|i| f(self.0[i])))
    }
    #[inline(always)]
    pub(crate) fn zip(self, o: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(from_fn(|i| f(self.0[i], o.0[i])))
    }
    #[inline(always)]
    pub(crate) fn recip(self) -> Self {
        self.map(|x| 1.0 / x)
    }
    /// The smaller of each pair; of a NaN in `self` the other.
    #[inline(always)]
    pub(crate) fn min(self, o: Self) -> Self {
        self.zip(o, |a, b| if a < b { a } else { b })
    }
    /// The larger of each pair; of a NaN in `self` the other.
    #[inline(always)]
    pub(crate) fn max(self, o: Self) -> Self {
        self.zip(o, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    pub(crate) fn largest(self) -> f64 {
        let [a, b, c, d] = self.0;
        let max = |x: f64, y: f64| if x > y { x } else { y };
        max(max(a, c), max(b, d))
    }
    #[inline(always)]
    pub(crate) fn sum(self) -> f64 {
        let [a, b, c, d] = self.0;
        (a + c) + (b + d)
    }
    #[inline(always)]
    pub(crate) fn least(self) -> f64 {
        let [a, b, c, d] = self.0;
        let min = |x: f64, y: f64| if x < y { x } else { y };
        min(min(a, c), min(b, d))
    }
}

impl Add for Lanes {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        self.zip(o, |a, b| a + b)
    }
}

impl Sub for Lanes {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        self.zip(o, |a, b| a - b)
    }
}

impl Mul for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        self.zip(o, |a, b| a * b)
    }
}

impl Mul<Lanes> for f64 {
    type Output = Lanes;
    #[inline(always)]
    fn mul(self, o: Lanes) -> Lanes {
        o.map(|x| self * x)
    }
}
