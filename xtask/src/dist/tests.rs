//! Tests of the archives and packages of a program. The tests in other systems are a part of `cargo xtask dist --test`.

use std::collections::BTreeMap;
use std::io::Read as _;

use flate2::read::GzDecoder;
use serde_json::Value;

use super::*;

/// A time after 2001, so that it has ten digits.
const TIME: u64 = 1_700_000_000;

/// A file that an archive contains: its mode and content.
type Files = BTreeMap<String, (u32, Vec<u8>)>;

fn program() -> Program {
    let third_party = notices::FILES.map(|name| File::new(name, "Licence of a wing\n")).to_vec();
    Program { platform: &PLATFORMS[1], bytes: b"\x7fELF\0".to_vec(), third_party }
}

/// Builds the archive of the program with a completion and a man page.
fn archive_with_documents() -> File {
    let folder = tempfile::tempdir().expect("a folder");
    for path in ["completions/_uavspec", "man/man1/uavspec.1"] {
        File::new(path, path).write(folder.path()).expect("a file");
    }
    archive(&program(), folder.path(), TIME).expect("an archive")
}

fn tape(bytes: &[u8]) -> Files {
    let mut archive = tar::Archive::new(GzDecoder::new(bytes));
    let mut files = Files::new();
    for entry in archive.entries().expect("entries") {
        let mut entry = entry.expect("an entry");
        let path = entry.path().expect("a path").display().to_string();
        assert_eq!((entry.header().uid().ok(), entry.header().gid().ok()), (Some(0), Some(0)), "{path}");
        let mut content = Vec::new();
        entry.read_to_end(&mut content).expect("content");
        let mode = entry.header().mode().expect("a mode");
        assert!(files.insert(path.clone(), (mode, content)).is_none(), "duplicate file {path}");
    }
    files
}

fn text(files: &Files, path: &str) -> String {
    String::from_utf8(files.get(path).unwrap_or_else(|| panic!("no {path}")).1.clone()).expect("UTF-8")
}

#[test]
fn the_archive_contains_the_program_and_its_documents() {
    let package = archive_with_documents();
    let folder = format!("uavspec-{VERSION}-aarch64-unknown-linux-musl");
    assert_eq!(package.path, format!("{folder}.tar.gz"));
    let files = tape(&package.bytes);
    assert_eq!(files[&format!("{folder}/uavspec")], (0o755, program().bytes));
    for path in ["LICENSE-MIT", notices::FILES[0], "README.md", "completions/_uavspec", "man/man1/uavspec.1"]
    {
        assert_eq!(files.get(&format!("{folder}/{path}")).map(|file| file.0), Some(0o644), "{path}");
    }
}

#[test]
fn cargo_binstall_finds_the_program_in_the_archive() {
    #[derive(serde::Deserialize)]
    struct Binstall {
        #[serde(rename = "pkg-url")]
        url: String,
        #[serde(rename = "bin-dir")]
        program: String,
    }
    let manifest: toml::Table =
        toml::from_str(include_str!("../../../conformance/Cargo.toml")).expect("TOML");
    let found: Binstall = manifest["package"]["metadata"]["binstall"].clone().try_into().expect("metadata");
    let package = archive_with_documents();
    let fill = |template: &str| {
        template
            .replace("{ version }", VERSION)
            .replace("{ target }", program().platform.target)
            .replace("{ bin }{ binary-ext }", "uavspec")
    };
    assert!(fill(&found.url).ends_with(&format!("/{}", package.path)), "{}", found.url);
    assert!(tape(&package.bytes).contains_key(&fill(&found.program)), "{}", found.program);
}

#[test]
fn the_npm_package_is_for_one_platform() {
    let package = package::for_platform(&program()).expect("a package");
    assert_eq!(package.path, format!("uavspec-linux-arm64-{VERSION}.tgz"));
    let files = tape(&package.bytes);
    assert_eq!(files["package/bin/uavspec"], (0o755, program().bytes));
    let manifest: Value = serde_json::from_str(&text(&files, "package/package.json")).expect("JSON");
    let expected = serde_json::json!(["@uavspec/linux-arm64", VERSION, ["linux"], ["arm64"]]);
    let found = ["name", "version", "os", "cpu"].map(|key| manifest[key].clone());
    assert_eq!(serde_json::json!(found), expected);
}

#[test]
fn the_npm_package_with_the_launcher_declares_only_the_platforms_that_were_built() {
    let packages = package::for_all_platforms(&[&PLATFORMS[1]]).expect("packages");
    assert_eq!(packages[1].path, format!("uavspec-{VERSION}.tgz"));
    let files = tape(&packages[1].bytes);
    assert_eq!(files.get("package/bin/uavspec.cjs").map(|file| file.0), Some(0o755));
    let manifest: Value = serde_json::from_str(&text(&files, "package/package.json")).expect("JSON");
    assert_eq!(manifest["bin"], serde_json::json!({ "uavspec": "bin/uavspec.cjs" }));
    assert_eq!(manifest["optionalDependencies"], serde_json::json!({ "@uavspec/linux-arm64": VERSION }));
}

#[test]
fn the_checksums_have_the_format_of_sha256sum() {
    let package = File::new("a.deb", "abc");
    let text = String::from_utf8(checksums(&[package]).bytes).expect("UTF-8");
    assert_eq!(text, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad  a.deb\n");
}
