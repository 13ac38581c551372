//! The pipeline: data flows one way.
//!
//! ```text
//!   Job ─check─▶ Arrangement ─┬─ regions ─layers─▶ rings + fronts ─bridge─▶ one contour per region
//!                             └─ loops ──size────▶ SizeField                      │ triad (parallel)
//!   Meshed ◀─certify─ smooth ◀──collect── quads of rings and patches ◀────────────┘
//! ```

use crate::cleaning::clean;
use crate::region::{Curves, LayerRules, RegionResult, mesh_region};
use crate::triad::{Filled, Triad};
use crate::{Job, MeshError, MeshReport, Meshed, Method, Options, Preset, Warning, Watch};
use csalf_geom::arrangement::{Arrangement, CheckOptions};
use csalf_geom::{Point2, QuadId, VertexId};
use csalf_mesh::validate;
use csalf_mesh::{NamedSets, QuadMesh, QuadTopology, RegionMesher};
use csalf_pave::{LoopPaver, PavingRules};
use csalf_sizemap::{Extras, SizeField};
use csalf_subdiv::fallback::Fallback;
use csalf_subdiv::{SplitRules, Subdivision};
use csalf_tfi::{TfiRules, Transfinite};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

/// Measures the stages of one run and tells them to the caller.
struct Stopwatch<'a> {
    watch: &'a dyn Watch,
    start: Instant,
    last: Instant,
    current: &'static str,
    stages: Vec<(&'static str, f64)>,
}

impl<'a> Stopwatch<'a> {
    fn new(watch: &'a dyn Watch) -> Self {
        let now = Instant::now();
        Self { watch, start: now, last: now, current: "", stages: Vec::new() }
    }

