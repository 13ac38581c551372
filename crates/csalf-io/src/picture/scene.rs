//! What is drawn: polygons by colour, lines, dots, the colour bar; in pixels, y downward.

use super::Shade;
use super::layout::{Layout, check};
use crate::{IoError, MeshView};
use csalf_geom::VertexId;
use csalf_mesh::{QuadTopology, quality::scaled_jacobian};

/// Red, green, blue.
pub(super) type Rgb = [u8; 3];

/// Steps of colour: quads of one step are one path.
pub(super) const STEPS: usize = 25;
/// Space around the mesh, and between mesh and bar.
pub(super) const MARGIN: f64 = 24.0;
/// Width of the colour bar with its labels.
pub(super) const BAR_WIDTH: f64 = 56.0;
/// A picture is at least so high, for the bar.
pub(super) const MIN_HEIGHT: f64 = 160.0;

/// Colours at scaled Jacobian 0, 0.5, 0.8 and 1.
const PLAIN: [Rgb; 4] = [[222, 120, 40], [244, 224, 130], [190, 224, 170], [128, 200, 160]];
/// The same in sets of even and odd number.
const SET: [[Rgb; 4]; 2] = [
    [[222, 120, 40], [230, 220, 180], [170, 200, 230], [140, 180, 230]],
    [[222, 120, 40], [230, 210, 170], [140, 170, 215], [100, 145, 210]],
];
const STOPS: [f64; 4] = [0.0, 0.5, 0.8, 1.0];
const BAD: Rgb = [220, 20, 20];
const TRIANGLE: Rgb = [190, 190, 200];

/// A polygon of three or four corners; a triangle repeats its last corner.
pub(super) type Corners = [[f64; 2]; 4];

/// Polygons of one colour, drawn together, and thick lines over them.
#[derive(Debug)]
pub(super) struct Fill {
    pub colour: Rgb,
    pub polygons: Vec<Corners>,
    pub lines: Vec<[[f64; 2]; 2]>,
}

/// Everything in a picture.
#[derive(Debug, Default)]
pub(super) struct Scene {
    pub width: f64,
    pub height: f64,
    /// Polygons in the order in which they are drawn.
    pub fills: Vec<Fill>,
    /// Width of the lines between quads; 0: none.
    pub line_width: f64,
    /// Boundary and edge sets, drawn over all polygons.
    pub outline: Vec<[[f64; 2]; 2]>,
    pub outline_width: f64,
    pub dots: Vec<[f64; 2]>,
    pub dot_radius: f64,
    /// Colour bar: boxes (x, y, width, height) and their colours.
    pub bar: Vec<([f64; 4], Rgb)>,
    /// Labels of the bar: left end, middle of the line.
    pub labels: Vec<([f64; 2], String)>,
}

fn colour(stops: &[Rgb; 4], sj: f64) -> Rgb {
    let k = STOPS[1..3].iter().filter(|&&s| sj >= s).count();
    let t = ((sj - STOPS[k]) / (STOPS[k + 1] - STOPS[k])).clamp(0.0, 1.0);
    std::array::from_fn(|c| {
        let (a, b) = (f64::from(stops[k][c]), f64::from(stops[k + 1][c]));
        (a + t * (b - a)).round() as u8
    })
}

/// Index of the colour of a quad: 0 bad, then `STEPS` of each of the three ranges, then triangles.
pub(super) fn bin(sj: f64, range: usize) -> usize {
    if sj.is_nan() || sj <= 0.0 {
        0
    } else {
        1 + range * STEPS + ((sj * STEPS as f64) as usize).min(STEPS - 1)
    }
}

pub(super) fn colour_of_bin(bin: usize) -> Rgb {
    let middle = |k: usize| (k as f64 + 0.5) / STEPS as f64;
    match bin.checked_sub(1) {
        None => BAD,
        Some(k) => match (k / STEPS, k % STEPS) {
            (0, k) => colour(&PLAIN, middle(k)),
            (r @ (1 | 2), k) => colour(&SET[r - 1], middle(k)),
            _ => TRIANGLE,
        },
    }
}

/// Index of the colour of a value between the limits; one that is no number is grey.
pub(super) fn bin_of(value: f64, shade: &Shade<'_>) -> usize {
    let [worst, best] = shade.limits;
    let t = (value - worst) / (best - worst);
    if t.is_nan() { 1 + 3 * STEPS } else { 1 + ((t.clamp(0.0, 1.0) * STEPS as f64) as usize).min(STEPS - 1) }
}

