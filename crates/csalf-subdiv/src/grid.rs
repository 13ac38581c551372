//! A uniform grid over the segments of a contour, for rays and visibility in large contours.

use crate::view::View;
use csalf_geom::Point2;

/// Overlap of neighbouring cells, in cells: rounding must not lose a segment that runs along their border.
const SLACK: f64 = 1e-6;
/// A view on one line is given this part of its diagonal as height, so that there are cells.
const THINNEST: f64 = 1e-6;

/// Segments of one contour hashed by cell. Rebuilt in place; cost O(n + cells).
#[derive(Debug, Default)]
pub(crate) struct SegmentGrid {
    low: Point2,
    cell: f64,
    nx: usize,
    ny: usize,
    start: Vec<u32>,
    items: Vec<u32>,
    fill: Vec<u32>,
}

impl SegmentGrid {
    pub(crate) fn build(&mut self, view: &View) {
        let n = view.len();
        let extent = (view.high - view.low).max(Point2::splat(view.diagonal() * THINNEST));
        // About two cells per segment.
        self.cell =
            (extent.x * extent.y / (2.0 * n as f64)).sqrt().max(extent.max_element() / (4.0 * n as f64));
        self.low = view.low;
        self.nx = (extent.x / self.cell) as usize + 1;
        self.ny = (extent.y / self.cell) as usize + 1;
        self.start.clear();
        self.start.resize(self.nx * self.ny + 1, 0);
        for i in 0..n {
            let (x0, x1, y0, y1) = self.cover(view.point[i], view.point[view.next(i)]);
            for y in y0..=y1 {
                for x in x0..=x1 {
                    self.start[y * self.nx + x + 1] += 1;
                }
            }
        }
        for c in 0..self.nx * self.ny {
            self.start[c + 1] += self.start[c];
        }
        self.items.clear();
        self.items.resize(self.start[self.nx * self.ny] as usize, 0);
        self.fill.clear();
        self.fill.extend_from_slice(&self.start);
        for i in 0..n {
            let (x0, x1, y0, y1) = self.cover(view.point[i], view.point[view.next(i)]);
            for y in y0..=y1 {
                for x in x0..=x1 {
                    let f = &mut self.fill[y * self.nx + x];
                    self.items[*f as usize] = i as u32;
                    *f += 1;
                }
            }
        }
    }

    fn column(&self, x: f64) -> usize {
        (((x - self.low.x) / self.cell).max(0.0) as usize).min(self.nx - 1)
    }
    fn row(&self, y: f64) -> usize {
        (((y - self.low.y) / self.cell).max(0.0) as usize).min(self.ny - 1)
    }
    /// Cells of the bounding box of a segment.
    fn cover(&self, a: Point2, b: Point2) -> (usize, usize, usize, usize) {
        let (lo, hi) = (a.min(b), a.max(b));
        (self.column(lo.x), self.column(hi.x), self.row(lo.y), self.row(hi.y))
    }

    /// Calls `visit` with every segment in the cells near the segment `ab` (some more than once), cell by cell
    /// from `a` on; stops when it returns true. Conservative: one ring of rounding is covered.
    pub(crate) fn along(&self, a: Point2, b: Point2, mut visit: impl FnMut(usize) -> bool) -> bool {
        let d = b - a;
        let steps_by_row = d.x.abs() >= d.y.abs();
        // March along the longer axis, one column (row) of cells at a time; cover the span of the other axis.
        let (from, to) =
            if steps_by_row { (self.column(a.x), self.column(b.x)) } else { (self.row(a.y), self.row(b.y)) };
        let forward = to >= from;
        let count = from.abs_diff(to);
        let slack = self.cell * SLACK;
        for s in 0..=count {
            let c = if forward { from + s } else { from - s };
            let (r0, r1) = if steps_by_row {
                let (x0, x1) = self.slab(c, self.low.x, a.x, b.x);
                let y = |x: f64| if d.x == 0.0 { a.y } else { a.y + d.y * ((x - a.x) / d.x) };
                let (y0, y1) = if d.x == 0.0 { (a.y, b.y) } else { (y(x0), y(x1)) };
                (self.row(y0.min(y1) - slack), self.row(y0.max(y1) + slack))
            } else {
                let (y0, y1) = self.slab(c, self.low.y, a.y, b.y);
                let x = |y: f64| a.x + d.x * ((y - a.y) / d.y);
                let (x0, x1) = (x(y0), x(y1));
                (self.column(x0.min(x1) - slack), self.column(x0.max(x1) + slack))
            };
            for r in r0..=r1 {
                let cell = if steps_by_row { r * self.nx + c } else { c * self.nx + r };
                for &i in &self.items[self.start[cell] as usize..self.start[cell + 1] as usize] {
                    if visit(i as usize) {
                        return true;
                    }
                }
            }
        }
        false
    }

    /// The part of [a, b] inside cell slab `c`, widened a little.
    fn slab(&self, c: usize, low: f64, a: f64, b: f64) -> (f64, f64) {
        let slack = self.cell * SLACK;
        let (lo, hi) = (a.min(b), a.max(b));
        let s0 = low + c as f64 * self.cell - slack;
        let s1 = s0 + self.cell + 2.0 * slack;
        (s0.clamp(lo, hi), s1.clamp(lo, hi))
    }

    /// First segment hit by the ray from occurrence `j` in direction `d` (unit), and the parameter along the ray.
    /// Segments at the occurrence's own point are ignored.
    pub(crate) fn shoot(&self, view: &View, j: usize, d: Point2) -> Option<(usize, f64)> {
        let a = view.point[j];
        // Clip the ray to the grid.
        let mut far = f64::INFINITY;
        for (p, v, lo, hi) in [(a.x, d.x, view.low.x, view.high.x), (a.y, d.y, view.low.y, view.high.y)] {
            if v > 0.0 {
                far = far.min((hi - p) / v);
            } else if v < 0.0 {
                far = far.min((lo - p) / v);
            }
        }
        if !far.is_finite() || far <= 0.0 {
            return None;
        }
        let mut best: Option<(usize, f64)> = None;
        // In pieces of growing length: most hits are near.
        let mut t0 = 0.0;
        let mut length = 4.0 * self.cell;
        while t0 < far {
            let t1 = (t0 + length).min(far);
            self.along(a + d * t0, a + d * t1, |i| {
                let (c, e) = (view.point[i], view.point[view.next(i)]);
                if c != a && e != a {
                    let u = e - c;
                    let den = d.perp_dot(u);
                    if den != 0.0 {
                        let t = (c - a).perp_dot(u) / den;
                        let s = (c - a).perp_dot(d) / den;
                        if t > 0.0 && (0.0..=1.0).contains(&s) && best.is_none_or(|b| t < b.1) {
                            best = Some((i, t));
                        }
                    }
                }
                false
            });
            if best.is_some_and(|b| b.1 <= t1) {
                return best;
            }
            t0 = t1;
            length *= 2.0;
        }
        best
    }
}