    /// Ends the stage that runs.
    fn end(&mut self) {
        let (stage, now) = (self.current, Instant::now());
        if !stage.is_empty() {
            self.stages.push((stage, (now - self.last).as_secs_f64()));
            tracing::info!(stage, seconds = (now - self.last).as_secs_f64(), "done");
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
        0 => run_here(job, options, watch),
        n => rayon::ThreadPoolBuilder::new()
            .num_threads(n)
            .build()
            .map_err(|e| MeshError::Internal { stage: "threads", detail: e.to_string() })?
            .install(|| run_here(job, options, watch)),
    }
}

/// Meshes with the options as given. If the certificate refuses the result (a defect of ours, on a domain at the limits
/// of floating-point numbers), again without cavities, then by subdivision alone; the report says so.
fn run_here(job: &Job, options: &Options, watch: &dyn Watch) -> Result<Meshed, MeshError> {
    let mut attempts = vec![options.clone()];
    if (options.method, options.preset) == (Method::Csalf, Preset::Quality) {
        attempts.push(Options { preset: Preset::Fast, ..options.clone() });
    }
    if options.method != Method::Tqm {
        attempts.push(Options { method: Method::Tqm, ..options.clone() });
    }
    let mut refused = Vec::new();
    for attempt in &attempts {
        match mesh_once(job, attempt, watch) {
            Err(_) if watch.cancelled() => return Err(MeshError::Cancelled),
            Err(e @ MeshError::Internal { .. }) => refused.push(e),
            Ok(mut meshed) => {
                let retried = |e: &MeshError| Warning::Retried { reason: e.to_string() };
                meshed.report.warnings.extend(refused.iter().map(retried));
                return Ok(meshed);
            }
            error => return error,
        }
    }
    Err(refused.swap_remove(0))
}

fn mesh_once(job: &Job, options: &Options, watch: &dyn Watch) -> Result<Meshed, MeshError> {
    let mut stages = Stopwatch::new(watch);
    let mut report = MeshReport::default();

    stages.begin("check")?;
    let check = CheckOptions { repair_parity: options.repair_parity, allow_odd: options.allow_triangles };
    let arrangement = Arrangement::new(&job.domain, &check).map_err(MeshError::Invalid)?;

    stages.begin("size")?;
    let size = size_field(job, options, &arrangement)?;

    stages.begin("fill")?;
    let members = members(options);
    let triad = Triad::new(&members, arrangement.tolerance, arrangement.points.len() as u32).watched(watch);
    let curves = Curves::new(job, &arrangement);
    let layer_rules = layer_rules(options);
    let results: Vec<RegionResult> = arrangement
        .regions
        .par_iter()
        .map(|region| mesh_region(region, &arrangement, &curves, layer_rules, size.as_ref(), &triad))
        .collect::<Result<_, MeshError>>()?;
    report.members = triad.tally();

    stages.begin("collect")?;
    let mut sets = sets(job, &arrangement);
    let mut mesh = QuadMesh { points: arrangement.points.clone(), ..QuadMesh::default() };
    let mut fixed = vec![true; mesh.points.len()];
    let protected = collect(results, &triad, &curves, &mut mesh, &mut fixed, &mut sets, &mut report);

    stages.begin("clean")?;
    let topology = clean(&mut mesh, fixed, protected, &mut sets, &arrangement, size.as_ref(), options);

    stages.begin("certify")?;
    certify(&mesh, &topology, &arrangement)?;
    stages.end();

    report.timing.wall_s = stages.start.elapsed().as_secs_f64();
    report.timing.stages = stages.stages;
    Ok(Meshed { sets, mesh, report })
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

/// The members of the triad for a method, in the order in which they are asked. Subdivision asks its companions before
/// every split, in the same order; the paper's order is transfinite interpolation, loop-paving, subdivision.
fn members(options: &Options) -> Vec<Arc<dyn RegionMesher>> {
    let (rules, companions): (SplitRules, Vec<Arc<dyn RegionMesher>>) = match (options.method, options.preset)
    {
        (Method::Tqm, _) => (SplitRules::QUALITY, Vec::new()),
        (Method::Paper, _) => {
            let tfi = Arc::new(Transfinite::new(TfiRules::paper()));
            (SplitRules::PAPER, vec![tfi, Arc::new(LoopPaver { rules: PavingRules::Paper })])
        }
        (Method::Csalf, Preset::Quality) => {
            (SplitRules::QUALITY, vec![Arc::new(Transfinite::new(TfiRules::default()))])
        }
        (Method::Csalf, Preset::Fast) => {
            (SplitRules::FAST, vec![Arc::new(Transfinite::new(TfiRules::default()))])
        }
    };
    let mut out = companions.clone();
    out.push(Arc::new(companions.into_iter().fold(Subdivision::new(rules), Subdivision::with_companion)));
    out.push(Arc::new(Fallback));
    out
}

/// Quads, or sides, that one task of the certificate looks at.
const CHUNK: usize = 1 << 14;

/// The certificate that every mesh carries: strictly convex quads by exact predicates, conforming, the given boundary
/// and nothing else, the area of the domain (together these exclude overlaps and gaps), scars and hard points kept.
fn certify(mesh: &QuadMesh, topology: &QuadTopology, arrangement: &Arrangement) -> Result<(), MeshError> {
    let fail = |detail: String| Err(MeshError::Internal { stage: "certify", detail });
    let bad = mesh
        .quads
        .par_chunks(CHUNK)
        .enumerate()
        .filter_map(|(c, quads)| validate::certify(&mesh.points, quads).map(|q| c * CHUNK + q))
        .min();
    if let Some(q) = bad {
        return fail(format!("quad {q} at {:?} is not convex", mesh.corners(QuadId::new(q))[0]));
    }
    // Vertices of one element that are one point by the tolerance of the input.
    let merge = arrangement.tolerance.merge();
    let shortest = mesh.quads.par_iter().with_min_len(CHUNK).map(|q| {
        let p = q.map(|v| mesh.points[v.index()]);
        (0..4).map(|k| p[k].distance_squared(p[(k + 1) & 3])).fold(p[0].distance_squared(p[2]), f64::min)
    });
    if let Some(l) = shortest.min_by(f64::total_cmp)
        && l.sqrt() <= merge
    {
        return fail(format!("two vertices of a quad are {:e} apart", l.sqrt()));
    }
    if topology.n_bad_edges > 0 {
        return fail(format!("{} edges do not conform", topology.n_bad_edges));
    }
    certify_curves(mesh, topology, arrangement)?;
    // About a point of the domain, so that the digits are kept far from the origin.
    let o = mesh.points.first().copied().unwrap_or_default();
    let twice = |a: VertexId, b: VertexId, c: VertexId, d: VertexId| {
        let p = |v: VertexId| mesh.points[v.index()] - o;
        (p(c) - p(a)).perp_dot(p(d) - p(b))
    };
    // Chunk by chunk, so that the sum does not depend on the number of threads.
    let chunk = |quads: &[[VertexId; 4]]| quads.iter().map(|q| twice(q[0], q[1], q[2], q[3])).sum::<f64>();
    let quads: f64 = mesh.quads.par_chunks(CHUNK).map(chunk).collect::<Vec<_>>().iter().sum();
    let triangles: f64 = mesh.triangles.iter().map(|t| twice(t[0], t[1], t[2], t[0])).sum();
    let area = 0.5 * (quads + triangles);
    if (area - arrangement.area).abs() > validate::AREA_TOLERANCE * arrangement.area {
        return fail(format!("the area is {area}, that of the domain {}", arrangement.area));
    }
    Ok(())
}

/// The part of [`certify`] that looks at curves: the edges used once are exactly the given segments, in direction;
/// every scar segment is an edge; every hard point is used.
fn certify_curves(
    mesh: &QuadMesh,
    topology: &QuadTopology,
    arrangement: &Arrangement,
) -> Result<(), MeshError> {
    let fail = |detail: String| Err(MeshError::Internal { stage: "certify", detail });
    let mut next = vec![None; arrangement.points.len()];
    for l in &arrangement.loops {
        for (i, &v) in l.iter().enumerate() {
            next[v as usize] = Some(VertexId(l[(i + 1) % l.len()]));
        }
    }
    let given = |a: VertexId, b: VertexId| next.get(a.index()).is_some_and(|&n| n == Some(b));
    let ends = |h: usize| (mesh.quads[h / 4][h & 3], mesh.quads[h / 4][(h + 1) & 3]);
    let sides = || mesh.triangles.iter().flat_map(|t| (0..3).map(|k| (t[k], t[(k + 1) % 3])));
    let mut n_given = sides().filter(|&(a, b)| given(a, b)).count();
    let open = topology.twin.par_iter().with_min_len(CHUNK).enumerate();
    let open: Vec<usize> = open.filter(|&(_, &t)| t == QuadTopology::NONE).map(|(h, _)| h).collect();
    for (a, b) in open.into_iter().map(ends) {
        if given(a, b) {
            n_given += 1;
        } else if !sides().any(|side| side == (b, a)) {
            return fail(format!(
                "edge {a} {b} is on the boundary of the mesh and not on that of the domain"
            ));
        }
    }
    let n_segments = arrangement.loops.iter().map(Vec::len).sum::<usize>();
    if n_given != n_segments {
        return fail(format!("{n_given} of {n_segments} boundary segments are edges"));
    }
    let is_edge = |a: VertexId, b: VertexId| topology.star(a).iter().any(|&h| ends(h as usize).1 == b);
    for s in arrangement.scars.iter().flat_map(|s| s.windows(2)) {
        let (a, b) = (VertexId(s[0]), VertexId(s[1]));
        if !is_edge(a, b) && !is_edge(b, a) && !sides().any(|side| side == (a, b) || side == (b, a)) {
            return fail(format!("scar segment {a} {b} is not an edge"));
        }
    }
    for v in arrangement.hard_points.iter().map(|&v| VertexId(v)) {
        if topology.n_quads_at(v) == 0 && !sides().any(|side| side.0 == v) {
            return fail(format!("hard point {v} is not used"));
        }
    }
    Ok(())
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
