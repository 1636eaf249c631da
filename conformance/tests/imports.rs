//! The rooms of the crate import each other in one direction.

#[path = "../../codegen/tests/imports/graph.rs"]
mod graph;

use std::path::Path;

use graph::Imports;

/// The rooms from the top down: each imports rooms of lower floors only.
const FLOORS: &[&[&str]] = &[
    &["app"],
    &["report"],
    &["matrix"],
    &["probe", "serve", "testee", "watch"],
    &["check"],
    &["rules"],
    &["definitions"],
    &["flockwave", "px4"],
    &["capture"],
    &["json", "net"],
    &["model"],
    &["text"],
];

#[test]
fn rooms_import_lower_floors_only() {
    let found = Imports::read(Path::new(env!("CARGO_MANIFEST_DIR"))).upward(FLOORS);
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn no_files_of_a_room_import_each_other_in_a_ring() {
    let levels = Imports::read(Path::new(env!("CARGO_MANIFEST_DIR"))).between_siblings();
    let found: Vec<String> = levels.iter().flat_map(Imports::cycles).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}
