//! All figures of one mesh.

use super::edges::HalfEdges;
use super::{Corners, SizeConformity, Structure, Tau, angles, aspect, shape, size, skew, space, structure};
use crate::QuadMesh;
use csalf_sizemap::{Hint, SizeField};
use serde::Serialize;
use std::fmt;

/// Quality of a mesh. Figures are over all elements; triangles take part in the scaled Jacobian, the angles
/// and the aspect ratio. Of a mesh without elements everything is 0 or `None`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct QualityReport {
    /// Number of vertices.
    pub n_vertices: usize,
    /// Number of quads.
    pub n_quads: usize,
    /// Number of triangles.
    pub n_triangles: usize,
    /// Smallest scaled Jacobian, -1 to 1.
    pub min_sj: f64,
    /// 1 % quantile of the scaled Jacobian (linear between ranks).
    pub p1_sj: f64,
    /// Mean scaled Jacobian.
    pub mean_sj: f64,
    /// Smallest interior angle, in degrees.
    pub min_angle: f64,
    /// Largest interior angle, in degrees.
    pub max_angle: f64,
    /// Mean aspect ratio, 1 or more.
    pub mean_aspect: f64,
    /// Largest aspect ratio.
    pub max_aspect: f64,
    /// Mean Verdict shape of the quads, 0 to 1.
    pub mean_shape: f64,
    /// Smallest Verdict shape of the quads.
    pub min_shape: f64,
    /// Mean skew of the quads, 0 to 1.
    pub mean_skew: f64,
    /// Largest skew of the quads.
    pub max_skew: f64,
    /// Largest warpage of the quads, of a mesh in space ([`super::space::warpage`]); `None` of a plane one.
    pub max_warpage: Option<f64>,
    /// Quads with a corner that is concave or flat ([`super::FLAT`]); they take no part in tau.
    pub n_nonpositive: usize,
    /// tau over all quads (harmonic mean of Jmin/Jmax); `None` of no quads.
    pub tau_global: Option<f64>,
    /// tau over the quads whose centre lies in the given circle.
    pub tau_local: Option<f64>,
    /// tau over the quads with a node on the boundary.
    pub tau_boundary: Option<f64>,
    /// Number of quads of `tau_local`.
    pub n_local: usize,
    /// Number of inner vertices.
    pub n_inner: usize,
    /// Of the inner vertices, those with other than four edges: how many.
    pub n_irregular: usize,
    /// Their share, 0 to 1; `None` if there is no inner vertex.
    pub irregular_share: Option<f64>,
    /// Most edges at an inner vertex.
    pub max_valence: u32,
    /// Edge lengths against the size field, over inner edges; `None` without a field or inner edges.
    pub size: Option<SizeConformity>,
    /// Sum of element area / h²: how many quads the field asks for (1 if a quad has exactly its size).
    pub expected_quads: Option<f64>,
    /// Rows and rings at the boundary; `None` if the boundary passes through a node twice.
    pub structure: Option<Structure>,
    /// Sum of the signed element areas; in space each is measured in its own plane, where it is positive.
    pub area: f64,
}

impl QualityReport {
    /// Measures `mesh`. With a size field its conformity too; with a circle `[x, y, radius]` the local tau.
    /// Vertex indices must be below the number of points. Cost O(n) and one size query per edge and element.
    pub fn new(mesh: &QuadMesh, size: Option<&dyn SizeField>, circle: Option<[f64; 3]>) -> Self {
        let edges = HalfEdges::new(mesh);
        let mut out = Self::counted(mesh, &edges);
        let sj = out.measure_shapes(mesh, mesh, &edges, circle);
        out.summarise(sj);
        if let Some(field) = size {
            out.size = size::conformity(&mesh.points, &edges, field);
            out.expected_quads = Some(expected_quads(mesh, field));
        }
        out.structure = structure::measure(mesh, &edges);
        out
    }

