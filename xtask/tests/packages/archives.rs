//! Tests of the content of the npm package, without npm.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::Read as _;
use std::path::Path;

use flate2::read::GzDecoder;
use serde_json::Value;

use super::tools::package;

/// The files of an archive, by path.
type Files = BTreeMap<String, String>;

fn tape(path: &Path) -> Files {
    let mut archive = tar::Archive::new(GzDecoder::new(File::open(path).expect("an archive")));
    let mut files = Files::new();
    for entry in archive.entries().expect("entries") {
        let mut entry = entry.expect("an entry");
        let path = entry.path().expect("a path").display().to_string();
        let header = entry.header();
        let found = (header.mode().ok(), header.uid().ok(), header.gid().ok(), header.mtime().ok());
        assert_eq!(found, (Some(0o644), Some(0), Some(0), Some(499_162_500)), "{path}");
        let mut text = String::new();
        entry.read_to_string(&mut text).expect("UTF-8");
        assert!(files.insert(path.clone(), text).is_none(), "duplicate file {path}");
    }
    files
}

#[test]
fn the_npm_package_has_the_expected_content() {
    let npm = tape(&package());
    for (path, text) in &npm {
        assert!(!text.contains('\r'), "{path} contains carriage returns");
    }
    let manifest: Value = serde_json::from_str(&npm["package/package.json"]).expect("JSON");
    assert_eq!(
        (&manifest["version"], &manifest["license"]),
        (&env!("CARGO_PKG_VERSION").into(), &"MIT OR Apache-2.0".into())
    );
    let mut targets = Vec::new();
    leaves(&manifest["exports"], &mut targets);
    assert!(targets.len() >= 20, "{targets:?}");
    for target in targets {
        let path = target.replacen('.', "package", 1);
        let exists = match path.strip_suffix('*') {
            Some(folder) => npm.keys().any(|path| path.starts_with(folder)),
            None => npm.contains_key(&path),
        };
        assert!(exists, "{target} is exported, but missing");
    }

    // The data matches the repository.
    let generated = Path::new(env!("CARGO_MANIFEST_DIR")).join("../generated");
    for path in [
        "schemas/px4/Event.schema.json",
        "schemas/flockwave.bundle.schema.json",
        "vectors/px4/Event.vectors.json",
    ] {
        let text = fs::read_to_string(generated.join(path)).expect("a generated file").replace("\r\n", "\n");
        assert_eq!(npm[&format!("package/{path}")], text);
    }
    assert!(npm["package/LICENSE-MIT"].starts_with("MIT License"));
    assert!(npm["package/LICENSE-APACHE"].contains("Apache License"));
}

/// Adds all strings within a value to `into`.
fn leaves<'v>(value: &'v Value, into: &mut Vec<&'v str>) {
    match value {
        Value::String(text) => into.push(text),
        Value::Object(members) => members.values().for_each(|inner| leaves(inner, into)),
        _ => {}
    }
}

#[test]
fn reports_an_unwritable_folder() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("file");
    fs::write(&path, "").expect("a file");
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_xtask"))
        .args(["package", "--out"])
        .arg(&path)
        .output()
        .expect("xtask runs");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{errors}");
    assert!(errors.contains("file: ") && errors.contains("--out"), "{errors}");
}
