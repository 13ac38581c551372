//! A curved face: charts, seams, planar meshes, back into space.
//!
//! 1. Sizes per vertex in space. 2. Charts: flattened, or cut and tried again. 3. Seams get their nodes.
//! 4. Each chart is meshed in the plane, with sizes scaled by its map.
//! 5. The meshes are joined by node ids, lifted, put on the surface and smoothed on it.
//! 6. Certificate and figures.

use crate::cut::{Bounds, cut_chart};
use crate::face::{constant, given_nodes, mesh, of_planar_piece};
use crate::flatten::map::scales;
use crate::flatten::{Flattened, extend, flatten};
use crate::heal::heal;
use crate::locate::{Anchor, Locator};
use crate::patch::{Chart, NONE, Patch, components, next};
use crate::quality::measure;
use crate::seams::{Seams, place};
use crate::sheet::{Ground, Sheet};
use crate::smooth::smooth;
use crate::{FaceError, FaceInput, FaceMesh, FaceSize, LayerRing};
use csalf_core::{Job, Options};
use csalf_geom::{HardPoint, Loop, LoopKind, Point2, Scar, VertexId};
use csalf_mesh::QuadTopology;
use csalf_pave::{LayerLaw, LayerSpec};
use csalf_sizemap::SizeSpec;
use glam::DVec2;

/// Facets longer than this share of the wanted length are divided before cuts are made along them.
const COARSE: f64 = 0.35;
/// Most facets after dividing.
const MAX_FACETS: usize = 60_000;
/// Most times that the facets are divided.
const MAX_LEVELS: usize = 3;
/// Times that a cut face is meshed with smaller sizes, if two pieces between the same seams are but one quad wide, so
/// that their meshes share more than the seams.
const RETRIES: usize = 4;
/// Factor of the sizes from one attempt to the next.
const FINER: f64 = 0.6;
/// Most charts of one face.
const MAX_CHARTS: usize = 400;
/// Quads that a closed surface without any size gets, about.
const DEFAULT_QUADS: f64 = 600.0;

/// The face with what belongs to its vertices and half-sides.
struct Face {
    patch: Patch,
    /// Wanted length in space, per vertex; empty until they are needed (an unrolled face without cuts does not).
    sizes: Vec<f64>,
    /// The facets are not divided any more.
    is_fine: bool,
    /// Scars as chains of vertices, with those that are no nodes.
    scars: Vec<Vec<u32>>,
    on_scar: Vec<bool>,
    in_scar: Vec<bool>,
    /// Per vertex: number of the given node.
    node_at: Vec<u32>,
    /// Loop of each vertex that is a loop node.
    loop_of: Vec<u32>,
}

/// One chart, flattened.
struct Piece {
    chart: Chart,
    map: Flattened,
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
                    if face.is_coarse() {
                        face.refine()?;
                    }
                }
                face.is_fine = true;
                given = None;
            }
            Err(e) => return Err(e),
        }
    };
    if !isometric(&pieces) {
        face.fill_sizes(input, options);
    }
    let mut refused = None;
    for attempt in 0..RETRIES {
        match face.mesh(input, options, &pieces, &cut, attempt) {
            Ok(out) => return Ok(out),
            Err(e @ (FaceError::TooThin { .. } | FaceError::Internal { .. } | FaceError::Planar { .. }))
                if pieces.len() > 1 =>
            {
                refused.get_or_insert(e);
            }
            Err(e) => return Err(e),
        }
    }
    Err(refused.unwrap_or(FaceError::NoArea))
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
    fn side(&self, a: u32, b: u32) -> Option<u32> {
        let at = |h: &u32| {
            let e = self.patch.ends(*h);
            e == (a, b) || e == (b, a)
        };
        (0..self.patch.twin.len() as u32).find(at)
    }

    fn is_coarse(&self) -> bool {
        let (mut l, mut h, n) = (0.0, 0.0, self.patch.twin.len());
        for s in 0..n as u32 {
            let (a, b) = self.patch.ends(s);
            l += self.patch.points[a as usize].distance(self.patch.points[b as usize]);
            h += self.sizes[a as usize];
        }
        l > COARSE * h && 4 * self.patch.triangles.len() <= MAX_FACETS
    }

    fn refine(&mut self) -> Result<(), FaceError> {
        let (patch, middle) = self.patch.subdivided(&mut self.sizes)?;
        let halves: Vec<Vec<u32>> = self
            .scars
            .iter()
            .map(|s| {
                let mut out = Vec::with_capacity(2 * s.len());
                for w in s.windows(2) {
                    out.push(w[0]);
                    out.extend(self.side(w[0], w[1]).map(|h| middle[h as usize]));
                }
                out.extend(s.last());
                out
            })
            .collect();
        self.scars = halves;
        self.patch = patch;
        self.node_at.resize(self.patch.points.len(), NONE);
        self.loop_of.resize(self.patch.points.len(), NONE);
        self.find_scars()
    }

    fn middle_of(&self, chart: &Chart) -> glam::DVec3 {
        chart.points.first().copied().unwrap_or_default()
    }
}

