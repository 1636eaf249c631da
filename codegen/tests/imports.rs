//! The modules of the crate import each other in one direction.

mod graph;

use std::path::Path;

use graph::Imports;

/// The modules from the top down: each imports modules of lower floors only.
const FLOORS: &[&[&str]] = &[
    &["cli"],
    &["generate"],
    &["load", "rewrite"],
    &["emit"],
    &["report"],
    &["breaking", "dynamic", "format", "lint"],
    &["example", "translation"],
    &["read", "render"],
    &["resolve"],
    &["schema"],
    &["table"],
    &["msg"],
    &["characters", "directive", "finding", "path", "pattern", "prose", "source", "unit", "value"],
    &["diagnostic"],
    &["failure", "span"],
];

#[test]
fn modules_import_lower_floors_only() {
    let found = Imports::read(Path::new(env!("CARGO_MANIFEST_DIR"))).upward(FLOORS);
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn no_files_import_each_other_in_a_ring() {
    let found = Imports::read(Path::new(env!("CARGO_MANIFEST_DIR"))).cycles();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn no_modules_of_a_folder_import_each_other_in_a_ring() {
    let levels = Imports::read(Path::new(env!("CARGO_MANIFEST_DIR"))).between_siblings();
    let found: Vec<String> = levels.iter().flat_map(Imports::cycles).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}
