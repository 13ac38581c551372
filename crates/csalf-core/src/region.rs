//! One connected region: layers around its loops, then bridges, then the triad.
//!
//! ```text
//!   walks ──layers──▶ rings of quads + fronts ──bridge──▶ one contour ──triad──▶ quads
//! ```
//!
//! Works on the nodes of the region alone, in local numbers, so that many small regions cost no more than one large.

use crate::triad::{Filled, Triad};
use crate::{Job, LoopReport, MeshError};
use csalf_geom::Point2;
use csalf_geom::arrangement::{Arrangement, Region};
use csalf_mesh::NodeFlags;
use csalf_pave::{LayerSpec, LayerTask, Layers, PavingRules, Walk, WalkKind, pave_layers};
use csalf_sizemap::{Background, Hint, NearCoarse, SizeField, graded};
use csalf_subdiv::fallback::{ear, without};
use csalf_subdiv::{Walks, bridge};

/// Which curve an input node belongs to: what a walk is called, and how it is layered.
#[derive(Debug)]
pub(crate) struct Curves<'a> {
    /// Per input node: index into `names`, or `u32::MAX`. Loops win over scars, scars over points.
    of_node: Vec<u32>,
    /// Loops, then scars, then points.
    pub(crate) names: Vec<&'a str>,
    n_loops: usize,
    asked: Vec<Option<&'a LayerSpec>>,
}

impl<'a> Curves<'a> {
    pub(crate) fn new(job: &'a Job, arrangement: &Arrangement) -> Self {
        let d = &job.domain;
        let mut of_node = vec![u32::MAX; arrangement.points.len()];
        let lists = arrangement.loops.iter().map(Vec::as_slice);
        let lists = lists.chain(arrangement.scars.iter().map(Vec::as_slice));
        for (k, list) in lists.chain(arrangement.hard_points.iter().map(std::slice::from_ref)).enumerate() {
            for &v in list {
                let slot = &mut of_node[v as usize];
                *slot = (*slot).min(k as u32);
            }
        }
        let (names, asked) = Self::asked_of(job).into_iter().unzip();
        Self { of_node, names, n_loops: d.loops.len(), asked }
    }

    /// Loops, scars and points by name, each with the layers that are asked for: the last pattern that fits decides.
    pub(crate) fn asked_of(job: &'a Job) -> Vec<(&'a str, Option<&'a LayerSpec>)> {
        let d = &job.domain;
        let names = d.loops.iter().map(|l| l.name.as_str()).chain(d.scars.iter().map(|s| s.name.as_str()));
        let asked = |name: &str| job.layers.iter().rev().find(|(pattern, _)| matches(pattern, name));
        let names = names.chain(d.points.iter().map(|p| p.name.as_str()));
        names.map(|name| (name, asked(name).map(|(_, spec)| spec))).collect()
    }

    /// The curve that a walk is named after: the loop it runs along, else the scar, else the point.
    fn of_walk(&self, walk: &[u32]) -> usize {
        walk.iter().map(|&v| self.of_node[v as usize]).min().map_or(0, |k| k as usize)
    }
}

/// True if `name` is `pattern`, in which each `*` stands for any characters.
pub(crate) fn matches(pattern: &str, name: &str) -> bool {
    let mut parts = pattern.split('*');
    let Some(mut rest) = parts.next().and_then(|head| name.strip_prefix(head)) else { return false };
    let mut tail = None;
    for part in parts {
        if let Some(previous) = tail.replace(part) {
            match rest.find(previous) {
                Some(at) => rest = &rest[at + previous.len()..],
                None => return false,
            }
        }
    }
    tail.map_or(rest.is_empty(), |last| rest.ends_with(last))
}

/// How a region is layered.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LayerRules {
    pub(crate) rules: PavingRules,
    /// Layers on loops that nobody asked for.
    pub(crate) defaults: bool,
}

