//! The types of the job format as serde and the JSON Schema see them. Every field's description here is the
//! description in the published schema.

use schemars::JsonSchema;
use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use serde::{Deserialize as De, Serialize as Ser};

/// A meshing job of csalf: discretised loops, scars and points, wanted sizes, wanted layers.
#[derive(De, Ser, JsonSchema, Default, Debug)]
pub(super) struct JobFile {
    /// Where the schema of this file lies; for editors.
    #[serde(rename = "$schema", default, skip_serializing_if = "Option::is_none")]
    pub schema: Option<String>,
    /// Short name, used for file names and reports.
    #[serde(default)]
    pub name: String,
    /// One sentence for people.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub about: String,
    /// One outer loop and any number of holes.
    pub loops: Vec<LoopFile>,
    /// Open polylines inside, which mesh edges must follow.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub scars: Vec<ScarFile>,
    /// Single mesh nodes inside.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub points: Vec<PointFile>,
    /// Wanted edge length; the boundary's own if left out.
    #[serde(default)]
    #[schemars(with = "Option<SizeSchema>")]
    pub size: SizeFile,
    /// Circle over which the local quality is reported.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub local_region: Option<RegionFile>,
    /// Layers of quads by pattern of names: `outer`, `hole0`, `hole*`, `scar0`. A later entry overrides an
    /// earlier one.
    #[serde(default, skip_serializing_if = "OrderedMap::is_empty")]
    #[schemars(with = "std::collections::BTreeMap<String, LayerFile>")]
    pub layers: OrderedMap<LayerFile>,
    /// How to mesh, where the caller of the program says nothing else.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub options: Option<OptionsFile>,
}

/// What a loop bounds.
#[derive(De, Ser, JsonSchema, Debug, Clone, Copy, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(super) enum KindFile {
    /// The loop around everything.
    Outer,
    /// The rim of a hole.
    Hole,
}

/// A closed, discretised curve: every node becomes a mesh node, every segment a mesh edge.
#[derive(De, Ser, JsonSchema, Debug)]
pub(super) struct LoopFile {
    /// Outer or hole.
    pub kind: KindFile,
    /// Name in sets and reports; `outer`, `hole0`, `hole1`, ... if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Nodes in order, the first not repeated.
    pub nodes: Vec<[f64; 2]>,
}

/// An open polyline that mesh edges must follow.
#[derive(De, Ser, JsonSchema, Debug)]
pub(super) struct ScarFile {
    /// Name in sets and reports; `scar0`, ... if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Nodes in order, at least two.
    pub nodes: Vec<[f64; 2]>,
}

/// A single mesh node inside.
#[derive(De, Ser, JsonSchema, Debug)]
pub(super) struct PointFile {
    /// Where.
    pub xy: [f64; 2],
    /// Name in sets and reports; `point0`, ... if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Wanted edge length there, > 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<f64>,
}

/// A circle.
#[derive(De, Ser, JsonSchema, Debug)]
pub(super) struct RegionFile {
    /// Centre x, centre y, radius.
    pub circle: [f64; 3],
}

/// A spot of another size: at distance d from `xy` the wanted length is
/// `h + clamp((d - radius) / falloff, 0, 1) * (far - h)`.
#[derive(De, Ser, JsonSchema, Debug)]
pub(super) struct SourceFile {
    /// Centre.
    pub xy: [f64; 2],
    /// Edge length within `radius`, > 0.
    pub h: f64,
    /// Radius of the spot, >= 0.
    pub radius: f64,
    /// Distance over which the size goes over to `far`, > 0.
    pub falloff: f64,
}

/// The kinds of size field.
#[derive(De, Ser, JsonSchema, Debug, Clone, Copy, Default)]
#[serde(rename_all = "lowercase")]
pub(super) enum SizeKind {
    #[default]
    Boundary,
    Uniform,
    Sources,
    Background,
}

/// Flat form in which sizes are read, so that errors and unknown keys keep their places.
#[derive(De, Ser, Debug, Default)]
pub(super) struct SizeFile {
    pub kind: SizeKind,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub h: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub far: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sources: Option<Vec<SourceFile>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub points: Option<Vec<[f64; 2]>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub triangles: Option<Vec<[u32; 3]>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub values: Option<Vec<f64>>,
}