/// A number of three digits, as short as it can be.
fn short(x: f64) -> String {
    let digits = if x == 0.0 { 0 } else { (2 - x.abs().log10().floor() as i32).clamp(0, 9) as usize };
    let text = format!("{x:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

impl Scene {
    /// Lays a mesh out, coloured by the scaled Jacobian or by `shade`.
    pub(super) fn new(out: &MeshView<'_>, shade: Option<&Shade<'_>>) -> Result<Self, IoError> {
        check(out, shade)?;
        if !out.heights.is_empty() {
            return super::space::scene(out, shade);
        }
        let (mesh, sets) = (out.mesh, out.sets);
        let n = mesh.points.len();
        let layout = Layout::new(mesh.points.iter().copied(), mesh.quads.len())?;
        let at = |v: VertexId| layout.pixel(mesh.points[v.index()]);

        let mut range = vec![0u8; mesh.quads.len()];
        for (k, (_, quads)) in sets.quads.iter().enumerate() {
            for q in quads.iter().filter(|q| q.index() < mesh.quads.len()) {
                range[q.index()] = 1 + (k % 2) as u8;
            }
        }
        let mut bins: Vec<Vec<Corners>> = vec![Vec::new(); 2 + 3 * STEPS];
        let mut drawn = 0.0;
        for (k, (q, &r)) in mesh.quads.iter().zip(&range).enumerate() {
            let p = q.map(|v| mesh.points[v.index()]);
            let bin = match shade {
                Some(s) => bin_of(s.values[k], s),
                None => bin(scaled_jacobian::value(&p), r.into()),
            };
            bins[bin].push(q.map(at));
            drawn += p[0].distance(p[1]) * layout.scale;
        }
        for (k, t) in mesh.triangles.iter().enumerate() {
            let bin = shade.map_or(1 + 3 * STEPS, |s| bin_of(s.values[mesh.quads.len() + k], s));
            bins[bin].push([at(t[0]), at(t[1]), at(t[2]), at(t[2])]);
        }
        let fills = bins.into_iter().enumerate().filter(|b| !b.1.is_empty());
        let fill = |(k, polygons)| Fill { colour: colour_of_bin(k), polygons, lines: Vec::new() };
        let fills = fills.map(fill).collect();

        let topology = QuadTopology::new(n, &mesh.quads);
        let open = (0..4 * mesh.quads.len()).filter(|&h| topology.twin[h] == QuadTopology::NONE);
        let mut outline: Vec<[[f64; 2]; 2]> = if mesh.triangles.is_empty() {
            open.map(|h| [at(mesh.quads[h / 4][h % 4]), at(mesh.quads[h / 4][(h + 1) % 4])]).collect()
        } else {
            Vec::new() // Quads beside triangles have no twin there: only the edge sets tell the boundary.
        };
        let edges = sets.edges.iter().flat_map(|(_, e)| e);
        outline.extend(edges.filter(|e| e.iter().all(|v| v.index() < n)).map(|e| e.map(at)));
        let mean = drawn / mesh.quads.len().max(1) as f64;
        let dots = if layout.many { Vec::new() } else { topology.irregular().into_iter().map(at).collect() };

        Ok(Self {
            outline,
            outline_width: if layout.many { 1.0 } else { 1.6 },
            dots,
            dot_radius: (mean / 6.0).clamp(1.0, 3.5),
            ..layout.scene(fills, mean, shade)
        })
    }

    pub(super) fn add_bar(&mut self, x: f64, height: f64, shade: Option<&Shade<'_>>) {
        let (h, w) = ((height * 0.6).min(320.0), 14.0);
        let top = MARGIN + 0.5 * (height - h);
        let step = h / STEPS as f64;
        for k in 0..STEPS {
            let y = top + (STEPS - 1 - k) as f64 * step;
            self.bar.push(([x, y, w, step], colour_of_bin(bin((k as f64 + 0.5) / STEPS as f64, 0))));
        }
        if shade.is_none() {
            self.bar.push(([x, top + h, w, step], BAD));
        }
        let [low, high] = shade.map_or([0.0, 1.0], |s| s.limits);
        for share in [1.0, 0.75, 0.5, 0.25, 0.0] {
            self.labels.push(([x + w + 4.0, top + h * (1.0 - share)], short(low + share * (high - low))));
        }
    }
}
