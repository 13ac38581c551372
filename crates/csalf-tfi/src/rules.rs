//! When a patch is good enough.

/// Which patches are tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum TfiMode {
    /// The paper: convex contours of four corners with equal opposite counts and ESG <= 1.2.
    Paper,
    /// All patterns, accepted by predicted shape and size.
    #[default]
    Patterns,
}

/// Thresholds of acceptance. Defaults are those of handbook 5.6, but for the sizes: with 1.15 and 1.8 in place of 1.35
/// and 2.9 the edges follow the field as well as those of other meshers, at the same share of irregular vertices once the
/// mesh has been cleaned (measured on 25 domains: size share 0.95 in the mean; 1.2 has 0.005 to 0.01 less and saves a
/// tenth of the time).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TfiRules {
    /// Which patches are tried.
    pub mode: TfiMode,
    /// Smallest scaled Jacobian. Lower: fewer splits, worse worst quads. A sharp corner of the input lowers
    /// it to
    /// 0.9 of the sine of its angle.
    pub min_sj: f64,
    /// The same for contours of at most `small` nodes, which splitting hardly improves.
    pub min_sj_small: f64,
    /// See `min_sj_small`; nodes.
    pub small: usize,
    /// Smallest mean scaled Jacobian.
    pub mean_sj: f64,
    /// Largest geometric mean of max(r, 1/r), r = sqrt(area)/h.
    pub size_error: f64,
    /// Largest max(r, 1/r) of a cell.
    pub worst_size_error: f64,
    /// Largest extremum size gradient (handbook 1.11) in paper mode.
    pub esg: f64,
    /// Largest interior angle of the contour, degrees (180 to 270).
    pub reflex: f64,
    /// Most quads of one patch.
    pub most_quads: u64,
}

impl Default for TfiRules {
    fn default() -> Self {
        Self {
            mode: TfiMode::Patterns,
            min_sj: 0.5,
            min_sj_small: 0.35,
            small: 40,
            mean_sj: 0.85,
            size_error: 1.15,
            worst_size_error: 1.8,
            esg: 1.2,
            reflex: 225.0,
            most_quads: 4_000_000,
        }
    }
}

impl TfiRules {
    /// The paper's rule: convex, mappable, ESG <= 1.2; any positive quad is accepted.
    pub fn paper() -> Self {
        Self {
            mode: TfiMode::Paper,
            min_sj: 0.2,
            min_sj_small: 0.2,
            mean_sj: 0.2,
            size_error: 2.0,
            worst_size_error: 4.0,
            ..Self::default()
        }
    }

    /// Weaker thresholds, for contours where every split is worse.
    pub fn relaxed() -> Self {
        Self {
            min_sj: 0.25,
            min_sj_small: 0.2,
            mean_sj: 0.7,
            size_error: 1.7,
            worst_size_error: 4.5,
            reflex: 250.0,
            ..Self::default()
        }
    }

    /// Smallest scaled Jacobian accepted on a contour of `n` nodes whose sharpest corner is `sharpest`
    /// degrees.
    pub fn floor(&self, n: usize, sharpest: f64) -> f64 {
        let m = if n <= self.small { self.min_sj_small } else { self.min_sj };
        if sharpest < 90.0 { m.min(0.9 * sharpest.to_radians().sin()) } else { m }
    }
}