/// Wanted edge length h(x).
#[derive(JsonSchema)]
#[serde(tag = "kind", rename_all = "lowercase")]
#[expect(dead_code, reason = "only its schema is used; values are read as `SizeFile`")]
enum SizeSchema {
    /// Node size is the mean of the two boundary segments there; linear on the constrained Delaunay triangulation
    /// of the boundary nodes.
    Boundary,
    /// The same length everywhere.
    Uniform {
        /// The length, > 0.
        h: f64,
    },
    /// The minimum of `far` and all sources.
    Sources {
        /// Length away from all sources, > 0.
        far: f64,
        /// The spots.
        sources: Vec<SourceFile>,
    },
    /// Linear on a triangulation of your own.
    Background {
        /// Its nodes.
        points: Vec<[f64; 2]>,
        /// Three node numbers per triangle, from 0.
        triangles: Vec<[u32; 3]>,
        /// Wanted length per node, > 0.
        values: Vec<f64>,
    },
}

/// How the thickness of layer i = 0, 1, ... follows from the first one, t0.
#[derive(De, Ser, JsonSchema, Debug, Clone, Copy, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(super) enum LawFile {
    /// As thick as the quads are long.
    Auto,
    /// t0, t0, t0, ...
    Constant,
    /// t0 (1 + i).
    Ramp,
    /// t0 (1 + r i²), r such that the last layer meets the size field.
    Parabolic,
    /// t0 times 1, 1, 2, 3, 5, 8, ...
    Fibonacci,
    /// t0 ratio^i; wants `ratio`.
    Geometric,
    /// The `thicknesses` themselves.
    Explicit,
}

/// Layers of one loop or of all that a pattern matches.
#[derive(De, Ser, JsonSchema, Debug)]
pub(super) struct LayerFile {
    /// Number of layers; 0 forbids them. May be left out if `thicknesses` are given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub count: Option<usize>,
    /// Law of the thickness; if left out, `explicit` with `thicknesses`, `geometric` with `ratio`, else `auto`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub law: Option<LawFile>,
    /// First thickness t0, > 0; the mean segment length of the loop if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub first: Option<f64>,
    /// Growth from layer to layer, > 0, of law `geometric`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ratio: Option<f64>,
    /// Thicknesses, > 0, of law `explicit`, from the loop inward.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thicknesses: Option<Vec<f64>>,
}

/// Which method meshes.
#[derive(De, Ser, JsonSchema, Debug, Clone, Copy, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(super) enum MethodFile {
    /// Layers, then the triad with patterns.
    Csalf,
    /// The paper's flow, letter for letter.
    Paper,
    /// Recursive subdivision alone.
    Tqm,
}

/// How much work is put into quality.
#[derive(De, Ser, JsonSchema, Debug, Clone, Copy, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(super) enum PresetFile {
    /// All of it.
    Quality,
    /// Little.
    Fast,
}

/// Options of the mesher. What is left out keeps its default; what the command line says comes first.
#[derive(De, Ser, JsonSchema, Debug, Default)]
pub(super) struct OptionsFile {
    /// Method.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<MethodFile>,
    /// Preset.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preset: Option<PresetFile>,
    /// Worker threads; 0: as many as there are cores.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub threads: Option<usize>,
    /// Largest growth of the size field, |grad h|, > 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gradation: Option<f64>,
    /// Allow triangles where a region has an odd number of segments.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub allow_triangles: Option<bool>,
    /// Allow one node to be added to a scar that cuts off an odd region.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub repair_parity: Option<bool>,
}

/// A JSON object whose entries keep their order.
#[derive(Debug)]
pub(super) struct OrderedMap<T>(pub Vec<(String, T)>);

impl<T> Default for OrderedMap<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> OrderedMap<T> {
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl<T: serde::Serialize> serde::Serialize for OrderedMap<T> {
    fn serialize<S: serde::Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
        s.collect_map(self.0.iter().map(|(k, v)| (k, v)))
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for OrderedMap<T> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct Entries<T>(std::marker::PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Entries<T> {
            type Value = OrderedMap<T>;
            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("an object")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                let mut out = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    out.push(entry);
                }
                Ok(OrderedMap(out))
            }
        }
        d.deserialize_map(Entries(std::marker::PhantomData))
    }
}
