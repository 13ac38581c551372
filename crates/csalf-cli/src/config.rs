//! The job file of `--config`: the options of `csalf mesh` in TOML, one key per long option.
//!
//! ```toml
//! input = "plate.json"            # paths are relative to this file
//! output = ["plate.vtu", "plate.png"]
//! size = 0.5
//! method = "csalf"
//! layer_law = "ramp"
//!
//! [layers]
//! "hole*" = 2
//! outer = { count = 1, law = "geometric(1.2)", first = 0.05 }
//! ```
//!
//! Of whole models there is more to say: see [`ModelKeys`].

use crate::args::{ElementArg, MeshArgs, MethodArg, PresetArg};
use crate::layers::{Layers, parse_law};
use crate::model_file::Reading;
use csalf_pave::LayerSpec;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// A parsed file. Every key is optional.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Config {
    input: Option<PathBuf>,
    output: Option<OneOrMore>,
    size: Option<f64>,
    resample: Option<bool>,
    gradation: Option<f64>,
    method: Option<MethodArg>,
    preset: Option<PresetArg>,
    layers: Option<LayersKey>,
    layer_law: Option<String>,
    first_layer: Option<f64>,
    allow_triangles: Option<bool>,
    repair_parity: Option<bool>,
    threads: Option<usize>,
    order: Option<u8>,
    centres: Option<bool>,
    element: Option<ElementArg>,
    format: Option<String>,
    input_format: Option<String>,
    json: Option<bool>,
    report: Option<PathBuf>,
    model: Option<ModelKeys>,
}

/// The table `[model]`: what is asked of a whole model, by names as `csalf info` lists them.
///
/// ```toml
/// [model]
/// min_size = 0.2               # curvature asks for no less
/// per_turn = 16                # elements per full turn
/// sewing = 0.02                # edges within this distance become one
/// faces = { "top*" = 2.0 }     # sizes; the smallest that fits counts
/// edges = { "rim" = 0.5 }      # sizes, whatever the curvature; the last that fits counts
/// loops = { "hole<12" = 0.4 }  # sizes of the edges of loops
/// counts = { "up*" = 6 }       # numbers of segments that must not change
/// points = { spot1 = [1.0, 2.0, 0.0] }
/// ```
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelKeys {
    /// Curvature asks for no less than this.
    pub min_size: Option<f64>,
    /// Elements per full turn of a curve or surface; 0: curvature does not matter.
    pub per_turn: Option<f64>,
    /// Sides at which the normal turns by more are edges of a model of facets, degrees.
    pub feature_angle: Option<f64>,
    /// Edges within this distance become one, length; without it 1e-6 of the diagonal, or up to 1e-4 if that closes the
    /// model.
    pub sewing: Option<f64>,
    /// Sizes of faces by pattern.
    #[serde(default, deserialize_with = "in_order")]
    pub faces: Vec<(String, f64)>,
    /// Sizes of edges by pattern.
    #[serde(default, deserialize_with = "in_order")]
    pub edges: Vec<(String, f64)>,
    /// Sizes of the edges of loops by pattern.
    #[serde(default, deserialize_with = "in_order")]
    pub loops: Vec<(String, f64)>,
    /// Fixed numbers of segments of edges by pattern.
    #[serde(default, deserialize_with = "in_order")]
    pub counts: Vec<(String, usize)>,
    /// Points that become nodes of the nearest face.
    #[serde(default, deserialize_with = "in_order")]
    pub points: Vec<(String, [f64; 3])>,
}

/// A table as a list in the order of the file.
fn in_order<'de, D, T>(from: D) -> Result<Vec<(String, T)>, D::Error>
where
    D: serde::Deserializer<'de>,
    T: serde::de::DeserializeOwned,
{
    let table = toml::Table::deserialize(from)?;
    let entry = |(key, value): (String, toml::Value)| {
        let value = value.try_into().map_err(|e| serde::de::Error::custom(format!("{key}: {e}")))?;
        Ok((key, value))
    };
    table.into_iter().map(entry).collect()
}

