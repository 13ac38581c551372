//! `csalf mesh --dry-run`: everything but the mesh. The domain is checked as the mesher would check it, and the
//! number of quads is foretold from the sizes.

use crate::commands::info;
use crate::commands::mesh::{path_of, several, shown_outline, size_field};
use crate::exit::Failure;
use crate::files::Output;
use crate::outlines::Outline;
use crate::{json, say};
use csalf_core::{Job, Options};
use csalf_geom::Point2;
use csalf_geom::arrangement::{Arrangement, CheckOptions};
use serde_json::{Map, Value};

/// Says what would be done.
///
/// # Errors
/// [`Failure::Invalid`] with all defects, as meshing would give it.
pub(super) fn run(
    shown: &str,
    outlines: &[Outline],
    options: &Options,
    outputs: &[Output],
    as_json: bool,
) -> Result<(), Failure> {
    let n = outlines.len();
    let mut failures = Vec::new();
    let mut entries = Vec::new();
    for (k, outline) in outlines.iter().enumerate() {
        let found = outline.job.as_ref().map_err(Clone::clone).and_then(|job| {
            let check =
                CheckOptions { allow_odd: options.allow_triangles, repair_parity: options.repair_parity };
            match Arrangement::new(&job.domain, &check) {
                Ok(_) => Ok(job),
                Err(defects) => Err(defects.iter().map(ToString::to_string).collect()),
            }
        });
        let job = match found {
            Ok(job) => job,
            Err(defects) => {
                let input = shown_outline(shown, &outline.name, n);
                failures.push(Failure::Invalid { input, defects });
                continue;
            }
        };
        let expected = expected_quads(job, options);
        if as_json {
            let mut entry = info::entry(job);
            entry["expected_quads"] = expected.map_or(Value::Null, Value::from);
            entries.push(entry);
            continue;
        }
        say::out(&info::describe(job))?;
        if let Some(n_quads) = expected {
            say::out(&format!("  about {n_quads} quads"))?;
        }
        for o in outputs {
            let path = path_of(&o.path, &outline.name, k, n);
            say::out(&format!("  would write {} ({})", path.display(), o.format.name()))?;
        }
    }
    if !as_json {
        say::out(&format!(
            "method {:?}, preset {:?}, threads {}",
            options.method, options.preset, options.threads
        ))?;
    }
    several(failures, n)?;
    if as_json {
        let mut m = Map::new();
        m.insert("jobs".into(), entries.into());
        say::out(&json::success(m))?;
    }
    Ok(())
}

/// Quads that the sizes ask for, rounded; `None` if the sizes cannot be used.
fn expected_quads(job: &Job, options: &Options) -> Option<u64> {
    let field = size_field(job, options.gradation)?;
    let loops: Vec<Vec<Point2>> = job.domain.loops.iter().map(|l| l.nodes.clone()).collect();
    let n = csalf_sizemap::expected_quads(&*field, &loops).ok()?;
    // Saturates; a mesh has at least one quad.
    Some(n.round().max(1.0) as u64)
}
