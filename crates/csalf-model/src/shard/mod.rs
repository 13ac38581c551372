//! A model meshed in several processes that know nothing of each other.
//!
//! ```text
//!   process 1:  Model ─prepare─▶ edges ─part 1 of its faces─▶ Shard 1, with names and nodes on edges ─┐
//!   process 2:  Model ─prepare─▶ edges ─part 2─▶ Shard 2 ─────────────────────────────────────────────┼─stitch─▶ mesh
//!   process n:  ...                                                                                   ─┘
//! ```
//!
//! Each process discretises all edges, which is little work and comes out the same everywhere, then meshes its part of
//! the faces. [`stitch`] gives the same bytes as [`crate::mesh_model`]. A fingerprint of the model, the options, the
//! version of the program and the nodes on edges tells shards of different runs apart.

pub(crate) mod case;
mod file;
mod fingerprint;
mod parts;

use crate::Prepared;
use crate::face::NodeName;
use crate::mesh::FaceResult;
use crate::report::ModelMesh;
use crate::stitch::Frame;
use csalf_core::Watch;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// More parts than this are a slip of the pen.
pub const MOST_PARTS: u32 = 1_000_000;

/// The meshes of some faces of a model.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Shard {
    /// How messages call it: the name of its file.
    #[serde(skip)]
    pub name: String,
    /// Which part, from 1.
    pub index: u32,
    /// Parts in all.
    pub count: u32,
    /// Of the run that it belongs to.
    pub fingerprint: u128,
    /// Part 1 has it.
    frame: Option<Frame>,
    /// Faces, ascending.
    faces: Vec<(u32, FaceResult)>,
}

impl Shard {
    /// Number of faces in it.
    pub fn n_faces(&self) -> usize {
        self.faces.len()
    }

    /// Faces without a mesh.
    pub fn failures(&self) -> impl Iterator<Item = &crate::FaceFailure> {
        let known = self.frame.iter().flat_map(|f| &f.failures);
        known.chain(self.faces.iter().filter_map(|f| f.1.as_ref().err().map(|e| &**e)))
    }

    /// Number of quads in it.
    pub fn n_quads(&self) -> usize {
        self.faces.iter().filter_map(|f| f.1.as_ref().ok()).map(|m| m.quads.len()).sum()
    }
}

/// What is wrong with a shard, or with a set of shards.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ShardError {
    /// Not a file of shards.
    #[error("{name} is not a shard of csalf")]
    NotAShard {
        /// The shard.
        name: String,
    },
    /// Written by a program with another format.
    #[error("{name} has version {found} of the shard format; this program reads version {known}")]
    Version {
        /// The shard.
        name: String,
        /// The version that it has.
        found: u32,
        /// The version that is read.
        known: u32,
    },
    /// Cut off, or changed after it was written.
    #[error("{name} is damaged: {what}")]
    Damaged {
        /// The shard.
        name: String,
        /// How it shows.
        what: String,
    },
    /// No shard at all.
    #[error("there is no shard to put together")]
    Nothing,
    /// Of another run than most of the others.
    #[error(
        "{name} belongs to another run than {other}: the model, the options, the number of shards or the version \
         of csalf differ"
    )]
    Foreign {
        /// The shard.
        name: String,
        /// One of the others.
        other: String,
    },
    /// The same part twice.
    #[error("{first} and {second} are both shard {index}")]
    Duplicate {
        /// Which part, from 1.
        index: u32,
        /// One of them.
        first: String,
        /// The other.
        second: String,
    },
    /// Parts that are not there.
    #[error("{} of {count} missing", parts_in_words(*first, *last))]
    Missing {
        /// The first of a run of them, from 1.
        first: u32,
        /// The last of the run.
        last: u32,
        /// Parts in all.
        count: u32,
    },
}

fn parts_in_words(first: u32, last: u32) -> String {
    if first == last { format!("shard {first}") } else { format!("shards {first} to {last}") }
}

/// The mesh of a model out of shards.
#[derive(Clone, Debug, Default)]
pub struct Stitched {
    /// Name of the model.
    pub name: String,
    /// Names of its faces.
    pub faces: Vec<String>,
    /// The mesh.
    pub mesh: ModelMesh,
}