impl ModelKeys {
    /// How the model is to be read.
    pub const fn reading(&self) -> Reading {
        Reading { feature_angle: self.feature_angle, sewing: self.sewing }
    }

    /// Sizes and angles must be above 0, points finite.
    fn check(&self) -> Result<(), String> {
        let keys =
            [("min_size", self.min_size), ("feature_angle", self.feature_angle), ("sewing", self.sewing)];
        for (key, value) in keys {
            positive(key, value)?;
        }
        let none = self.per_turn.filter(|n| *n != 0.0);
        positive("per_turn", none)?;
        for (key, value) in self.faces.iter().chain(&self.edges).chain(&self.loops) {
            positive(key, Some(*value))?;
        }
        match self.points.iter().find(|(_, p)| p.iter().any(|x| !x.is_finite())) {
            Some((name, _)) => Err(format!("the point {name} is not finite")),
            None => Ok(()),
        }
    }
}

/// What the file says that has no place on the command line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Extra {
    /// Layers of the table `[layers]`.
    pub layers: Layers,
    /// The table `[model]`.
    pub model: Option<ModelKeys>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
enum OneOrMore {
    One(PathBuf),
    More(Vec<PathBuf>),
}

/// `layers = "hole*=2"` or a table in the order of the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
enum LayersKey {
    Short(String),
    Table(toml::Table),
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LayerEntry {
    count: usize,
    law: Option<String>,
    first: Option<f64>,
}

/// The arguments with what the file adds, and what has no place among them.
///
/// # Errors
/// What is wrong with the text, in words.
pub fn merge(args: &MeshArgs, text: &str, folder: &Path) -> Result<(MeshArgs, Extra), String> {
    let c: Config = toml::from_str(text).map_err(|e| e.to_string().trim_end().to_owned())?;
    let place = |p: PathBuf| if p.as_os_str() == "-" { p } else { folder.join(p) };
    let mut out = args.clone();
    let mut table = Layers::new();
    out.input = out.input.or_else(|| c.input.map(place));
    if out.output.is_empty() {
        out.output = match c.output {
            Some(OneOrMore::One(p)) => vec![place(p)],
            Some(OneOrMore::More(list)) => list.into_iter().map(place).collect(),
            None => Vec::new(),
        };
    }
    out.size = out.size.or(positive("size", c.size)?);
    out.gradation = out.gradation.or(positive("gradation", c.gradation)?);
    out.first_layer = out.first_layer.or(positive("first_layer", c.first_layer)?);
    out.method = out.method.or(c.method);
    out.preset = out.preset.or(c.preset);
    if out.layer_law.is_none() {
        out.layer_law =
            c.layer_law.as_deref().map(parse_law).transpose().map_err(|e| format!("layer_law: {e}"))?;
    }
    if out.layers.is_none() {
        match c.layers {
            Some(LayersKey::Short(s)) => out.layers = Some(s),
            Some(LayersKey::Table(t)) => {
                for (pattern, value) in t {
                    let spec = entry(value, &out).map_err(|e| format!("layers.{pattern}: {e}"))?;
                    table.push((pattern, spec));
                }
            }
            None => {}
        }
    }
    out.allow_triangles |= c.allow_triangles.unwrap_or(false);
    out.repair_parity |= c.repair_parity.unwrap_or(false);
    out.resample |= c.resample.unwrap_or(false);
    out.json |= c.json.unwrap_or(false);
    out.threads = out.threads.or(c.threads);
    if let Some(n) = c.order.filter(|n| !(1..=2).contains(n)) {
        return Err(format!("order = {n}: known are 1 and 2"));
    }
    out.order = out.order.or(c.order);
    out.centres |= c.centres.unwrap_or(false);
    out.element = out.element.or(c.element);
    out.format = out.format.or(c.format);
    out.input_format = out.input_format.or(c.input_format);
    out.report = out.report.or_else(|| c.report.map(place));
    if let Some(model) = &c.model {
        model.check().map_err(|e| format!("model: {e}"))?;
    }
    Ok((out, Extra { layers: table, model: c.model }))
}

fn entry(value: toml::Value, args: &MeshArgs) -> Result<LayerSpec, String> {
    let entry = match value {
        toml::Value::Integer(n) => {
            let count = usize::try_from(n).map_err(|_| format!("{n} is not a number of layers"))?;
            LayerEntry { count, law: None, first: None }
        }
        other => other.try_into().map_err(|e| e.to_string())?,
    };
    let law = match &entry.law {
        Some(l) => parse_law(l)?,
        None => args.layer_law.clone().unwrap_or_default(),
    };
    Ok(LayerSpec { count: entry.count, law, first: positive("first", entry.first)?.or(args.first_layer) })
}

fn positive(key: &str, value: Option<f64>) -> Result<Option<f64>, String> {
    match value {
        Some(v) if !(v.is_finite() && v > 0.0) => Err(format!("{key} = {v} is not a number above 0")),
        v => Ok(v),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use csalf_pave::LayerLaw;

    const TEXT: &str = "input = 'in.json'\noutput = ['a.vtu', '-']\nsize = 2\nmethod = 'tqm'\nlayer_law = 'ramp'\n\
                        [layers]\n'hole*' = 2\nouter = { count = 1, law = 'constant', first = 0.1 }\n";

    #[test]
    fn a_file_fills_what_the_command_line_leaves_open() {
        let args = MeshArgs { size: Some(0.5), ..MeshArgs::default() };
        let (m, extra) = merge(&args, TEXT, Path::new("jobs")).unwrap();
        let layers = extra.layers;
        assert_eq!(m.size, Some(0.5));
        assert_eq!(m.input, Some(PathBuf::from("jobs/in.json")));
        assert_eq!(m.output, [PathBuf::from("jobs/a.vtu"), PathBuf::from("-")]);
        assert_eq!(m.method, Some(MethodArg::Tqm));
        let spec = |count, law, first| LayerSpec { count, law, first };
        assert!(layers.contains(&("hole*".into(), spec(2, LayerLaw::Ramp, None))));
        assert!(layers.contains(&("outer".into(), spec(1, LayerLaw::Constant, Some(0.1)))));
    }

    #[test]
    fn layers_on_the_command_line_replace_those_of_the_file() {
        let args = MeshArgs { layers: Some("outer=3".into()), ..MeshArgs::default() };
        let (m, extra) = merge(&args, TEXT, Path::new("")).unwrap();
        assert_eq!(m.layers.as_deref(), Some("outer=3"));
        assert!(extra.layers.is_empty());
    }

    #[test]
    fn models_have_keys_of_their_own() {
        let text = "[model]\nper_turn = 0\nedges = { b = 1, a = 0.5 }\ncounts = { 'up*' = 4 }\n\
                    points = { s = [1.0, 2.0, 3.0] }\n";
        let (_, extra) = merge(&MeshArgs::default(), text, Path::new("")).unwrap();
        let model = extra.model.unwrap();
        assert_eq!(model.counts, [("up*".to_owned(), 4)]);
        assert_eq!(model.points, [("s".to_owned(), [1.0, 2.0, 3.0])]);
        assert_eq!(model.edges.len(), 2);
    }

    #[test]
    fn wrong_files_say_what_is_wrong() {
        for (text, word) in [
            ("sizes = 1", "sizes"),
            ("size = -1", "above 0"),
            ("method = 'x'", "method"),
            ("[layers]\na = -1", "number of layers"),
            ("[layers]\na = { count = 1, low = 2 }", "low"),
            ("layer_law = 'x'", "layer_law"),
            ("size = ", "TOML"),
            ("[model]\nfaces = { a = -1 }", "above 0"),
            ("[model]\nfoo = 1", "foo"),
        ] {
            let e = merge(&MeshArgs::default(), text, Path::new("")).unwrap_err();
            assert!(e.contains(word), "{text}: {e}");
        }
    }
}
