//! Tests that the modules of the crate import each other in one direction only.

mod graph;

use std::path::Path;
use std::sync::LazyLock;

use graph::Imports;

/// The modules in layers, from top to bottom. Each module may import only modules in lower layers.
const LAYERS: &[&[&str]] = &[
    &["fuzzing"],
    &["cli", "lsp"],
    &["generate"],
    &["load", "rewrite"],
    &["emit"],
    &["report"],
    &["format", "lint"],
    &["conversion", "release"],
    &["breaking", "dynamic"],
    &["example", "translation"],
    &["read", "render"],
    &["resolve"],
    &["schema"],
    &["table"],
    &["msg"],
    &[
        "difference",
        "directive",
        "finding",
        "identity",
        "json_text",
        "name",
        "parallel",
        "path",
        "pattern",
        "prose",
        "source",
        "stage",
        "unit",
        "value",
        "wording",
    ],
    &["failure"],
    &["terminal"],
    &["characters"],
    &["diagnostic"],
    &["span"],
];

/// The imports of this crate.
static IMPORTS: LazyLock<Imports> = LazyLock::new(|| Imports::read(Path::new(env!("CARGO_MANIFEST_DIR"))));

#[test]
fn modules_import_lower_layers_only() {
    let found = IMPORTS.upward(LAYERS);
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn imports_between_files_have_no_cycles() {
    let found = IMPORTS.cycles();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn imports_between_modules_of_a_folder_have_no_cycles() {
    let levels = IMPORTS.between_siblings();
    let found: Vec<String> = levels.iter().flat_map(Imports::cycles).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}
