//! Whole models.

use crate::common::{folder, run};

const BLOCK: &str = include_str!("../../../csalf-step/tests/data/block.step");

const JOB: &str = "input = 'block.step'\noutput = ['block.vtu']\nsize = 3\nthreads = 2\nreport = 'all.json'\njson = true\n\
                   [layers]\n'hole<20' = 1\n\
                   [model]\nper_turn = 20\nfaces = { top = 2.5 }\nloops = { 'hole*' = 1.5 }\n\
                   points = { spot = [5.0, 5.0, 10.0] }\n";

#[test]
fn a_model_takes_its_options_from_a_file() {
    let folder = folder("model_config");
    std::fs::write(folder.join("block.step"), BLOCK).unwrap();
    std::fs::write(folder.join("job.toml"), JOB).unwrap();
    let ran = run(&folder, &["mesh", "--config", "job.toml"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    let v = ran.json();
    assert_eq!((v["n_faces"].as_u64(), v["n_free_sides"].as_u64()), (Some(7), Some(0)));
    assert_eq!((v["n_failures"].as_u64(), v["outputs"][0].as_str()), (Some(0), Some("block.vtu")));
    assert!(v["mesh_cpu_s"].as_f64().is_some() && v["read_s"].as_f64().is_some());
    let all: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(folder.join("all.json")).unwrap()).unwrap();
    assert_eq!(all["faces"].as_array().map(Vec::len), Some(7));
    let sum: u64 = all["faces"].as_array().unwrap().iter().map(|f| f["n_quads"].as_u64().unwrap()).sum();
    assert_eq!(Some(sum), v["n_quads"].as_u64());
    assert_eq!(all["layers"].as_array().map(Vec::len), Some(2), "{}", all["layers"]);
    // The command line wins, and the number of threads does not matter.
    let first = std::fs::read(folder.join("block.vtu")).unwrap();
    assert_eq!(run(&folder, &["mesh", "--config", "job.toml", "--threads", "1"]).code, 0);
    assert!(first == std::fs::read(folder.join("block.vtu")).unwrap());
    let coarse = run(&folder, &["mesh", "--config", "job.toml", "--size", "6"]).json();
    assert!(coarse["n_quads"].as_u64() < v["n_quads"].as_u64());
}

#[test]
fn what_a_model_cannot_have_is_said() {
    let folder = folder("model_wrong");
    std::fs::write(folder.join("block.step"), BLOCK).unwrap();
    std::fs::write(folder.join("part.igs"), "").unwrap();
    for (args, word) in [
        (&["mesh", "block.step"][..], "nothing to write"),
        (&["mesh", "block.step", "-o", "a.vtu", "--format", "nonsense"], "nonsense"),
        (&["mesh", "block.step", "-o", "a", "--shard", "1/2", "--order", "2"], "--order"),
        (&["mesh", "block.step", "-o", "a.vtu", "--centres"], "--order"),
        (&["mesh", "part.igs", "-o", "a.vtu"], "csalf.cad"),
    ] {
        let ran = run(&folder, args);
        assert_eq!(ran.code, 2, "{args:?}: {}", ran.err);
        assert!(ran.err.contains(word), "{args:?}: {}", ran.err);
    }
    let ran = run(&folder, &["mesh", "block.step", "-o", "a.obj", "--order", "2"]);
    assert!(ran.code == 3 && ran.err.contains("no quadratic elements"), "{}", ran.err);
    let ran = run(&folder, &["mesh", "block.step", "-o", "a.vtu", "--size", "8", "--layers", "slot*=2"]);
    assert!(ran.code == 0 && ran.err.contains("no loop has such a name"), "{}", ran.err);
    std::fs::remove_file(folder.join("a.vtu")).unwrap();
    let ran = run(&folder, &["mesh", "block.step", "-o", "a.vtu", "--dry-run"]);
    assert!(ran.code == 0 && ran.out.contains("circle, diameter 12"), "{}", ran.out);
    assert!(!folder.join("a.vtu").exists());
}

#[test]
fn elements_of_second_order_are_those_of_the_first_with_more_nodes() {
    let folder = folder("model_order");
    std::fs::write(folder.join("block.step"), BLOCK).unwrap();
    let nodes_of = |order: &[&str]| {
        let ran = run(&folder, &[&["mesh", "block.step", "-o", "a.msh2", "--size", "6"], order].concat());
        assert_eq!(ran.code, 0, "{}", ran.err);
        let text = std::fs::read_to_string(folder.join("a.msh2")).unwrap();
        let part = |name: &str| {
            let (_, rest) = text.split_once(&format!("${name}\n")).unwrap();
            rest.lines().skip(1).take_while(|l| !l.starts_with('$')).map(str::to_owned).collect::<Vec<_>>()
        };
        (part("Nodes"), part("Elements"))
    };
    let quads = |elements: &[String], kind: &str| {
        let all = elements.iter().map(|l| l.split(' ').map(str::to_owned).collect::<Vec<_>>());
        all.filter(|l| l[1] == kind).map(|l| l[5..9].to_vec()).collect::<Vec<_>>()
    };
    let (points, elements) = nodes_of(&[]);
    let corners = quads(&elements, "3");
    for (order, kind, more) in [
        (&["--order", "2"][..], "16", 2 * corners.len()),
        (&["--order", "2", "--centres"], "10", 3 * corners.len()),
    ] {
        let (all, elements) = nodes_of(order);
        assert_eq!(all[..points.len()], points);
        // The block is closed: as many sides as half of four per quad.
        assert_eq!(all.len(), points.len() + more);
        assert_eq!(quads(&elements, kind), corners);
    }
}

#[test]
fn info_lists_faces_and_holes() {
    let folder = folder("model_info");
    std::fs::write(folder.join("block.step"), BLOCK).unwrap();
    let v = run(&folder, &["info", "block.step", "--json"]).json();
    assert_eq!(v["faces"].as_array().map(Vec::len), Some(7));
    assert_eq!(
        (v["holes"][0]["name"].as_str(), v["holes"][0]["diameter"].as_f64()),
        (Some("hole1"), Some(12.0))
    );
}

#[test]
fn a_meshed_model_is_checked_drawn_and_shown() {
    let folder = folder("model_shown");
    std::fs::write(folder.join("block.step"), BLOCK).unwrap();
    let page = ["mesh", "block.step", "-o", "a.vtu", "-o", "a.png", "--size", "6", "--report", "a.html"];
    assert_eq!(run(&folder, &[&page[..], &["--layers", "hole*=2"]].concat()).code, 0);
    let text = std::fs::read_to_string(folder.join("a.html")).unwrap();
    for part in ["\"face_of_quad\"", "hole1", "warpage", "function triangle("] {
        assert!(text.contains(part), "{part}");
    }
    assert!(!text.contains("://") && !text.contains("@HOW@"));
    let checked = run(&folder, &["check", "a.vtu", "--json", "--min-sj", "0.3"]);
    assert_eq!(checked.code, 0, "{}", checked.err);
    let v = checked.json();
    assert!(v["quality"]["max_warpage"].as_f64().is_some_and(|w| w < 0.2), "{}", checked.out);
    assert_eq!(run(&folder, &["plot", "a.vtu", "-o", "w.svg", "--by", "warpage"]).code, 0);
    assert!(std::fs::read_to_string(folder.join("w.svg")).unwrap().contains("</svg>"));
    // A quad turned round is found.
    let obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 0 1\nv 1 1 1\nf 1 2 3 4\nf 2 3 6 5\n";
    std::fs::write(folder.join("turned.obj"), obj).unwrap();
    let ran = run(&folder, &["check", "turned.obj"]);
    assert!(ran.code == 1 && ran.err.contains("same direction"), "{} {}", ran.out, ran.err);
    let swept = run(&folder, &["sweep", "turned.obj", "-o", "s.vtu", "--along", "0,0,1", "--layers", "2"]);
    assert!(swept.code != 0 && swept.err.contains("not planar"), "{}", swept.err);
}