    /// Measures a mesh in space, seen from above with the heights of its vertices: each element in its mean plane.
    /// There are neither sizes nor rows at the boundary. Vertex indices must be below the number of points. Cost O(n).
    pub fn in_space(mesh: &QuadMesh, heights: &[f64]) -> Self {
        let edges = HalfEdges::new(mesh);
        let mut out = Self::counted(mesh, &edges);
        let mut sj = out.measure_shapes(mesh, &space::laid_flat(mesh, heights), &edges, None);
        let mut max_warpage = 0.0;
        for (q, sj) in mesh.quads.iter().zip(&mut sj) {
            let p = q.map(|v| space::place(mesh, heights, v));
            // The lengths are those in space.
            *sj = space::scaled_jacobian(p);
            max_warpage = f64::max(max_warpage, space::warpage(p));
        }
        out.summarise(sj);
        out.max_warpage = Some(max_warpage);
        out
    }

    /// What is counted without coordinates.
    fn counted(mesh: &QuadMesh, edges: &HalfEdges) -> Self {
        let mut out = Self {
            n_vertices: mesh.n_vertices(),
            n_quads: mesh.n_quads(),
            n_triangles: mesh.triangles.len(),
            ..Self::default()
        };
        out.measure_vertices(edges);
        out
    }

    /// Returns the scaled Jacobians. `flat`: the elements of `mesh` in the plane, each by itself.
    fn measure_shapes(
        &mut self,
        mesh: &QuadMesh,
        flat: &QuadMesh,
        edges: &HalfEdges,
        circle: Option<[f64; 3]>,
    ) -> Vec<f64> {
        let n = self.n_quads + self.n_triangles;
        if n == 0 {
            return Vec::new();
        }
        let mut sj = Vec::with_capacity(n);
        let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
        let (mut aspects, mut max_aspect) = (0.0, 0f64);
        let (mut shapes, mut min_shape, mut skews, mut max_skew) = (0.0, f64::INFINITY, 0.0, 0f64);
        let (mut global, mut local, mut boundary) = (Tau::default(), Tau::default(), Tau::default());
        for (q, own) in mesh.quads.iter().zip(&flat.quads) {
            let p = own.map(|v| flat.points[v.index()]);
            let c = Corners::new(&p);
            sj.push(c.min_scaled());
            let (a, b) = angles::min_max(&p);
            (lo, hi) = (lo.min(a), hi.max(b));
            let r = aspect::of_corners(&c);
            (aspects, max_aspect) = (aspects + r, max_aspect.max(r));
            let s = shape::of_corners(&c);
            (shapes, min_shape) = (shapes + s, min_shape.min(s));
            let s = skew::value(&p);
            (skews, max_skew) = (skews + s, max_skew.max(s));
            self.n_nonpositive += usize::from(c.is_flat());
            self.area += c.area;
            global.add(&c);
            if q.iter().any(|v| edges.on_boundary[v.index()]) {
                boundary.add(&c);
            }
            if let Some([x, y, radius]) = circle {
                let centre = 0.25 * (p[0] + p[1] + p[2] + p[3]);
                if centre.distance(csalf_geom::Point2::new(x, y)) <= radius {
                    self.n_local += 1;
                    local.add(&c);
                }
            }
        }
        for t in &flat.triangles {
            let p = t.map(|v| flat.points[v.index()]);
            let c = Corners::new(&p);
            sj.push(c.min_scaled() * 2.0 / 3f64.sqrt());
            let (a, b) = angles::min_max(&p);
            (lo, hi) = (lo.min(a), hi.max(b));
            let r = aspect::of_corners(&c);
            (aspects, max_aspect) = (aspects + r, max_aspect.max(r));
            self.area += c.area;
        }
        (self.min_angle, self.max_angle) = (lo, hi);
        (self.mean_aspect, self.max_aspect) = (aspects / n as f64, max_aspect);
        if self.n_quads > 0 {
            let m = self.n_quads as f64;
            (self.mean_shape, self.min_shape) = (shapes / m, min_shape);
            (self.mean_skew, self.max_skew) = (skews / m, max_skew);
        }
        (self.tau_global, self.tau_local, self.tau_boundary) = (global.mean(), local.mean(), boundary.mean());
        sj
    }

    /// The figures of the scaled Jacobians.
    fn summarise(&mut self, mut sj: Vec<f64>) {
        if sj.is_empty() {
            return;
        }
        self.mean_sj = sj.iter().sum::<f64>() / sj.len() as f64;
        self.p1_sj = quantile(&mut sj, 0.01);
        self.min_sj = sj.iter().copied().fold(f64::INFINITY, f64::min);
    }