/// Wanted length per vertex, in space, limited to the gradation that is asked for.
fn sizes(input: &FaceInput<'_>, options: &Options, patch: &Patch) -> Vec<f64> {
    let n = patch.points.len();
    let mut out = match input.size {
        FaceSize::Uniform(h) => return vec![h; n],
        FaceSize::Vertices(h) => h.to_vec(),
        FaceSize::Boundary => {
            let mut log = vec![f64::NAN; n];
            for l in input.loops {
                let p = |i: usize| patch.points[l.nodes[i % l.nodes.len()] as usize];
                for i in 0..l.nodes.len() {
                    let before = p(i + l.nodes.len() - 1).distance(p(i));
                    let h = 0.5 * (before + p(i).distance(p(i + 1)));
                    if h > 0.0 {
                        log[l.nodes[i] as usize] = h.ln();
                    }
                }
            }
            if input.loops.is_empty() {
                let area: f64 =
                    (0..patch.triangles.len() as u32).map(|t| patch.area_vector(t).length()).sum();
                log.fill((0.5 * area / DEFAULT_QUADS).sqrt().ln());
            } else {
                extend(patch, &mut log);
            }
            log.iter().map(|l| l.exp()).collect()
        }
    };
    if let Some(g) = options.gradation
        && g > 0.0
    {
        limit(patch, &mut out, g);
    }
    out
}

