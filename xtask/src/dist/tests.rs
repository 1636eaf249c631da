//! Tests of the archives and packages of a program. The tests in other systems are a part of `cargo xtask dist --test`.

use std::collections::BTreeMap;
use std::io::{Cursor, Read as _};
use std::sync::LazyLock;

use flate2::read::GzDecoder;
use serde_json::Value;
use zip::ZipArchive;

use super::*;

/// A time after 2001, so that it has ten digits.
const TIME: u64 = 1_700_000_000;

/// A file that an archive contains: its mode and content.
type Files = BTreeMap<String, (u32, Vec<u8>)>;

fn program() -> Program {
    let mut licences = licences();
    licences.extend(notices::FILES.map(|name| File::new(name, "Licence of a wing\n")));
    Program { platform: &PLATFORMS[1], bytes: b"\x7fELF\0".to_vec(), licences }
}

fn documents() -> Documents {
    Documents {
        completions: ["uavspec.bash", "uavspec.fish", "_uavspec"].map(|name| File::new(name, name)).to_vec(),
        man_pages: vec![File::new("uavspec.1", ".TH uavspec 1\n")],
        changes: File::new("CHANGELOG.md", "# Changes\n"),
    }
}

/// The npm package and the wheel of a program. They are built once for all tests.
static PACKAGES: LazyLock<[Package; 2]> = LazyLock::new(|| {
    package::for_platform(&Content::of(repository()).expect("the content"), &program()).expect("packages")
});

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

/// The members of an `ar` archive.
fn members(mut bytes: &[u8]) -> BTreeMap<String, Vec<u8>> {
    bytes = bytes.strip_prefix(b"!<arch>\n").expect("an ar archive");
    let mut members = BTreeMap::new();
    while !bytes.is_empty() {
        let (header, rest) = bytes.split_at(60);
        let header = std::str::from_utf8(header).expect("ASCII");
        assert!(header.ends_with("`\n"), "{header:?}");
        assert_eq!(header[16..28].trim_end(), TIME.to_string(), "{header:?}");
        let size: usize = header[48..58].trim_end().parse().expect("a size");
        members.insert(header[..16].trim_end().to_owned(), rest[..size].to_vec());
        bytes = &rest[size.next_multiple_of(2).min(rest.len())..];
    }
    members
}

fn text(files: &Files, path: &str) -> String {
    String::from_utf8(files.get(path).unwrap_or_else(|| panic!("no {path}")).1.clone()).expect("UTF-8")
}

#[test]
fn the_archive_contains_the_program_and_its_documents() {
    let package = archive(&program(), &documents(), TIME).expect("an archive");
    let folder = format!("uavspec-{VERSION}-aarch64-unknown-linux-musl");
    assert_eq!(package.file_name, format!("{folder}.tar.gz"));
    let files = tape(&package.bytes);
    assert_eq!(files[&format!("{folder}/uavspec")], (0o755, program().bytes));
    for path in ["LICENSE-MIT", notices::FILES[0], "README.md", "completions/_uavspec", "man/man1/uavspec.1"]
    {
        assert_eq!(files.get(&format!("{folder}/{path}")).map(|file| file.0), Some(0o644), "{path}");
    }
    assert_eq!(files.len(), package.count);
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
    let package = archive(&program(), &documents(), TIME).expect("an archive");
    let fill = |template: &str| {
        template
            .replace("{ version }", VERSION)
            .replace("{ target }", program().platform.target)
            .replace("{ bin }{ binary-ext }", "uavspec")
    };
    assert!(fill(&found.url).ends_with(&format!("/{}", package.file_name)), "{}", found.url);
    assert!(tape(&package.bytes).contains_key(&fill(&found.program)), "{}", found.program);
}

