//! Values carried from some vertices to all others: the harmonic function on the facets.

use super::map::gradients;
use super::sparse::{Order, Symmetric};
use crate::patch::{NONE, Patch};

/// Fills the NaN entries of `values` harmonically from the others. Vertices that no facet uses, or all of
/// them if the system cannot be solved, get the mean. Cost: one sparse solve.
pub(crate) fn extend(patch: &Patch, values: &mut [f64]) {
    let known: Vec<f64> = values.iter().copied().filter(|x| !x.is_nan()).collect();
    if known.len() == values.len() {
        return;
    }
    let mean = if known.is_empty() { 0.0 } else { known.iter().sum::<f64>() / known.len() as f64 };
    if !known.is_empty() {
        solve(patch, values);
    }
    values.iter_mut().filter(|x| !x.is_finite()).for_each(|x| *x = mean);
}

fn solve(patch: &Patch, values: &mut [f64]) -> Option<()> {
    let order = Order::new(&patch.points, &patch.triangles);
    let mut used = vec![false; values.len()];
    patch.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
    let mut by_rank = vec![NONE; values.len()];
    for (v, &r) in order.rank.iter().enumerate() {
        by_rank[r as usize] = v as u32;
    }
    let mut index = vec![NONE; values.len()];
    let mut n = 0;
    for &v in &by_rank {
        if used[v as usize] && values[v as usize].is_nan() {
            index[v as usize] = n;
            n += 1;
        }
    }
    let mut matrix = Symmetric::new(n as usize);
    let mut rhs = vec![0f64; n as usize];
    for t in &patch.triangles {
        let (g, area) = gradients(t.map(|v| patch.points[v as usize]));
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            // Positive weights keep every value between the given ones.
            let w = (-area * g[k].dot(g[(k + 1) % 3])).max(0.02);
            let (i, j) = (index[a as usize], index[b as usize]);
            for (x, other) in [(i, b), (j, a)] {
                if x != NONE {
                    matrix.add(x, x, w);
                    if index[other as usize] == NONE {
                        rhs[x as usize] += w * values[other as usize];
                    }
                }
            }
            if i != NONE && j != NONE {
                matrix.add(i, j, -w);
            }
        }
    }
    matrix.factor()?.solve(&mut rhs);
    for (v, &i) in index.iter().enumerate() {
        if i != NONE {
            values[v] = rhs[i as usize];
        }
    }
    Some(())
}