/// What became of one region.
#[derive(Debug, Default)]
pub(crate) struct RegionResult {
    /// Rings, bridges, patches, in this order.
    pub(crate) trees: Vec<Filled>,
    /// Layers per walk.
    pub(crate) loops: Vec<LoopReport>,
    /// Per quad of the first tree: curve and layer number.
    pub(crate) quad_layer: Vec<(u32, u32)>,
    /// Provisional ids of ring nodes that must not move: those of layers that the user asked for.
    pub(crate) frozen: Vec<u32>,
    /// The triangle of an odd region, in provisional ids.
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// Meshes one region.
pub(crate) fn mesh_region(
    region: &Region,
    arrangement: &Arrangement,
    curves: &Curves<'_>,
    layer_rules: Option<LayerRules>,
    size: &dyn SizeField,
    triad: &Triad<'_>,
) -> Result<RegionResult, MeshError> {
    let mut out = RegionResult::default();
    let global_walks: Vec<&[u32]> =
        std::iter::once(region.outer.as_slice()).chain(region.inner.iter().map(Vec::as_slice)).collect();
    let mut ids: Vec<u32> = global_walks.iter().flat_map(|w| w.iter().copied()).collect();
    ids.sort_unstable();
    ids.dedup();
    let local = |v: u32| ids.binary_search(&v).map_or(0, |i| i as u32);
    let mut walks: Vec<Vec<u32>> =
        global_walks.iter().map(|w| w.iter().map(|&v| local(v)).collect()).collect();
    let mut points: Vec<Point2> = ids.iter().map(|&v| arrangement.points[v as usize]).collect();
    let mut flags = vec![NodeFlags::GEOMETRY; points.len()];

    let mut ring_sizes = Vec::new();
    if let Some(rules) = layer_rules {
        let which: Vec<usize> = global_walks.iter().map(|w| curves.of_walk(w)).collect();
        let layers = lay(&walks, &which, &points, curves, rules, size, arrangement);
        let first = triad.reserve(layers.points.len());
        ids.extend((0..layers.points.len() as u32).map(|k| first + k));
        for (k, r) in layers.reports.iter().enumerate() {
            out.loops.push(LoopReport {
                name: curves.names[which[k]].to_owned(),
                asked: r.asked,
                made: r.made,
                stopped: r.stopped.as_ref().map(ToString::to_string).unwrap_or_default(),
                thickness_error: r.thickness_error,
            });
        }
        for (q, &(walk, _)) in layers.quads.iter().zip(&layers.quad_layer) {
            if curves.asked[which[walk as usize]].is_some() {
                out.frozen.extend(q.iter().map(|&v| ids[v as usize]));
            }
        }
        out.quad_layer = layers.quad_layer.iter().map(|&(w, n)| (which[w as usize] as u32, n)).collect();
        let quads = layers.quads.iter().map(|q| q.map(|v| ids[v as usize])).collect();
        flags.resize(points.len() + layers.points.len(), NodeFlags::LAYER);
        points.extend_from_slice(&layers.points);
        out.trees.push(Filled::leaf(first, layers.points, quads));
        walks = layers.fronts;
        // The paper knows nothing of what follows from them.
        if rules.rules == PavingRules::Corrected {
            ring_sizes = layers.ring_sizes;
        }
    }
    let handed = hand_over(size, &points, &ring_sizes, &walks);
    let size = handed.as_ref().map_or(size, |b| b as &dyn SizeField);
    let roomy = (!ring_sizes.is_empty()).then(|| room_beside(size, &points, &walks)).flatten();
    let size = roomy.as_ref().map_or(size, |b| b as &dyn SizeField);

    let internal = |stage, detail: String| MeshError::Internal { stage, detail };
    let input = Walks { walks: &walks, points: &points, flags: &flags };
    let mut bridged =
        bridge(input, size, points.len() as u32).map_err(|e| internal("bridge", e.to_string()))?;
    let first = triad.reserve(bridged.new_points.len());
    ids.extend((0..bridged.new_points.len() as u32).map(|k| first + k));
    for id in &mut bridged.contour.ids {
        *id = ids[*id as usize];
    }
    if bridged.contour.len() % 2 == 1 {
        // Only where the caller allows triangles: the check of the input stops odd regions otherwise.
        let c = &bridged.contour;
        let n = c.len();
        let tip = ear(c).map_err(|e| internal("triangle", e.to_string()))?;
        out.triangles.push([c.ids[(tip + n - 1) % n], c.ids[tip], c.ids[(tip + 1) % n]]);
        bridged.contour = without(c, tip);
    }
    out.trees.push(Filled::leaf(first, bridged.new_points, Vec::new()));
    if bridged.contour.len() < 4 {
        return Ok(out);
    }
    let filled = triad.fill(&bridged.contour, size).map_err(|e| internal("triad", e.to_string()))?;
    out.trees.push(filled);
    Ok(out)
}

/// Largest growth of the size from the last rings on, per unit of length. Smaller (0.25, 0.35): fewer irregular
/// vertices beside rings, but edges shorter than asked for far around (slots: size share 0.90 to 0.80).
const HAND_OVER: f64 = 0.7;
/// Rings whose edges are longer than this share of the wanted length need no hand-over.
const FINER: f64 = 0.75;

/// The size field of what the fronts bound, lowered to the sizes of the last rings: it leaves them with the gradation
/// [`HAND_OVER`], so that there is no jump. `None` if nowhere lower, or if the fronts cannot be triangulated (scars).
fn hand_over(
    size: &dyn SizeField,
    points: &[Point2],
    rings: &[(u32, f64)],
    fronts: &[Vec<u32>],
) -> Option<Background> {
    let mut hint = Hint::default();
    if !rings.iter().any(|&(v, s)| s < FINER * size.h(points[v as usize], &mut hint)) {
        return None;
    }
    let mut nodes: Vec<u32> = fronts.iter().flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    let name = |v: u32| nodes.binary_search(&v).map_or(0, |i| i as u32);
    let at: Vec<Point2> = nodes.iter().map(|&v| points[v as usize]).collect();
    let mut values: Vec<f64> = at.iter().map(|&p| size.h(p, &mut hint)).collect();
    for &(v, s) in rings {
        let k = name(v) as usize;
        values[k] = values[k].min(s);
    }
    let loops: Vec<Vec<u32>> =
        fronts.iter().filter(|f| f.len() > 2).map(|f| f.iter().map(|&v| name(v)).collect()).collect();
    graded(size, &at, &values, &loops, HAND_OVER).ok()
}

/// Larger sizes beside segments of the fronts that are long for the field: thick layers leave such, and where they end
/// before a hole their sides are some.
fn room_beside<'a>(
    size: &'a dyn SizeField,
    points: &[Point2],
    fronts: &[Vec<u32>],
) -> Option<NearCoarse<&'a dyn SizeField>> {
    let loops: Vec<Vec<Point2>> = fronts
        .iter()
        .filter(|f| f.len() > 2)
        .map(|f| f.iter().map(|&v| points[v as usize]).collect())
        .collect();
    NearCoarse::new(size, &loops).ok().flatten()
}

