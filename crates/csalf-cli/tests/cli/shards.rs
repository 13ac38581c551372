//! Models in shards: the bytes of one process, and refusals that say which shard.

use crate::common::{folder, run};
use std::fs;

const BLOCK: &str = include_str!("../../../csalf-step/tests/data/block.step");

#[test]
fn shards_stitch_to_the_bytes_of_one_run() {
    let dir = folder("shards");
    fs::write(dir.join("block.step"), BLOCK).unwrap();
    let asked = ["--size", "4", "--layers", "hole*=2"];
    let mesh = |more: &[&str]| run(&dir, &[&["mesh", "block.step"], &asked[..], more].concat());
    let whole = mesh(&["-o", "whole.inp", "-o", "whole.vtu"]);
    assert_eq!(whole.code, 0, "{}", whole.err);
    for k in 1..=3 {
        let r = mesh(&["--shard", &format!("{k}/3"), "-o", &format!("part{k}.csalf-shard")]);
        assert_eq!(r.code, 0, "{}", r.err);
        assert!(r.out.contains(&format!("shard {k} of 3")), "{}", r.out);
    }
    let parts = ["part2.csalf-shard", "part3.csalf-shard", "part1.csalf-shard"];
    let stitch = |parts: &[&str], more: &[&str]| run(&dir, &[&["stitch"], parts, more].concat());
    let r = stitch(&parts, &["-o", "all.inp", "-o", "all.vtu"]);
    assert_eq!(r.code, 0, "{}", r.err);
    for suffix in ["inp", "vtu"] {
        let read = |name: &str| fs::read(dir.join(format!("{name}.{suffix}"))).unwrap();
        assert!(read("whole") == read("all"), "{suffix}");
    }
    let j = stitch(&parts, &["--json"]).json();
    assert!(j["ok"] == true && j["n_faces"] == 7 && j["n_free_sides"] == 0, "{j}");
    // What is missing, twice, of another run, damaged.
    let missing = stitch(&parts[..2], &["-o", "x.inp"]);
    assert_eq!(missing.code, 3);
    assert!(missing.err.contains("shard 1 of 3 missing"), "{}", missing.err);
    let twice = stitch(&[parts[0], parts[1], parts[2], parts[0]], &["-o", "x.inp"]);
    assert!(twice.code == 3 && twice.err.contains("both shard 2"), "{}", twice.err);
    let other =
        run(&dir, &["mesh", "block.step", "--size", "5", "--shard", "1/3", "-o", "other.csalf-shard"]);
    assert_eq!(other.code, 0, "{}", other.err);
    let foreign = stitch(&[parts[0], parts[1], "other.csalf-shard"], &["-o", "x.inp"]);
    let says = "other.csalf-shard belongs to another run";
    assert!(foreign.code == 3 && foreign.err.contains(says), "{}", foreign.err);
    let mut bytes = fs::read(dir.join("part1.csalf-shard")).unwrap();
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    fs::write(dir.join("torn.csalf-shard"), bytes).unwrap();
    let torn = stitch(&[parts[0], parts[1], "torn.csalf-shard"], &["-o", "x.inp"]);
    assert!(torn.code == 3 && torn.err.contains("torn.csalf-shard is damaged"), "{}", torn.err);
    assert!(!dir.join("x.inp").exists());
}

#[test]
fn wrong_uses_of_shards() {
    let dir = folder("shards_wrong");
    fs::write(dir.join("block.step"), BLOCK).unwrap();
    fs::write(dir.join("square.json"), crate::common::square(2)).unwrap();
    for part in ["0/3", "4/3", "3", "a/b", "1/0", "1/99999999"] {
        let r = run(&dir, &["mesh", "block.step", "--shard", part, "-o", "x.csalf-shard"]);
        assert_eq!(r.code, 2, "{part}: {}", r.err);
    }
    assert_eq!(run(&dir, &["mesh", "block.step", "--shard", "1/2"]).code, 2);
    assert_eq!(run(&dir, &["mesh", "square.json", "--shard", "1/2", "-o", "x"]).code, 2);
    assert_eq!(run(&dir, &["stitch", "block.step", "-o", "x.inp"]).code, 3);
    assert_eq!(run(&dir, &["stitch", "none", "-o", "x.inp"]).code, 5);
    assert_eq!(run(&dir, &["stitch", "block.step"]).code, 2);
}
