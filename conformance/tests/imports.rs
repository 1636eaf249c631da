//! Tests that the modules of the crate import each other in one direction only.

#[path = "../../codegen/tests/imports/graph.rs"]
mod graph;

use std::path::Path;

use graph::Imports;

/// The modules in layers, from the top down: each imports only modules in lower layers.
const LAYERS: &[&[&str]] = &[
    &["app", "fuzzing"],
    &["explain", "tables"],
    &["report"],
    &["self_test"],
    &["convert", "probe", "serve", "testee", "watch"],
    &["story", "vehicle"],
    &["check"],
    &["rules"],
    &["definitions"],
    &["bus", "flockwave", "px4"],
    &["capture"],
    &["json", "net"],
    &["model"],
    &["clock", "text"],
];

#[test]
fn modules_import_only_lower_layers() {
    let found = Imports::read(Path::new(env!("CARGO_MANIFEST_DIR"))).upward(LAYERS);
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// The module whose files may import each other in cycles: rules that are always violated together refer to each other.
const RULES: &str = "rules::flockwave::";

#[test]
fn files_of_a_module_have_no_import_cycles() {
    let levels = Imports::read(Path::new(env!("CARGO_MANIFEST_DIR"))).between_siblings();
    let cycles = levels.iter().flat_map(Imports::cycles);
    let found: Vec<String> =
        cycles.filter(|cycle| !cycle.split(", ").all(|file| file.starts_with(RULES))).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}
