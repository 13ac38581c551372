//! Loops and scars out of loose segments.
//!
//! ```text
//!    o──────o        1. prune dead ends (scars)
//!    │  ┌┐  │        2. faces of what is left, traced with the face on the left
//!    ├──┘└──┤──      3. which faces are material: even-odd by nesting, or all but those with a hole seed
//!    o──────o        4. segments with material on one side are loops, on both sides scars
//! ```
//!
//! Sides and angles are compared exactly. Segments that cross are not looked for: that is `Domain::check`'s work,
//! here they only give odd faces. Cost O(n log n) plus O(c n) for c separate components.

use crate::{Input, IoError, JobInput, JobOptions};
use csalf_core::Job;
use csalf_geom::polygon::{Side, bounds, locate, signed_area};
use csalf_geom::{Domain, HardPoint, Loop, LoopKind, Point2, Scar, predicates::orient2d};

/// Which faces are material.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Rule<'a> {
    /// Every level of nesting turns material into void and back.
    EvenOdd,
    /// All faces but the innermost around each of these points.
    Seeds(&'a [Point2]),
}

/// One connected piece of material.
#[derive(Clone, Debug, Default)]
pub(crate) struct Area {
    /// The outer loop, counter-clockwise, then holes, clockwise.
    pub loops: Vec<Vec<u32>>,
    /// Open chains; a closed one repeats its first node.
    pub scars: Vec<Vec<u32>>,
    /// Hard points and their names.
    pub points: Vec<(u32, Option<String>)>,
}

/// All pieces.
#[derive(Clone, Debug, Default)]
pub(crate) struct Plan {
    pub areas: Vec<Area>,
    pub notes: Vec<String>,
}

/// Half-edges of the core graph: 2k runs along core segment k, 2k + 1 back.
struct Core<'a> {
    p: &'a [Point2],
    ends: Vec<[u32; 2]>,
    /// Outgoing half-edges of each node, counter-clockwise.
    out: Vec<Vec<u32>>,
}

impl Core<'_> {
    fn tail(&self, h: u32) -> u32 {
        self.ends[(h / 2) as usize][(h & 1) as usize]
    }
    fn head(&self, h: u32) -> u32 {
        self.tail(h ^ 1)
    }
    /// The half-edge leaving the head of `h` that comes first clockwise from its way back and fulfils `keep`.
    fn next(&self, h: u32, keep: impl Fn(u32) -> bool) -> Option<u32> {
        let ring = &self.out[self.head(h) as usize];
        let at = ring.iter().position(|&g| g == h ^ 1)?;
        (1..=ring.len()).map(|k| ring[(at + ring.len() - k) % ring.len()]).find(|&g| keep(g))
    }
    fn points_of(&self, cycle: &[u32]) -> Vec<Point2> {
        cycle.iter().map(|&h| self.p[self.tail(h) as usize]).collect()
    }
}

/// Order of directions by angle from the positive x axis, exact.
fn by_angle(o: Point2, a: Point2, b: Point2) -> std::cmp::Ordering {
    let lower = |q: Point2| q.y < o.y || (q.y == o.y && q.x < o.x);
    lower(a).cmp(&lower(b)).then_with(|| 0.0f64.total_cmp(&orient2d(o, a, b)))
}

/// The smallest of the polygons (by area) that holds `q` strictly inside.
fn innermost<'a>(polygons: impl Iterator<Item = (usize, &'a [Point2], f64)>, q: Point2) -> Option<usize> {
    let holds = |ring: &[Point2]| {
        bounds(ring.iter().copied()).is_some_and(|(lo, hi)| q.cmpge(lo).all() && q.cmple(hi).all())
            && locate(ring, q) == Side::Inside
    };
    polygons.filter(|(_, ring, _)| holds(ring)).min_by(|a, b| a.2.total_cmp(&b.2)).map(|f| f.0)
}

