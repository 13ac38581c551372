//! From outline to files, through the whole program.

use crate::common::{folder, program, run, run_with_input, square};
use std::fs;

#[test]
fn an_outline_becomes_a_mesh() {
    let dir = folder("mesh");
    fs::write(dir.join("a.json"), square(4)).unwrap();
    let r = run(&dir, &["mesh", "a.json", "-o", "b.vtu"]);
    assert_eq!(r.code, 0, "{}", r.err);
    assert!(r.out.contains("square: 16 quads, 25 vertices"), "{}", r.out);
    assert!(r.out.contains("wrote b.vtu"), "{}", r.out);
    let bytes = fs::read(dir.join("b.vtu")).unwrap();
    assert!(String::from_utf8_lossy(&bytes).contains("UnstructuredGrid"));
}

#[test]
fn standard_input_to_standard_output() {
    let dir = folder("streams");
    let r = run_with_input(&dir, &["mesh", "-", "-o", "-"], &square(2));
    assert_eq!(r.code, 0, "{}", r.err);
    assert!(r.out.starts_with("<?xml") && r.out.trim_end().ends_with("</VTKFile>"), "{}", r.out);
    assert_eq!(fs::read_dir(&dir).unwrap().count(), 0);
}

#[test]
fn json_is_the_last_line_and_complete() {
    let dir = folder("json");
    let r = run_with_input(&dir, &["mesh", "-", "-o", "a.vtu", "--json"], &square(3));
    assert_eq!(r.code, 0, "{}", r.err);
    assert_eq!(r.out.lines().count(), 1, "{}", r.out);
    let j = r.json();
    assert_eq!(j["ok"], true);
    assert_eq!(
        (j["n_quads"].as_u64(), j["n_vertices"].as_u64(), j["n_triangles"].as_u64()),
        (Some(9), Some(16), Some(0))
    );
    assert!(j["mesh_s"].as_f64().unwrap() >= 0.0 && j["mesh_cpu_s"].as_f64().unwrap() >= 0.0);
    assert!((j["quality"]["min_sj"].as_f64().unwrap() - 1.0).abs() < 1e-9, "{j}");
    for key in ["layers", "members", "warnings", "n_warnings", "stages", "outputs", "name"] {
        assert!(j.get(key).is_some(), "{key} is missing in {j}");
    }
}

#[test]
fn the_report_is_written() {
    let dir = folder("report");
    let r = run_with_input(&dir, &["mesh", "-", "--report", "r.json"], &square(3));
    assert_eq!(r.code, 0, "{}", r.err);
    let all: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(dir.join("r.json")).unwrap()).unwrap();
    assert_eq!(all[0]["n_quads"], 9);
}

#[test]
fn an_invalid_domain_is_3_and_every_defect_is_listed() {
    let dir = folder("invalid");
    let hole = r#",{"kind":"hole","nodes":[[1,1],[1,2],[9,2],[2,1.5],[2,1]]}]}"#;
    let text = square(4).replace("]}]}", &format!("]}}{hole}"));
    let r = run_with_input(&dir, &["mesh", "-", "-o", "a.vtu"], &text);
    assert_eq!(r.code, 3, "{}", r.err);
    assert!(r.err.starts_with("error: standard input: "), "{}", r.err);
    assert!(r.err.lines().count() > 2, "one line per defect: {}", r.err);
    assert!(r.err.contains("hole0 [1]"), "loop and node: {}", r.err);
    assert!(r.err.contains("(9, 2)"), "coordinates: {}", r.err);
    assert!(!dir.join("a.vtu").exists());
    let j = run_with_input(&dir, &["mesh", "-", "--json"], &text).json();
    assert!(j["exit_code"] == 3 && j["n_errors"].as_u64() > Some(1), "{j}");
}

#[test]
fn a_folder_that_is_not_there_is_5() {
    let dir = folder("no_folder");
    let r = run_with_input(&dir, &["mesh", "-", "-o", "none/a.vtu"], &square(2));
    assert_eq!(r.code, 5, "{}", r.err);
    assert!(r.err.contains("none/a.vtu") || r.err.contains("none\\a.vtu"), "{}", r.err);
}

