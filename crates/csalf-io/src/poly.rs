//! Triangle's `.poly` files: nodes, segments, hole seeds.
//!
//! Segments between material and nothing are loops, all others scars; nodes on no segment are hard points. The
//! format is that of J. R. Shewchuk's Triangle, as its manual describes it. Files that leave their nodes to a
//! `.node` file beside them (0 nodes) are not read.

use crate::{IoError, JobInput, graph, text::Cursor};
use csalf_geom::Point2;

const FORMAT: &str = "Triangle";

/// Reads jobs, one for each connected piece of material.
///
/// # Errors
/// [`IoError::Syntax`] with the line; [`IoError::Unsupported`]; [`IoError::Empty`] without a closed loop.
pub fn read(bytes: &[u8]) -> Result<JobInput, IoError> {
    let clean = without_comments(bytes);
    let mut text = Cursor::new(&clean, FORMAT);
    let n_nodes: usize = text.number("the number of nodes")?;
    if n_nodes == 0 {
        return Err(text.unsupported("the nodes are in a .node file; put them into the .poly file"));
    }
    if text.number::<u32>("the dimension")? != 2 {
        return Err(text.unsupported("nodes of more than two dimensions"));
    }
    let n_attributes: usize = text.number("the number of attributes")?;
    let n_markers: usize = text.number("the number of markers")?;
    let mut points = Vec::new();
    let mut first = 0;
    for i in 0..n_nodes {
        let number: usize = text.number("a node number")?;
        if i == 0 {
            first = number;
        }
        if number != first.saturating_add(i) || first > 1 {
            return Err(text.error(format!("node {number} where {} should be", first + i)));
        }
        let p = Point2::new(text.number("a coordinate")?, text.number("a coordinate")?);
        if !p.is_finite() {
            return Err(text.error(format!("node {number} is not at a finite place")));
        }
        for _ in 0..n_attributes {
            text.number::<f64>("an attribute")?;
        }
        for _ in 0..n_markers {
            text.number::<f64>("a marker")?;
        }
        points.push(p);
    }
    let n_segments: usize = text.number("the number of segments")?;
    let n_markers: usize = text.number("the number of markers")?;
    let mut segments = Vec::new();
    for _ in 0..n_segments {
        let _number: i64 = text.number("a segment number")?;
        let mut ends = [0u32; 2];
        for e in &mut ends {
            let node: usize = text.number("a node number")?;
            let k = node.checked_sub(first).filter(|&k| k < points.len());
            *e = k.ok_or_else(|| text.error(format!("there is no node {node}")))? as u32;
        }
        for _ in 0..n_markers {
            text.number::<f64>("a marker")?;
        }
        segments.push(ends);
    }
    let mut holes = Vec::new();
    // The list of holes may be missing at the end of hand-written files.
    if let Some(n) = text.token() {
        let n: usize = n.parse().map_err(|_| text.error(format!("{n:?} is not the number of holes")))?;
        for _ in 0..n {
            let _number: i64 = text.number("a hole number")?;
            holes.push(Point2::new(text.number("a coordinate")?, text.number("a coordinate")?));
        }
    }
    let mut plan = graph::assemble(&points, &segments, graph::Rule::Seeds(&holes));
    let mut on_segment = vec![false; points.len()];
    segments.iter().flatten().for_each(|&v| on_segment[v as usize] = true);
    let lone = (0..points.len() as u32).filter(|&v| !on_segment[v as usize]);
    plan.add_points(&points, lone.map(|v| (v, None)));
    plan.into_input(FORMAT, &points, &[], Vec::new())
}

/// The text with all comments (`#` to the end of the line) made blank, so that lines keep their numbers.
fn without_comments(bytes: &[u8]) -> Vec<u8> {
    let mut inside = false;
    let blank = |&b: &u8| {
        inside = b != b'\n' && (inside || b == b'#');
        if inside { b' ' } else { b }
    };
    bytes.iter().map(blank).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Input;
    use csalf_core::Job;

    fn jobs(text: &str) -> Vec<Job> {
        match read(text.as_bytes()).unwrap().input {
            Input::Jobs(j) => j,
            _ => Vec::new(),
        }
    }

    const PLATE: &str = "# a plate\n9 2 0 1\n1 0 0 1\n2 4 0 1\n3 4 4 1\n4 0 4 1\n\
        5 1 1 2\n6 2 1 2\n7 2 2 2\n8 1 2 2\n9 3 3 0\n";

    #[test]
    fn a_ring_with_a_seed_is_a_hole_and_one_without_a_scar() {
        let segments = "8 0\n1 1 2\n2 2 3\n3 3 4\n4 4 1\n5 5 6\n6 6 7\n7 7 8\n8 8 5\n";
        let with = jobs(&format!("{PLATE}{segments}1\n1 1.5 1.5\n"));
        let d = &with[0].domain;
        assert_eq!((with.len(), d.loops.len(), d.scars.len(), d.points.len()), (1, 2, 0, 1));
        assert_eq!(d.points[0].xy, Point2::new(3.0, 3.0));
        assert!(csalf_geom::polygon::signed_area(&d.loops[0].nodes) == 16.0);
        assert!(csalf_geom::polygon::signed_area(&d.loops[1].nodes) == -1.0);
        let without = jobs(&format!("{PLATE}{segments}0\n"));
        let d = &without[0].domain;
        assert_eq!((d.loops.len(), d.scars.len()), (1, 1));
        assert_eq!(d.scars[0].nodes.len(), 5);
    }

    #[test]
    fn dead_ends_and_chords_are_scars() {
        let chord = jobs(&format!("{PLATE}6 1\n1 1 2 1\n2 2 3 1\n3 3 4 1\n4 4 1 1\n5 1 5 0\n6 5 3 0\n"));
        let d = &chord[0].domain;
        assert_eq!((d.loops[0].nodes.len(), d.scars.len(), d.scars[0].nodes.len()), (4, 1, 3));
        let tail = jobs(&format!("{PLATE}5 0\n1 1 2\n2 2 3\n3 3 4\n4 4 1\n5 1 5\n0\n"));
        assert_eq!(tail[0].domain.scars[0].nodes, [Point2::new(0.0, 0.0), Point2::new(1.0, 1.0)]);
        assert_eq!(tail[0].domain.points.len(), 4);
    }

    #[test]
    fn errors_have_their_line() {
        let e = read(b"4 2 0 0\n0 0 0\n1 1 x\n").unwrap_err().to_string();
        assert!(e.contains("line 3"), "{e}");
        let e = read(b"2 2 0 0\n0 0 0\n1 1 0\n1 0\n0 0 7\n").unwrap_err().to_string();
        assert!(e.contains("node 7"), "{e}");
        let e = read(b"2 2 0 0\n0 0 0\n1 1 0\n1 0\n0 0 1\n0\n").unwrap_err().to_string();
        assert!(e.contains("closed loop"), "{e}");
    }
}
