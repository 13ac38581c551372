//! The trait that all size fields obey.

use csalf_geom::Point2;

/// Remembers where the last query ended (the owner triangle), so that the next one nearby is cheap. A hint never
/// changes a result. One hint serves one field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Hint {
    /// The owner.
    pub(crate) owner: u32,
    /// The owner in the second mesh of a field that asks two.
    pub(crate) second: u32,
}

impl Hint {
    /// What `query` gives for the second mesh of a field.
    pub(crate) fn second<R>(&mut self, query: impl FnOnce(&mut Self) -> R) -> R {
        let mut hint = Self { owner: self.second, second: 0 };
        let found = query(&mut hint);
        self.second = hint.owner;
        found
    }
}

/// The wanted edge length h over the plane (the paper's grading g, eq. 18).
///
/// Implementations are pure: the same point gives the same bits, whatever was asked before.
pub trait SizeField: Send + Sync + std::fmt::Debug {
    /// Wanted edge length at `p`, in model units: finite and > 0 everywhere, also outside the domain.
    fn h(&self, p: Point2, hint: &mut Hint) -> f64;

    /// The value, if the field is the same everywhere: lets a mesher skip sampling.
    fn constant(&self) -> Option<f64> {
        None
    }

    /// Smallest and largest value that the field takes.
    fn range(&self) -> (f64, f64);
}

/// What points to a field is that field: references, `Arc`.
impl<P> SizeField for P
where
    P: std::ops::Deref<Target: SizeField> + Send + Sync + std::fmt::Debug,
{
    fn h(&self, p: Point2, hint: &mut Hint) -> f64 {
        (**self).h(p, hint)
    }

    fn constant(&self) -> Option<f64> {
        (**self).constant()
    }

    fn range(&self) -> (f64, f64) {
        (**self).range()
    }
}
