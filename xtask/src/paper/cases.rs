//! The cases of the paper's experiments.

use csalf_core::Job;
use csalf_geom::{Domain, Point2};
use csalf_pave::{LayerLaw, LayerSpec};
use std::f64::consts::TAU;

/// One figure of the paper: its cases and the part of them that is drawn.
pub(super) struct Experiment {
    pub(super) title: &'static str,
    pub(super) about: &'static str,
    pub(super) jobs: Vec<Job>,
    /// Lower left and upper right corner of the pictures.
    pub(super) frame: [Point2; 2],
}

/// All of them, in the order of the paper.
pub(super) fn experiments() -> Vec<Experiment> {
    let laws = [
        ("fig4_ramp", LayerLaw::Ramp),
        ("fig4_parabola", LayerLaw::Parabolic),
        ("fig4_fibonacci", LayerLaw::Fibonacci),
    ];
    let square = |r: f64| [Point2::splat(-r), Point2::splat(r)];
    vec![
        Experiment {
            title: "Fig. 4: five layers around a hole",
            about: "Five layers by three laws, the first as thick as the segments of the hole. The pictures show \
                    the middle. (`tqm` makes no layers.)",
            jobs: laws
                .into_iter()
                .map(|(name, law)| {
                    let spec = LayerSpec { count: 5, law, first: None };
                    Job { layers: vec![("hole0".into(), spec)], ..plate(name, 64, 1.0) }
                })
                .collect(),
            frame: square(4.0),
        },
        Experiment {
            title: "Fig. 5: segments of the hole a tenth of those of the plate",
            about: "The paper reports tau_l 0.98 and tau_g 0.83 (TQM: 0.70 and 0.78), on a curved face.",
            jobs: vec![plate("fig5", 64, 1.0)],
            frame: square(6.0),
        },
        Experiment {
            title: "Fig. 5 with a fine hole",
            about: "320 segments round the hole. In `fig5_tenth` those of the plate are ten times as long, as in the \
                    figure, and the rings follow the size field. In `fig5_fine` the plate is that of Fig. 5: its \
                    sizes grow fifty-fold, far faster than square quads round a hole can, so 20 layers are asked \
                    for, as many as fill the local region. The pictures show the middle.",
            jobs: vec![
                plate("fig5_tenth", 320, 0.2),
                Job {
                    layers: vec![("hole0".into(), LayerSpec { count: 20, law: LayerLaw::Auto, first: None })],
                    ..plate("fig5_fine", 320, 1.0)
                },
            ],
            frame: square(1.5),
        },
        Experiment {
            title: "Fig. 6: a source face with four finely divided slots",
            about: "The pictures show a quarter of the face.",
            jobs: vec![slots()],
            frame: [Point2::new(0.0, 0.0), Point2::new(5.0, 5.0)],
        },
        Experiment {
            title: "Figs. 7 and 8: a freeform face with widely varying sizes",
            about: "Flat here. The paper reports tau_g 0.79 (TQM: 0.68). The pictures show the left part.",
            jobs: vec![freeform()],
            frame: [Point2::new(-16.0, -5.0), Point2::new(0.0, 5.0)],
        },
    ]
}

fn job(name: &str, domain: Domain, local_region: Option<[f64; 3]>) -> Job {
    Job { name: name.into(), domain, local_region, ..Job::default() }
}

/// Plate of side 12, in segments of `h`, with a hole of radius 1 and `n` segments around it.
fn plate(name: &str, n: usize, h: f64) -> Job {
    let outer = rectangle([-6.0, -6.0], [6.0, 6.0], h, false);
    job(name, Domain::new(outer).with_hole(circle(Point2::ZERO, 1.0, n)), Some([0.0, 0.0, 1.5]))
}

fn slots() -> Job {
    const H: f64 = 0.06;
    let mut domain = Domain::new(rectangle([0.0; 2], [10.0; 2], 1.0, false));
    for (lo, hi) in [
        ([1.5, 2.2], [4.5, 2.9]),
        ([5.5, 7.1], [8.5, 7.8]),
        ([7.1, 1.5], [7.8, 4.5]),
        ([2.2, 5.5], [2.9, 8.5]),
    ] {
        domain = domain.with_hole(rectangle(lo, hi, H, true));
    }
    job("fig6", domain, None)
}

