//! What may stand on the command line.

use crate::layers::{parse_law, parse_length};
use crate::requirement::Requirement;
use clap::{ArgAction, Parser, Subcommand, ValueEnum, ValueHint};
use csalf_core::{Method, Preset};
use csalf_io::inp::InpElement;
use csalf_pave::LayerLaw;
use std::path::PathBuf;

/// What stands below the options in the long help and in the man page.
const EXIT_CODES: &str = "Exit codes: 0 done; 1 a mesh failed its check; 2 wrong usage; 3 invalid input; \
4 could not mesh; 5 a file cannot be read or written.";

/// Quad meshes from outlines: structured rings around every boundary, all quads, the boundary kept exactly.
#[derive(Parser, Clone, Debug)]
#[command(name = "csalf", version, about, after_help = EXIT_CODES, max_term_width = 100)]
pub struct Args {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// How much to say.
    #[command(flatten)]
    pub verbosity: Verbosity,
}

/// How much to say.
#[derive(clap::Args, Clone, Copy, Debug, Default)]
pub struct Verbosity {
    /// Show the stages of the work; twice: every patch; three times: everything
    #[arg(short, long, action = ArgAction::Count, global = true)]
    pub verbose: u8,
    /// Say nothing but errors
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
}

impl Verbosity {
    /// -1 quiet, 0 normal, 1 and more for each `-v`.
    pub fn level(self) -> i32 {
        if self.quiet { -1 } else { i32::from(self.verbose) }
    }
}

/// The commands.
#[derive(Subcommand, Clone, Debug)]
pub enum Command {
    /// Mesh an outline and write the mesh
    Mesh(Box<MeshArgs>),
    /// Print the quality of a mesh, and fail if it is broken
    Check(CheckArgs),
    /// Mesh a built-in plate with a hole; leaves a mesh and a picture
    Demo(DemoArgs),
    /// Sweep a planar mesh along a vector or a path into hexahedra
    Sweep(SweepArgs),
    /// Put the shards of a model (`csalf mesh --shard`) together
    Stitch(StitchArgs),
    /// Draw a mesh, coloured by a metric
    Plot(PlotArgs),
    /// Tell what is in an outline, a mesh or a model, without meshing
    Info(InfoArgs),
    /// Draw, mesh and look at outlines in the browser
    #[cfg(feature = "studio")]
    Studio(StudioArgs),
    /// Print the completion script of a shell
    #[command(hide = true)]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
}

/// Arguments of `csalf mesh`. Each long option is also a key of the `--config` file.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct MeshArgs {
    /// Outline to mesh: .json job, .geojson, .topojson, .poly, .dxf, .svg, .msh; model: .step, .stl, .obj, .ply; `-` is
    /// standard input
    #[arg(value_hint = ValueHint::FilePath, required_unless_present = "config")]
    pub input: Option<PathBuf>,
    /// Mesh or picture to write, format by extension; `-` is standard output; may be given several times
    #[arg(short, long, value_name = "OUT", value_hint = ValueHint::FilePath, action = ArgAction::Append)]
    pub output: Vec<PathBuf>,
    /// Wanted edge length everywhere, in place of the sizes that the input asks for
    #[arg(long, value_name = "H", value_parser = parse_length, allow_negative_numbers = true)]
    pub size: Option<f64>,
    /// Place new nodes on outlines whose nodes are given, as far apart as the size says; corners stay
    #[arg(long)]
    pub resample: bool,
    /// Largest growth of the wanted size per unit of length
    #[arg(long, value_name = "G", value_parser = parse_length, allow_negative_numbers = true)]
    pub gradation: Option<f64>,
    /// Which method drives the mesher
    #[arg(long, value_enum)]
    pub method: Option<MethodArg>,
    /// How much work to put into quality
    #[arg(long, value_enum)]
    pub preset: Option<PresetArg>,
    /// Layers by pattern of loop names: `PATTERN=COUNT[:LAW[:FIRST]],...`
    #[arg(long, value_name = "LAYERS")]
    pub layers: Option<String>,
    /// Thickness law of the layers: auto, constant, ramp, parabolic, fibonacci, geometric(Q), explicit(T,...)
    #[arg(long, value_name = "LAW", value_parser = parse_law)]
    pub layer_law: Option<LayerLaw>,
    /// Thickness of the first layer [default: the mean segment of the loop]
    #[arg(long, value_name = "T", value_parser = parse_length, allow_negative_numbers = true)]
    pub first_layer: Option<f64>,
    /// Leave a triangle where a region has an odd number of segments
    #[arg(long)]
    pub allow_triangles: bool,
    /// Add a node to a scar where it cuts off a region with an odd number of segments
    #[arg(long)]
    pub repair_parity: bool,
    /// Worker threads, 0 for all cores; the mesh does not depend on it
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// Order of the elements: 1, or 2 with mid-side nodes, on the curve where it is known
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=2))]
    pub order: Option<u8>,
    /// With --order 2: a ninth node at the centre of each quad
    #[arg(long)]
    pub centres: bool,
    /// Elements of .inp files [default: shell]
    #[arg(long, value_enum, value_name = "KIND")]
    pub element: Option<ElementArg>,
    /// Of a model: mesh only part I of N of its faces, into a shard for `csalf stitch`
    #[arg(long, value_name = "I/N", value_parser = parse_part)]
    pub shard: Option<(u32, u32)>,
    /// Format of all outputs, in place of their extensions: vtu, msh41, msh22, inp, bdf, obj, exodus, unv, su2,
    /// foam, vtkhdf, ism, svg, png
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<String>,
    /// Format of the input, in place of its extension
    #[arg(long, value_name = "FORMAT")]
    pub input_format: Option<String>,
    /// Options from a TOML file; those on the command line win
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub config: Option<PathBuf>,
    /// Print one JSON object as the last line on standard output
    #[arg(long)]
    pub json: bool,
    /// Write the full report: a page to look at (.html), else JSON, loop by loop
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub report: Option<PathBuf>,
    /// Read and check everything, say what would be done, write nothing
    #[arg(long)]
    pub dry_run: bool,
}