/// Finds the areas that `segments` (pairs of positions in `points`, all in range) bound.
pub(crate) fn assemble(points: &[Point2], segments: &[[u32; 2]], rule: Rule<'_>) -> Plan {
    let mut plan = Plan::default();
    let mut all: Vec<[u32; 2]> =
        segments.iter().map(|&[a, b]| [a.min(b), a.max(b)]).filter(|s| s[0] != s[1]).collect();
    all.sort_unstable();
    all.dedup();
    let (ends, tails) = prune(points.len(), &all);
    let n_half = 2 * ends.len() as u32;
    let mut core = Core { p: points, ends, out: vec![Vec::new(); points.len()] };
    for h in 0..n_half {
        let t = core.tail(h) as usize;
        core.out[t].push(h);
    }
    for v in 0..points.len() {
        let mut ring = std::mem::take(&mut core.out[v]);
        let at = |h: u32| points[core.head(h) as usize];
        ring.sort_by(|&a, &b| by_angle(points[v], at(a), at(b)).then(a.cmp(&b)));
        core.out[v] = ring;
    }

    // Faces, with the face on the left.
    let mut face_of = vec![usize::MAX; n_half as usize];
    let mut faces: Vec<(Vec<Point2>, f64)> = Vec::new();
    for start in 0..n_half {
        if face_of[start as usize] != usize::MAX {
            continue;
        }
        let mut cycle = Vec::new();
        let mut h = start;
        while face_of[h as usize] == usize::MAX {
            face_of[h as usize] = faces.len();
            cycle.push(h);
            h = core.next(h, |_| true).unwrap_or(start);
        }
        let ring = core.points_of(&cycle);
        let area = signed_area(&ring);
        faces.push((ring, area));
    }

    let material = material_faces(&core, &face_of, &faces, rule);
    let filled = |h: u32| material[face_of[h as usize]];
    let bounding = |h: u32| filled(h) && !filled(h ^ 1);
    let void = (0..n_half).step_by(2).filter(|&h| !filled(h) && !filled(h ^ 1)).count();
    if void > 0 {
        plan.notes.push(format!("{void} segments lie where there is no material and were left out"));
    }

    // Loops, material on the left.
    let mut used = vec![false; n_half as usize];
    let (mut outers, mut holes) = (Vec::new(), Vec::new());
    for start in (0..n_half).filter(|&h| bounding(h)) {
        let mut cycle = Vec::new();
        let mut h = start;
        while !used[h as usize] {
            used[h as usize] = true;
            cycle.push(h);
            h = core.next(h, bounding).unwrap_or(start);
        }
        if cycle.is_empty() {
            continue;
        }
        let ring = core.points_of(&cycle);
        let area = signed_area(&ring);
        let nodes: Vec<u32> = cycle.iter().map(|&h| core.tail(h)).collect();
        if area > 0.0 { outers.push((ring, area, nodes)) } else { holes.push((ring, nodes)) }
    }
    let inside = |q: Point2| innermost(outers.iter().enumerate().map(|(i, o)| (i, &o.0[..], o.1)), q);
    plan.areas = outers.iter().map(|o| Area { loops: vec![o.2.clone()], ..Area::default() }).collect();
    for (ring, nodes) in holes {
        match ring.iter().find_map(|&q| inside(q)) {
            Some(i) => plan.areas[i].loops.push(nodes),
            None => plan.notes.push("a hole lies in no outer loop and was left out".into()),
        }
    }

    let on_loop = {
        let mut on = vec![false; points.len()];
        plan.areas.iter().flat_map(|a| &a.loops).flatten().for_each(|&v| on[v as usize] = true);
        on
    };
    let inner = (0..n_half).step_by(2).filter(|&h| filled(h) && filled(h ^ 1));
    let scar_segments: Vec<[u32; 2]> = inner.map(|h| core.ends[(h / 2) as usize]).chain(tails).collect();
    for chain in chains(points.len(), &scar_segments, &on_loop) {
        let middle = points[chain[0] as usize].midpoint(points[chain[1] as usize]);
        match inside(middle) {
            Some(i) => plan.areas[i].scars.push(chain),
            None => plan
                .notes
                .push(format!("an open line of {} nodes lies outside and was left out", chain.len())),
        }
    }
    plan
}