/// A closed curve with six holes of various shapes and segment lengths.
fn freeform() -> Job {
    let outer = |t: f64| {
        let r = 10.0
            * (1.0 + 0.16 * (2.0 * t + 0.4).cos() + 0.11 * (3.0 * t - 1.1).cos() + 0.06 * (5.0 * t).sin());
        Point2::new(1.25 * r * t.cos(), 0.8 * r * t.sin())
    };
    let ellipse = |t: f64| Point2::new(5.0 + 1.6 * t.cos(), 0.5 - 0.9 * t.sin());
    let bean = |t: f64| {
        let x = (2.0 + 0.55 * (2.0 * t).cos()) * t.cos();
        Point2::new(x - 4.2, 1.6 - (1.2 - 0.5 * t.cos()) * t.sin())
    };
    let blob = |t: f64| {
        let r = 1.25 + 0.3 * (3.0 * t).cos();
        Point2::new(-0.4 + r * t.cos(), -2.6 - r * t.sin())
    };
    let domain = Domain::new(spaced(outer, 0, |_, s| 0.9 - 0.6 * (TAU * (s - 0.15)).cos().powi(2)))
        .with_hole(spaced(ellipse, 0, |p, _| if p.x > 5.0 { 0.26 } else { 0.16 }))
        .with_hole(spaced(bean, 0, |_, s| 0.10 + 0.35 * (0.5 * TAU * s).sin().abs()))
        .with_hole(spaced(blob, 0, |_, _| 0.25))
        .with_hole(circle(Point2::new(2.2, 3.6), 0.42, 44))
        .with_hole(circle(Point2::new(-7.4, -2.2), 0.5, 16))
        .with_hole(circle(Point2::new(8.4, -1.4), 0.30, 24));
    job("fig7", domain, None)
}

/// `n` nodes of a circle, clockwise.
fn circle(centre: Point2, r: f64, n: usize) -> Vec<Point2> {
    (0..n).map(|i| centre + Point2::from_angle(-TAU * i as f64 / n as f64) * r).collect()
}

/// Nodes of a rectangle at a distance of about `h`.
fn rectangle(lo: [f64; 2], hi: [f64; 2], h: f64, clockwise: bool) -> Vec<Point2> {
    let [x0, y0] = lo;
    let [x1, y1] = hi;
    let mut corners = [Point2::new(x0, y0), Point2::new(x1, y0), Point2::new(x1, y1), Point2::new(x0, y1)];
    if clockwise {
        corners.reverse();
    }
    let mut out = Vec::new();
    for k in 0..4 {
        let (a, b) = (corners[k], corners[(k + 1) % 4]);
        let n = (a.distance(b) / h).round().max(1.0) as usize;
        out.extend((0..n).map(|i| a.lerp(b, i as f64 / n as f64)));
    }
    out
}

/// Nodes along the closed `curve` (parameter 0 to 2π), as far apart as `size` says of a place and its share of the
/// length; their number has the given parity.
fn spaced(curve: impl Fn(f64) -> Point2, parity: usize, size: impl Fn(Point2, f64) -> f64) -> Vec<Point2> {
    const FINE: usize = 4000;
    let at: Vec<Point2> = (0..=FINE).map(|i| curve(TAU * i as f64 / FINE as f64)).collect();
    let length: f64 = at.windows(2).map(|w| w[0].distance(w[1])).sum();
    // Segments so far, as a real number.
    let mut count = vec![0.0; FINE + 1];
    let mut along = 0.0;
    for i in 0..FINE {
        let d = at[i].distance(at[i + 1]);
        count[i + 1] = count[i] + d / size(at[i].midpoint(at[i + 1]), (along + 0.5 * d) / length);
        along += d;
    }
    let total = count[FINE];
    let mut n = (total.round() as usize).max(4);
    n += (n + parity) % 2;
    (0..n)
        .map(|k| {
            let want = total * k as f64 / n as f64;
            let i = count.partition_point(|&c| c <= want).clamp(1, FINE) - 1;
            at[i].lerp(at[i + 1], (want - count[i]) / (count[i + 1] - count[i]))
        })
        .collect()
}
