//! A curved face: charts, seams, planar meshes, back into space.
//!
//! 1. Sizes per vertex in space. 2. Charts: flattened, or cut and tried again. 3. Seams get their nodes.
//! 4. Each chart is meshed in the plane, with sizes scaled by its map.
//! 5. The meshes are joined by node ids, lifted, put on the surface and smoothed on it.
//! 6. Certificate and figures.

use crate::cut::{Bounds, cut_chart};
use crate::face::given_nodes;
use crate::flatten::{Flattened, flatten};
use crate::heal::heal;
use crate::locate::Anchor;
use crate::patch::{Chart, NONE, Patch, components};
use crate::quality::measure;
use crate::seams::place;
use crate::sheet::{Ground, Sheet};
use crate::sizes::sizes;
use crate::smooth::smooth;
use crate::{FaceError, FaceInput, FaceMesh, FaceSize};
use csalf_core::Options;
use csalf_geom::VertexId;
use csalf_mesh::QuadTopology;
use glam::DVec2;

/// Sides of facets longer than this share of the wanted length are halved before cuts are made along them. Smaller:
/// maps of more facets, which cost most of the time (0.7: twice as long on a machined part, for the same quads).
const COARSE: f64 = 1.0;
/// Most facets after dividing.
const MAX_FACETS: usize = 60_000;
/// Most times that the facets are divided.
const MAX_LEVELS: usize = 6;
/// Times that a cut face is meshed with smaller sizes, if two pieces between the same seams are but one quad
/// wide, so that their meshes share more than the seams, or if quads come out folded.
const RETRIES: usize = 4;
/// Faces in more charts than this are meshed once, as are those in one: where heaps of needles end in hundreds of
/// charts, finer sizes took minutes to fail again (`fuzz-models`, seed 2026).
const FEW_CHARTS: usize = 64;
/// Nor are those whose cuts then get more nodes than this: cuts through heaps of needles are long, and as fine as these
/// (seed 20153: 17 nodes given, 11,700 on cuts, a minute).
const MOST_ON_CUTS: usize = 2000;
/// Factor of the sizes from one attempt to the next.
const FINER: f64 = 0.6;
/// Most charts of one face.
const MAX_CHARTS: usize = 150;

/// The face with what belongs to its vertices and half-sides.
pub(crate) struct Face {
    pub(crate) patch: Patch,
    /// Wanted length in space, per vertex; empty until they are needed (an unrolled face without cuts does
    /// not).
    pub(crate) sizes: Vec<f64>,
    /// The facets are not divided any more.
    pub(crate) is_fine: bool,
    /// Scars as chains of vertices, with those that are no nodes.
    pub(crate) scars: Vec<Vec<u32>>,
    pub(crate) on_scar: Vec<bool>,
    pub(crate) in_scar: Vec<bool>,
    /// Per vertex: number of the given node.
    pub(crate) node_at: Vec<u32>,
    /// Loop of each vertex that is a loop node.
    pub(crate) loop_of: Vec<u32>,
}

/// One chart, flattened.
pub(crate) struct Piece {
    pub(crate) chart: Chart,
    pub(crate) map: Flattened,
}

