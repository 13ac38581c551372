//! The program `csalf`, run as a user runs it: exit codes, streams, files.

mod common;
mod formats;
mod meshing;
mod models;
mod shards;
mod usage;