#[test]
fn the_debian_package_has_the_format_of_dpkg() {
    let package = debian::package(&program(), &documents(), TIME).expect("a package");
    assert_eq!(package.file_name, format!("uavspec_{VERSION}-1_arm64.deb"));
    let members = members(&package.bytes);
    assert_eq!(members["debian-binary"], b"2.0\n");
    let control = text(&tape(&members["control.tar.gz"]), "control");
    for line in ["Package: uavspec", "Architecture: arm64", &format!("Version: {VERSION}-1")] {
        assert!(control.lines().any(|found| found == line), "{line} is missing in {control}");
    }
    let files = tape(&members["data.tar.gz"]);
    for folder in ["usr/", "usr/bin/", "usr/share/man/man1/"] {
        assert_eq!(files.get(folder).map(|file| file.0), Some(0o755), "{folder}");
    }
    assert_eq!(files["usr/bin/uavspec"], (0o755, program().bytes));
    let copyright = text(&files, "usr/share/doc/uavspec/copyright");
    assert!(
        copyright.contains(" Permission is hereby granted") && !copyright.contains("\n\n Perm"),
        "{copyright}"
    );
    for path in [
        "bash-completion/completions/uavspec",
        "doc/uavspec/THIRD-PARTY-LICENSES.txt.gz",
        "fish/vendor_completions.d/uavspec.fish",
        "man/man1/uavspec.1.gz",
        "zsh/vendor-completions/_uavspec",
    ] {
        assert_eq!(files.get(&format!("usr/share/{path}")).map(|file| file.0), Some(0o644), "{path}");
    }
}

#[test]
fn the_wheel_contains_the_program_for_its_platform() {
    let [_, package] = &*PACKAGES;
    let tags = "manylinux_2_17_aarch64.manylinux2014_aarch64.musllinux_1_1_aarch64";
    assert_eq!(package.file_name, format!("uavspec-{VERSION}-py3-none-{tags}.whl"));
    let mut archive = ZipArchive::new(Cursor::new(&package.bytes)).expect("an archive");
    let mut read = |path: &str| {
        let mut entry = archive.by_name(path).unwrap_or_else(|error| panic!("{path}: {error}"));
        let mut content = Vec::new();
        entry.read_to_end(&mut content).expect("content");
        (entry.unix_mode().map(|mode| mode & 0o777), content)
    };
    let script = format!("uavspec-{VERSION}.data/scripts/uavspec");
    assert_eq!(read(&script), (Some(0o755), program().bytes));
    let mut text = |name: &str| {
        let (_, bytes) = read(&format!("uavspec-{VERSION}.dist-info/{name}"));
        String::from_utf8(bytes).expect("UTF-8")
    };
    let wheel = text("WHEEL");
    assert!(wheel.contains("Root-Is-Purelib: false\n"), "{wheel}");
    for tag in tags.split('.') {
        assert!(wheel.contains(&format!("Tag: py3-none-{tag}\n")), "{wheel}");
    }
    assert!(text("RECORD").contains(&format!("{script},sha256=")));
    assert!(text("METADATA").contains("License-File: THIRD-PARTY-LICENSES.txt\n"));
    assert_eq!(text("licenses/THIRD-PARTY-LICENSES.txt"), "Licence of a wing\n");
}

#[test]
fn the_npm_package_is_for_one_platform() {
    let [package, _] = &*PACKAGES;
    assert_eq!(package.file_name, format!("uavspec-linux-arm64-{VERSION}.tgz"));
    let files = tape(&package.bytes);
    assert_eq!(files["package/bin/uavspec"], (0o755, program().bytes));
    let manifest: Value = serde_json::from_str(&text(&files, "package/package.json")).expect("JSON");
    let expected = serde_json::json!(["@uavspec/linux-arm64", VERSION, ["linux"], ["arm64"]]);
    let found = ["name", "version", "os", "cpu"].map(|key| manifest[key].clone());
    assert_eq!(serde_json::json!(found), expected);
}

#[test]
fn the_npm_package_with_the_launcher_declares_only_the_platforms_that_were_built() {
    let content = Content::of(repository()).expect("the content");
    let packages = package::for_all_platforms(&content, &[&PLATFORMS[1]]).expect("packages");
    let files = tape(&packages[0].bytes);
    assert_eq!(files.get("package/bin/uavspec.cjs").map(|file| file.0), Some(0o755));
    assert!(text(&files, "package/README.md").contains("\n## Program\n"));
    let manifest: Value = serde_json::from_str(&text(&files, "package/package.json")).expect("JSON");
    assert_eq!(manifest["bin"], serde_json::json!({ "uavspec": "bin/uavspec.cjs" }));
    assert_eq!(manifest["optionalDependencies"], serde_json::json!({ "@uavspec/linux-arm64": VERSION }));
}

#[test]
fn the_checksums_have_the_format_of_sha256sum() {
    let package = Package { file_name: "a.deb".to_owned(), count: 1, bytes: b"abc".to_vec() };
    let text = String::from_utf8(checksums(&[package]).bytes).expect("UTF-8");
    assert_eq!(text, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad  a.deb\n");
}
