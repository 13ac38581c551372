//! The pipeline: data flows one way.
//!
//! ```text
//!   Job ─check─▶ Arrangement ─┬─ regions ─layers─▶ rings + fronts ─bridge─▶ one contour per region
//!                             └─ loops ──size────▶ SizeField                      │ triad (parallel)
//!   Meshed ◀─certify─ smooth ◀──collect── quads of rings and patches ◀────────────┘
//! ```

use crate::attempts::{Attempt, by_attempts};
use crate::certify::certify;
use crate::cleaning::{CleanTask, clean};
use crate::clock;
use crate::region::{Curves, LayerRules, RegionResult, mesh_region};
use crate::triad::{FALLBACK, Filled, Triad};
use crate::{Job, MeshError, MeshReport, Meshed, Method, Options, Preset, Watch};
use csalf_geom::arrangement::{Arrangement, CheckOptions};
use csalf_geom::{Point2, QuadId, VertexId};
use csalf_mesh::{NamedSets, QuadMesh, QuadTopology, RegionMesher};
use csalf_pave::{LoopPaver, PavingRules};
use csalf_sizemap::{Extras, SizeField, SizeSpec};
use csalf_subdiv::fallback::Fallback;
use csalf_subdiv::{SplitRules, Subdivision};
use csalf_tfi::{TfiRules, Transfinite};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Measures the stages of one run and tells them to the caller.
struct Stopwatch<'a> {
    watch: &'a dyn Watch,
    /// Seconds of [`clock::now`].
    last: f64,
    current: &'static str,
    stages: Vec<(&'static str, f64)>,
}

impl<'a> Stopwatch<'a> {
    fn new(watch: &'a dyn Watch) -> Self {
        Self { watch, last: clock::now(), current: "", stages: Vec::new() }
    }

    /// Ends the stage that runs.
    fn end(&mut self) {
        let (stage, now) = (self.current, clock::now());
        if !stage.is_empty() {
            self.stages.push((stage, now - self.last));
            tracing::info!(stage, seconds = now - self.last, "done");
        }
        self.last = now;
    }

    /// Ends the stage that runs and begins `stage`, unless the caller has had enough.
    fn begin(&mut self, stage: &'static str) -> Result<(), MeshError> {
        self.end();
        if self.watch.cancelled() {
            return Err(MeshError::Cancelled);
        }
        self.current = stage;
        self.watch.stage(stage);
        Ok(())
    }
}

pub(crate) fn run(job: &Job, options: &Options, watch: &dyn Watch) -> Result<Meshed, MeshError> {
    match options.threads {
        0 => by_attempts(job, options, watch),
        n => rayon::ThreadPoolBuilder::new()
            .num_threads(n)
            .build()
            .map_err(|e| MeshError::Internal { stage: "threads", detail: e.to_string() })?
            .install(|| by_attempts(job, options, watch)),
    }
}

/// Meshes in one way.
pub(crate) fn mesh_once(job: &Job, attempt: &Attempt, watch: &dyn Watch) -> Result<Meshed, MeshError> {
    let options = &attempt.options;
    let mut stages = Stopwatch::new(watch);
    let mut report = MeshReport::default();

    stages.begin("check")?;
    let check = CheckOptions { repair_parity: options.repair_parity, allow_odd: options.allow_triangles };
    let arrangement = Arrangement::new(&job.domain, &check).map_err(MeshError::Invalid)?;

    stages.begin("size")?;
    let size = size_field(job, options, &arrangement)?;

    stages.begin("fill")?;
    let members = members(attempt);
    let triad = Triad::new(&members, arrangement.tolerance, arrangement.points.len() as u32).watched(watch);
    let curves = Curves::new(job, &arrangement);
    let layer_rules = layer_rules(options);
    let results: Vec<RegionResult> = arrangement
        .regions
        .par_iter()
        .map(|region| mesh_region(region, &arrangement, &curves, layer_rules, size.as_ref(), &triad))
        .collect::<Result<_, MeshError>>()?;

    stages.begin("collect")?;
    let mut sets = sets(job, &arrangement);
    let mut mesh = QuadMesh { points: arrangement.points.clone(), ..QuadMesh::default() };
    let mut fixed = vec![true; mesh.points.len()];
    let protected = collect(results, &triad, &curves, &mut mesh, &mut fixed, &mut sets, &mut report);

    stages.begin("clean")?;
    let topology = if attempt.clean {
        let made: Vec<usize> = sets.quads.iter().map(|s| s.1.len()).collect();
        let task = CleanTask { arrangement: &arrangement, size: size.as_ref(), options };
        let (topology, mended) = clean(&mut mesh, fixed, protected, &mut sets, &task);
        count_fallbacks(&mut report, mended.n_fallbacks);
        if mended.n_holes > 0 {
            layers_cut_into(&mut report, &made, &sets);
        }
        topology
    } else {
        QuadTopology::new(mesh.n_vertices(), &mesh.quads)
    };

    stages.begin("certify")?;
    certify(&mesh, &topology, &arrangement, !attempt.clean)?;
    stages.end();

    report.timing.stages = stages.stages;
    Ok(Meshed { sets, mesh, report })
}

/// Adds to the number of contours that the guaranteed fallback filled.
fn count_fallbacks(report: &mut MeshReport, n: usize) {
    report.members.iter_mut().filter(|m| m.0 == FALLBACK).for_each(|m| m.1 += n);
}

