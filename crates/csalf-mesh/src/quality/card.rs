//! What every metric says of itself, in the form of the Verdict manual.

/// Description of one quad metric. Ranges are `(low, high)`, inclusive.
///
/// Source: C. Stimpson et al., *The Verdict Geometric Quality Library*, SAND2007-1751 (2007), whose cards
/// these follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Card {
    /// Name of the metric.
    pub name: &'static str,
    /// Dimension: `1` (a ratio), `degrees`, `length`, `length^2`.
    pub dimension: &'static str,
    /// Values that a good mesh shows.
    pub acceptable: (f64, f64),
    /// Values of quads that are not degenerate.
    pub normal: (f64, f64),
    /// Values that may occur at all.
    pub full: (f64, f64),
    /// Value of the unit square.
    pub unit_square: f64,
    /// Where the definition comes from.
    pub source: &'static str,
}
