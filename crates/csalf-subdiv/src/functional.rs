//! The functional Φ that ranks split lines (paper eqs. 7-9).
//!
//! ```text
//!            k
//!        φ3 /| φ4        Φ = A1 L + A2 φ + A3 ε (+ terms of the handbook)
//!          / |           L  length over the diagonal of the contour's bounding box
//!   C_L   /  |  C_R      φ  deviation of the four split angles, over 2π
//!        /   |           ε  error of the node count
//!    φ1 /| φ2
//!      j
//! ```

use std::f64::consts::{FRAC_PI_2, TAU};

/// Weights of the functional.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// A1: length.
    pub length: f64,
    /// A2: angles.
    pub angle: f64,
    /// A3: node count error.
    pub count: f64,
    /// Balance |N - 2 (k - j)| / N: keeps the recursion O(log n) deep.
    pub balance: f64,
    /// Topological charge left in the children.
    pub charge: f64,
    /// Share of an angle that is compared with the nearest multiple of 90 degrees (true) or with 90 (the paper).
    pub multiples: bool,
}

impl Weights {
    /// Handbook 4.6.
    pub const QUALITY: Self =
        Self { length: 0.17, angle: 0.52, count: 0.10, balance: 0.14, charge: 0.20, multiples: true };
    /// The paper's three terms; its constants are not given, these are Talbert and Parkinson's (handbook 4.5).
    pub const PAPER: Self =
        Self { length: 0.3, angle: 0.5, count: 0.2, balance: 0.0, charge: 0.0, multiples: false };
}

/// Deviation of an angle from the nearest positive multiple of 90 degrees, radians; below 90 the plain deficit.
/// (Handbook 1.7: the paper's |φ - π/2| punishes the ideal remainder of 180 degrees.)
#[inline]
pub fn angle_deviation(a: f64) -> f64 {
    // Rounding by truncation: `f64::round` is a call on baseline processors.
    if a < FRAC_PI_2 { FRAC_PI_2 - a } else { (a - FRAC_PI_2 * ((a / FRAC_PI_2 + 0.5) as i32 as f64)).abs() }
}

/// φ of eq. (9): four split angles in radians; 0 is ideal, clipped to 1.5.
#[inline]
pub fn angle_term(angles: [f64; 4], multiples: bool) -> f64 {
    let dev = |a: f64| if multiples { angle_deviation(a) } else { (a - FRAC_PI_2).abs() };
    (angles.iter().map(|&a| dev(a)).sum::<f64>() / TAU).min(1.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_angles_and_straight_remainders_are_ideal() {
        let r = FRAC_PI_2;
        assert_eq!(angle_term([r, r, r, r], false), 0.0);
        assert_eq!(angle_term([r, 2.0 * r, r, r], true), 0.0);
        assert!((angle_term([r, 2.0 * r, r, r], false) - 0.25).abs() < 1e-15);
        assert!((angle_term([r / 2.0; 4], true) - 0.5).abs() < 1e-15);
    }
}
