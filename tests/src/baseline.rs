//! The figures of a mesh that a regression run compares: counts exactly, reals within a tolerance.

use csalf_core::{Job, Meshed};
use csalf_geom::Point2;
use csalf_mesh::{QuadMesh, QualityReport};
use csalf_sizemap::Extras;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Largest relative difference of a real: below what anyone sees, above what another libm does.
const RELATIVE: f64 = 1e-4;
/// Largest absolute difference of a real, for those near 0.
const ABSOLUTE: f64 = 1e-5;

/// Figures of one mesh.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of quads.
    pub quads: usize,
    /// Number of warnings.
    pub warnings: usize,
    /// Layers made in full, over all loops.
    pub layers: usize,
    /// Inner vertices of other than four edges, by number of edges.
    pub irregular: BTreeMap<String, usize>,
    /// Smallest scaled Jacobian.
    pub min_sj: f64,
    /// 1 % quantile of the scaled Jacobian.
    pub p1_sj: f64,
    /// Mean scaled Jacobian.
    pub mean_sj: f64,
    /// tau over all quads.
    pub tau: f64,
    /// Largest aspect ratio.
    pub worst_aspect: f64,
    /// Share of edges that have the wanted size.
    pub size_share: f64,
    /// Share of boundary segments served by their row.
    pub row1_share: f64,
}

/// One figure that differs.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// Its name.
    pub figure: String,
    /// In the baseline.
    pub was: f64,
    /// Now.
    pub is: f64,
}

impl Change {
    /// |is - was| over the larger of both: 0 to 1 (2 if the sign changes).
    pub fn relative(&self) -> f64 {
        (self.is - self.was).abs() / self.is.abs().max(self.was.abs()).max(f64::MIN_POSITIVE)
    }
}

impl Figures {
    /// Measures a mesh; sizes against the job's own field.
    pub fn new(job: &Job, meshed: &Meshed) -> Self {
        let mesh = &meshed.mesh;
        let loops: Vec<Vec<Point2>> = job.domain.loops.iter().map(|l| l.nodes.clone()).collect();
        let tolerance = csalf_geom::Tolerance::of_points(loops.iter().flatten().copied());
        let field = csalf_sizemap::build(&job.size, &loops, &Extras::default(), tolerance).ok();
        let q = QualityReport::new(mesh, field.as_deref(), None);
        Self {
            vertices: q.n_vertices,
            quads: q.n_quads,
            warnings: meshed.report.warnings.len(),
            layers: meshed.report.loops.iter().map(|l| l.made).sum(),
            irregular: irregular(mesh),
            min_sj: q.min_sj,
            p1_sj: q.p1_sj,
            mean_sj: q.mean_sj,
            tau: q.tau_global.unwrap_or(0.0),
            worst_aspect: q.max_aspect,
            size_share: q.size.map_or(0.0, |s| s.share),
            row1_share: q.structure.map_or(0.0, |s| s.row1_share),
        }
    }

    fn counts(&self) -> Vec<(String, f64)> {
        let mut out = vec![
            ("vertices".to_owned(), self.vertices as f64),
            ("quads".to_owned(), self.quads as f64),
            ("warnings".to_owned(), self.warnings as f64),
            ("layers".to_owned(), self.layers as f64),
        ];
        out.extend(self.irregular.iter().map(|(k, &n)| (format!("valence {k}"), n as f64)));
        out
    }

    fn reals(&self) -> [(&'static str, f64); 7] {
        [
            ("min_sj", self.min_sj),
            ("p1_sj", self.p1_sj),
            ("mean_sj", self.mean_sj),
            ("tau", self.tau),
            ("worst_aspect", self.worst_aspect),
            ("size_share", self.size_share),
            ("row1_share", self.row1_share),
        ]
    }

    /// What differs from `was`: counts exactly, reals by a relative 1e-4 or an absolute 1e-5, whichever is more.
    pub fn changes_from(&self, was: &Self) -> Vec<Change> {
        let mut out = Vec::new();
        let (old, new) = (was.counts(), self.counts());
        let of = |list: &[(String, f64)], name: &str| list.iter().find(|c| c.0 == name).map_or(0.0, |c| c.1);
        let mut names: Vec<&String> = old.iter().chain(&new).map(|c| &c.0).collect();
        names.sort();
        names.dedup();
        for name in names {
            let (was, is) = (of(&old, name), of(&new, name));
            if was != is {
                out.push(Change { figure: name.clone(), was, is });
            }
        }
        for ((name, is), (_, was)) in self.reals().into_iter().zip(was.reals()) {
            if (is - was).abs() > ABSOLUTE.max(RELATIVE * was.abs().max(is.abs())) {
                out.push(Change { figure: name.to_owned(), was, is });
            }
        }
        out
    }
}

/// Inner vertices of other than four edges, by number of edges.
fn irregular(mesh: &QuadMesh) -> BTreeMap<String, usize> {
    let sides =
        mesh.quads.iter().flat_map(|q| (0..4).map(|k| (q[k].min(q[(k + 1) % 4]), q[k].max(q[(k + 1) % 4]))));
    let mut sides: Vec<_> = sides.collect();
    sides.sort_unstable();
    let mut valence = vec![0usize; mesh.n_vertices()];
    let mut on_boundary = vec![false; mesh.n_vertices()];
    for edge in sides.chunk_by(|a, b| a == b) {
        for v in [edge[0].0, edge[0].1] {
            valence[v.index()] += 1;
            on_boundary[v.index()] |= edge.len() == 1;
        }
    }
    let mut out = BTreeMap::new();
    for (n, _) in valence.iter().zip(&on_boundary).filter(|(n, b)| **n != 4 && !**b) {
        *out.entry(n.to_string()).or_default() += 1;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_exact_and_reals_are_not() {
        let was = Figures { vertices: 100, min_sj: 0.5, worst_aspect: 3.0, ..Figures::default() };
        let mut is = Figures { min_sj: 0.500_04, ..was.clone() };
        assert_eq!(is.changes_from(&was), []);
        is.vertices = 101;
        is.worst_aspect = 3.001;
        is.irregular.insert("5".into(), 2);
        let names: Vec<_> = is.changes_from(&was).into_iter().map(|c| c.figure).collect();
        assert_eq!(names, ["valence 5", "vertices", "worst_aspect"]);
    }
}
