//! `csalf plot`: a picture of a mesh file, coloured by a metric or by values of the file.

use crate::args::PlotArgs;
use crate::exit::Failure;
use crate::files;
use csalf_io::MeshFormat;
use csalf_io::picture::{Shade, write_png_by, write_svg_by};
use csalf_mesh::quality::metrics::{self, SCALES, WARPAGE};

/// Runs the command.
///
/// # Errors
/// A [`Failure`].
pub fn run(args: &PlotArgs) -> Result<(), Failure> {
    let picture = files::mesh_format(&args.output, args.format.as_deref())?;
    let draw = match picture {
        MeshFormat::Svg => write_svg_by,
        MeshFormat::Png => write_png_by,
        other => {
            let message = format!("a picture is svg or png, not {}", other.name());
            return Err(Failure::Usage(message));
        }
    };
    let input = files::mesh_format(&args.mesh, args.input_format.as_deref())?;
    let data = files::read_mesh(&args.mesh, input)?;
    let title = files::stem(&args.mesh);
    if args.by == "scaled_jacobian" {
        let output = files::Output { path: args.output.clone(), format: picture };
        return files::write_mesh(&data.view(&title), &csalf_io::WriteOptions::default(), &output);
    }
    let of_file = data.cell_data.iter().find(|d| d.name == args.by).map(|d| d.values.clone());
    let Some(values) = of_file.or_else(|| super::check::metric(&data, &args.by)) else {
        let mut known: Vec<&str> = metrics::NAMES.to_vec();
        known.extend(data.cell_data.iter().map(|d| d.name.as_str()));
        return Err(Failure::Usage(format!("--by {}: known are {}", args.by, known.join(", "))));
    };
    let shade = Shade { values: &values, limits: limits(&args.by, &values) };
    files::write(&args.output, |sink| draw(&data.view(&title), &shade, sink))
}

/// The worst and the best value: those of the scale of a metric, else those that occur.
fn limits(name: &str, values: &[f64]) -> [f64; 2] {
    if let Some(scale) = SCALES.iter().chain([&WARPAGE]).find(|s| s.name == name) {
        return if scale.good == "low" { [scale.high, scale.low] } else { [scale.low, scale.high] };
    }
    let finite = || values.iter().copied().filter(|v| v.is_finite());
    let (least, most) = (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
    // Without any value all is grey.
    if least <= most { [least, most] } else { [0.0, 1.0] }
}