/// The largest sizes below the given ones that grow by at most `g` per length along the sides of the facets.
fn limit(patch: &Patch, h: &mut [f64], g: f64) {
    use std::cmp::Reverse;
    let mut near: Vec<Vec<u32>> = vec![Vec::new(); h.len()];
    for t in &patch.triangles {
        for k in 0..3 {
            near[t[k] as usize].extend([t[(k + 1) % 3], t[(k + 2) % 3]]);
        }
    }
    let mut heap: std::collections::BinaryHeap<_> =
        h.iter().enumerate().map(|(v, x)| Reverse((x.to_bits(), v as u32))).collect();
    while let Some(Reverse((k, v))) = heap.pop() {
        if k != h[v as usize].to_bits() {
            continue;
        }
        for &w in &near[v as usize] {
            let most = h[v as usize] + g * patch.points[v as usize].distance(patch.points[w as usize]);
            if most < h[w as usize] {
                h[w as usize] = most;
                heap.push(Reverse((most.to_bits(), w)));
            }
        }
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
    while let Some(facets) = open.pop() {
        let chart = Chart::new(patch, &cut, facets, &mut scratch);
        let many = pieces.len() + open.len() >= MAX_CHARTS;
        if let Some(map) = flatten(&chart, given, many) {
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

/// One contour of a chart: mesh nodes and their flat places, the loop it follows alone.
struct Contour {
    nodes: Vec<u32>,
    flat: Vec<Point2>,
    loop_index: Option<usize>,
    /// Mean length in the plane over length in space.
    scale: f64,
}

impl Face {
    fn mesh(
        &self,
        input: &FaceInput<'_>,
        options: &Options,
        pieces: &[Piece],
        cut: &[bool],
        attempt: usize,
    ) -> Result<FaceMesh, FaceError> {
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
        Ok(out)
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

    /// Given segments on the contour of each chart. Also: every run of boundary sides between two nodes must be a
    /// segment of a loop.
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

    /// The contours of a chart.
    fn contours(&self, piece: &Piece, seams: &Seams) -> Vec<Contour> {
        let c = &piece.chart;
        let mut out = Vec::new();
        for l in &c.loops {
            let mut k = Contour { nodes: Vec::new(), flat: Vec::new(), loop_index: None, scale: 1.0 };
            let (mut plane, mut space) = (0.0, 0.0);
            let mut n_cut = 0;
            for &h in l {
                let (a, b) = (c.tail(h), c.tail(next(h)));
                let (fa, fb) = (piece.map.flat[a as usize], piece.map.flat[b as usize]);
                plane += fa.distance(fb);
                space += c.points[a as usize].distance(c.points[b as usize]);
                let node = seams.node_at[c.vertex[a as usize] as usize];
                if node != NONE {
                    k.nodes.push(node);
                    k.flat.push(fa);
                }
                let g = 3 * c.facets[h as usize / 3] + h % 3;
                n_cut += usize::from(self.patch.twin[g as usize] != NONE);
                for &(s, id) in seams.inside.get(&g).into_iter().flatten() {
                    k.nodes.push(id);
                    k.flat.push(fa.lerp(fb, s));
                }
            }
            k.scale = if space > 0.0 { plane / space } else { 1.0 };
            if n_cut == 0 {
                let v = l.iter().map(|&h| c.vertex[c.tail(h) as usize]);
                k.loop_index = v.map(|v| self.loop_of[v as usize]).find(|&l| l != NONE).map(|l| l as usize);
            }
            out.push(k);
        }
        out
    }

    #[allow(clippy::too_many_arguments, reason = "one call, and all of it is context")]
    fn mesh_piece(
        &self,
        input: &FaceInput<'_>,
        options: &Options,
        piece: &Piece,
        seams: &Seams,
        ground: &Ground<'_>,
        sheet: &mut Sheet,
        out: &mut FaceMesh,
        finer: f64,
    ) -> Result<(), FaceError> {
        let (chart, flat) = (&piece.chart, &piece.map.flat);
        let contours = self.contours(piece, seams);
        let mut job = Job { size: self.size_spec(input, piece), ..Job::default() };
        let area = |c: &Contour| csalf_geom::polygon::signed_area(&c.flat);
        let outer = (0..contours.len())
            .max_by(|&a, &b| area(&contours[a]).total_cmp(&area(&contours[b])).then(b.cmp(&a)));
        // Mesh nodes in the order of the planar mesher's first points.
        let mut ids: Vec<u32> = Vec::new();
        let mut first: Vec<Point2> = Vec::new();
        for (k, c) in contours.iter().enumerate() {
            let kind = if Some(k) == outer { LoopKind::Outer } else { LoopKind::Hole };
            let name = c.loop_index.map_or_else(|| format!("c{k}"), |l| format!("l{l}"));
            if let Some(spec) = c.loop_index.and_then(|l| input.loops[l].layers.as_ref()) {
                job.layers.push((name.clone(), scaled(spec, c.scale)));
            }
            job.domain.loops.push(Loop { kind, name, nodes: c.flat.clone() });
            ids.extend(&c.nodes);
            first.extend(&c.flat);
        }
        self.add_interior(input, piece, seams, &mut job, &mut ids, &mut first);
        // Sizes per vertex are limited in space already.
        let gradation = if self.sizes.is_empty() { options.gradation } else { None };
        let options = Options { gradation, ..options.clone() };
        if let SizeSpec::Background { values, .. } = &mut job.size {
            values.iter_mut().for_each(|h| *h *= finer);
        }
        let meshed = mesh(&job, &options).map_err(|e| of_planar_piece(self.middle_of(chart), e))?;
        if meshed.mesh.points.len() < first.len() || meshed.mesh.points[..first.len()] != first[..] {
            return Err(FaceError::Internal { stage: "contour", detail: "nodes were renumbered".into() });
        }
        let locator = Locator::new(chart, flat);
        let mut last = 0;
        for &p in &meshed.mesh.points[first.len()..] {
            let (t, bary) = locator.find(p, last);
            last = t;
            ids.push(sheet.points.len() as u32);
            let anchor = Anchor { facet: chart.facets[t as usize], bary };
            out.report.n_unprojected += usize::from(!sheet.add(ground, anchor));
        }
        let n_before = sheet.quads.len() as u32;
        sheet.quads.extend(meshed.mesh.quads.iter().map(|q| q.map(|v| ids[v.index()])));
        let loop_of = |name: &str| name.strip_prefix('l').and_then(|k| k.parse::<usize>().ok());
        for r in &meshed.report.loops {
            if let Some(slot) = loop_of(&r.name).and_then(|k| out.report.layers.get_mut(k)) {
                *slot = (r.asked, r.made, r.stopped.clone());
            }
        }
        for (name, quads) in &meshed.sets.quads {
            let Some((l, n)) = name.split_once("_layer") else { continue };
            let (Some(loop_index), Ok(layer)) = (loop_of(l), n.parse()) else { continue };
            let quads: Vec<u32> = quads.iter().map(|q| n_before + q.0).collect();
            if input.loops[loop_index].layers.is_some() {
                for &q in &quads {
                    sheet.quads[q as usize].iter().for_each(|&v| sheet.fixed[v as usize] = true);
                }
            }
            out.rings.push(LayerRing { loop_index, layer, quads });
        }
        out.report.warnings.extend(meshed.report.warnings.iter().map(ToString::to_string));
        Ok(())
    }

    /// Sizes of a chart in the plane.
    fn size_spec(&self, input: &FaceInput<'_>, piece: &Piece) -> SizeSpec {
        if piece.map.is_isometric() {
            match input.size {
                FaceSize::Uniform(h) => return SizeSpec::Uniform { h: h * piece.map.verdict.mean_scale },
                FaceSize::Vertices(list) => {
                    if let Some(h) = constant(list) {
                        return SizeSpec::Uniform { h: h * piece.map.verdict.mean_scale };
                    }
                }
                FaceSize::Boundary if self.sizes.is_empty() => return SizeSpec::Boundary,
                FaceSize::Boundary => {}
            }
        }
        let scale = scales(&piece.chart, &piece.map.flat);
        SizeSpec::Background {
            points: piece.map.flat.clone(),
            triangles: piece.chart.triangles.clone(),
            values: piece.chart.vertex.iter().zip(scale).map(|(&v, s)| s * self.sizes[v as usize]).collect(),
        }
    }

    /// Scars and points of a chart.
    fn add_interior(
        &self,
        input: &FaceInput<'_>,
        piece: &Piece,
        seams: &Seams,
        job: &mut Job,
        ids: &mut Vec<u32>,
        first: &mut Vec<Point2>,
    ) {
        if self.scars.is_empty() && input.points.is_empty() {
            return;
        }
        let c = &piece.chart;
        let mut local = vec![NONE; self.patch.points.len()];
        for (v, &g) in c.vertex.iter().enumerate() {
            local[g as usize] = v as u32;
        }
        let mut on_contour = vec![false; c.vertex.len()];
        c.loops.iter().flatten().for_each(|&h| on_contour[c.tail(h) as usize] = true);
        let mut seen = on_contour.clone();
        let mut in_chart = vec![false; self.patch.triangles.len()];
        c.facets.iter().for_each(|&t| in_chart[t as usize] = true);
        let mut note = |v: u32, ids: &mut Vec<u32>, first: &mut Vec<Point2>| {
            if !std::mem::replace(&mut seen[v as usize], true) {
                ids.push(seams.node_at[c.vertex[v as usize] as usize]);
                first.push(piece.map.flat[v as usize]);
            }
        };
        for s in &self.scars {
            let mut run: Vec<u32> = Vec::new();
            let mut flush = |run: &mut Vec<u32>| {
                if run.len() >= 2 {
                    run.iter().for_each(|&v| note(v, ids, first));
                    let nodes = run.iter().map(|&v| piece.map.flat[v as usize]).collect();
                    let name = format!("s{}", job.domain.scars.len());
                    job.domain.scars.push(Scar { name, nodes });
                }
                run.clear();
            };
            for w in s.windows(2) {
                // The side's own corners: of a vertex on a cut, the copy that the side touches.
                let ends = self.side(w[0], w[1]).and_then(|h| {
                    let h = [h, self.patch.twin[h as usize]]
                        .into_iter()
                        .find(|&h| h != NONE && in_chart[h as usize / 3])?;
                    let t = c.facets.binary_search(&(h / 3)).ok()?;
                    let (a, b) = (c.triangles[t][h as usize % 3], c.triangles[t][(h as usize % 3 + 1) % 3]);
                    Some(if c.vertex[a as usize] == w[0] { (a, b) } else { (b, a) })
                });
                let Some((a, b)) = ends else {
                    flush(&mut run);
                    continue;
                };
                let is_node = |v: u32| seams.node_at[c.vertex[v as usize] as usize] != NONE;
                if run.is_empty() && is_node(a) {
                    run.push(a);
                }
                if is_node(b) {
                    run.push(b);
                }
            }
            flush(&mut run);
        }
        for &p in input.points {
            let v = local[p as usize];
            if v == NONE || on_contour[v as usize] {
                continue;
            }
            note(v, ids, first);
            let name = format!("p{}", job.domain.points.len());
            job.domain.points.push(HardPoint { name, xy: piece.map.flat[v as usize], size: None });
        }
    }

    /// Conforming, and the boundary is the given segments.
    fn certify(&self, input: &FaceInput<'_>, sheet: &Sheet) -> Result<QuadTopology, FaceError> {
        let fail = |detail: String| Err(FaceError::Internal { stage: "certify", detail });
        if let Some(q) = sheet.quads.iter().find(|q| (0..4).any(|i| (0..i).any(|j| q[i] == q[j]))) {
            return fail(format!("quad {q:?} has a vertex twice"));
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

/// Thicknesses in lengths of the plane.
fn scaled(spec: &LayerSpec, scale: f64) -> LayerSpec {
    let law = match &spec.law {
        LayerLaw::Explicit(t) => LayerLaw::Explicit(t.iter().map(|t| t * scale).collect()),
        other => other.clone(),
    };
    LayerSpec { count: spec.count, law, first: spec.first.map(|t| t * scale) }
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
