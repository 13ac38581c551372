//! Orientation and nesting of loops, and what lies outside: the second half of the checks.

use super::{Checker, Kind, MAX_COORDINATE};
use crate::boxtree::{Aabb, BoxTree};
use crate::cone::in_cone;
use crate::predicates::orient2d;
use crate::{Defect, Place, Point2};

impl Checker<'_> {
    fn is_loop(&self, c: usize) -> bool {
        self.curves[c].kind != Kind::Scar
    }

    /// Finds loops without area and the way round of the others, by the exact turn at the leftmost node.
    fn find_loop(&mut self, c: usize) {
        let slots = self.curves[c].slots.clone();
        let p = &self.slots[slots];
        let (Some(&a), n) = (p.first(), p.len()) else { return };
        let far = p.iter().fold(a, |b, &q| if q.distance(a) > b.distance(a) { q } else { b });
        let (axis, merge) = (far - a, self.tolerance.merge());
        let width = |q: &Point2| axis.perp_dot(*q - a).abs() / axis.length();
        if far == a || p.iter().all(|q| width(q) <= merge || orient2d(a, far, *q) == 0.0) {
            self.defects.push(Defect::ZeroArea { name: self.curves[c].name.into() });
            (self.curves[c].simple, self.curves[c].flat) = (false, true);
            return;
        }
        let lowest = (0..n).min_by(|&i, &j| p[i].x.total_cmp(&p[j].x).then(p[i].y.total_cmp(&p[j].y)));
        let Some(i) = lowest else { return };
        let ccw = orient2d(p[(i + n - 1) % n], p[i], p[(i + 1) % n]) > 0.0;
        self.curves[c].reversed = ccw != (self.curves[c].kind == Kind::Outer);
    }

    /// [`Self::find_loop`] for all loops.
    pub(super) fn find_orientation(&mut self) {
        for c in 0..self.domain.loops.len() {
            self.find_loop(c);
        }
    }

    /// The simple loops that contain `q`, which is on none of them, in increasing order; exact.
    fn loops_around(&self, q: Point2, out: &mut Vec<usize>) {
        out.clear();
        let ray = Aabb { lo: Point2::new(f64::NEG_INFINITY, q.y), hi: q };
        self.tree.window(ray, &mut |s| {
            let [i, j] = self.segments[s as usize];
            if (i as usize) < self.n_loop_slots
                && is_left_of(self.slots[i as usize], self.slots[j as usize], q)
            {
                out.push(self.curve_of[i as usize] as usize);
            }
        });
        // Odd numbers of crossings remain.
        out.sort_unstable();
        let mut kept = 0;
        for k in 0..out.len() {
            if kept > 0 && out[kept - 1] == out[k] {
                kept -= 1;
            } else {
                out[kept] = out[k];
                kept += 1;
            }
        }
        out.truncate(kept);
        out.retain(|&c| self.curves[c].simple);
    }

    /// True if `q` is inside the outer loop and in no hole, as far as these are known.
    fn is_inside(&self, q: Point2, around: &mut Vec<usize>) -> bool {
        self.loops_around(q, around);
        let known = |c: &usize| self.curves[*c].kind == Kind::Outer && self.curves[*c].simple;
        let needed = (0..self.domain.loops.len()).find(known);
        needed.is_none_or(|c| around.contains(&c))
            && around.iter().all(|&c| self.curves[c].kind == Kind::Outer)
    }

    /// Every hole must lie in the outer loop and in no other hole.
    pub(super) fn check_nesting(&mut self) {
        let outers: Vec<_> =
            (0..self.domain.loops.len()).filter(|&c| self.curves[c].kind == Kind::Outer).collect();
        let (mut around, mut found) = (Vec::new(), Vec::new());
        for c in 0..self.domain.loops.len() {
            let curve = &self.curves[c];
            if !curve.simple || curve.slots.is_empty() {
                continue;
            }
            self.loops_around(self.slots[curve.slots.start], &mut around);
            if let ([outer], Kind::Hole) = (outers.as_slice(), curve.kind) {
                let known = self.curves[*outer].simple && !self.are_entangled(c, *outer);
                if known && !around.contains(outer) && !self.surrounds(c, *outer) {
                    found.push(Defect::Outside { at: self.place(curve.slots.start) });
                }
            }
            for &d in around.iter().filter(|&&d| d != c && !self.are_entangled(c, d)) {
                let name = || self.curves[d].name.to_owned();
                match (curve.kind, self.curves[d].kind) {
                    (Kind::Hole, Kind::Hole) => {
                        found
                            .push(Defect::HoleInHole { inner: self.place(curve.slots.start), outer: name() });
                    }
                    (Kind::Outer, Kind::Hole) => {
                        found.push(Defect::HoleAroundOuter { hole: name(), outer: curve.name.into() });
                    }
                    _ => {}
                }
            }
        }
        self.defects.append(&mut found);
    }

    /// True if loop `c` contains the first node of loop `d`.
    fn surrounds(&self, c: usize, d: usize) -> bool {
        let mut around = Vec::new();
        self.loops_around(self.slots[self.curves[d].slots.start], &mut around);
        around.contains(&c)
    }

    /// Scars must run inside. One defect per scar: the first node or segment outside.
    pub(super) fn check_scars(&mut self) {
        // The slot of each node of a loop; nodes of loops are numbered first.
        let mut loop_slot = vec![u32::MAX; self.points.len()];
        for i in (0..self.n_loop_slots).rev() {
            loop_slot[self.node_of[i] as usize] = i as u32;
        }
        let mut tangled = vec![false; self.curves.len()];
        for &(c, d) in &self.entangled {
            tangled[d as usize] |= self.is_loop(c as usize);
        }
        let (mut around, mut found) = (Vec::new(), Vec::new());
        for (curve, tangled) in self.curves.iter().zip(tangled).skip(self.domain.loops.len()) {
            let slots = curve.slots.clone();
            if slots.is_empty() || tangled {
                continue;
            }
            let on_loop = |i: usize| loop_slot[self.node_of[i] as usize] != u32::MAX;
            // Without crossings, one free node decides for all up to the next touch of a loop.
            let free = slots.clone().find(|&i| !on_loop(i));
            let mut bad = free.filter(|&i| !self.is_inside(self.slots[i], &mut around));
            for i in slots.clone() {
                if bad.is_some() {
                    break;
                }
                let before = (i > slots.start).then(|| i - 1);
                let after = (i + 1 < slots.end).then_some(i + 1);
                for j in [before, after].into_iter().flatten() {
                    if on_loop(i) && !self.leaves_into_material(loop_slot[self.node_of[i] as usize], j) {
                        bad = Some(i);
                    }
                }
            }
            if let Some(i) = bad {
                found.push(Defect::Outside { at: self.place(i) });
            }
        }
        self.defects.append(&mut found);
    }

    /// True if the segment from the loop node `slot` to slot `to` starts into the material (or if that loop is
    /// not simple, so that nothing can be said).
    fn leaves_into_material(&self, slot: u32, to: usize) -> bool {
        let curve = &self.curves[self.curve_of[slot as usize] as usize];
        if !curve.simple {
            return true;
        }
        let (n, i) = (curve.slots.len(), slot as usize - curve.slots.start);
        let at = |k: usize| self.slots[curve.slots.start + k % n];
        let (mut u, mut w) = (at(i + n - 1), at(i + 1));
        if curve.reversed {
            (u, w) = (w, u);
        }
        in_cone(u, at(i), w, self.slots[to])
    }

    /// Checks the hard points and gives each a node, an old one if there is one at its place.
    pub(super) fn place_points(&mut self) -> Vec<u32> {
        let merge = self.tolerance.merge();
        let mut ids = Vec::with_capacity(self.domain.points.len());
        let (mut new, mut around, mut near) = (Vec::new(), Vec::new(), Vec::new());
        for p in &self.domain.points {
            let (q, at) = (p.xy, Place { name: p.name.clone(), index: 0, x: p.xy.x, y: p.xy.y });
            ids.push(u32::MAX);
            if let Some(size) = p.size.filter(|s| !(s.is_finite() && *s > 0.0)) {
                self.defects.push(Defect::BadSize { at: at.clone(), size });
            }
            if !q.is_finite() {
                self.defects.push(Defect::NotFinite { at });
                continue;
            }
            if q.abs().max_element() > MAX_COORDINATE {
                self.defects.push(Defect::Scale { at });
                continue;
            }
            near.clear();
            self.tree.window(Aabb::of_segment(q, q, 0.51 * merge), &mut |s| near.push(s));
            near.sort_unstable();
            let ends = near.iter().flat_map(|&s| self.segments[s as usize]);
            let at_node =
                ends.map(|i| i as usize).filter(|&i| self.slots[i].distance(q) <= merge).min_by(|&i, &j| {
                    self.slots[i].distance(q).total_cmp(&self.slots[j].distance(q)).then(i.cmp(&j))
                });
            let on = near.iter().map(|&s| self.segments[s as usize]).find(|e| {
                let [a, b] = e.map(|i| self.slots[i as usize]);
                self.is_near(q, a, b)
            });
            if let Some(i) = at_node {
                if let Some(id) = ids.last_mut() {
                    *id = self.node_of[i];
                }
            } else if let Some([i, _]) = on {
                self.defects.push(Defect::PointOnSegment { point: at, segment: self.place(i as usize) });
            } else if !self.is_inside(q, &mut around) {
                self.defects.push(Defect::Outside { at });
            } else {
                new.push((ids.len() - 1, q));
            }
        }
        // Points at one place are one node: each takes the first point near it.
        let mut first: Vec<u32> = (0..new.len() as u32).collect();
        let tree = BoxTree::new(new.iter().map(|&(_, q)| Aabb::of_segment(q, q, 0.51 * merge)));
        tree.pairs(&mut |i, j| {
            if new[i as usize].1.distance(new[j as usize].1) <= merge {
                first[j as usize] = first[j as usize].min(i);
            }
            true
        });
        for (k, &(i, q)) in new.iter().enumerate() {
            if first[k] as usize == k {
                ids[i] = self.points.len() as u32;
                self.points.push(q);
            } else {
                ids[i] = ids[new[first[k] as usize].0];
            }
        }
        ids
    }
}

/// Exact: the segment `ab` crosses the height just above `q`, strictly left of `q`.
pub(crate) fn is_left_of(a: Point2, b: Point2, q: Point2) -> bool {
    if (a.y > q.y) == (b.y > q.y) {
        return false;
    }
    let o = orient2d(a, b, q);
    if b.y > a.y { o < 0.0 } else { o > 0.0 }
}