/// Reads `I/N`, 1 <= I <= N.
fn parse_part(text: &str) -> Result<(u32, u32), String> {
    let most = csalf_model::shard::MOST_PARTS;
    let part = text.split_once('/').and_then(|(i, n)| Some((i.trim().parse().ok()?, n.trim().parse().ok()?)));
    match part {
        Some((i, n)) if 1 <= i && i <= n && n <= most => Ok((i, n)),
        _ => Err(format!("expected I/N, such as 3/16, with I from 1 to N and N at most {most}")),
    }
}

/// Arguments of `csalf stitch`.
#[derive(clap::Args, Clone, Debug)]
pub struct StitchArgs {
    /// The shards, all of one run, in any order
    #[arg(value_hint = ValueHint::FilePath, required = true)]
    pub shards: Vec<PathBuf>,
    /// Mesh or picture to write, format by extension; `-` is standard output; may be given several times
    #[arg(short, long, value_name = "OUT", value_hint = ValueHint::FilePath, action = ArgAction::Append)]
    pub output: Vec<PathBuf>,
    /// Elements of .inp files [default: shell]
    #[arg(long, value_enum, value_name = "KIND")]
    pub element: Option<ElementArg>,
    /// Format of all outputs, in place of their extensions
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<String>,
    /// Print one JSON object as the last line on standard output
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `csalf plot`.
#[derive(clap::Args, Clone, Debug)]
pub struct PlotArgs {
    /// Mesh to draw: .vtu, .msh, .inp, .bdf, .obj; `-` is standard input
    #[arg(value_hint = ValueHint::FilePath)]
    pub mesh: PathBuf,
    /// Picture to write: .svg or .png; `-` is standard output
    #[arg(short, long, value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,
    /// What the colours show: scaled_jacobian, shape, skew, aspect_ratio, jacobian_ratio, min_angle, max_angle, area,
    /// edge_ratio, min_edge, warpage, or values that the file has
    #[arg(long, value_name = "METRIC", default_value = "scaled_jacobian")]
    pub by: String,
    /// Format of the mesh, in place of its extension
    #[arg(long, value_name = "FORMAT")]
    pub input_format: Option<String>,
    /// Format of the picture, in place of its extension: svg, png
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<String>,
}

/// Arguments of `csalf check`.
#[derive(clap::Args, Clone, Debug)]
pub struct CheckArgs {
    /// Mesh to check: .vtu, .msh, .inp, .bdf, .obj; `-` is standard input
    #[arg(value_hint = ValueHint::FilePath)]
    pub mesh: PathBuf,
    /// Fail if an element has a smaller scaled Jacobian than this
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub min_sj: Option<f64>,
    /// Fail if an element does not meet this, such as 'min_angle>=30', 'edge_ratio<=5' or 'warpage<=0.05'; may be given
    /// several times; metrics as for `csalf plot --by`
    #[arg(long, value_name = "METRIC<=X", value_parser = Requirement::parse, action = ArgAction::Append)]
    pub require: Vec<Requirement>,
    /// Format of the mesh, in place of its extension
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<String>,
    /// Print one JSON object as the last line on standard output
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `csalf demo`.
#[derive(clap::Args, Clone, Debug)]
pub struct DemoArgs {
    /// Folder for demo.vtu and demo.png
    #[arg(short, long, value_name = "DIR", default_value = ".", value_hint = ValueHint::DirPath)]
    pub output: PathBuf,
}

/// Arguments of `csalf sweep`.
#[derive(clap::Args, Clone, Debug)]
pub struct SweepArgs {
    /// Planar mesh of quads: .vtu, .msh, .inp, .bdf, .obj; `-` is standard input
    #[arg(value_hint = ValueHint::FilePath)]
    pub mesh: PathBuf,
    /// Mesh to write: .vtu, .inp (C3D8), .msh; `-` is standard output
    #[arg(short, long, value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,
    /// Along which path: a vector `X,Y,Z`, or points `X,Y,Z;X,Y,Z;...`
    #[arg(long, value_name = "PATH", allow_hyphen_values = true)]
    pub along: String,
    /// Layers along the path: `COUNT[:LAW[:FIRST]]`, laws as of `csalf mesh --layers`
    #[arg(long, value_name = "LAYERS", default_value = "10")]
    pub layers: String,
    /// Format of the input, in place of its extension
    #[arg(long, value_name = "FORMAT")]
    pub input_format: Option<String>,
    /// Format of the output, in place of its extension: vtu, inp, msh22
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<String>,
}

/// Arguments of `csalf info`.
#[derive(clap::Args, Clone, Debug)]
pub struct InfoArgs {
    /// Outline, mesh or model; `-` is standard input
    #[arg(value_hint = ValueHint::FilePath)]
    pub input: PathBuf,
    /// Write what would be meshed as a job file, one per outline; `-` is standard output
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub job: Option<PathBuf>,
    /// Wanted edge length everywhere, as with `csalf mesh`
    #[arg(long, value_name = "H", value_parser = parse_length, allow_negative_numbers = true)]
    pub size: Option<f64>,
    /// Place new nodes on outlines whose nodes are given, as with `csalf mesh`
    #[arg(long)]
    pub resample: bool,
    /// Format of the input, in place of its extension
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<String>,
    /// Print one JSON object as the last line on standard output
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `csalf studio`.
#[cfg(feature = "studio")]
#[derive(clap::Args, Clone, Debug)]
pub struct StudioArgs {
    /// Outline to begin with: .json job, .geojson, .topojson, .poly, .dxf, .svg, .msh
    #[arg(value_hint = ValueHint::FilePath)]
    pub file: Option<PathBuf>,
    /// Port on 127.0.0.1 [default: any that is free]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    pub port: u16,
    /// Only print the address, open no browser
    #[arg(long)]
    pub no_open: bool,
}

/// `--method`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MethodArg {
    /// Layers, then the triad with patterns (default)
    Csalf,
    /// The flow of the CSALF-Q paper, letter for letter
    Paper,
    /// Recursive subdivision alone (TriQuaMesh)
    Tqm,
}

impl From<MethodArg> for Method {
    fn from(m: MethodArg) -> Self {
        match m {
            MethodArg::Csalf => Self::Csalf,
            MethodArg::Paper => Self::Paper,
            MethodArg::Tqm => Self::Tqm,
        }
    }
}

/// `--element`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ElementArg {
    /// S4, S3; S8R, S6
    Shell,
    /// CPS4, CPS3; CPS8, CPS6
    PlaneStress,
    /// CPE4, CPE3; CPE8, CPE6
    PlaneStrain,
    /// CAX4, CAX3; CAX8, CAX6; the axis is x = 0
    Axisymmetric,
}

impl From<ElementArg> for InpElement {
    fn from(e: ElementArg) -> Self {
        match e {
            ElementArg::Shell => Self::Shell,
            ElementArg::PlaneStress => Self::PlaneStress,
            ElementArg::PlaneStrain => Self::PlaneStrain,
            ElementArg::Axisymmetric => Self::Axisymmetric,
        }
    }
}

/// `--preset`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PresetArg {
    /// Lookahead, cleaning, optimisation (default)
    Quality,
    /// Neither lookahead nor cleaning
    Fast,
}

impl From<PresetArg> for Preset {
    fn from(p: PresetArg) -> Self {
        match p {
            PresetArg::Quality => Self::Quality,
            PresetArg::Fast => Self::Fast,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_sound() {
        Args::command().debug_assert();
    }

    #[test]
    fn several_outputs_and_verbosity_anywhere() {
        let a =
            Args::try_parse_from(["csalf", "mesh", "a.json", "-o", "b.vtu", "-vv", "-o", "c.png"]).unwrap();
        assert_eq!(a.verbosity.level(), 2);
        let Command::Mesh(m) = a.command else { panic!("not mesh") };
        assert_eq!(m.output, [PathBuf::from("b.vtu"), PathBuf::from("c.png")]);
    }

    #[test]
    fn wrong_values_are_refused() {
        for extra in [
            ["--size", "-1"],
            ["--size", "nan"],
            ["--threads", "-1"],
            ["--method", "x"],
            ["--layer-law", "y"],
        ] {
            let line = ["csalf", "mesh", "a.json"].into_iter().chain(extra);
            assert!(Args::try_parse_from(line).is_err(), "{extra:?}");
        }
    }
}
