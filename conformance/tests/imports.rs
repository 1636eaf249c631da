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

/// Rules name each other where one can't be violated without the other, so their files may form rings.
const RULES: &str = "rules::flockwave::";

#[test]
fn no_files_of_a_room_import_each_other_in_a_ring() {
    let levels = Imports::read(Path::new(env!("CARGO_MANIFEST_DIR"))).between_siblings();
    let rings = levels.iter().flat_map(Imports::cycles);
    let found: Vec<String> =
        rings.filter(|ring| !ring.split(", ").all(|file| file.starts_with(RULES))).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}