/// Lowers the number of layers that were made, where mending took quads of them. `made`: sizes of the quad sets before.
fn layers_cut_into(report: &mut MeshReport, made: &[usize], sets: &NamedSets) {
    for (_, (name, _)) in made.iter().zip(&sets.quads).filter(|(n, s)| **n > s.1.len()) {
        let Some((curve, Ok(layer))) = name.rsplit_once("_layer").map(|(c, l)| (c, l.parse::<usize>()))
        else {
            continue;
        };
        for l in report.loops.iter_mut().filter(|l| l.name == curve && l.made >= layer) {
            l.made = layer.saturating_sub(1);
            l.stopped = "cut into where quads had to be made convex".to_owned();
        }
    }
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
    let field = csalf_sizemap::build(&job.size, &loops, &extras, arrangement.tolerance)?;
    let scars: Vec<Vec<Point2>> = arrangement
        .scars
        .iter()
        .map(|s| s.iter().map(|&v| arrangement.points[v as usize]).collect())
        .collect();
    let field = csalf_sizemap::near_fine(field, &loops, &scars, options.gradation)?;
    // Sizes of the boundary itself suit it, unless fine parts of it lower them on others.
    match (&job.size, options.gradation) {
        (SizeSpec::Boundary, None) => Ok(field),
        _ => Ok(csalf_sizemap::near_coarse(field, &loops)?),
    }
}

/// The members of the triad for a method, in the order in which they are asked. Subdivision asks its companions before
/// every split, in the same order; the paper's order is transfinite interpolation, loop-paving, subdivision.
fn members(attempt: &Attempt) -> Vec<Arc<dyn RegionMesher>> {
    let options = &attempt.options;
    let (rules, companions): (SplitRules, Vec<Arc<dyn RegionMesher>>) = match (options.method, options.preset)
    {
        (Method::Tqm, _) => (SplitRules::QUALITY, Vec::new()),
        (Method::Paper, _) => {
            let tfi = Arc::new(Transfinite::new(TfiRules::paper()));
            (SplitRules::PAPER, vec![tfi, Arc::new(LoopPaver { rules: PavingRules::Paper })])
        }
        (Method::Csalf, Preset::Quality) => {
            let rules = SplitRules { variant: attempt.variant, ..SplitRules::QUALITY };
            (rules, vec![Arc::new(Transfinite::new(TfiRules::default()))])
        }
        (Method::Csalf, Preset::Fast) => {
            (SplitRules::FAST, vec![Arc::new(Transfinite::new(TfiRules::default()))])
        }
    };
    let mut out = companions.clone();
    let subdivision = companions.into_iter().fold(Subdivision::new(rules), Subdivision::with_companion);
    out.push(Arc::new(subdivision.behind_companions().loose(attempt.loose)));
    out.push(Arc::new(Fallback));
    out
}

/// Which layers a method makes; `None` for none at all.
fn layer_rules(options: &Options) -> Option<LayerRules> {
    match options.method {
        Method::Tqm => None,
        Method::Paper => Some(LayerRules { rules: PavingRules::Paper, defaults: true }),
        Method::Csalf => Some(LayerRules { rules: PavingRules::default(), defaults: true }),
    }
}

/// Numbers all points and quads in tree order; marks the nodes of asked layers as fixed; names the layers.
/// Returns per quad whether it is one of a layer.
fn collect(
    results: Vec<RegionResult>,
    triad: &Triad<'_>,
    curves: &Curves<'_>,
    mesh: &mut QuadMesh,
    fixed: &mut Vec<bool>,
    sets: &mut NamedSets,
    report: &mut MeshReport,
) -> Vec<bool> {
    let mut trees = Vec::new();
    let mut frozen = Vec::new();
    let mut triangles = Vec::new();
    let mut layers: BTreeMap<(u32, u32), Vec<QuadId>> = BTreeMap::new();
    let mut n_quads = 0;
    for r in results {
        for (q, &key) in r.quad_layer.iter().enumerate() {
            layers.entry(key).or_default().push(QuadId::new(n_quads + q));
        }
        n_quads += r.trees.iter().map(Filled::n_quads).sum::<usize>();
        report.loops.extend(r.loops);
        frozen.extend(r.frozen);
        triangles.extend(r.triangles);
        trees.extend(r.trees);
    }
    report.members = triad.tally(&trees);
    let (quads, number) = Filled::collect(&trees, &mut mesh.points, triad.id_bound());
    mesh.quads = quads;
    mesh.triangles = triangles.iter().map(|t| t.map(|v| VertexId(number[v as usize]))).collect();
    fixed.resize(mesh.points.len(), false);
    for v in frozen {
        fixed[number[v as usize] as usize] = true;
    }
    // Layers that were asked for stay; of those made by rule, the first.
    let mut protected = vec![false; mesh.quads.len()];
    for (&(_, layer), quads) in &layers {
        for q in quads {
            protected[q.index()] = layer == 0 || mesh.quads[q.index()].iter().all(|v| fixed[v.index()]);
        }
    }
    for ((curve, layer), quads) in layers {
        sets.quads.push((format!("{}_layer{}", curves.names[curve as usize], layer + 1), quads));
    }
    protected
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