pub(crate) fn curved(input: &FaceInput<'_>, options: &Options) -> Result<FaceMesh, FaceError> {
    let mut face = Face::new(input)?;
    face.check_boundary(input)?;
    let isometric = |pieces: &[Piece]| pieces.iter().all(|p| p.map.is_isometric());
    let mut given = input.flat;
    let (pieces, cut) = loop {
        match divide(&face, given) {
            Ok(Some(done)) => break done,
            Ok(None) => {
                face.fill_sizes(input, options);
                for _ in 0..MAX_LEVELS {
                    if face.patch.triangles.len() >= MAX_FACETS || !face.refine()? {
                        break;
                    }
                }
                face.is_fine = true;
                given = None;
            }
            Err(e) => return Err(e),
        }
    };
    // A chart without distortion takes one size or the boundary's; a list has to be carried to its vertices.
    if !isometric(&pieces) || matches!(input.size, FaceSize::Vertices(_)) {
        face.fill_sizes(input, options);
    }
    // Of attempts with quads that are folded in space the one with the fewest; and why there is none.
    let mut folded: Option<FaceMesh> = None;
    let mut refused = None;
    let attempts = if (2..=FEW_CHARTS).contains(&pieces.len()) { RETRIES } else { 1 };
    for attempt in 0..attempts {
        match face.mesh(input, options, &pieces, &cut, attempt) {
            Ok(None) => break,
            Ok(Some(out)) if out.report.quality.n_nonpositive == 0 => return Ok(out),
            Ok(Some(out)) => {
                let n = out.report.quality.n_nonpositive;
                if folded.as_ref().is_none_or(|f| n < f.report.quality.n_nonpositive) {
                    folded = Some(out);
                }
            }
            Err(e @ (FaceError::TooThin { .. } | FaceError::Internal { .. } | FaceError::Planar { .. })) => {
                refused.get_or_insert(e);
            }
            Err(e) => return Err(e),
        }
    }
    // Where both sides of a cut met, folded quads are no cure.
    match (refused, folded) {
        (None, Some(out)) => Ok(out),
        (refused, _) => Err(refused.unwrap_or(FaceError::NoArea)),
    }
}

impl Face {
    fn new(input: &FaceInput<'_>) -> Result<Self, FaceError> {
        let patch = Patch::new(input.facets)?;
        let n = patch.points.len();
        let mut node_at = vec![NONE; n];
        for (i, v) in given_nodes(input).into_iter().enumerate() {
            node_at[v as usize] = i as u32;
        }
        let mut loop_of = vec![NONE; n];
        for (k, l) in input.loops.iter().enumerate() {
            l.nodes.iter().for_each(|&v| loop_of[v as usize] = k as u32);
        }
        let mut out = Self {
            patch,
            sizes: Vec::new(),
            is_fine: false,
            scars: input.scars.to_vec(),
            on_scar: Vec::new(),
            in_scar: Vec::new(),
            node_at,
            loop_of,
        };
        out.find_scars()?;
        Ok(out)
    }

    fn fill_sizes(&mut self, input: &FaceInput<'_>, options: &Options) {
        if self.sizes.is_empty() {
            self.sizes = sizes(input, options, &self.patch);
        }
    }

    /// Marks the half-sides and vertices of scars.
    fn find_scars(&mut self) -> Result<(), FaceError> {
        self.on_scar = vec![false; self.patch.twin.len()];
        self.in_scar = vec![false; self.patch.points.len()];
        for (index, s) in self.scars.iter().enumerate() {
            s.iter().for_each(|&v| self.in_scar[v as usize] = true);
            for w in s.windows(2) {
                let Some(h) = self.side(w[0], w[1]) else {
                    return Err(FaceError::BadInput { what: "scar", index });
                };
                self.on_scar[h as usize] = true;
                if self.patch.twin[h as usize] != NONE {
                    self.on_scar[self.patch.twin[h as usize] as usize] = true;
                }
            }
        }
        Ok(())
    }

    /// A half-side between two vertices, in either direction. Cost O(n): scars are few.
    pub(crate) fn side(&self, a: u32, b: u32) -> Option<u32> {
        let at = |h: &u32| {
            let e = self.patch.ends(*h);
            e == (a, b) || e == (b, a)
        };
        (0..self.patch.twin.len() as u32).find(at)
    }

    /// Halves the sides that are too long; false if there is none.
    fn refine(&mut self) -> Result<bool, FaceError> {
        let sizes = self.sizes.clone();
        let is_long = |s: u32| {
            let (a, b) = self.patch.ends(s);
            let h = 0.5 * (sizes[a as usize] + sizes[b as usize]);
            self.patch.points[a as usize].distance(self.patch.points[b as usize]) > COARSE * h
        };
        if !(0..self.patch.twin.len() as u32).any(is_long) {
            return Ok(false);
        }
        let (patch, middle) = self.patch.subdivided(&mut self.sizes, is_long)?;
        let halves: Vec<Vec<u32>> = self
            .scars
            .iter()
            .map(|s| {
                let mut out = Vec::with_capacity(2 * s.len());
                for w in s.windows(2) {
                    out.push(w[0]);
                    out.extend(self.side(w[0], w[1]).map(|h| middle[h as usize]).filter(|&v| v != NONE));
                }
                out.extend(s.last());
                out
            })
            .collect();
        self.scars = halves;
        self.patch = patch;
        self.node_at.resize(self.patch.points.len(), NONE);
        self.loop_of.resize(self.patch.points.len(), NONE);
        self.find_scars()?;
        Ok(true)
    }

