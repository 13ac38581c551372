//! How a [`Background`] is made: points merged and scaled, triangulated, told inside from outside, put in order.

use super::{Background, Node, Triangle};
use crate::SizeError;
use crate::error::check_size;
use crate::triangulate::{self, NONE, Triangulation};
use csalf_geom::{Point2, polygon::bounds, predicates::orient2d};
use rstar::RTree;
use rstar::primitives::GeomWithData;
use std::sync::OnceLock;

/// Grid cells per triangle. More: shorter walks, more memory (4 bytes each) and time to fill them.
const CELLS_PER_TRIANGLE: usize = 2;
/// Of few triangles, which are those of a boundary and large, up to this many cells.
const FEW_CELLS: usize = 1 << 14;
/// But not more than these per triangle.
const MOST_CELLS_PER_TRIANGLE: usize = 8;

impl Background {
    /// Constrained Delaunay triangulation of `points` with `values`; `loops` are closed lists of point indices
    /// (either orientation) that bound the domain: the field is linear inside and takes the nearest boundary
    /// value outside. Equal points become one, with the smallest of their values. O(n log n).
    ///
    /// # Errors
    /// [`SizeError`] of a bad point, a bad value, an index out of range, or a domain without area.
    pub fn from_points(points: &[Point2], values: &[f64], loops: &[Vec<u32>]) -> Result<Self, SizeError> {
        let sides = loops
            .iter()
            .enumerate()
            .flat_map(|(k, l)| (0..l.len()).map(move |i| (k, [l[i], l[(i + 1) % l.len()]])));
        let Prepared { scale, points: distinct, values, name } = prepare(points, values, "background node")?;
        let sides = sides
            .map(|(k, s)| rename(s, &name).map_err(|node| bad(k, node, points.len())))
            .collect::<Result<Vec<_>, _>>()?;
        let t = triangulate::triangulate(&distinct, &sides)?;
        let inside = triangulate::inside_loops(&t);
        Self::assemble(scale, &distinct, &values, &t, &inside)
    }