    fn measure_vertices(&mut self, edges: &HalfEdges) {
        for v in 0..self.n_vertices as u32 {
            if edges.on_boundary[v as usize] || edges.n_elements_at(v) == 0 {
                continue;
            }
            let valence = edges.valence[v as usize];
            self.n_inner += 1;
            self.n_irregular += usize::from(valence != 4);
            self.max_valence = self.max_valence.max(valence);
        }
        if self.n_inner > 0 {
            self.irregular_share = Some(self.n_irregular as f64 / self.n_inner as f64);
        }
    }
}

/// The `share` quantile of `x`, linear between ranks. Reorders `x`, which must not be empty. Cost O(n).
fn quantile(x: &mut [f64], share: f64) -> f64 {
    let at = share * (x.len() - 1) as f64;
    let k = at as usize;
    let (_, &mut low, above) = x.select_nth_unstable_by(k, f64::total_cmp);
    let high = above.iter().copied().fold(f64::INFINITY, f64::min);
    if above.is_empty() { low } else { low + (at - k as f64) * (high - low) }
}

fn expected_quads(mesh: &QuadMesh, field: &dyn SizeField) -> f64 {
    let mut hint = Hint::default();
    let mut sum = 0.0;
    for q in &mesh.quads {
        let p = q.map(|v| mesh.points[v.index()]);
        let h = field.h(0.25 * (p[0] + p[1] + p[2] + p[3]), &mut hint);
        sum += 0.5 * (p[2] - p[0]).perp_dot(p[3] - p[1]) / (h * h);
    }
    for t in &mesh.triangles {
        let p = t.map(|v| mesh.points[v.index()]);
        let h = field.h((p[0] + p[1] + p[2]) / 3.0, &mut hint);
        sum += 0.5 * (p[1] - p[0]).perp_dot(p[2] - p[0]) / (h * h);
    }
    sum
}

impl fmt::Display for QualityReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let opt = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.4}"));
        writeln!(f, "vertices {}  quads {}  triangles {}", self.n_vertices, self.n_quads, self.n_triangles)?;
        writeln!(f, "                     worst      mean")?;
        writeln!(
            f,
            "scaled Jacobian   {:8.4}  {:8.4}   (1 % quantile {:.4})",
            self.min_sj, self.mean_sj, self.p1_sj
        )?;
        writeln!(f, "shape             {:8.4}  {:8.4}", self.min_shape, self.mean_shape)?;
        writeln!(f, "aspect ratio      {:8.3}  {:8.3}", self.max_aspect, self.mean_aspect)?;
        writeln!(f, "skew              {:8.4}  {:8.4}", self.max_skew, self.mean_skew)?;
        if let Some(warpage) = self.max_warpage {
            writeln!(f, "warpage           {warpage:8.4}")?;
        }
        writeln!(f, "angles            {:8.2} to {:.2} degrees", self.min_angle, self.max_angle)?;
        write!(f, "tau  global {}  boundary {}", opt(self.tau_global), opt(self.tau_boundary))?;
        writeln!(f, "  local {}   concave or flat quads {}", opt(self.tau_local), self.n_nonpositive)?;
        write!(f, "irregular vertices  {} of {} inner", self.n_irregular, self.n_inner)?;
        writeln!(f, " ({}), largest valence {}", opt(self.irregular_share), self.max_valence)?;
        if let Some(s) = &self.size {
            write!(
                f,
                "size  conforming {:.4}  rms log {:.4}  mean log {:+.4}",
                s.share, s.rms_log, s.mean_log
            )?;
            writeln!(
                f,
                "  ratios {:.3} to {:.3}  expected quads {}",
                s.min_ratio,
                s.max_ratio,
                opt(self.expected_quads)
            )?;
        }
        if let Some(s) = &self.structure {
            write!(f, "boundary  first row {:.4}  closed rings {:?}", s.row1_share, s.closed_rings_per_loop)?;
            writeln!(f, "  regular rings {:?}", s.rings_per_loop)?;
        }
        Ok(())
    }
}
