//! Exit codes, streams and messages of everything that does not need a mesh.

use crate::common::{self, folder, run, run_with_input, square};
use std::fs;

#[test]
fn help_and_version_are_done() {
    let dir = folder("help");
    for args in [&["--help"][..], &["mesh", "--help"], &["--version"], &["check", "-h"]] {
        let r = run(&dir, args);
        assert_eq!(r.code, 0, "{args:?}: {}", r.err);
        assert!(!r.out.is_empty() && r.err.is_empty(), "{args:?}");
    }
    assert!(run(&dir, &["--help"]).out.contains("Exit codes"));
}

#[test]
fn wrong_usage_is_2() {
    let dir = folder("usage");
    fs::write(dir.join("a.json"), square(2)).unwrap();
    fs::write(dir.join("bad.toml"), "sizes = 1\n").unwrap();
    let cases: [(&[&str], &str); 16] = [
        (&[], "Usage"),
        (&["stitch"], "stitch"),
        (&["mesh"], "INPUT"),
        (&["mesh", "a.json"], "nothing to write"),
        (&["mesh", "a.json", "-o", "b.zip"], "extension"),
        (&["mesh", "a.json", "-o", "b"], "extension"),
        (&["mesh", "a.xyz", "-o", "b.vtu"], "extension"),
        (&["mesh", "a.json", "-o", "b.vtu", "-o", "b.vtu"], "twice"),
        (&["mesh", "a.json", "-o", "-", "--json"], "standard output"),
        (&["mesh", "a.json", "-o", "b.vtu", "--format", "zip"], "vtu, msh41"),
        (&["mesh", "a.json", "-o", "b.vtu", "--size", "0"], "above 0"),
        (&["mesh", "a.json", "-o", "b.vtu", "--layers", "hole*"], "PATTERN=COUNT"),
        (&["mesh", "a.json", "-o", "b.vtu", "--layer-law", "step"], "not a law"),
        (&["mesh", "a.json", "-o", "b.vtu", "-q", "-v"], "cannot be used"),
        (&["mesh", "--config", "bad.toml"], "sizes"),
        (&["check", "a.vtu", "--min-sj", "x"], "min-sj"),
    ];
    for (args, word) in cases {
        let r = run(&dir, args);
        assert_eq!(r.code, 2, "{args:?}: {}", r.err);
        assert!(r.err.contains(word), "{args:?} should say '{word}': {}", r.err);
        assert!(args.contains(&"--json") || r.out.is_empty(), "{args:?}: {}", r.out);
    }
    assert_eq!(fs::read_dir(&dir).unwrap().count(), 2, "nothing was written");
}

#[test]
fn content_that_is_no_job_is_3() {
    let dir = folder("content");
    for (text, word) in [
        ("", "line 1"),
        ("{\"loops\":[{\"kind\":\"outer\",\"nodes\":[[0,0],[1,0,", "line"),
        ("{\"loops\":[{\"kind\":\"outer\",\"nodes\":[[0,0],[1,\"a\"]]}]}", "loops[0].nodes[1]"),
        ("{\"loops\":[],\"size\":{\"kind\":\"uniform\",\"h\":-1}}", "size"),
    ] {
        let r = run_with_input(&dir, &["mesh", "-", "-o", "out.vtu"], text);
        assert_eq!(r.code, 3, "{text}: {}", r.err);
        assert!(r.err.contains(word) && r.err.contains("standard input"), "{text}: {}", r.err);
    }
    assert!(!dir.join("out.vtu").exists());
}

#[test]
fn file_trouble_is_5() {
    let dir = folder("trouble");
    for args in [
        &["mesh", "missing.json", "-o", "a.vtu"][..],
        &["mesh", "--config", "missing.toml"],
        &["check", "missing.vtu"],
        &["info", "missing.json"],
    ] {
        let r = run(&dir, args);
        assert_eq!(r.code, 5, "{args:?}: {}", r.err);
        assert!(r.err.contains("missing"), "{args:?}: {}", r.err);
    }
}

#[test]
fn a_failure_with_json_ends_with_one_object() {
    let dir = folder("json_failure");
    let r = run(&dir, &["mesh", "missing.json", "--json"]);
    assert_eq!(r.code, 5);
    assert_eq!(r.out.lines().count(), 1);
    assert_eq!(r.json()["ok"], false);
    assert_eq!(r.json()["exit_code"], 5);
    assert_eq!(r.json()["n_errors"], 1);
}

#[test]
fn no_colour_where_nobody_looks() {
    let dir = folder("color");
    for args in [&["mesh", "missing.json", "--json"][..], &["--bad"], &["--help"]] {
        let r = run(&dir, args);
        assert!(!r.err.contains('\x1b') && !r.out.contains('\x1b'), "{args:?}: {:?}", r.err);
        let mut c = common::program(&dir, args);
        let o = c.env("NO_COLOR", "1").env("CLICOLOR_FORCE", "0").output().unwrap();
        assert!(!o.stderr.contains(&0x1b) && !o.stdout.contains(&0x1b), "{args:?}");
    }
}

#[test]
fn info_tells_what_is_there() {
    let dir = folder("info");
    fs::write(dir.join("a.json"), square(3)).unwrap();
    let r = run(&dir, &["info", "a.json"]);
    assert_eq!(r.code, 0, "{}", r.err);
    assert!(r.out.contains("1 loops, 12 segments (even), area 9"), "{}", r.out);
    let j = run_with_input(&dir, &["info", "-", "--json"], &square(3)).json();
    assert_eq!(j["jobs"][0]["n_segments"], 12);
    assert_eq!(j["jobs"][0]["area"], 9.0);
}

#[test]
fn a_dry_run_writes_nothing() {
    let dir = folder("dry");
    fs::write(dir.join("a.json"), square(3)).unwrap();
    fs::write(
        dir.join("job.toml"),
        "input = 'a.json'\noutput = 'b.vtu'\nmethod = 'tqm'\n[layers]\nouter = 2\n",
    )
    .unwrap();
    let r = run(&dir, &["mesh", "--config", "job.toml", "--dry-run"]);
    assert_eq!(r.code, 0, "{}", r.err);
    assert!(r.out.contains("would write") && r.out.contains("Tqm") && r.out.contains("outer 2"), "{}", r.out);
    assert!(!dir.join("b.vtu").exists());
}

#[test]
fn unknown_keys_are_named_and_do_no_harm() {
    let dir = folder("keys");
    let text = square(2).replacen('{', "{\"colour\":\"red\",", 1);
    let r = run_with_input(&dir, &["info", "-"], &text);
    assert_eq!(r.code, 0);
    assert!(r.err.contains("warning: standard input: unknown key `colour`"), "{}", r.err);
    let quiet = run_with_input(&dir, &["info", "-", "-q"], &text);
    assert!(quiet.err.is_empty(), "{}", quiet.err);
}

#[test]
fn completions_name_the_commands() {
    let dir = folder("completions");
    for shell in ["bash", "zsh", "fish"] {
        let r = run(&dir, &["completions", shell]);
        assert_eq!(r.code, 0);
        assert!(r.out.contains("dry-run") && r.out.contains("check"), "{shell}");
    }
}
