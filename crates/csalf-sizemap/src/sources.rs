//! Spots of smaller size on top of another field, in closed form.
//!
//! ```text
//!   h │ far ───────╮           ╭─────        h(p) = min( base(p), for every source at distance d:
//!     │             ╲         ╱                       h + clamp((d - radius) / falloff, 0, 1) (far - h) )
//!   h_i              ╲_______╱
//!     └──────────────────┼──────── d         a source larger than the base field has no effect
//!                      xy  radius falloff
//! ```
//!
//! Source: the formula of the public cases, and handbook 8.3. Limiting the gradient of such a field to g is closed,
//! too: the largest field below it with slopes <= g is the minimum of the spots, each with
//! falloff >= (far - h) / g (handbook 8.2 applied to one cone at a time).

use crate::error::check_size;
use crate::{Hint, SizeError, SizeField, Source};
use csalf_geom::Point2;
use rstar::RTree;
use rstar::primitives::{GeomWithData, Rectangle};
use std::sync::Arc;

/// From this many sources on they are found by an R-tree of their boxes, not one after the other.
const INDEX_FROM: usize = 12;

/// Longest falloff, in model units: keeps sums finite; no length of a real domain.
const LONGEST: f64 = 1e150;

/// What lies under the spots.
#[derive(Debug)]
enum Base {
    /// The far size.
    Far,
    /// Another field, which is nowhere larger than the far size.
    Field(Arc<dyn SizeField>),
}

/// The minimum of a base field and of spots.
#[derive(Debug)]
pub struct Sources {
    base: Base,
    far: f64,
    /// Spots with h < far.
    spots: Vec<Source>,
    index: Option<RTree<GeomWithData<Rectangle<[f64; 2]>, u32>>>,
    range: (f64, f64),
}

impl Sources {
    /// The field of the public cases: `far` and all sources; with `gradation` the largest field below it whose
    /// gradient is at most that.
    ///
    /// # Errors
    /// [`SizeError`] of a bad size, point, radius or falloff.
    pub fn new(far: f64, sources: &[Source], gradation: Option<f64>) -> Result<Self, SizeError> {
        check_size("far size", 0, far)?;
        Self::assemble(Base::Far, far, (far, far), sources, gradation)
    }

    /// `points` with a size each, as spots on `base`: h(p) = min(base(p), h_i + g |p - x_i|).
    ///
    /// # Errors
    /// [`SizeError`] of a bad size or point.
    pub fn hard_points(
        base: Arc<dyn SizeField>,
        points: &[(Point2, f64)],
        g: f64,
    ) -> Result<Self, SizeError> {
        let (_, far) = base.range();
        for (i, &(xy, h)) in points.iter().enumerate() {
            check_size("hard point", i, h)?;
            if !xy.is_finite() {
                return Err(SizeError::BadPoint { what: "hard point", index: i });
            }
        }
        let small = points.iter().filter(|p| p.1 < far);
        let spots: Vec<_> = small
            .map(|&(xy, h)| Source {
                xy,
                h,
                radius: 0.0,
                falloff: ((far - h) / g).clamp(f64::MIN_POSITIVE, LONGEST),
            })
            .collect();
        let range = base.range();
        let base = if base.constant().is_some() { Base::Far } else { Base::Field(base) };
        Self::assemble(base, far, range, &spots, None)
    }

    fn assemble(
        base: Base,
        far: f64,
        mut range: (f64, f64),
        sources: &[Source],
        gradation: Option<f64>,
    ) -> Result<Self, SizeError> {
        let mut spots = Vec::with_capacity(sources.len());
        for (i, s) in sources.iter().enumerate() {
            check_size("source", i, s.h)?;
            if !s.xy.is_finite() {
                return Err(SizeError::BadPoint { what: "source", index: i });
            }
            if s.radius < 0.0 || !s.radius.is_finite() {
                return Err(SizeError::BadSource { index: i, what: "radius", value: s.radius });
            }
            if s.falloff <= 0.0 || !s.falloff.is_finite() {
                return Err(SizeError::BadSource { index: i, what: "falloff", value: s.falloff });
            }
            if s.h < far {
                let least = gradation.map_or(0.0, |g| (far - s.h) / g).min(LONGEST);
                spots.push(Source { falloff: s.falloff.max(least), ..*s });
                range.0 = range.0.min(s.h);
            }
        }
        let index = (spots.len() >= INDEX_FROM).then(|| {
            let boxes = spots.iter().enumerate().map(|(i, s)| {
                // A little more than the reach, for rounding: a larger box changes no result.
                let r = Point2::splat(((s.radius + s.falloff) * (1.0 + 4.0 * f64::EPSILON)).min(LONGEST));
                let (lo, hi) = ((s.xy - r).to_array(), (s.xy + r).to_array());
                GeomWithData::new(Rectangle::from_corners(lo, hi), i as u32)
            });
            RTree::bulk_load(boxes.collect())
        });
        Ok(Self { base, far, spots, index, range })
    }