    pub(crate) fn middle_of(&self, chart: &Chart) -> glam::DVec3 {
        chart.points.first().copied().unwrap_or_default()
    }
}

/// All charts, and per half-side whether it is cut.
type Atlas = (Vec<Piece>, Vec<bool>);

/// Charts that are flattened, and the cuts between them; `None` if the facets should be finer first.
fn divide(face: &Face, given: Option<&[DVec2]>) -> Result<Option<Atlas>, FaceError> {
    let patch = &face.patch;
    let mut cut = vec![false; patch.twin.len()];
    let is_node: Vec<bool> = face.node_at.iter().map(|&n| n != NONE).collect();
    let bounds = Bounds { is_node: &is_node, on_scar: &face.on_scar, in_scar: &face.in_scar };
    let mut scratch = vec![NONE; patch.triangles.len()];
    let mut open = components(patch, &cut, None);
    open.reverse();
    let mut pieces: Vec<Piece> = Vec::new();
    // Of one piece, that the coarse facets could not be flattened is answer enough.
    let mut refused = face.is_fine && open.len() == 1;
    while let Some(facets) = open.pop() {
        let chart = Chart::new(patch, &cut, facets, &mut scratch);
        let many = pieces.len() + open.len() >= MAX_CHARTS;
        let skip = std::mem::take(&mut refused);
        if !skip && let Some(map) = flatten(&chart, given, many) {
            pieces.push(Piece { chart, map });
            continue;
        }
        if !face.is_fine {
            return Ok(None);
        }
        let done = !many && cut_chart(patch, &chart, &bounds, &mut cut);
        if !done {
            let Some(map) = flatten(&chart, given, true) else {
                let why = "no map without overlap was found, and no way to cut it".into();
                return Err(FaceError::Flatten { at: face.middle_of(&chart), why });
            };
            pieces.push(Piece { chart, map });
            continue;
        }
        let mut parts = components(patch, &cut, Some(&chart.facets));
        parts.reverse();
        open.append(&mut parts);
    }
    Ok(Some((pieces, cut)))
}

