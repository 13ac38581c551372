//! Tells what job files hold: `cargo run -p csalf-io --example read_jobs -- FILE...`.
#![allow(clippy::print_stdout, reason = "an example that prints")]

use csalf_io::{Input, read_job};

fn main() {
    for path in std::env::args().skip(1) {
        match read_job(path.as_ref()) {
            Err(e) => println!("{path}: {e}"),
            Ok(read) => {
                match &read.input {
                    Input::Curves(list) => {
                        for c in list {
                            let (g, defects) = (&c.geometry, c.geometry.check());
                            let n: usize = g.chains().map(|(_, edges, _)| edges.len()).sum();
                            let counts = (g.loops.len(), g.scars.len());
                            println!("{path}: {} (loops, scars) {counts:?}, {n} curves, {defects:?}", c.name);
                        }
                    }
                    Input::Jobs(list) => {
                        let loops: usize = list.iter().map(|j| j.domain.loops.len()).sum();
                        let scars: usize = list.iter().map(|j| j.domain.scars.len()).sum();
                        let nodes: usize =
                            list.iter().flat_map(|j| &j.domain.loops).map(|l| l.nodes.len()).sum();
                        println!("{path}: {} jobs, {loops} loops, {scars} scars, {nodes} nodes", list.len());
                    }
                    _ => println!("{path}: something newer than this example"),
                }
                println!("{path}: {} notes, first: {:?}", read.notes.len(), read.notes.first());
            }
        }
    }
}
