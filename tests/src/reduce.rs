//! Shrinks a failing job: delta debugging over holes, scars, points, layers, sizes and nodes.
//!
//! 1. Plain things first: no layers, no gradation, sizes of the boundary; near the origin, rounded coordinates.
//! 2. Whole holes, scars and points, in halves, quarters, ... down to one (`drop_chunks`).
//! 3. Nodes of each loop and scar, in even chunks down to two, so that parity stays.
//! 4. Again from 2 until nothing goes.
//!
//! A candidate is kept if it is a valid domain and fails in the same way. Source: Zeller and Hildebrandt 2002,
//! "Simplifying and isolating failure-inducing input".

use crate::run::{Failure, run};
use csalf_core::{Job, Options};
use csalf_geom::Point2;
use csalf_sizemap::SizeSpec;
use std::time::{Duration, Instant};

/// A job that is being shrunk.
#[derive(Debug)]
struct Reducer<'a> {
    job: Job,
    options: Options,
    kind: String,
    failure: Failure,
    threads: &'a [usize],
    deadline: Instant,
}

/// The result of [`reduce`].
#[derive(Clone, Debug)]
pub struct Reduced {
    /// The small job.
    pub job: Job,
    /// Its options.
    pub options: Options,
    /// How it fails.
    pub failure: Failure,
}

/// Shrinks a job while it fails in the same way, for at most `limit`; `None` if it does not fail.
pub fn reduce(job: &Job, options: &Options, threads: &[usize], limit: Duration) -> Option<Reduced> {
    let failure = run(job, options, threads).err()?;
    let mut r = Reducer {
        job: job.clone(),
        options: options.clone(),
        kind: failure.kind(),
        failure,
        threads,
        deadline: Instant::now() + limit,
    };
    r.simplify();
    while r.drop_parts() | r.drop_nodes() {}
    r.round();
    let Reducer { job, options, failure, .. } = r;
    Some(Reduced { job, options, failure })
}

impl Reducer<'_> {
    /// Keeps the candidate if it fails in the same way.
    fn keep(&mut self, job: Job, options: Options) -> bool {
        if Instant::now() > self.deadline || !job.domain.check().is_empty() {
            return false;
        }
        match run(&job, &options, self.threads) {
            Err(f) if f.kind() == self.kind => {
                (self.job, self.options, self.failure) = (job, options, f);
                true
            }
            _ => false,
        }
    }

    fn change(&mut self, f: impl FnOnce(&mut Job, &mut Options)) -> bool {
        let (mut job, mut options) = (self.job.clone(), self.options.clone());
        f(&mut job, &mut options);
        (job != self.job || options != self.options) && self.keep(job, options)
    }

    fn simplify(&mut self) {
        self.change(|j, _| j.layers.clear());
        self.change(|_, o| o.gradation = None);
        self.change(|j, _| j.size = SizeSpec::Boundary);
        self.change(|j, _| j.domain.points.iter_mut().for_each(|p| p.size = None));
        self.change(|j, _| j.domain.points.clear());
        self.change(|j, _| j.domain.scars.clear());
        // Into a box of side 10 at the origin.
        self.change(|j, _| {
            let all = j.domain.loops.iter().flat_map(|l| l.nodes.iter().copied());
            if let Some((lo, hi)) = csalf_geom::polygon::bounds(all) {
                let scale = 10.0 / (hi - lo).max_element();
                for_all_points(j, &|p| (p - lo) * scale);
                scale_sizes(j, scale, lo);
            }
        });
    }

    /// Halves, quarters, ... of holes, scars, points, layers, sources. True if something went.
    fn drop_parts(&mut self) -> bool {
        let mut any = self.drop_chunks(|j| j.domain.loops.len(), |j, r| drop(j.domain.loops.drain(r)), 1);
        any |= self.drop_chunks(|j| j.domain.scars.len(), |j, r| drop(j.domain.scars.drain(r)), 1);
        any |= self.drop_chunks(|j| j.domain.points.len(), |j, r| drop(j.domain.points.drain(r)), 1);
        any |= self.drop_chunks(|j| j.layers.len(), |j, r| drop(j.layers.drain(r)), 1);
        any | self.drop_chunks(
            |j| if let SizeSpec::Sources { sources, .. } = &j.size { sources.len() } else { 0 },
            |j, r| {
                if let SizeSpec::Sources { sources, .. } = &mut j.size {
                    sources.drain(r);
                }
            },
            1,
        )
    }

    /// Even chunks of nodes of each curve; then single nodes of two curves at once keep the total even, too.
    fn drop_nodes(&mut self) -> bool {
        let mut any = false;
        for k in (0..self.job.domain.loops.len()).rev() {
            any |= self.drop_chunks(
                |j| j.domain.loops[k].nodes.len(),
                |j, r| drop(j.domain.loops[k].nodes.drain(r)),
                2,
            );
        }
        for k in (0..self.job.domain.scars.len()).rev() {
            any |= self.drop_chunks(
                |j| j.domain.scars[k].nodes.len(),
                |j, r| drop(j.domain.scars[k].nodes.drain(r)),
                1,
            );
        }
        any
    }

    /// Tries to remove chunks of `0 .. len`, large ones first, none smaller than `least`.
    fn drop_chunks(
        &mut self,
        len: impl Fn(&Job) -> usize,
        remove: impl Fn(&mut Job, std::ops::Range<usize>),
        least: usize,
    ) -> bool {
        let mut any = false;
        let mut size = len(&self.job) / 2 / least * least;
        while size >= least {
            let mut at = 0;
            while at + size <= len(&self.job) {
                if self.change(|j, _| remove(j, at..at + size)) {
                    any = true;
                } else {
                    at += size.min(least.max(size / 2));
                }
            }
            size = if size == least { 0 } else { (size / 2).max(least) / least * least };
        }
        // A pair need not be neighbours.
        if least == 2 {
            let mut i = 0;
            while i + 2 < len(&self.job) && len(&self.job) <= 40 {
                let n = len(&self.job);
                let gone = (i + 2..n).any(|k| {
                    self.change(|j, _| {
                        remove(j, k..k + 1);
                        remove(j, i..i + 1);
                    })
                });
                any |= gone;
                i += usize::from(!gone);
            }
        }
        any
    }

    /// Coordinates of few digits.
    fn round(&mut self) {
        for digits in [1e0, 1e1, 1e2, 1e3, 1e4, 1e6] {
            if self.change(|j, _| for_all_points(j, &|p| (p * digits).round() / digits)) {
                return;
            }
        }
    }
}