#[test]
fn quiet_is_silent() {
    let dir = folder("quiet");
    let r = run_with_input(&dir, &["mesh", "-", "-o", "a.vtu", "-q"], &square(2));
    assert_eq!((r.code, r.out.as_str(), r.err.as_str()), (0, "", ""));
}

#[test]
fn threads_and_verbosity_do_not_change_a_byte() {
    let dir = folder("threads");
    let text = square(12);
    let mesh = |extra: &[&str]| {
        let args = [&["mesh", "-", "-o", "-", "--size", "0.7", "--layers", "outer=1"], extra].concat();
        let r = run_with_input(&dir, &args, &text);
        assert_eq!(r.code, 0, "{}", r.err);
        r.bytes
    };
    let one = mesh(&["--threads", "1"]);
    assert!(one.len() > 1000);
    assert_eq!(one, mesh(&["--threads", "2"]));
    assert_eq!(one, mesh(&["--threads", "4", "-vvv"]));
}

#[test]
fn a_configuration_does_what_its_options_would() {
    let dir = folder("config");
    fs::create_dir(dir.join("jobs")).unwrap();
    fs::write(dir.join("jobs/a.json"), square(6)).unwrap();
    fs::write(dir.join("jobs/a.toml"), "input = 'a.json'\noutput = ['b.vtu', 'c.vtu']\nmethod = 'tqm'\n")
        .unwrap();
    let r = run(&dir, &["mesh", "--config", "jobs/a.toml"]);
    assert_eq!(r.code, 0, "{}", r.err);
    let direct = run(&dir, &["mesh", "jobs/a.json", "-o", "d.vtu", "--method", "tqm"]);
    assert_eq!(direct.code, 0, "{}", direct.err);
    assert_eq!(fs::read(dir.join("jobs/b.vtu")).unwrap(), fs::read(dir.join("d.vtu")).unwrap());
    assert!(dir.join("jobs/c.vtu").exists());
}

#[test]
fn a_closed_pipe_is_no_error() {
    let dir = folder("pipe");
    fs::write(dir.join("a.json"), square(40)).unwrap();
    let mut child = program(&dir, &["mesh", "a.json", "-o", "-"])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let o = child.wait_with_output().unwrap();
    assert_eq!(o.status.code(), Some(0), "{}", String::from_utf8_lossy(&o.stderr));
    assert!(o.stderr.is_empty());
}

/// Two squares, the first with a spike that crosses it, and a name with signs that files do not like.
const COUNTIES: &str = r#"{"type":"FeatureCollection","features":[
{"type":"Feature","properties":{"NAME":"Bath/1"},"geometry":{"type":"Polygon",
 "coordinates":[[[0,0],[2,0],[2,2],[1,-1],[0,2],[0,0]]]}},
{"type":"Feature","properties":{"NAME":"York"},"geometry":{"type":"Polygon",
 "coordinates":[[[5,0],[6,0],[7,0],[7,1],[7,2],[6,2],[5,2],[5,0]]]}}]}"#;

#[test]
fn a_failing_outline_does_not_lose_the_others() {
    let dir = folder("outlines");
    fs::write(dir.join("va.geojson"), COUNTIES).unwrap();
    let r = run(&dir, &["mesh", "va.geojson", "-o", "va.vtu", "--json"]);
    assert_eq!(r.code, 3, "{}", r.err);
    assert!(dir.join("va_1_York.vtu").exists() && !dir.join("va_0_Bath_1.vtu").exists());
    assert!(r.err.contains("a node was added to outer"), "{}", r.err);
    assert!(r.err.contains("va.geojson (Bath/1): ") && r.err.contains("cross"), "{}", r.err);
    assert!(r.err.contains("1 of 2 outlines failed"), "{}", r.err);
    let j = r.json();
    assert!(j["n_errors"] == 1 && j["errors"][0].as_str().unwrap().contains("Bath/1"), "{j}");
    let r = run(&dir, &["mesh", "va.geojson", "-o", "va.vtu", "--dry-run"]);
    assert_eq!(r.code, 3, "{}", r.err);
    assert!(r.out.contains("about ") && r.out.contains("va_1_York.vtu"), "{}", r.out);
}

