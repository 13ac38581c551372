//! What a person reads after a run.

use crate::timing::Seconds;
use csalf_core::{LoopReport, Meshed};
use std::fmt::Write;

/// Most loops listed one by one.
const MAX_LOOPS: usize = 8;

/// A few lines on what came out.
pub fn of_mesh(
    name: &str,
    meshed: &Meshed,
    seconds: Seconds,
    quality: &csalf_mesh::quality::QualityReport,
) -> String {
    let m = &meshed.mesh;
    let mut s = format!("{name}: {} quads", m.n_quads());
    if !m.triangles.is_empty() {
        let _ = write!(s, ", {} triangles", m.triangles.len());
    }
    let _ = write!(s, ", {} vertices in {:.3} s", m.n_vertices(), seconds.wall);
    let _ = write!(
        s,
        "\n  scaled Jacobian at least {:.3}, mean {:.3}; angles {:.0} to {:.0} degrees",
        quality.min_sj, quality.mean_sj, quality.min_angle, quality.max_angle
    );
    let irregular = quality.irregular_share.unwrap_or(0.0);
    let _ = write!(s, "\n  irregular vertices {:.1} %", 100.0 * irregular);
    if let Some(size) = &quality.size {
        let _ = write!(s, "; edges of the wanted size {:.1} %", 100.0 * size.share);
    }
    let layers = layers(&meshed.report.loops);
    if !layers.is_empty() {
        let _ = write!(s, "\n  layers: {layers}");
    }
    s
}

/// `hole0 2, outer 1 of 3 (fronts meet)`; loops without layers are left out.
fn layers(loops: &[LoopReport]) -> String {
    let with: Vec<&LoopReport> = loops.iter().filter(|l| l.asked > 0 || l.made > 0).collect();
    let mut parts: Vec<String> = with.iter().take(MAX_LOOPS).map(|l| one(l)).collect();
    if with.len() > MAX_LOOPS {
        let short = with.iter().filter(|l| l.made < l.asked).count();
        parts.push(format!("... ({} loops in all, {short} with fewer than asked)", with.len()));
    }
    parts.join(", ")
}

fn one(l: &LoopReport) -> String {
    let mut s = format!("{} {}", l.name, l.made);
    if l.made < l.asked {
        let _ = write!(s, " of {}", l.asked);
    }
    if !l.stopped.is_empty() {
        let _ = write!(s, " ({})", l.stopped);
    }
    s
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_tell_what_is_missing() {
        let l = |name: &str, asked, made, stopped: &str| LoopReport {
            name: name.into(),
            asked,
            made,
            stopped: stopped.into(),
            thickness_error: 0.0,
        };
        let loops = [l("outer", 0, 0, ""), l("hole0", 2, 2, ""), l("hole1", 5, 3, "fronts meet")];
        assert_eq!(layers(&loops), "hole0 2, hole1 3 of 5 (fronts meet)");
        let many: Vec<_> = (0..20).map(|i| l(&format!("h{i}"), 2, i % 3, "")).collect();
        assert!(layers(&many).ends_with("(20 loops in all, 14 with fewer than asked)"), "{}", layers(&many));
    }
}