    /// The field of a triangulation of the caller's: exactly its triangles, whatever their orientation. A broken
    /// one is repaired: where triangles overlap or nodes hang on sides, the points are triangulated again with as
    /// many of the sides as do not cross. Equal points become one, with the smallest of their values. Nodes of no
    /// triangle take no part. O(n log n).
    ///
    /// # Errors
    /// [`SizeError`] of a bad point, a bad value, an index out of range, or no triangle of positive area.
    pub fn from_triangles(
        points: &[Point2],
        triangles: &[[u32; 3]],
        values: &[f64],
    ) -> Result<Self, SizeError> {
        let Prepared { scale, points: mut distinct, mut values, name } =
            prepare(points, values, "background node")?;
        let mut wanted = Vec::with_capacity(triangles.len());
        for (k, t) in triangles.iter().enumerate() {
            wanted.push(rename(*t, &name).map_err(|node| bad(k, node, points.len()))?);
        }
        wanted.retain(|&[a, b, c]| orient2d(at(&distinct, a), at(&distinct, b), at(&distinct, c)) != 0.0);
        // Only nodes in use, renumbered.
        let mut new = vec![NONE; distinct.len()];
        wanted.iter().flatten().for_each(|&v| new[v as usize] = 0);
        let mut n = 0;
        for (old, v) in new.iter_mut().enumerate() {
            if *v == 0 {
                (distinct[n], values[n], *v) = (distinct[old], values[old], n as u32);
                n += 1;
            }
        }
        distinct.truncate(n);
        values.truncate(n);
        wanted.iter_mut().flatten().for_each(|v| *v = new[*v as usize]);

        let mut sides: Vec<[u32; 2]> = wanted
            .iter()
            .flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]])
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        sides.sort_unstable();
        sides.dedup();
        let t = triangulate::triangulate(&distinct, &sides)?;
        let inside = covered(&t, &wanted, &distinct);
        Self::assemble(scale, &distinct, &values, &t, &inside)
    }

    fn assemble(
        scale: f64,
        points: &[Point2],
        values: &[f64],
        t: &Triangulation,
        inside: &[bool],
    ) -> Result<Self, SizeError> {
        let Some((low, high)) = bounds(points.iter().copied()) else { return Err(SizeError::NoArea) };
        let n = t.corners.len();
        let n_inside = inside.iter().filter(|&&i| i).count();
        if n_inside == 0 {
            return Err(SizeError::NoArea);
        }
        let order = spatial_order(t, inside, points, low, high);
        let mut new = vec![0u32; n];
        for (k, &old) in order.iter().enumerate() {
            new[old as usize] = k as u32;
        }
        let triangles: Vec<_> = order
            .iter()
            .map(|&old| Triangle {
                p: t.corners[old as usize].map(|v| at(points, v)),
                corners: t.corners[old as usize],
                across: t.across[old as usize].map(|j| if j == NONE { NONE } else { new[j as usize] }),
            })
            .collect();
        let nodes: Vec<_> = points.iter().zip(values).map(|(&p, &h)| Node { p, h }).collect();
        let size = high - low;
        let few = FEW_CELLS.min(MOST_CELLS_PER_TRIANGLE * n);
        let wanted = (CELLS_PER_TRIANGLE * n).max(few).clamp(16, 1 << 22) as f64;
        let cell = (size.x * size.y / wanted).sqrt().max(size.max_element() / 4096.0);
        let count = |l: f64| ((l / cell).ceil().clamp(1.0, 4096.0)) as u32;
        let (columns, rows) = (count(size.x), count(size.y));
        let mut out = Self {
            nodes,
            triangles,
            n_inside: n_inside as u32,
            scale,
            low,
            high,
            range: (0.0, 0.0),
            cells: OnceLock::new(),
            columns,
            rows,
            per_unit: Point2::splat(1.0 / cell),
            centroids: OnceLock::new(),
            rim: OnceLock::new(),
        };
        out.settle();
        Ok(out)
    }

    /// See the field; filled by [`Self::starts`].
    pub(super) fn cells(&self) -> &[u32] {
        self.cells.get_or_init(|| self.starts())
    }

    /// The owner of the centre of each cell, but for rounding; of cells off the hull that of one nearby. Each triangle
    /// fills the stretches of cells that it covers, row by row. Cost: the cells, and the triangles with the rows of
    /// each.
    fn starts(&self) -> Vec<u32> {
        let (columns, rows) = (self.columns as usize, self.rows as usize);
        let mut cells = vec![NONE; columns * rows];
        for (t, triangle) in (0..).zip(&self.triangles) {
            // In cells, from the first centre on.
            let p = triangle.p.map(|p| (p - self.low) * self.per_unit - Point2::splat(0.5));
            let ys = p.map(|p| p.y);
            let (bottom, top) = (ys[0].min(ys[1]).min(ys[2]), ys[0].max(ys[1]).max(ys[2]));
            let after = ((top.floor() + 1.0).max(0.0) as usize).min(rows);
            for j in bottom.ceil().max(0.0) as usize..after {
                let y = j as f64;
                let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
                for k in 0..3 {
                    let (a, b) = (p[k], p[(k + 1) % 3]);
                    if (a.y <= y) != (b.y <= y) {
                        let x = a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x);
                        (left, right) = (left.min(x), right.max(x));
                    }
                }
                let (from, to) = (left.ceil().max(0.0), right.floor().min(columns as f64 - 1.0));
                if from <= to {
                    cells[j * columns + from as usize..=j * columns + to as usize].fill(t);
                }
            }
        }
        // What is off the hull: as the cell before, or the row before.
        let mut last = 0;
        for cell in &mut cells {
            if *cell == NONE {
                *cell = last;
            }
            last = *cell;
        }
        cells
    }

    /// Sets all that follows from the values: the range, and the values of nodes outside the domain (of no
    /// triangle in it), which are those that any point outside gets.
    pub(super) fn settle(&mut self) {
        let mut used = vec![false; self.nodes.len()];
        let mut range = (f64::INFINITY, 0.0f64);
        for v in self.triangles[..self.n_inside as usize].iter().flat_map(|t| t.corners) {
            used[v as usize] = true;
            let h = self.nodes[v as usize].h;
            range = (range.0.min(h), range.1.max(h));
        }
        self.range = range;
        for v in (0..used.len()).filter(|&v| !used[v]) {
            self.nodes[v].h = self.outside(self.nodes[v].p);
        }
    }
}

fn at(points: &[Point2], i: u32) -> Point2 {
    points[i as usize]
}

fn bad(triangle: usize, node: u32, n_points: usize) -> SizeError {
    SizeError::BadTriangle { triangle, node, n_points }
}

/// New names of some points; the first that does not exist as error.
fn rename<const N: usize>(list: [u32; N], name: &[u32]) -> Result<[u32; N], u32> {
    match list.iter().find(|&&v| v as usize >= name.len()) {
        Some(&v) => Err(v),
        None => Ok(list.map(|v| name[v as usize])),
    }
}