fn for_all_points(job: &mut Job, map: &dyn Fn(Point2) -> Point2) {
    let d = &mut job.domain;
    let curves = d.loops.iter_mut().map(|l| &mut l.nodes).chain(d.scars.iter_mut().map(|s| &mut s.nodes));
    curves.flatten().for_each(|p| *p = map(*p));
    d.points.iter_mut().for_each(|p| p.xy = map(p.xy));
}

/// Sizes, after all points went to (p - lo) * scale.
fn scale_sizes(job: &mut Job, scale: f64, lo: Point2) {
    job.domain.points.iter_mut().for_each(|p| p.size = p.size.map(|h| h * scale));
    match &mut job.size {
        SizeSpec::Boundary => {}
        SizeSpec::Uniform { h } => *h *= scale,
        SizeSpec::Sources { far, sources } => {
            *far *= scale;
            for s in sources {
                s.xy = (s.xy - lo) * scale;
                (s.h, s.radius, s.falloff) = (s.h * scale, s.radius * scale, s.falloff * scale);
            }
        }
        SizeSpec::Background { points, values, .. } => {
            points.iter_mut().for_each(|p| *p = (*p - lo) * scale);
            values.iter_mut().for_each(|h| *h *= scale);
        }
    }
    for (_, l) in &mut job.layers {
        l.first = l.first.map(|t| t * scale);
        if let csalf_pave::LayerLaw::Explicit(t) = &mut l.law {
            t.iter_mut().for_each(|x| *x *= scale);
        }
    }
}

/// A Rust test that meshes the job and fails as it does; to be pasted into `tests/tests/regressions.rs`.
pub fn as_test(reduced: &Reduced) -> String {
    let list = |p: &[Point2]| {
        let text: Vec<_> = p.iter().map(|p| format!("({:?}, {:?})", p.x, p.y)).collect();
        format!("&[{}]", text.join(", "))
    };
    let mut out = String::from("#[test]\nfn name_the_rule() {\n");
    out += &format!("    // {}\n", reduced.failure.to_string().lines().next().unwrap_or_default());
    let d = &reduced.job.domain;
    for (k, l) in d.loops.iter().enumerate() {
        let (start, end) =
            if k == 0 { ("    let domain = Domain::new(p(", "))") } else { ("        .with_hole(p(", "))") };
        out += &format!("{start}{}{end}\n", list(&l.nodes));
    }
    for s in &d.scars {
        out += &format!("        .with_scar(p({}))\n", list(&s.nodes));
    }
    for p in &d.points {
        out += &format!("        .with_point(Point2::new({:?}, {:?}))\n", p.xy.x, p.xy.y);
    }
    out.truncate(out.trim_end().len());
    out += ";\n";
    out += &format!("    let size = SizeSpec::{:?};\n", reduced.job.size);
    if !reduced.job.layers.is_empty() {
        out += &format!("    // layers: {:?}\n", reduced.job.layers);
    }
    let o = &reduced.options;
    out += &format!(
        "    let options = Options {{ method: Method::{:?}, gradation: {:?}, ..Options::default() }};\n",
        o.method, o.gradation
    );
    out + "    must_mesh(domain, size, &options);\n}\n"
}