/// Algorithm I on the walks of one region.
fn lay(
    walks: &[Vec<u32>],
    which: &[usize],
    points: &[Point2],
    curves: &Curves<'_>,
    rules: LayerRules,
    size: &dyn SizeField,
    arrangement: &Arrangement,
) -> Layers {
    let walks: Vec<Walk> = walks
        .iter()
        .enumerate()
        .map(|(k, nodes)| Walk {
            nodes: nodes.clone(),
            kind: match (k, nodes.len()) {
                (0, _) => WalkKind::Outer,
                (_, 1) => WalkKind::Point,
                _ if which[k] < curves.n_loops => WalkKind::Hole,
                _ => WalkKind::Scar,
            },
            asked: curves.asked[which[k]].cloned(),
        })
        .collect();
    pave_layers(&LayerTask {
        points,
        walks: &walks,
        size,
        tolerance: arrangement.tolerance,
        rules: rules.rules,
        defaults: rules.defaults,
        partial: rules.rules != PavingRules::Paper,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_of_names() {
        for (pattern, name, want) in [
            ("hole0", "hole0", true),
            ("hole0", "hole01", false),
            ("hole*", "hole12", true),
            ("hole*", "outer", false),
            ("*", "anything", true),
            ("h*e*3", "hole13", true),
            ("h*e*3", "hole31", false),
            ("", "", true),
            ("*a*a", "aa", true),
            ("*a*a", "a", false),
        ] {
            assert_eq!(matches(pattern, name), want, "{pattern} on {name}");
        }
    }
}
