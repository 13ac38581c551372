//! One chart: its contours, its planar job, and its mesh brought back into space.

use crate::curved::{Face, Piece};
use crate::face::{constant, mesh, of_planar_piece};
use crate::flatten::map::scales;
use crate::locate::{Anchor, Locator};
use crate::patch::{NONE, next};
use crate::seams::Seams;
use crate::sheet::{Ground, Sheet};
use crate::{FaceError, FaceInput, FaceMesh, FaceSize, LayerRing};
use csalf_core::{Job, Options};
use csalf_geom::{HardPoint, Loop, LoopKind, Point2, Scar};
use csalf_pave::{LayerLaw, LayerSpec};
use csalf_sizemap::SizeSpec;

/// One contour of a chart: mesh nodes and their flat places, the loop it follows alone.
struct Contour {
    nodes: Vec<u32>,
    flat: Vec<Point2>,
    loop_index: Option<usize>,
    /// Mean length in the plane over length in space.
    scale: f64,
}

impl Face {
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
    pub(crate) fn mesh_piece(
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
}

/// Thicknesses in lengths of the plane.
fn scaled(spec: &LayerSpec, scale: f64) -> LayerSpec {
    let law = match &spec.law {
        LayerLaw::Explicit(t) => LayerLaw::Explicit(t.iter().map(|t| t * scale).collect()),
        other => other.clone(),
    };
    LayerSpec { count: spec.count, law, first: spec.first.map(|t| t * scale) }
}