/// Splits segments into those of cycles and bridges (the 2-core) and dead ends.
fn prune(n_points: usize, all: &[[u32; 2]]) -> (Vec<[u32; 2]>, Vec<[u32; 2]>) {
    let mut at: Vec<Vec<u32>> = vec![Vec::new(); n_points];
    for (k, s) in all.iter().enumerate() {
        s.iter().for_each(|&v| at[v as usize].push(k as u32));
    }
    let mut degree: Vec<usize> = at.iter().map(Vec::len).collect();
    let mut dead = vec![false; all.len()];
    let mut stack: Vec<usize> = (0..n_points).filter(|&v| degree[v] == 1).collect();
    while let Some(v) = stack.pop() {
        let Some(&k) = at[v].iter().find(|&&k| !dead[k as usize]) else { continue };
        dead[k as usize] = true;
        for w in all[k as usize] {
            degree[w as usize] -= 1;
            if degree[w as usize] == 1 {
                stack.push(w as usize);
            }
        }
    }
    let part = |want: bool| (0..all.len()).filter(|&k| dead[k] == want).map(|k| all[k]).collect();
    (part(false), part(true))
}

/// Which faces are material; the outer face of a component is what the face around the component is.
fn material_faces(
    core: &Core<'_>,
    face_of: &[usize],
    faces: &[(Vec<Point2>, f64)],
    rule: Rule<'_>,
) -> Vec<bool> {
    // Components by joining the ends of segments.
    let mut root: Vec<u32> = (0..core.p.len() as u32).collect();
    fn find(root: &mut [u32], v: u32) -> u32 {
        let mut v = v;
        while root[v as usize] != v {
            root[v as usize] = root[root[v as usize] as usize];
            v = root[v as usize];
        }
        v
    }
    for &[a, b] in &core.ends {
        let (a, b) = (find(&mut root, a), find(&mut root, b));
        root[a.max(b) as usize] = a.min(b);
    }
    let mut component = vec![0u32; faces.len()];
    for (h, &f) in face_of.iter().enumerate() {
        component[f] = find(&mut root, core.tail(h as u32));
    }
    // (component, outer face): the face of smallest area, which is minus all the others together.
    let mut order: Vec<usize> = (0..faces.len()).collect();
    order.sort_by(|&a, &b| component[a].cmp(&component[b]).then(faces[a].1.total_cmp(&faces[b].1)));
    let mut outer: Vec<usize> = Vec::new();
    for run in order.chunk_by(|&a, &b| component[a] == component[b]) {
        outer.push(run[0]);
    }
    let mut is_outer = vec![false; faces.len()];
    outer.iter().for_each(|&f| is_outer[f] = true);
    let inner = || (0..faces.len()).filter(|&f| !is_outer[f]);
    // Larger components first: what is around a component is decided before it.
    outer.sort_by(|&a, &b| faces[a].1.total_cmp(&faces[b].1));
    let mut material = vec![false; faces.len()];
    let mut seeded = vec![false; faces.len()];
    if let Rule::Seeds(seeds) = rule {
        for &s in seeds {
            if let Some(f) = innermost(inner().map(|f| (f, &faces[f].0[..], faces[f].1)), s) {
                seeded[f] = true;
            }
        }
    }
    for &o in &outer {
        let around = innermost(
            inner().filter(|&f| component[f] != component[o]).map(|f| (f, &faces[f].0[..], faces[f].1)),
            faces[o].0[0],
        );
        let ground = around.is_some_and(|f| material[f]);
        material[o] = ground;
        for f in inner().filter(|&f| component[f] == component[o]) {
            material[f] = match rule {
                Rule::EvenOdd => !ground,
                Rule::Seeds(_) => !seeded[f],
            };
        }
    }
    material
}

/// Longest chains of segments, broken at `stops` and at nodes with other than two segments.
fn chains(n_points: usize, segments: &[[u32; 2]], stops: &[bool]) -> Vec<Vec<u32>> {
    let mut at: Vec<Vec<u32>> = vec![Vec::new(); n_points];
    for (k, s) in segments.iter().enumerate() {
        s.iter().for_each(|&v| at[v as usize].push(k as u32));
    }
    let is_end = |v: u32| stops[v as usize] || at[v as usize].len() != 2;
    let mut used = vec![false; segments.len()];
    let walk = |from: u32, first: u32, used: &mut Vec<bool>| {
        let (mut chain, mut v, mut k) = (vec![from], from, first);
        loop {
            used[k as usize] = true;
            let [a, b] = segments[k as usize];
            v = if a == v { b } else { a };
            chain.push(v);
            match at[v as usize].iter().find(|&&g| !used[g as usize]) {
                Some(&g) if !is_end(v) => k = g,
                _ => return chain,
            }
        }
    };
    let mut out = Vec::new();
    for pass_ends in [true, false] {
        for v in 0..n_points as u32 {
            for &k in &at[v as usize] {
                if !used[k as usize] && (!pass_ends || is_end(v)) {
                    out.push(walk(v, k, &mut used));
                }
            }
        }
    }
    out
}

