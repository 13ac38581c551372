//! Readers of jobs and outlines: small good files, and broken ones, which are errors and never panics.

use csalf_geom::{Point2, polygon::signed_area};
use csalf_io::{Input, JobFormat, JobInput, read_job_bytes};
use proptest::prelude::*;

const GEOJSON: &str = r#"{"type":"FeatureCollection","features":[{"type":"Feature","properties":{"NAME":"A"},
 "geometry":{"type":"MultiPolygon","coordinates":[[[[0,0],[4,0],[4,0],[4,4],[0,4],[0,0]],[[1,1],[1,2],[2,2],[1,1]]],
 [[[9,0],[10,0],[10,1],[9,1],[9,0]]]]}},{"type":"Feature","properties":{},"geometry":{"type":"Point","coordinates":[1,2]}}]}"#;

const TOPOJSON: &str = r#"{"type":"Topology","transform":{"scale":[0.5,2],"translate":[10,20]},
 "arcs":[[[0,0],[4,0]],[[4,0],[0,4],[-4,0],[0,-4]]],
 "objects":{"map":{"type":"GeometryCollection","geometries":[
 {"type":"Polygon","id":7,"arcs":[[0,1]]},{"type":"Polygon","properties":{"name":"back"},"arcs":[[-2,-1]]}]}}}"#;

const MSH: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n1 5 \"rim\"\n$EndPhysicalNames\n\
 $Nodes\n8\n1 0 0 0\n2 4 0 0\n3 4 4 0\n4 0 4 0\n5 1 1 0\n6 2 1 0\n7 2 2 0\n8 1 2 0\n$EndNodes\n$Elements\n8\n\
 1 1 2 0 1 1 2\n2 1 2 0 1 3 2\n3 1 2 0 1 3 4\n4 1 2 0 1 4 1\n\
 5 1 2 5 2 5 6\n6 1 2 5 2 6 7\n7 1 2 5 2 7 8\n8 1 2 5 2 8 5\n$EndElements\n";

const JSON: &str = r#"{"name":"n","loops":[{"kind":"outer","nodes":[[0,0],[4,0],[4,4],[0,4]]}],
 "layers":{"outer":{"count":2,"law":"ramp"}},"size":{"kind":"uniform","h":0.5}}"#;

const POLY: &str = "4 2 0 0\n1 0 0\n2 1 0\n3 1 1\n4 0 1\n4 0\n1 1 2\n2 2 3\n3 3 4\n4 4 1\n0\n";

const SVG: &str =
    r#"<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9"><path d="M0 0C1 1 2 2 3 0L3 3z"/></svg>"#;

const DXF: &str = "0\nSECTION\n2\nENTITIES\n0\nCIRCLE\n8\n0\n10\n3\n20\n3\n40\n0.5\n0\nLWPOLYLINE\n8\n0\n90\n4\n70\n1\n\
 10\n0\n20\n0\n10\n2\n20\n0\n42\n1\n10\n2\n20\n1\n10\n0\n20\n1\n42\n1\n0\nENDSEC\n0\nEOF\n";

const ALL: [(JobFormat, &str); 7] = [
    (JobFormat::Json, JSON),
    (JobFormat::GeoJson, GEOJSON),
    (JobFormat::TopoJson, TOPOJSON),
    (JobFormat::Poly, POLY),
    (JobFormat::Svg, SVG),
    (JobFormat::Msh, MSH),
    (JobFormat::Dxf, DXF),
];

fn jobs(format: JobFormat, text: &str) -> (Vec<csalf_core::Job>, Vec<String>) {
    let JobInput { input, notes, .. } = read_job_bytes(format, text.as_bytes()).unwrap();
    match input {
        Input::Jobs(jobs) => (jobs, notes),
        other => panic!("jobs expected, not {other:?}"),
    }
}

#[test]
fn geojson_polygons_become_even_jobs() {
    let (jobs, notes) = jobs(JobFormat::Json, GEOJSON); // found out by its `type`
    let names: Vec<&str> = jobs.iter().map(|j| j.name.as_str()).collect();
    assert_eq!(names, ["A_0", "A_1"]);
    // 4 and 3 nodes: one more in the middle of the longest segment, the first of length 4.
    assert_eq!(jobs[0].domain.loops[0].nodes.len(), 5);
    assert_eq!(jobs[0].domain.loops[0].nodes[1], Point2::new(2.0, 0.0));
    assert_eq!(jobs[0].domain.loops[1].nodes.len(), 3);
    assert_eq!(notes.len(), 3, "{notes:?}");
}

#[test]
fn topojson_arcs_are_decoded_and_turned() {
    let (jobs, _) = jobs(JobFormat::TopoJson, TOPOJSON);
    assert_eq!((jobs[0].name.as_str(), jobs[1].name.as_str()), ("7", "back"));
    let ring = &jobs[0].domain.loops[0].nodes;
    assert_eq!(ring[..], [(10., 20.), (12., 20.), (12., 28.), (10., 28.)].map(|(x, y)| Point2::new(x, y)));
    assert_eq!(signed_area(ring), 16.0);
    assert_eq!(signed_area(&jobs[1].domain.loops[0].nodes), -16.0);
}

#[test]
fn gmsh_lines_become_loops_with_the_names_of_their_groups() {
    let (jobs, notes) = jobs(JobFormat::Msh, MSH);
    assert_eq!((jobs.len(), notes.len()), (1, 0));
    let loops = &jobs[0].domain.loops;
    assert_eq!((loops[0].name.as_str(), loops[1].name.as_str()), ("outer", "rim"));
    assert_eq!((signed_area(&loops[0].nodes), signed_area(&loops[1].nodes)), (16.0, -1.0));
}

#[test]
fn drawings_give_curves() {
    for (format, text, n) in [(JobFormat::Dxf, DXF, 2), (JobFormat::Svg, SVG, 1)] {
        match read_job_bytes(format, text.as_bytes()).unwrap().input {
            Input::Curves(c) => {
                assert_eq!(c.len(), n);
                assert!(c.iter().all(|c| c.geometry.check().is_empty()));
            }
            other => panic!("curves expected, not {other:?}"),
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Cut off, with bytes changed, taken out or put in: a value or an error, never a panic.
    #[test]
    fn broken_files_do_not_panic(
        which in 0..ALL.len(),
        cut in 0.0f64..1.0,
        changes in prop::collection::vec((0.0f64..1.0, prop::sample::select(&b"0123456789-.eE[]{}\",:\n <>/zAx\xff"[..])), 0..5),
        remove in 0usize..4,
    ) {
        let (format, text) = ALL[which];
        let mut bytes = text.as_bytes().to_vec();
        for (at, byte) in changes {
            let k = (at * bytes.len() as f64) as usize;
            bytes[k] = byte;
        }
        let k = (cut * bytes.len() as f64) as usize;
        if remove == 0 { bytes.truncate(k) } else { bytes.drain(k..(k + remove - 1).min(bytes.len())); }
        let _ = read_job_bytes(format, &bytes);
    }

    /// Any bytes at all.
    #[test]
    fn noise_does_not_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        for (format, _) in ALL {
            let _ = read_job_bytes(format, &bytes);
        }
    }
}
