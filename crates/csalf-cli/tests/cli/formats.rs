//! All formats, the gate on meshes, and the demo.

use crate::common::{folder, run, run_with_input, square};
use std::fs;

#[test]
fn several_outputs_of_one_run() {
    let dir = folder("several");
    let names = ["a.vtu", "a.msh", "a.msh2", "a.inp", "a.bdf", "a.obj", "a.svg", "a.png"];
    let mut args = vec!["mesh", "-"];
    names.iter().for_each(|n| args.extend(["-o", n]));
    let r = run_with_input(&dir, &args, &square(3));
    assert_eq!(r.code, 0, "{}", r.err);
    for name in names {
        assert!(fs::metadata(dir.join(name)).unwrap().len() > 100, "{name}");
    }
    for name in &names[..6] {
        let j = run(&dir, &["check", name, "--json"]).json();
        assert_eq!((j["ok"].as_bool(), j["n_quads"].as_u64()), (Some(true), Some(9)), "{name}: {j}");
    }
}

#[test]
fn check_is_a_gate() {
    let dir = folder("check");
    let r = run_with_input(&dir, &["mesh", "-", "-o", "a.vtu"], &square(3));
    assert_eq!(r.code, 0, "{}", r.err);
    let good = run(&dir, &["check", "a.vtu", "--min-sj", "0.99"]);
    assert_eq!(good.code, 0, "{}", good.err);
    assert!(good.out.contains("scaled Jacobian"), "{}", good.out);
    let held = ["check", "a.vtu", "--json", "--require", "min_angle>=89", "--require", "edge_ratio<=1.01"];
    let held = run(&dir, &held).json();
    assert_eq!(held["requirements"][1]["n_failed"], 0);
    assert_eq!(held["digest"].as_str().map(str::len), Some(32));
    let unmet = run(&dir, &["check", "a.vtu", "--require", "min_edge>=1e6"]);
    assert!(unmet.code == 1 && unmet.err.contains("min_edge>=1000000: not met by"), "{}", unmet.err);
    let bad = run(&dir, &["check", "a.vtu", "--min-sj", "1.01"]);
    assert_eq!(bad.code, 1);
    assert!(bad.err.contains("less than 1.01"), "{}", bad.err);
    let j = run(&dir, &["check", "a.vtu", "--min-sj", "1.01", "--json"]).json();
    assert!(j["ok"] == false && j["exit_code"] == 1, "{j}");
}

#[test]
fn check_finds_broken_meshes_and_reads_standard_input() {
    let dir = folder("broken");
    let head = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\n";
    let check =
        |faces: &str| run_with_input(&dir, &["check", "-", "--format", "obj"], &format!("{head}{faces}"));
    let good = check("f 1 2 3 4\nf 2 5 6 3\n");
    assert_eq!(good.code, 0, "{}", good.err);
    for faces in ["f 1 2 3 4\nf 2 3 6 5\n", "f 1 2 4 3\nf 2 5 6 3\n", "f 1 2 3 4\nf 1 2 3 4\n"] {
        let r = check(faces);
        assert_eq!(r.code, 1, "{faces}: {} {}", r.out, r.err);
        assert!(r.err.starts_with("error: "), "{}", r.err);
    }
    assert_eq!(check("f 1 2 3 99\n").code, 3);
    assert_eq!(check("").code, 3);
}

#[test]
fn the_demo_leaves_a_mesh_and_a_picture() {
    let dir = folder("demo");
    let r = run(&dir, &["demo", "-o", "new/folder"]);
    assert_eq!(r.code, 0, "{}", r.err);
    let picture = fs::read(dir.join("new/folder/demo.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG"));
    let mesh = fs::read(dir.join("new/folder/demo.vtu")).unwrap();
    assert_eq!(run(&dir, &["demo"]).code, 0);
    assert_eq!(mesh, fs::read(dir.join("demo.vtu")).unwrap(), "the same bytes on every run");
    let j = run(&dir, &["check", "demo.vtu", "--json", "--min-sj", "0.3"]).json();
    assert!(j["ok"] == true && j["n_triangles"] == 0, "{j}");
}

#[test]
fn the_format_of_standard_output_can_be_chosen() {
    let dir = folder("stdout_format");
    let obj = run_with_input(&dir, &["mesh", "-", "-o", "-", "--format", "obj"], &square(2));
    assert_eq!(obj.out.lines().filter(|l| l.starts_with("f ")).count(), 4, "{}", obj.out);
}

#[test]
fn plot_draws_a_mesh_by_a_metric() {
    let dir = folder("plot");
    let r = run_with_input(&dir, &["mesh", "-", "-o", "a.vtu", "-o", "a.svg"], &square(4));
    assert_eq!(r.code, 0, "{}", r.err);
    let plot = |more: &[&str]| run(&dir, &[&["plot", "a.vtu", "-o"], more].concat());
    for by in
        ["shape", "skew", "aspect_ratio", "jacobian_ratio", "min_angle", "max_angle", "area", "size_ratio"]
    {
        let r = plot(&["b.svg", "--by", by]);
        assert_eq!(r.code, 0, "{by}: {}", r.err);
        assert!(fs::read_to_string(dir.join("b.svg")).unwrap().starts_with("<svg"));
    }
    assert_eq!(plot(&["b.png", "--by", "area"]).code, 0);
    assert!(fs::read(dir.join("b.png")).unwrap().starts_with(b"\x89PNG"));
    assert!(plot(&["-", "--format", "svg"]).out.starts_with("<svg"));
    let unknown = plot(&["b.svg", "--by", "beauty"]);
    assert!(unknown.code == 2 && unknown.err.contains("known are scaled_jacobian"), "{}", unknown.err);
    assert_eq!(plot(&["b.vtu"]).code, 2);
}
