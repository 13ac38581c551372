//! Wanted lengths in space, per facet vertex.

use crate::flatten::extend;
use crate::patch::Patch;
use crate::{FaceInput, FaceSize};
use csalf_core::Options;

/// Quads that a closed surface without any size gets, about.
const DEFAULT_QUADS: f64 = 600.0;

/// Wanted length per vertex, in space, limited to the gradation that is asked for.
pub(crate) fn sizes(input: &FaceInput<'_>, options: &Options, patch: &Patch) -> Vec<f64> {
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