impl Face {
    /// Meshes the pieces and puts them together; `None` if a further attempt is not worth it.
    fn mesh(
        &self,
        input: &FaceInput<'_>,
        options: &Options,
        pieces: &[Piece],
        cut: &[bool],
        attempt: usize,
    ) -> Result<Option<FaceMesh>, FaceError> {
        let patch = &self.patch;
        let finer = FINER.powi(attempt as i32);
        let nodes = given_nodes(input);
        let mut chart_of = vec![0u32; patch.triangles.len()];
        for (k, p) in pieces.iter().enumerate() {
            p.chart.facets.iter().for_each(|&t| chart_of[t as usize] = k as u32);
        }
        let n_real = self.real_segments(input, pieces.iter().map(|p| &p.chart))?;
        let seams =
            place(patch, cut, &self.sizes, &chart_of, self.node_at.clone(), nodes.len(), &n_real, finer)?;
        if attempt > 0 && seams.anchors.len() > MOST_ON_CUTS {
            return Ok(None);
        }

        let mut sheet = Sheet::default();
        let ground = Ground { patch, normals: patch.normals(), facets: input.facets, surface: input.surface };
        let mut corner_of = vec![NONE; patch.points.len()];
        for (t, c) in patch.triangles.iter().enumerate() {
            for k in 0..3 {
                corner_of[c[k] as usize] = (3 * t + k) as u32;
            }
        }
        let mut out = FaceMesh::default();
        for &v in &nodes {
            let c = corner_of[v as usize];
            if c == NONE {
                let index = v as usize;
                return Err(FaceError::BadInput { what: "node without facet, vertex", index });
            }
            let mut bary = [0.0; 3];
            bary[c as usize % 3] = 1.0;
            let anchor = Anchor { facet: c / 3, bary };
            let (_, normal, _) = ground.at(anchor);
            sheet.push(patch.points[v as usize], normal, anchor, true);
        }
        for &a in &seams.anchors {
            out.report.n_unprojected += usize::from(!sheet.add(&ground, a));
        }
        let n_on_curves = sheet.points.len();
        out.report.layers = vec![(0, 0, String::new()); input.loops.len()];
        for piece in pieces {
            self.mesh_piece(input, options, piece, &seams, &ground, &mut sheet, &mut out, finer)?;
        }
        let topology = self.certify(input, &sheet)?;
        let seeds: Vec<u32> = (nodes.len() as u32..n_on_curves as u32).collect();
        if !seeds.is_empty() || !pieces.iter().all(|p| p.map.is_isometric()) {
            let before = sheet.clone();
            smooth(&mut sheet, &ground, &topology, &seeds);
            let q = |s: &Sheet| measure(&s.points, &s.quads, |v| s.normals[v as usize]);
            let (a, b) = (q(&before), q(&sheet));
            if b.n_nonpositive > a.n_nonpositive || b.min_sj < a.min_sj.min(0.3) {
                sheet = before;
            }
            out.report.n_healed = heal(&mut sheet, &ground, options, nodes.len(), &mut out);
            self.certify(input, &sheet)?;
        }
        let r = &mut out.report;
        r.n_charts = pieces.len();
        r.flattening = pieces.iter().map(|p| p.map.how).max().unwrap_or_default();
        r.anisotropy = pieces.iter().map(|p| p.map.verdict.anisotropy).fold(1.0, f64::max);
        for (k, l) in input.loops.iter().enumerate() {
            if let Some(spec) = &l.layers
                && spec.count > 0
                && r.layers[k].0 == 0
            {
                r.layers[k] = (spec.count, 0, "a cut of the face ends at the loop".into());
            }
        }
        r.max_angle_error = pieces.iter().map(|p| p.map.verdict.angle_error).fold(0.0, f64::max);
        r.scale_range = pieces.iter().map(|p| p.map.verdict.scale_range).fold(1.0, f64::max);
        r.quality = measure(&sheet.points, &sheet.quads, |v| sheet.normals[v as usize]);
        r.quality.max_deviation = deviation(&sheet, &ground);
        (out.points, out.normals, out.quads, out.nodes) = (sheet.points, sheet.normals, sheet.quads, nodes);
        Ok(Some(out))
    }

    /// The boundary of the facets must be the loops, before any work is done.
    fn check_boundary(&self, input: &FaceInput<'_>) -> Result<(), FaceError> {
        let cut = vec![false; self.patch.twin.len()];
        let mut scratch = vec![NONE; self.patch.triangles.len()];
        let parts = components(&self.patch, &cut, None);
        let charts: Vec<Chart> =
            parts.into_iter().map(|t| Chart::new(&self.patch, &cut, t, &mut scratch)).collect();
        self.real_segments(input, charts.iter()).map(|_| ())
    }

