//! What a mesh has to meet: limits of metrics, element by element.

use csalf_mesh::quality::metrics::NAMES;
use serde_json::{Value, json};

/// A limit of a metric: `METRIC>=X` or `METRIC<=X`.
#[derive(Clone, Debug, PartialEq)]
pub struct Requirement {
    /// One of [`NAMES`].
    pub metric: String,
    /// The limit is a lower one.
    pub at_least: bool,
    /// The limit itself; it is allowed.
    pub limit: f64,
}

/// How far a requirement is met.
#[derive(Clone, Debug)]
pub struct Met<'a> {
    /// Which.
    pub requirement: &'a Requirement,
    /// Elements that do not meet it.
    pub n_failed: usize,
    /// The worst of all elements and its value; `None` where the metric has no value.
    pub worst: Option<(usize, f64)>,
}

impl Requirement {
    /// Reads `METRIC>=X` or `METRIC<=X`.
    ///
    /// # Errors
    /// Words for the user.
    pub fn parse(text: &str) -> Result<Self, String> {
        let wrong = || format!("expected METRIC>=X or METRIC<=X, with METRIC one of {}", NAMES.join(", "));
        let (metric, at_least, limit) = match (text.split_once(">="), text.split_once("<=")) {
            (Some((m, x)), None) => (m, true, x),
            (None, Some((m, x))) => (m, false, x),
            _ => return Err(wrong()),
        };
        let (metric, limit) = (metric.trim(), limit.trim().parse::<f64>().map_err(|_| wrong())?);
        // A size ratio needs a size field, which files do not have.
        if !NAMES.contains(&metric) || metric == "size_ratio" || limit.is_nan() {
            return Err(wrong());
        }
        Ok(Self { metric: metric.into(), at_least, limit })
    }

    /// Holds it against the values of its metric. Elements without a value (NaN: triangles have no skew) meet it.
    pub fn hold(&self, values: &[f64]) -> Met<'_> {
        let worse = |a: f64, b: f64| if self.at_least { a < b } else { a > b };
        let known = || values.iter().copied().enumerate().filter(|v| !v.1.is_nan());
        let worst = known().reduce(|a, b| if worse(b.1, a.1) { b } else { a });
        Met { requirement: self, n_failed: known().filter(|v| worse(v.1, self.limit)).count(), worst }
    }
}

impl std::fmt::Display for Requirement {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}{}{}", self.metric, if self.at_least { ">=" } else { "<=" }, self.limit)
    }
}

impl Met<'_> {
    /// As an entry of the JSON output.
    pub fn entry(&self) -> Value {
        json!({
            "requirement": self.requirement.to_string(),
            "n_failed": self.n_failed,
            "worst": self.worst.map(|w| w.1),
            "element": self.worst.map(|w| w.0),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_read_and_held() {
        let r = Requirement::parse("min_angle >= 30").unwrap();
        assert_eq!(r, Requirement { metric: "min_angle".into(), at_least: true, limit: 30.0 });
        let met = r.hold(&[45.0, f64::NAN, 20.0, 30.0, 10.0]);
        assert_eq!((met.n_failed, met.worst), (2, Some((4, 10.0))));
        let r = Requirement::parse("edge_ratio<=5").unwrap();
        assert_eq!(r.hold(&[1.0, 5.0, f64::INFINITY]).worst, Some((2, f64::INFINITY)));
        assert_eq!(r.hold(&[f64::NAN]).worst, None);
        for wrong in
            ["min_angle", "min_angle>30", "beauty>=1", "skew<=x", "skew<=NaN", "size_ratio<=2", "a>=1<=2"]
        {
            assert!(Requirement::parse(wrong).is_err(), "{wrong}");
        }
    }
}