impl Plan {
    /// Gives every point that is on no loop or scar to the area around it.
    pub(crate) fn add_points<'a>(
        &mut self,
        points: &[Point2],
        wanted: impl Iterator<Item = (u32, Option<&'a str>)>,
    ) {
        let mut taken = vec![false; points.len()];
        for a in &self.areas {
            a.loops.iter().chain(&a.scars).flatten().for_each(|&v| taken[v as usize] = true);
        }
        let rings: Vec<(Vec<Point2>, f64)> = self
            .areas
            .iter()
            .map(|a| {
                let ring: Vec<Point2> = a.loops[0].iter().map(|&v| points[v as usize]).collect();
                let area = signed_area(&ring);
                (ring, area)
            })
            .collect();
        let mut outside = 0;
        for (v, name) in wanted {
            if std::mem::replace(&mut taken[v as usize], true) {
                continue;
            }
            let around = rings.iter().enumerate().map(|(i, r)| (i, &r.0[..], r.1));
            match innermost(around, points[v as usize]) {
                Some(i) => self.areas[i].points.push((v, name.map(str::to_owned))),
                None => outside += 1,
            }
        }
        if outside > 0 {
            self.notes.push(format!("{outside} points lie outside and were left out"));
        }
    }

    /// Jobs of the areas. A loop or scar gets the name of the set that holds its first segment, if it is the only
    /// one to get it.
    pub(crate) fn into_input(
        self,
        format: &'static str,
        points: &[Point2],
        names: &[(&str, Vec<[u32; 2]>)],
        mut notes: Vec<String>,
    ) -> Result<JobInput, IoError> {
        if self.areas.is_empty() {
            return Err(IoError::Empty { format, wanted: "closed loop" });
        }
        let mut named: Vec<([u32; 2], usize)> = Vec::new();
        for (i, (_, edges)) in names.iter().enumerate() {
            named.extend(edges.iter().map(|&[a, b]| ([a.min(b), a.max(b)], i)));
        }
        named.sort_unstable();
        let name_of = |chain: &[u32]| -> Option<usize> {
            let key = [chain[0].min(*chain.get(1)?), chain[0].max(chain[1])];
            let k = named.partition_point(|e| e.0 < key);
            named.get(k).filter(|e| e.0 == key).map(|e| e.1)
        };
        let xy = |chain: &[u32]| chain.iter().map(|&v| points[v as usize]).collect::<Vec<_>>();
        let mut jobs = Vec::new();
        for a in &self.areas {
            let mut n_uses = vec![0usize; names.len()];
            a.loops.iter().chain(&a.scars).filter_map(|c| name_of(c)).for_each(|i| n_uses[i] += 1);
            let name = |chain: &[u32], standard: String| match name_of(chain) {
                Some(i) if n_uses[i] == 1 => names[i].0.to_owned(),
                _ => standard,
            };
            let mut domain = Domain::default();
            for (k, l) in a.loops.iter().enumerate() {
                let (kind, standard) = match k.checked_sub(1) {
                    None => (LoopKind::Outer, "outer".to_owned()),
                    Some(k) => (LoopKind::Hole, format!("hole{k}")),
                };
                domain.loops.push(Loop { kind, name: name(l, standard), nodes: xy(l) });
            }
            for (k, s) in a.scars.iter().enumerate() {
                domain.scars.push(Scar { name: name(s, format!("scar{k}")), nodes: xy(s) });
            }
            for (k, (v, label)) in a.points.iter().enumerate() {
                let name = label.clone().unwrap_or_else(|| format!("point{k}"));
                domain.points.push(HardPoint { name, xy: points[*v as usize], size: None });
            }
            jobs.push(Job { domain, ..Job::default() });
        }
        notes.extend(self.notes);
        Ok(JobInput { input: Input::Jobs(jobs), options: JobOptions::default(), notes })
    }
}