/// Distinct nodes.
struct Prepared {
    /// Power of two that the points are multiplied by.
    scale: f64,
    /// Distinct scaled points, in order of first occurrence.
    points: Vec<Point2>,
    /// Their values.
    values: Vec<f64>,
    /// Per point of the caller, which distinct one it is.
    name: Vec<u32>,
}

/// Checks points and values, scales the points and merges equal ones.
fn prepare(points: &[Point2], values: &[f64], what: &'static str) -> Result<Prepared, SizeError> {
    if points.len() != values.len() {
        return Err(SizeError::Lengths { n_points: points.len(), n_values: values.len() });
    }
    // A hull of n nodes has up to 2 n triangles.
    if points.len() > NONE as usize / 2 - 1 {
        return Err(SizeError::TooMany(points.len()));
    }
    if let Some(index) = points.iter().position(|p| !p.is_finite()) {
        return Err(SizeError::BadPoint { what, index });
    }
    for (i, &h) in values.iter().enumerate() {
        check_size(what, i, h)?;
    }
    let scale = triangulate::scale_of(points);
    let scaled: Vec<_> = points.iter().map(|&p| triangulate::normalised(p, scale)).collect();
    let (name, first) = triangulate::merge(&scaled);
    let distinct: Vec<_> = first.iter().map(|&i| scaled[i as usize]).collect();
    let mut merged = vec![f64::INFINITY; distinct.len()];
    for (i, &h) in values.iter().enumerate() {
        let m = &mut merged[name[i] as usize];
        *m = m.min(h);
    }
    Ok(Prepared { scale, points: distinct, values: merged, name })
}

/// Which triangles of `t` are wanted ones, or parts of them (their centroid lies in one).
fn covered(t: &Triangulation, wanted: &[[u32; 3]], points: &[Point2]) -> Vec<bool> {
    let key = |c: &[u32; 3]| {
        let mut c = *c;
        c.sort_unstable();
        c
    };
    let mut sorted: Vec<_> = wanted.iter().map(key).collect();
    sorted.sort_unstable();
    let mut inside: Vec<_> = t.corners.iter().map(|c| sorted.binary_search(&key(c)).is_ok()).collect();
    // Of a valid triangulation, all of it is there now.
    sorted.dedup();
    if inside.iter().filter(|&&i| i).count() == sorted.len() {
        return inside;
    }
    let boxes = wanted.iter().map(|w| {
        let [a, b, c] = w.map(|v| at(points, v));
        let (lo, hi) = (a.min(b).min(c), a.max(b).max(c));
        GeomWithData::new(rstar::primitives::Rectangle::from_corners(lo.to_array(), hi.to_array()), *w)
    });
    let tree = RTree::bulk_load(boxes.collect());
    for (i, c) in t.corners.iter().enumerate().filter(|(i, _)| !inside[*i]).collect::<Vec<_>>() {
        let m = c.iter().map(|&v| at(points, v)).sum::<Point2>() / 3.0;
        inside[i] = tree.locate_all_at_point([m.x, m.y]).any(|r| {
            let [a, b, c] = r.data.map(|v| at(points, v));
            let o = [orient2d(a, b, m), orient2d(b, c, m), orient2d(c, a, m)];
            o.iter().all(|&o| o >= 0.0) || o.iter().all(|&o| o <= 0.0)
        });
    }
    inside
}

/// Triangles of the domain first, each group along a Morton curve: neighbours in the plane are neighbours in
/// memory.
fn spatial_order(
    t: &Triangulation,
    inside: &[bool],
    points: &[Point2],
    low: Point2,
    high: Point2,
) -> Vec<u32> {
    let to_cell = 65535.0 / (high - low).max_element();
    let spread = |x: f64| {
        let mut v = x as u32 & 0xffff;
        v = (v | v << 8) & 0x00ff_00ff;
        v = (v | v << 4) & 0x0f0f_0f0f;
        v = (v | v << 2) & 0x3333_3333;
        (v | v << 1) & 0x5555_5555
    };
    let mut keys: Vec<(bool, u32, u32)> = (0..t.corners.len())
        .map(|i| {
            let m = t.corners[i].iter().map(|&v| at(points, v)).sum::<Point2>() / 3.0;
            let u = (m - low) * to_cell;
            (!inside[i], spread(u.x) | spread(u.y) << 1, i as u32)
        })
        .collect();
    keys.sort_unstable();
    keys.into_iter().map(|k| k.2).collect()
}
