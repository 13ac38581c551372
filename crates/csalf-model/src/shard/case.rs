//! The flat boundary of a failed face in a shard: loops and points are all that such a job has.

use csalf_core::Job;
use csalf_geom::{Domain, HardPoint, Loop, LoopKind, Point2};
use csalf_sizemap::SizeSpec;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Name; about; loops with name, hole or not, and nodes; points with name and place.
type Stored = (String, String, Vec<(String, bool, Vec<Point2>)>, Vec<(String, Point2)>);

pub(crate) fn serialize<S: Serializer>(case: &Option<Job>, to: S) -> Result<S::Ok, S::Error> {
    let stored: Option<Stored> = case.as_ref().map(|job| {
        let d = &job.domain;
        let loops = d.loops.iter().map(|l| (l.name.clone(), l.kind == LoopKind::Hole, l.nodes.clone()));
        let points = d.points.iter().map(|p| (p.name.clone(), p.xy));
        (job.name.clone(), job.about.clone(), loops.collect(), points.collect())
    });
    stored.serialize(to)
}

pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Job>, D::Error> {
    let stored = Option::<Stored>::deserialize(from)?;
    Ok(stored.map(|(name, about, loops, points)| {
        let loops = loops.into_iter().map(|(name, hole, nodes)| {
            let kind = if hole { LoopKind::Hole } else { LoopKind::Outer };
            Loop { kind, name, nodes }
        });
        let points = points.into_iter().map(|(name, xy)| HardPoint { name, xy, size: None });
        let domain = Domain { loops: loops.collect(), points: points.collect(), ..Domain::default() };
        Job { name, about, domain, size: SizeSpec::Boundary, ..Job::default() }
    }))
}