    /// Given segments on the contour of each chart. Also: every run of boundary sides between two nodes must
    /// be a segment of a loop.
    fn real_segments<'c>(
        &self,
        input: &FaceInput<'_>,
        charts: impl Iterator<Item = &'c Chart>,
    ) -> Result<Vec<usize>, FaceError> {
        let mut after = vec![(NONE, NONE); self.patch.points.len()];
        for l in input.loops {
            for (i, &v) in l.nodes.iter().enumerate() {
                after[v as usize] =
                    (l.nodes[(i + 1) % l.nodes.len()], l.nodes[(i + l.nodes.len() - 1) % l.nodes.len()]);
            }
        }
        let mut out = Vec::new();
        let mut total = 0;
        for c in charts {
            let mut n = 0;
            for l in &c.loops {
                let at = |h: u32| c.vertex[c.tail(h) as usize];
                let real = |h: u32| self.patch.twin[(3 * c.facets[h as usize / 3] + h % 3) as usize] == NONE;
                let is_node = |v: u32| self.loop_of[v as usize] != NONE;
                // Rotate to a node, so that runs are whole.
                let Some(first) = l.iter().position(|&h| is_node(at(h))) else {
                    if let Some(&h) = l.iter().find(|&&h| real(h)) {
                        return Err(FaceError::Boundary { at: self.patch.points[at(h) as usize] });
                    }
                    continue;
                };
                let mut last = at(l[first]);
                let mut is_real = real(l[first]);
                for i in 1..=l.len() {
                    let h = l[(first + i) % l.len()];
                    let v = at(h);
                    if is_node(v) {
                        if is_real {
                            n += 1;
                            let (a, b) = after[last as usize];
                            if a != v && b != v {
                                return Err(FaceError::Boundary { at: self.patch.points[v as usize] });
                            }
                        }
                        (last, is_real) = (v, real(h));
                    } else if real(h) != is_real {
                        let at = self.patch.points[v as usize];
                        let why = "a cut ends between two nodes of the boundary".into();
                        return Err(FaceError::Flatten { at, why });
                    }
                }
            }
            total += n;
            out.push(n);
        }
        if total != input.loops.iter().map(|l| l.nodes.len()).sum::<usize>() {
            let at = input.loops.iter().flat_map(|l| &l.nodes).next().map_or(0, |&v| v);
            return Err(FaceError::Boundary { at: self.patch.points[at as usize] });
        }
        Ok(out)
    }

    /// Conforming, and the boundary is the given segments.
    fn certify(&self, input: &FaceInput<'_>, sheet: &Sheet) -> Result<QuadTopology, FaceError> {
        let fail = |detail: String| Err(FaceError::Internal { stage: "certify", detail });
        // Both sides of a cut met in one quad.
        let twice = |q: &[u32; 4]| (0..4).find(|&i| q[..i].contains(&q[i])).map(|i| q[i]);
        if let Some(v) = sheet.quads.iter().find_map(twice) {
            return Err(FaceError::TooThin { at: sheet.points[v as usize] });
        }
        let quads: Vec<[VertexId; 4]> = sheet.quads.iter().map(|q| q.map(VertexId)).collect();
        let topology = QuadTopology::new(sheet.points.len(), &quads);
        if topology.n_bad_edges > 0 {
            let side = |q: &[u32; 4], k: usize| {
                let (a, b) = (q[k], q[(k + 1) & 3]);
                [a.min(b), a.max(b)]
            };
            let mut sides: Vec<_> =
                sheet.quads.iter().flat_map(|q| (0..4).map(move |k| side(q, k))).collect();
            sides.sort_unstable();
            let place = sides.windows(3).find(|w| w[0] == w[2]).map(|w| sheet.points[w[0][0] as usize]);
            return match place {
                Some(at) => Err(FaceError::TooThin { at }),
                None => fail(format!("{} edges do not conform", topology.n_bad_edges)),
            };
        }
        let n_free = topology.twin.iter().filter(|&&t| t == QuadTopology::NONE).count();
        let n_given: usize = input.loops.iter().map(|l| l.nodes.len()).sum();
        if n_free != n_given {
            return fail(format!("{n_free} boundary edges instead of {n_given}"));
        }
        Ok(topology)
    }
}

/// Largest distance of a quad's centre from the ground.
fn deviation(sheet: &Sheet, ground: &Ground<'_>) -> f64 {
    let mut most = 0f64;
    for q in &sheet.quads {
        let centre = 0.25 * q.iter().map(|&v| sheet.points[v as usize]).sum::<glam::DVec3>();
        let anchor = ground.nearest(sheet.anchors[q[0] as usize], centre);
        most = most.max(anchor.point(ground.patch).distance(centre));
    }
    most
}

impl Sheet {
    pub(crate) fn push(&mut self, p: glam::DVec3, n: glam::DVec3, a: Anchor, fixed: bool) {
        self.points.push(p);
        self.normals.push(n);
        self.anchors.push(a);
        self.fixed.push(fixed);
    }

    /// Adds a free vertex on the ground; false if the surface refused it.
    pub(crate) fn add(&mut self, ground: &Ground<'_>, a: Anchor) -> bool {
        let (p, n, on) = ground.at(a);
        self.push(p, n, a, false);
        on
    }
}
