//! Draws a closure stencil: as text for people who hold the paper beside it, and as SVG.

use super::stencil::{Name, NamedQuad, Stencil};
use crate::Front;
use crate::place::{PavingRules, Site};
use csalf_geom::Point2;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

/// Where the nodes of a stencil lie and what joins them.
pub(crate) struct Plan {
    nodes: BTreeMap<Name, Point2>,
    quads: Vec<NamedQuad>,
    /// Sides of the loop: X-A, A-B, B-C.
    walk: [Name; 4],
}

/// Interior angle at which a front is drawn, in degrees; a reversal well open, so that two of them stay apart.
fn drawn_angle(f: Front) -> f64 {
    match f {
        Front::Acute => 40.0,
        Front::Right | Front::Obtuse => 90.0,
        Front::Flat => 180.0,
        Front::RightReversal => 270.0,
        Front::Reversal => 290.0,
    }
}

/// The finished stencil, AB horizontal, material above it.
pub(crate) fn plan(first: Front, last: Front, s: &Stencil) -> Plan {
    use Name::{A, B, C, P, P2, Q, Q2, R, R2, S, S2, T, T2, U, U2, X};
    let dir = |deg: f64| Point2::from_angle(deg.to_radians());
    let (a, b) = (Point2::ZERO, Point2::X);
    let x = a + dir(drawn_angle(last));
    let c = b + dir(180.0 - drawn_angle(first));
    let mut at: BTreeMap<Name, Point2> = [(X, x), (A, a), (B, b), (C, c)].into();
    at.insert(P, x + (a - x).perp());
    let (sa, sb) = (Site::new(x, a, b, 1.0), Site::new(a, b, c, 1.0));
    let mut put =
        |names: &[Name], points: &[Point2]| at.extend(names.iter().copied().zip(points.iter().copied()));
    match first {
        Front::Acute => {}
        Front::Right | Front::Obtuse => put(&[Q2], &[sb.corner()]),
        _ if last == Front::Acute => put(&[Q2], &[sb.start()]),
        Front::Flat => put(&[Q2], &[sb.flat()]),
        Front::RightReversal => put(&[R2, S2, Q2], &sb.right_reversal(PavingRules::Corrected)),
        Front::Reversal => put(&[R2, S2, T2, U2, Q2], &sb.reversal(PavingRules::Corrected)),
    }
    match last {
        Front::Acute => {}
        Front::Right | Front::Obtuse if s.peel || first == Front::Acute => {}
        Front::Right | Front::Obtuse => put(&[if first == Front::Flat { Q2 } else { R2 }], &[sa.corner()]),
        _ if first == Front::Acute => put(&[Q], &[sa.end()]),
        Front::Flat => put(&[Q], &[sa.flat()]),
        Front::RightReversal => put(&[R, S, Q], &sa.right_reversal(PavingRules::Corrected)),
        Front::Reversal => put(&[R, S, T, U, Q], &sa.reversal(PavingRules::Corrected)),
    }
    if first.is_corner() && at.contains_key(&Q) {
        at.insert(Q, sb.corner());
    }
    let mut quads: Vec<NamedQuad> = s.opening.iter().filter(|q| !s.withdraw.contains(q)).copied().collect();
    for (old, new) in &s.change {
        quads.iter_mut().filter(|q| *q == old).for_each(|q| *q = *new);
    }
    quads.extend(&s.create);
    let used: BTreeSet<Name> = quads.iter().flatten().copied().chain([X, A, B, C]).collect();
    let ray = (last == Front::Acute && !first.is_corner() && first != Front::Acute).then_some(Q2);
    at.retain(|v, _| (used.contains(v) || Some(*v) == ray) && *v != P2);
    Plan { nodes: at, quads, walk: [X, A, B, C] }
}

pub(crate) struct Drawing;

impl Drawing {
    /// Characters: `=` sides of the loop, `.` new sides.
    pub(crate) fn text(p: &Plan) -> String {
        const W: f64 = 14.0;
        const H: f64 = 6.0;
        let cell = |q: Point2| ((q.x * W).round() as i32, (-q.y * H).round() as i32);
        let cells: Vec<(i32, i32)> = p.nodes.values().map(|q| cell(*q)).collect();
        let (x0, x1) =
            (cells.iter().map(|c| c.0).min().unwrap_or(0), cells.iter().map(|c| c.0).max().unwrap_or(0));
        let (y0, y1) =
            (cells.iter().map(|c| c.1).min().unwrap_or(0), cells.iter().map(|c| c.1).max().unwrap_or(0));
        let mut grid = vec![vec![' '; (x1 - x0 + 4) as usize]; (y1 - y0 + 1) as usize];
        let mut line = |a: Point2, b: Point2, mark: char| {
            let (a, b) = (cell(a), cell(b));
            let steps = (a.0 - b.0).abs().max((a.1 - b.1).abs()).max(1);
            for k in 0..=steps {
                let f = |u: i32, v: i32| {
                    (f64::from(u) + f64::from(v - u) * f64::from(k) / f64::from(steps)).round() as i32
                };
                grid[(f(a.1, b.1) - y0) as usize][(f(a.0, b.0) - x0) as usize] = mark;
            }
        };
        for q in &p.quads {
            for k in 0..4 {
                line(p.nodes[&q[k]], p.nodes[&q[(k + 1) % 4]], '.');
            }
        }
        for w in p.walk.windows(2) {
            line(p.nodes[&w[0]], p.nodes[&w[1]], '=');
        }
        for (v, q) in &p.nodes {
            let (x, y) = cell(*q);
            for (k, ch) in v.text().chars().enumerate() {
                grid[(y - y0) as usize][(x - x0) as usize + k] = ch;
            }
        }
        let rows: Vec<String> = grid
            .iter()
            .map(|r| format!("   {}", r.iter().collect::<String>()).trim_end().to_string())
            .collect();
        rows.join("\n")
    }

    pub(crate) fn svg(p: &Plan) -> String {
        let s = 90.0;
        let (lo, hi) =
            csalf_geom::polygon::bounds(p.nodes.values().copied()).unwrap_or((Point2::ZERO, Point2::ONE));
        let at = |v: Name| {
            let q = p.nodes[&v];
            ((q.x - lo.x) * s + 30.0, (hi.y - q.y) * s + 30.0)
        };
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{:.0}\" height=\"{:.0}\" font-family=\"serif\" font-size=\"16\">\n",
            (hi.x - lo.x) * s + 70.0,
            (hi.y - lo.y) * s + 60.0
        );
        for q in &p.quads {
            let points: Vec<String> = q.iter().map(|&v| format!("{:.1},{:.1}", at(v).0, at(v).1)).collect();
            let _ = writeln!(
                out,
                "<polygon points=\"{}\" fill=\"#dce9f5\" stroke=\"#36648b\"/>",
                points.join(" ")
            );
        }
        let walk: Vec<String> = p.walk.iter().map(|&v| format!("{:.1},{:.1}", at(v).0, at(v).1)).collect();
        let _ = writeln!(
            out,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"black\" stroke-width=\"3\"/>",
            walk.join(" ")
        );
        for &v in p.nodes.keys() {
            let (x, y) = at(v);
            let _ = writeln!(out, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\"/>");
            let label = v.text().replace('"', "&#8243;");
            let _ = writeln!(out, "<text x=\"{:.1}\" y=\"{:.1}\">{label}</text>", x + 5.0, y - 5.0);
        }
        out.push_str("</svg>\n");
        out
    }
}
