//! Reads the line elements of a `.msh` as loops and scars.

use super::{FORMAT, read::gather};
use crate::{IoError, JobInput, graph};

/// Reads a job from line elements: closed chains are loops, open ones scars, point elements hard points. Every
/// node is a mesh node. Other elements do not matter.
///
/// # Errors
/// [`IoError::Syntax`], [`IoError::Unsupported`]; [`IoError::Empty`] if there is no closed chain.
pub fn read_job(bytes: &[u8]) -> Result<JobInput, IoError> {
    let mut g = gather(bytes)?;
    g.name_sets();
    let (data, lines) = g.builder.finish_with_lines()?;
    let data = data.planar(FORMAT)?;
    if lines.is_empty() {
        return Err(IoError::Empty { format: FORMAT, wanted: "line elements" });
    }
    let segments: Vec<[u32; 2]> = lines.iter().map(|l| l.map(|v| v.0)).collect();
    let mut plan = graph::assemble(&data.mesh.points, &segments, graph::Rule::EvenOdd);
    let points =
        data.sets.nodes.iter().flat_map(|(name, v)| v.iter().map(move |v| (v.0, Some(name.as_str()))));
    plan.add_points(&data.mesh.points, points);
    let names: Vec<(&str, Vec<[u32; 2]>)> = data
        .sets
        .edges
        .iter()
        .map(|(n, e)| (n.as_str(), e.iter().map(|e| e.map(|v| v.0)).collect()))
        .collect();
    plan.into_input(FORMAT, &data.mesh.points, &names, data.notes)
}
