//! Documents to replies, without a server: what the page and the WebAssembly module rely on.

use csalf_core::Job;
use csalf_geom::Domain;
use csalf_geom::curve::Curve;
use csalf_geom::{Geometry, Point2};
use csalf_sizemap::SizeSpec;
use csalf_studio::{Document, engine};
use serde_json::Value;

fn head(reply: &[u8]) -> Value {
    let n = u32::from_le_bytes(reply[..4].try_into().unwrap()) as usize;
    serde_json::from_slice(&reply[4..4 + n]).unwrap()
}

fn text(document: &Document) -> Vec<u8> {
    document.write().unwrap().get().as_bytes().to_vec()
}

fn ring() -> Geometry {
    let circle = |r| vec![Curve::circle(Point2::new(1.0, 2.0), r)];
    Geometry::new(circle(3.0)).with_hole(circle(1.0))
}

#[test]
fn a_document_comes_back_as_it_was() {
    let document = Document::of_geometry("ring".into(), ring());
    assert_eq!(Document::read(&text(&document)).unwrap(), document);
    let square = [(0.0, 0.0), (0.1, 0.0), (0.1, 0.1), (0.0, 0.1)].map(Point2::from);
    let document = Document::of_job(Job { domain: Domain::new(square.to_vec()), ..Job::default() });
    assert_eq!(Document::read(&text(&document)).unwrap(), document);
}

#[test]
fn curves_follow_the_size_and_given_nodes_do_not() {
    let mut document = Document::of_geometry("ring".into(), ring());
    let nodes = |d: &Document, k: usize| d.ready().unwrap().job.domain.loops[k].nodes.len();
    document.job.size = SizeSpec::Uniform { h: 0.5 };
    let coarse = nodes(&document, 0);
    document.job.size = SizeSpec::Uniform { h: 0.25 };
    assert!(nodes(&document, 0) > 3 * coarse / 2);

    // The hole as given nodes: it stays, the outer loop follows; all of it with `resample`.
    let given = document.ready().unwrap().job.domain.loops[1].nodes.clone();
    document.job.domain.loops[1].nodes.clone_from(&given);
    document.loops[1] = None;
    document.job.size = SizeSpec::Uniform { h: 0.5 };
    let ready = document.ready().unwrap();
    assert_eq!(ready.job.domain.loops[1].nodes, given);
    assert!(ready.job.domain.loops[0].nodes.len().abs_diff(coarse) <= 1);
    assert!(ready.job.domain.check().is_empty(), "25 given nodes: the rest is odd, too");
    assert_eq!(given.len() % 2, 1);
    document.resample = true;
    assert!(nodes(&document, 1) < given.len());
    // Without a size the curve takes that of the nodes beside it.
    document.resample = false;
    document.job.size = SizeSpec::Boundary;
    assert!(nodes(&document, 0) > 3 * coarse / 2);
}

#[test]
fn the_same_document_gives_the_same_bytes() {
    let document = Document::of_geometry("ring".into(), ring());
    let mesh = || {
        let reply = engine::mesh(&text(&document), &()).unwrap();
        let n = u32::from_le_bytes(reply[..4].try_into().unwrap()) as usize;
        reply[4 + n..].to_vec()
    };
    assert_eq!(mesh(), mesh());
    let export = || engine::export(&text(&document), "vtu", &()).unwrap();
    assert_eq!(export(), export());
}

#[test]
fn defects_have_places() {
    let mut document = Document::of_geometry("ring".into(), ring());
    document.loops[1] = Some(vec![Curve::circle(Point2::new(4.0, 2.0), 1.0)]);
    let head_of = |d: &Document| head(&engine::mesh(&text(d), &()).unwrap());
    let reply = head_of(&document);
    assert_eq!(reply["ok"], false);
    let place = reply["errors"][0]["places"][0].as_array().unwrap();
    let (x, y) = (place[0].as_f64().unwrap(), place[1].as_f64().unwrap());
    assert!((Point2::new(x, y).distance(Point2::new(1.0, 2.0)) - 3.0).abs() < 0.1, "{reply}");
    assert!(reply["arrays"]["outline"][1].as_u64().unwrap() > 100, "the outline is there to be drawn");

    // A gap: no nodes, and still a sketch.
    document.loops[1] = Some(vec![Curve::arc(Point2::new(1.0, 2.0), 1.0, 0.0, 3.0)]);
    let reply = head_of(&document);
    assert!(reply["errors"][0]["text"].as_str().unwrap().contains("gap"), "{reply}");
    assert!(reply["arrays"]["outline"][1].as_u64().unwrap() > 20);

    let nothing = head_of(&Document::default());
    assert!(nothing["errors"][0]["text"].as_str().unwrap().contains("outer"), "{nothing}");
}

#[test]
fn the_exported_job_gives_the_same_mesh() {
    let document = Document::of_geometry("ring".into(), ring());
    let job = engine::export(&text(&document), "json", &()).unwrap();
    assert_eq!(job.name, "ring.json");
    let opened: Value = serde_json::from_slice(&engine::open(&job.name, &job.bytes).unwrap()).unwrap();
    let again = opened["documents"][0].to_string();
    let bdf = |d: &[u8]| engine::export(d, "bdf", &()).unwrap().bytes;
    assert_eq!(bdf(again.as_bytes()), bdf(&text(&document)));
}