    #[inline]
    fn spot(&self, s: &Source, p: Point2) -> f64 {
        let w = ((p.distance(s.xy) - s.radius) / s.falloff).clamp(0.0, 1.0);
        s.h + w * (self.far - s.h)
    }
}

impl SizeField for Sources {
    fn h(&self, p: Point2, hint: &mut Hint) -> f64 {
        let base = match &self.base {
            Base::Far => self.far,
            Base::Field(f) => f.h(p, hint),
        };
        if !p.is_finite() {
            return base;
        }
        match &self.index {
            None => self.spots.iter().fold(base, |h, s| h.min(self.spot(s, p))),
            Some(tree) => tree
                .locate_all_at_point(p.to_array())
                .fold(base, |h, s| h.min(self.spot(&self.spots[s.data as usize], p))),
        }
    }

    fn constant(&self) -> Option<f64> {
        (matches!(self.base, Base::Far) && self.spots.is_empty()).then_some(self.far)
    }

    fn range(&self) -> (f64, f64) {
        self.range
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(n: usize) -> impl Iterator<Item = Point2> {
        (0..n * n).map(move |k| Point2::new((k % n) as f64, (k / n) as f64) * (10.0 / n as f64))
    }

    fn many(n: usize) -> Vec<Source> {
        (0..n)
            .map(|i| {
                let t = i as f64;
                let xy = Point2::new((t * 3.7) % 10.0, (t * 2.3) % 10.0);
                Source {
                    xy,
                    h: 0.05 + 0.01 * (t % 7.0),
                    radius: 0.1 * (t % 3.0),
                    falloff: 0.5 + 0.1 * (t % 5.0),
                }
            })
            .collect()
    }

    #[test]
    fn the_formula() {
        let s = Source { xy: Point2::ZERO, h: 1.0, radius: 2.0, falloff: 4.0 };
        let f = Sources::new(3.0, &[s], None).unwrap();
        let h = |x: f64| f.h(Point2::new(x, 0.0), &mut Hint::default());
        assert_eq!([h(0.0), h(2.0), h(4.0), h(6.0), h(60.0)], [1.0, 1.0, 2.0, 3.0, 3.0]);
        assert_eq!(f.range(), (1.0, 3.0));
    }

    #[test]
    fn the_index_changes_nothing() {
        let all = many(200);
        let f = Sources::new(1.0, &all, None).unwrap();
        assert!(f.index.is_some());
        for p in grid(60) {
            let plain = all.iter().fold(1.0f64, |h, s| h.min(f.spot(s, p)));
            assert_eq!(f.h(p, &mut Hint::default()).to_bits(), plain.to_bits());
        }
    }

    #[test]
    fn the_limit_holds_and_never_enlarges() {
        let all = many(30);
        let (f, g) = (Sources::new(1.0, &all, None).unwrap(), Sources::new(1.0, &all, Some(0.2)).unwrap());
        let at = |f: &Sources, p| f.h(p, &mut Hint::default());
        let step = Point2::new(0.03, -0.02);
        let mut smaller = 0;
        for p in grid(50) {
            assert!(at(&g, p) <= at(&f, p));
            smaller += usize::from(at(&g, p) < at(&f, p));
            assert!((at(&g, p + step) - at(&g, p)).abs() <= 0.2 * step.length() * (1.0 + 1e-9));
        }
        assert!(smaller > 0);
    }

    #[test]
    fn bad_sources_are_named() {
        let s = Source { xy: Point2::ZERO, h: 1.0, radius: 2.0, falloff: 4.0 };
        let err = |s| Sources::new(3.0, &[s], None).unwrap_err();
        assert!(matches!(err(Source { h: 0.0, ..s }), SizeError::NotPositive { index: 0, .. }));
        assert!(matches!(err(Source { h: f64::NAN, ..s }), SizeError::NotFinite { .. }));
        assert!(matches!(err(Source { radius: -1.0, ..s }), SizeError::BadSource { what: "radius", .. }));
        assert!(matches!(err(Source { falloff: 0.0, ..s }), SizeError::BadSource { what: "falloff", .. }));
        assert!(matches!(err(Source { xy: Point2::NAN, ..s }), SizeError::BadPoint { .. }));
    }
}