#[test]
fn curves_are_given_nodes() {
    let dir = folder("curves");
    let svg = r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 10 10">
        <path fill-rule="evenodd" d="M0 0H10V10H0Z M5 3A2 2 0 0 1 5 7A2 2 0 0 1 5 3Z"/></svg>"#;
    fs::write(dir.join("plate.svg"), svg).unwrap();
    let r = run(&dir, &["mesh", "plate.svg", "-o", "plate.vtu", "--size", "0.5"]);
    assert_eq!(r.code, 0, "{}", r.err);
    let j = run(&dir, &["check", "plate.vtu", "--json", "--min-sj", "0.2"]).json();
    assert!(j["ok"] == true && (300..700).contains(&j["n_quads"].as_u64().unwrap()), "{j}");
    let r = run(&dir, &["info", "plate.svg", "--job", "plate.json"]);
    assert!(r.err.contains("no size given"), "{}", r.err);
    let j = run(&dir, &["info", "plate.json", "--json"]).json();
    assert!(j["jobs"][0]["n_loops"] == 2 && j["jobs"][0]["n_segments"].as_u64().unwrap() > 100, "{j}");
}

#[test]
fn given_nodes_are_kept_or_placed_anew() {
    let dir = folder("resample");
    let n = |args: &[&str]| {
        let r = run_with_input(&dir, args, &square(4));
        assert_eq!(r.code, 0, "{}", r.err);
        r.json()["jobs"][0]["n_segments"].as_u64().unwrap()
    };
    assert_eq!(n(&["info", "-", "--json", "--size", "0.5"]), 16);
    assert_eq!(n(&["info", "-", "--json", "--size", "0.5", "--resample"]), 32);
    let j = run_with_input(&dir, &["mesh", "-", "--size", "0.5", "--resample", "--json"], &square(4)).json();
    assert_eq!(j["n_quads"], 64);
    let dry = run_with_input(&dir, &["mesh", "-", "--size", "0.5", "--dry-run", "--json"], &square(4)).json();
    assert_eq!(dry["jobs"][0]["expected_quads"], 64);
}

#[test]
fn layers_for_nobody_are_a_warning() {
    let dir = folder("nobody");
    let r = run_with_input(&dir, &["mesh", "-", "--json", "--layers", "hole*=2,outer=1"], &square(4));
    assert_eq!(r.code, 0, "{}", r.err);
    assert!(r.err.contains("layers for 'hole*': nothing has such a name"), "{}", r.err);
    assert!(!r.err.contains("'outer'"), "{}", r.err);
}

#[test]
fn rings_that_touch_nest_or_leave_are_named() {
    let dir = folder("rings");
    let outer = "[[0,0],[6,0],[6,6],[0,6],[0,0]]";
    for (rings, word) in [
        (format!("{outer},[[0,0],[1,2],[2,2],[2,1],[0,0]]"), "two loops may not touch"),
        (format!("{outer},[[5,5],[8,5],[8,8],[5,8],[5,5]]"), "cross near (6, 5)"),
        (format!("{outer},[[8,8],[9,8],[9,9],[8,9],[8,8]]"), "hole0 [0] (8, 8) lies outside"),
        (
            format!("{outer},[[1,1],[5,1],[5,5],[1,5],[1,1]],[[2,2],[3,2],[3,3],[2,3],[2,2]]"),
            "inside the hole hole0",
        ),
        ("[[0,0],[2,2],[4,0],[4,4],[2,2],[0,4],[0,0]]".into(), "outer [4] (2, 2) repeats outer [1] (2, 2)"),
    ] {
        let text = format!(r#"{{"type":"Polygon","coordinates":[{rings}]}}"#);
        let r = run_with_input(&dir, &["mesh", "-", "--json"], &text);
        assert_eq!(r.code, 3, "{rings}: {}", r.err);
        assert!(r.err.contains(word), "{rings}: {}", r.err);
    }
    // An island in a hole is an outline of its own.
    let text = format!(
        r#"{{"type":"MultiPolygon","coordinates":[[{outer},[[1,1],[5,1],[5,5],[1,5],[1,1]]],[[[2,2],[3,2],[3,3],[2,3],[2,2]]]]}}"#
    );
    let r = run_with_input(&dir, &["mesh", "-", "--json"], &text);
    assert_eq!((r.code, r.json()["n_jobs"].as_u64()), (0, Some(2)), "{}", r.err);
}
