//! `csalf demo`: a plate with a hole, without any file.

use crate::args::DemoArgs;
use crate::commands::mesh::{Order, Request, mesh_one};
use crate::exit::Failure;
use crate::files::Output;
use crate::say;
use csalf_core::{Job, Options};
use csalf_geom::{Domain, Point2};
use csalf_io::MeshFormat;
use csalf_io::inp::InpElement;
use csalf_pave::{LayerLaw, LayerSpec};
use csalf_sizemap::SizeSpec;

/// Segments along each side of the plate.
const SIDE: usize = 12;

/// Segments round the hole; together with the sides an even number.
const RIM: usize = 64;

/// A square plate of side 12 with a hole of radius 1 in its middle and three layers of quads round the hole. The
/// segments at the hole are a tenth as long as those of the sides.
pub fn plate() -> Job {
    let half = 0.5 * SIDE as f64;
    let mut outer = Vec::with_capacity(4 * SIDE);
    for [a, b] in
        [[(-1., -1.), (1., -1.)], [(1., -1.), (1., 1.)], [(1., 1.), (-1., 1.)], [(-1., 1.), (-1., -1.)]]
    {
        let (a, b) = (half * Point2::from(a), half * Point2::from(b));
        outer.extend((0..SIDE).map(|i| a.lerp(b, i as f64 / SIDE as f64)));
    }
    let rim = (0..RIM).map(|i| {
        let (y, x) = (std::f64::consts::TAU * i as f64 / RIM as f64).sin_cos();
        Point2::new(x, -y)
    });
    Job {
        name: "demo".into(),
        about: "a plate with a hole".into(),
        domain: Domain::new(outer).with_hole(rim.collect()),
        size: SizeSpec::Boundary,
        layers: vec![("hole0".into(), LayerSpec { count: 3, law: LayerLaw::Auto, first: None })],
        local_region: Some([0.0, 0.0, 2.0]),
    }
}

/// Meshes the plate and writes demo.vtu and demo.png.
///
/// # Errors
/// [`Failure::Unmeshed`] or [`Failure::Files`].
pub fn run(args: &DemoArgs, level: i32) -> Result<(), Failure> {
    let folder = &args.output;
    std::fs::create_dir_all(folder)
        .map_err(|e| Failure::Files(format!("cannot make the folder {}: {e}", folder.display())))?;
    let outputs = [
        Output { path: folder.join("demo.vtu"), format: MeshFormat::Vtu },
        Output { path: folder.join("demo.png"), format: MeshFormat::Png },
    ];
    let job = plate();
    let request = Request {
        input: "demo",
        options: Options::default(),
        outputs: &outputs,
        level,
        order: Order::First,
        element: InpElement::default(),
        geometry: None,
    };
    let done = mesh_one(&job, &request)?;
    if level >= 0 {
        say::out(&done.summary())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plate_is_even_and_closed() {
        let job = plate();
        let n: usize = job.domain.loops.iter().map(|l| l.nodes.len()).sum();
        assert_eq!(n, 4 * SIDE + RIM);
        assert_eq!(n % 2, 0);
        assert!(csalf_geom::polygon::signed_area(&job.domain.loops[0].nodes) > 0.0);
        assert!(csalf_geom::polygon::signed_area(&job.domain.loops[1].nodes) < 0.0);
    }
}
