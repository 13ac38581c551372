//! The flat boundary of a face as a job of the planar mesher: to reproduce a failure, or to mesh in the chart.

use super::open::{ChartNode, Opened};
use crate::brep::Face;
use csalf_core::Job;
use csalf_geom::{Domain, HardPoint, Loop, LoopKind};
use csalf_sizemap::SizeSpec;
use glam::DVec2;

/// The chart's polygons as a job; loops are `l0`, `l1`, ..., points `p0`, ...
pub(super) fn job_of(opened: &Opened<'_>) -> Job {
    let area = |l: &[ChartNode]| {
        let q: Vec<DVec2> = l.iter().map(|n| n.q).collect();
        csalf_geom::polygon::signed_area(&q).abs()
    };
    let areas: Vec<f64> = opened.loops.iter().map(|l| area(&l.1)).collect();
    let outer = (0..areas.len()).max_by(|a, b| areas[*a].total_cmp(&areas[*b]).then(b.cmp(a)));
    let loops = opened.loops.iter().enumerate().map(|(k, (_, nodes))| Loop {
        kind: if Some(k) == outer { LoopKind::Outer } else { LoopKind::Hole },
        name: format!("l{k}"),
        nodes: nodes.iter().map(|n| n.q).collect(),
    });
    let points = opened.points.iter().enumerate().map(|(k, n)| HardPoint {
        name: format!("p{k}"),
        xy: n.q,
        size: None,
    });
    let domain = Domain { loops: loops.collect(), points: points.collect(), ..Domain::default() };
    Job { domain, size: SizeSpec::Boundary, ..Job::default() }
}

/// The same, named after its face.
pub(super) fn of_chart(face: &Face, opened: &Opened<'_>) -> Job {
    let about = "flat boundary of a face that was not meshed".to_owned();
    Job { name: face.name.clone(), about, ..job_of(opened) }
}
