//! `csalf sweep`: a planar mesh along a path into hexahedra.

use crate::args::SweepArgs;
use crate::exit::Failure;
use crate::{files, layers, say};
use csalf_mesh::sweep;
use csalf_pave::LayerSpec;
use csalf_pave::laws::{Thickness, thickness};
use glam::DVec3;

/// Runs the command.
///
/// # Errors
/// A [`Failure`].
pub fn run(args: &SweepArgs, level: i32) -> Result<(), Failure> {
    let path = parse_path(&args.along).map_err(|e| Failure::Usage(format!("--along: {e}")))?;
    let spec = layers::parse(&format!("sweep={}", args.layers), None, None)
        .map_err(|e| Failure::Usage(format!("--layers: {e}")))?;
    let spec = spec.into_iter().next().map(|s| s.1).unwrap_or_default();
    let output = files::mesh_format(&args.output, args.format.as_deref())?;
    let input = files::mesh_format(&args.mesh, args.input_format.as_deref())?;
    let shown = files::shown(&args.mesh);
    let data = files::read_mesh(&args.mesh, input)?;
    let data = data.planar(input.name()).map_err(|e| Failure::of_file(&shown, &e))?;
    let length = path.windows(2).map(|w| w[0].distance(w[1])).sum();
    let levels = levels(&spec, length);
    let swept = sweep(&data.mesh, &data.sets, &path, &levels)
        .map_err(|e| Failure::Invalid { input: shown.clone(), defects: vec![e.to_string()] })?;
    let title = files::stem(&args.mesh);
    files::write(&args.output, |sink| csalf_io::hex::write(output, &swept, &title, sink))?;
    if level >= 0 && !files::is_standard(&args.output) {
        let (n, out) = (swept.hexes.len(), args.output.display());
        say::out(&format!("{title}: {n} hexahedra, {} nodes\nwrote {out}", swept.points.len()))?;
    }
    Ok(())
}

/// Reads `X,Y,Z` (a vector from the origin) or `X,Y,Z;X,Y,Z;...` (points).
fn parse_path(text: &str) -> Result<Vec<DVec3>, String> {
    let point = |t: &str| -> Result<DVec3, String> {
        let x: Vec<f64> = t
            .split(',')
            .map(|w| w.trim().parse().map_err(|_| format!("'{}' is not a number", w.trim())))
            .collect::<Result<_, _>>()?;
        match x[..] {
            [x, y, z] => Ok(DVec3::new(x, y, z)),
            _ => Err(format!("'{t}': expected three coordinates X,Y,Z")),
        }
    };
    let mut points: Vec<DVec3> = text.split(';').map(point).collect::<Result<_, _>>()?;
    if points.len() == 1 {
        points.insert(0, DVec3::ZERO);
    }
    Ok(points)
}

/// Shares of the length at the levels: thicknesses by the law, scaled to fill it.
fn levels(spec: &LayerSpec, length: f64) -> Vec<f64> {
    let n = spec.count.max(1);
    let mean = length / n as f64;
    let all: Vec<f64> = (0..n)
        .map(|i| match thickness(spec, i, mean, mean) {
            Thickness::Fixed(t) => t,
            Thickness::Isotropic(_) => mean,
        })
        .collect();
    let total: f64 = all.iter().sum();
    let mut levels = vec![0.0];
    let mut sum = 0.0;
    for t in &all[..n - 1] {
        sum += t;
        levels.push(sum / total);
    }
    levels.push(1.0);
    levels
}

#[cfg(test)]
mod tests {
    use super::*;
    use csalf_pave::LayerLaw;

    #[test]
    fn paths_and_levels() {
        assert_eq!(parse_path("0,0,5").expect("a vector"), [DVec3::ZERO, DVec3::Z * 5.0]);
        assert_eq!(parse_path("1,0,0; 1,0,2;3,0,2").expect("points").len(), 3);
        assert!(parse_path("1,2").is_err() && parse_path("a,b,c").is_err());
        let spec = LayerSpec { count: 3, law: LayerLaw::Geometric(2.0), first: None };
        let l = levels(&spec, 7.0);
        assert!(l.iter().zip([0.0, 1.0 / 7.0, 3.0 / 7.0, 1.0]).all(|(a, b)| (a - b).abs() < 1e-15), "{l:?}");
        assert_eq!(levels(&LayerSpec { count: 4, ..LayerSpec::default() }, 1.0), [0.0, 0.25, 0.5, 0.75, 1.0]);
    }
}
