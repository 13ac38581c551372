//! The pipeline: data flows one way.
//!
//! ```text
//!   Job ─check─▶ Arrangement ─┬─ regions ─layers─▶ rings + fronts ─bridge─▶ one contour per region
//!                             └─ loops ──size────▶ SizeField                      │ triad (parallel)
//!   Meshed ◀─certify─ smooth ◀──collect── quads of rings and patches ◀────────────┘
//! ```

use crate::triad::{Filled, Triad};
use crate::{Job, MeshError, MeshReport, Meshed, Method, Options};
use csalf_clean::smooth::SmoothOptions;
use csalf_geom::arrangement::{Arrangement, CheckOptions};
use csalf_geom::{Point2, VertexId};
use csalf_mesh::{NamedSets, NodeFlags, QuadMesh, QuadTopology, RegionMesher};
use csalf_sizemap::{Extras, SizeField};
use csalf_subdiv::fallback::Fallback;
use csalf_subdiv::{SplitRules, Subdivision, Walks, bridge};
use csalf_tfi::{TfiRules, Transfinite};
use rayon::prelude::*;
use std::sync::Arc;
use std::time::Instant;

/// Measures the stages of one run.
struct Stopwatch {
    start: Instant,
    last: Instant,
    stages: Vec<(&'static str, f64)>,
}

impl Stopwatch {
    fn new() -> Self {
        let now = Instant::now();
        Self { start: now, last: now, stages: Vec::new() }
    }
    fn lap(&mut self, stage: &'static str) {
        let now = Instant::now();
        self.stages.push((stage, (now - self.last).as_secs_f64()));
        tracing::info!(stage, seconds = (now - self.last).as_secs_f64(), "done");
        self.last = now;
    }
}

pub(crate) fn run(job: &Job, options: &Options) -> Result<Meshed, MeshError> {
    match options.threads {
        0 => run_here(job, options),
        n => rayon::ThreadPoolBuilder::new()
            .num_threads(n)
            .build()
            .map_err(|e| MeshError::Internal { stage: "threads", detail: e.to_string() })?
            .install(|| run_here(job, options)),
    }
}

fn run_here(job: &Job, options: &Options) -> Result<Meshed, MeshError> {
    let mut watch = Stopwatch::new();
    let mut report = MeshReport::default();

    let check = CheckOptions { repair_parity: options.repair_parity, allow_odd: options.allow_triangles };
    let arrangement = Arrangement::new(&job.domain, &check).map_err(MeshError::Invalid)?;
    watch.lap("check");

    let size = size_field(job, options, &arrangement)?;
    watch.lap("size");

    let members = members(options);
    let points = arrangement.points.clone();
    let flags = vec![NodeFlags::GEOMETRY; points.len()];
    let triad = Triad::new(&members, size.as_ref(), arrangement.tolerance, points.len() as u32);
    let trees: Vec<Vec<Filled>> = arrangement
        .regions
        .par_iter()
        .map(|region| {
            let mut walks = vec![region.outer.clone()];
            walks.extend(region.inner.iter().cloned());
            fill_region(&triad, &walks, &points, &flags, size.as_ref())
        })
        .collect::<Result<_, MeshError>>()?;
    report.members = triad.tally();
    watch.lap("fill");

    let trees: Vec<Filled> = trees.into_iter().flatten().collect();
    let mut mesh = QuadMesh { points, ..QuadMesh::default() };
    mesh.quads = Filled::collect(&trees, &mut mesh.points, triad.id_bound());
    drop(trees);
    watch.lap("collect");

    let topology = QuadTopology::new(mesh.points.len(), &mesh.quads);
    watch.lap("topology");
    let mut fixed = vec![false; mesh.points.len()];
    fixed[..arrangement.points.len()].fill(true);
    csalf_clean::smooth::finish(&mut mesh, &topology, &fixed, size.as_ref(), &SmoothOptions::default());
    watch.lap("smooth");

    report.timing.stages = watch.stages;
    report.timing.wall_s = watch.start.elapsed().as_secs_f64();
    Ok(Meshed { sets: sets(job, &arrangement), mesh, report })
}

fn size_field(
    job: &Job,
    options: &Options,
    arrangement: &Arrangement,
) -> Result<Arc<dyn SizeField>, MeshError> {
    let loops: Vec<Vec<Point2>> = arrangement
        .loops
        .iter()
        .map(|l| l.iter().map(|&v| arrangement.points[v as usize]).collect())
        .collect();
    let hard: Vec<(Point2, f64)> =
        job.domain.points.iter().filter_map(|p| p.size.map(|h| (p.xy, h))).collect();
    let extras = Extras { hard_points: &hard, gradation: options.gradation };
    Ok(csalf_sizemap::build(&job.size, &loops, &extras, arrangement.tolerance)?)
}

/// The members of the triad for a method, in the order in which they are asked.
fn members(options: &Options) -> Vec<Arc<dyn RegionMesher>> {
    let mut out: Vec<Arc<dyn RegionMesher>> = Vec::new();
    let subdivision = match options.method {
        Method::Tqm => Subdivision::new(SplitRules::QUALITY),
        Method::Paper => {
            let tfi: Arc<dyn RegionMesher> = Arc::new(Transfinite::new(TfiRules::paper()));
            out.push(tfi.clone());
            Subdivision::new(SplitRules::PAPER).with_companion(tfi)
        }
        Method::Csalf => {
            let tfi: Arc<dyn RegionMesher> = Arc::new(Transfinite::new(TfiRules::default()));
            out.push(tfi.clone());
            Subdivision::new(SplitRules::QUALITY).with_companion(tfi)
        }
    };
    out.push(Arc::new(subdivision));
    out.push(Arc::new(Fallback));
    out
}

/// Bridges the walks of one region and fills the contour.
fn fill_region(
    triad: &Triad<'_>,
    walks: &[Vec<u32>],
    points: &[Point2],
    flags: &[NodeFlags],
    size: &dyn SizeField,
) -> Result<Vec<Filled>, MeshError> {
    let internal = |stage, detail: String| MeshError::Internal { stage, detail };
    let mut bridged = bridge(Walks { walks, points, flags }, size, u32::MAX / 2)
        .map_err(|e| internal("bridge", e.to_string()))?;
    // The bridge nodes get their true ids now that their number is known.
    let first = triad.reserve(bridged.new_points.len());
    for id in &mut bridged.contour.ids {
        if *id >= u32::MAX / 2 {
            *id = *id - u32::MAX / 2 + first;
        }
    }
    let filled = triad.fill(&bridged.contour).map_err(|e| internal("triad", e.to_string()))?;
    Ok(vec![Filled::leaf(first, bridged.new_points, Vec::new()), filled])
}

/// Sets named after loops, scars and hard points.
fn sets(job: &Job, arrangement: &Arrangement) -> NamedSets {
    let ids = |list: &[u32]| list.iter().map(|&v| VertexId(v)).collect::<Vec<_>>();
    let mut out = NamedSets::default();
    for (l, nodes) in job.domain.loops.iter().zip(&arrangement.loops) {
        let v = ids(nodes);
        out.edges.push((l.name.clone(), (0..v.len()).map(|i| [v[i], v[(i + 1) % v.len()]]).collect()));
        out.nodes.push((l.name.clone(), v));
    }
    for (s, nodes) in job.domain.scars.iter().zip(&arrangement.scars) {
        let v = ids(nodes);
        out.edges.push((s.name.clone(), v.windows(2).map(|w| [w[0], w[1]]).collect()));
        out.nodes.push((s.name.clone(), v));
    }
    for (p, &v) in job.domain.points.iter().zip(&arrangement.hard_points) {
        out.nodes.push((p.name.clone(), vec![VertexId(v)]));
    }
    out
}
