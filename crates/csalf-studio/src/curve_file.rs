//! Curves as JSON, between page and engine. Numbers survive bit for bit, but for weighted B-splines (last
//! digit).

use csalf_geom::Point2;
use csalf_geom::curve::nurbs::{CurveError, Nurbs};
use csalf_geom::curve::{Curve, spline::Spline};
use serde::{Deserialize, Serialize};

/// A [`Curve`] in a document: an object with the kind as its one key.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CurveFile {
    /// Straight segments.
    Polyline(Vec<[f64; 2]>),
    /// An arc of an ellipse, angles in radians.
    Arc {
        /// Centre.
        center: [f64; 2],
        /// Semi-axes.
        radii: [f64; 2],
        /// Angle of the first semi-axis.
        rotation: f64,
        /// Eccentric angle of the start.
        start: f64,
        /// Angle swept.
        sweep: f64,
    },
    /// A quadratic Bezier curve.
    Quadratic([[f64; 2]; 3]),
    /// A cubic Bezier curve.
    Cubic([[f64; 2]; 4]),
    /// A B-spline.
    Nurbs {
        /// Degree.
        degree: usize,
        /// Knots.
        knots: Vec<f64>,
        /// Control points.
        points: Vec<[f64; 2]>,
        /// Their weights.
        weights: Vec<f64>,
    },
    /// A cubic spline through points.
    Spline {
        /// The points.
        points: Vec<[f64; 2]>,
        /// From the last point back to the first.
        closed: bool,
    },
}

fn arrays(points: &[Point2]) -> Vec<[f64; 2]> {
    points.iter().map(|p| p.to_array()).collect()
}

fn points(arrays: Vec<[f64; 2]>) -> Vec<Point2> {
    arrays.into_iter().map(Point2::from_array).collect()
}

impl From<&Curve> for CurveFile {
    fn from(curve: &Curve) -> Self {
        match curve {
            Curve::Polyline(p) => Self::Polyline(arrays(p)),
            Curve::Arc { center, radii, rotation, start, sweep } => Self::Arc {
                center: center.to_array(),
                radii: radii.to_array(),
                rotation: *rotation,
                start: *start,
                sweep: *sweep,
            },
            Curve::Quadratic(p) => Self::Quadratic(p.map(|q| q.to_array())),
            Curve::Cubic(p) => Self::Cubic(p.map(|q| q.to_array())),
            Curve::Nurbs(n) => {
                let (points, weights) = n.controls().map(|(p, w)| (p.to_array(), w)).unzip();
                Self::Nurbs { degree: n.degree(), knots: n.knots().to_vec(), points, weights }
            }
            Curve::Spline(s) => Self::Spline { points: arrays(s.points()), closed: s.is_closed() },
        }
    }
}

impl TryFrom<CurveFile> for Curve {
    type Error = CurveError;

    fn try_from(file: CurveFile) -> Result<Self, CurveError> {
        Ok(match file {
            CurveFile::Polyline(p) => Self::Polyline(points(p)),
            CurveFile::Arc { center, radii, rotation, start, sweep } => Self::Arc {
                center: Point2::from_array(center),
                radii: Point2::from_array(radii),
                rotation,
                start,
                sweep,
            },
            CurveFile::Quadratic(p) => Self::Quadratic(p.map(Point2::from_array)),
            CurveFile::Cubic(p) => Self::Cubic(p.map(Point2::from_array)),
            CurveFile::Nurbs { degree, knots, points: p, weights } => {
                Self::Nurbs(Nurbs::new(degree, &knots, &points(p), &weights)?)
            }
            CurveFile::Spline { points: p, closed } => Self::Spline(Spline::new(&points(p), closed)?),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_comes_back_as_it_was() {
        let p = |x: f64, y: f64| Point2::new(x, y);
        let four = [p(0.1, 0.2), p(1.0, 0.3), p(1.7, 1.1), p(2.0, 2.0)];
        let knots = [0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0];
        for curve in [
            Curve::Polyline(four.to_vec()),
            Curve::circle(p(0.1, 0.2), 1.0 / 3.0),
            Curve::Quadratic([four[0], four[1], four[2]]),
            Curve::Cubic(four),
            Curve::Nurbs(Nurbs::new(2, &knots, &four, &[]).unwrap()),
            Curve::through(&four, false).unwrap(),
            Curve::through(&four, true).unwrap(),
        ] {
            let text = serde_json::to_string(&CurveFile::from(&curve)).unwrap();
            let file: CurveFile = serde_json::from_str(&text).unwrap();
            assert_eq!(Curve::try_from(file).unwrap(), curve, "{text}");
        }
    }

    #[test]
    fn wrong_curves_are_refused() {
        let bad = CurveFile::Nurbs { degree: 3, knots: vec![0.0], points: vec![[0.0; 2]], weights: vec![] };
        assert!(Curve::try_from(bad).is_err());
        assert!(Curve::try_from(CurveFile::Spline { points: vec![[0.0; 2]; 2], closed: false }).is_err());
    }
}