impl Prepared<'_> {
    /// The faces of each of `count` parts, all of about the same estimated work; ascending in each. The same in every
    /// process.
    pub fn parts(&self, count: u32) -> Vec<Vec<usize>> {
        parts::parts(self, count.min(MOST_PARTS))
    }

    /// What all shards of a run in `count` parts have in common, and those of no other run. Cost: linear in the model.
    pub fn fingerprint(&self, count: u32) -> u128 {
        fingerprint::of(self, count)
    }

    /// Meshes part `index` (from 1) of `count`, at most [`MOST_PARTS`]. `None` if there is no such part.
    pub fn shard(&self, index: u32, count: u32, watch: &dyn Watch) -> Option<Shard> {
        let faces = self.parts(count).into_iter().nth((index.checked_sub(1)?) as usize)?;
        let meshed = self.mesh_faces(&faces, watch);
        Some(Shard {
            name: format!("shard {index}"),
            index,
            count,
            fingerprint: self.fingerprint(count),
            frame: (index == 1).then(|| self.frame.clone()),
            faces: faces.into_iter().map(|f| f as u32).zip(meshed).collect(),
        })
    }
}

/// Puts the mesh together. The shards may come in any order.
///
/// # Errors
/// Everything that is wrong with them.
pub fn stitch(mut shards: Vec<Shard>) -> Result<Stitched, Vec<ShardError>> {
    let mut errors = strangers(&shards);
    if errors.is_empty() {
        shards.sort_by_key(|s| s.index);
        errors = holes(&shards);
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    let Some(frame) = shards.first_mut().and_then(|s| s.frame.take()) else {
        let what = "it has no names and nodes on edges".to_owned();
        return Err(vec![ShardError::Damaged { name: shards[0].name.clone(), what }]);
    };
    let errors: Vec<ShardError> = shards.iter().filter_map(|s| damage(s, &frame)).collect();
    if !errors.is_empty() {
        return Err(errors);
    }
    let first = shards[0].name.clone();
    let mut faces: Vec<(u32, FaceResult)> = shards.into_iter().flat_map(|s| s.faces).collect();
    faces.sort_by_key(|f| f.0);
    let n = if frame.able { frame.faces.len() } else { 0 };
    if faces.len() != n || faces.windows(2).any(|w| w[0].0 == w[1].0) {
        let what = format!("the shards hold {} faces, but the model has {n}", faces.len());
        return Err(vec![ShardError::Damaged { name: first, what }]);
    }
    let (name, names) = (frame.name.clone(), frame.faces.iter().map(|f| f.0.clone()).collect());
    let mesh = frame.stitch(faces.into_iter().map(|(f, m)| (f as usize, m)));
    Ok(Stitched { name, faces: names, mesh })
}

/// Shards of another run than most; of equally many, than the first ones.
fn strangers(shards: &[Shard]) -> Vec<ShardError> {
    let mut runs: BTreeMap<u128, (usize, usize)> = BTreeMap::new();
    for (k, s) in shards.iter().enumerate() {
        runs.entry(s.fingerprint).or_insert((0, k)).0 += 1;
    }
    let home = runs.into_iter().min_by_key(|(_, (n, first))| (std::cmp::Reverse(*n), *first));
    let Some((home, (_, first))) = home else { return vec![ShardError::Nothing] };
    let other = &shards[first].name;
    let strange = shards.iter().filter(|s| s.fingerprint != home);
    strange.map(|s| ShardError::Foreign { name: s.name.clone(), other: other.clone() }).collect()
}

/// Parts that are there twice or not at all; the shards are sorted, of one run, and at least one.
fn holes(shards: &[Shard]) -> Vec<ShardError> {
    let mut errors = Vec::new();
    for w in shards.windows(2).filter(|w| w[0].index == w[1].index) {
        let (first, second) = (w[0].name.clone(), w[1].name.clone());
        errors.push(ShardError::Duplicate { index: w[0].index, first, second });
    }
    let count = shards.first().map_or(0, |s| s.count);
    let mut next = 1;
    for index in shards.iter().map(|s| s.index).chain([count + 1]) {
        if index > next {
            errors.push(ShardError::Missing { first: next, last: index - 1, count });
        }
        next = index + 1;
    }
    errors
}

/// Numbers that point at nothing: a shard that no program of ours wrote.
fn damage(s: &Shard, frame: &Frame) -> Option<ShardError> {
    let n_nodes = frame.table.points.len();
    let frame_is_sound = frame.table.of_edge.iter().flatten().all(|&k| (k as usize) < n_nodes);
    let sound = |(f, result): &(u32, FaceResult)| {
        let Ok(m) = result else { return true };
        let inside = |n: &NodeName| match n {
            NodeName::Model(k) => (*k as usize) < n_nodes,
            NodeName::Own(k) => (*k as usize) < m.own.len(),
        };
        (*f as usize) < frame.faces.len()
            && m.quads.iter().flatten().all(inside)
            && m.rings.iter().flat_map(|r| &r.2).all(|&q| (q as usize) < m.quads.len())
    };
    let fine = frame_is_sound && s.faces.iter().all(sound);
    let what = "it names nodes, quads or faces that are not there".to_owned();
    (!fine).then(|| ShardError::Damaged { name: s.name.clone(), what })
}
