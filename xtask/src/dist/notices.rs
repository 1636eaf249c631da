//! The licences of all code that is linked into the program and the Python module: crates, their C code, and the libraries
//! of Rust and C.
//!
//! cargo-about (0.9.3) also lists macros, which aren't linked. It omits unrecognized texts, such as the licence of
//! fiat-crypto in ring, and the authors of crates without a text. Therefore, this module writes the licences.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use walkdir::{DirEntry, WalkDir};

use crate::archive::File;
use crate::command::output;
use crate::sbom::Crates;

/// The files with licences: of crates and C code, and of Rust's standard library.
pub(super) const FILES: [&str; 2] = ["THIRD-PARTY-LICENSES.txt", "RUST-LIBRARY-LICENSES.html"];

/// Libraries that are not crates, with their licence, origin and copyright. Each program for Linux contains them.
const LIBRARIES: [[&str; 4]; 2] = [
    ["musl", "MIT", "https://musl.libc.org", "Copyright © 2005-2020 Rich Felker, et al."],
    ["libunwind", "Apache-2.0 WITH LLVM-exception", "https://llvm.org", "The LLVM project"],
];

/// The start of the names of files with licences, in lower case.
const NAMES: [&str; 6] = ["licence", "license", "copying", "copyright", "notice", "unlicense"];

/// Licences that don't apply, by crate and path: licences of code that isn't compiled, and alternatives to other
/// licences.
const UNUSED: [(&str, &str); 3] =
    [("libsqlite3-sys", "sqlcipher"), ("petgraph", "assets"), ("zstd-sys", "zstd/COPYING")];

const RULE: &str = "--------------------------------------------------------------------------------";

/// A licensed part of the program.
struct Part {
    name: String,
    licence: String,
    origin: Option<String>,
    /// The texts of its licences, and notices.
    texts: Vec<String>,
}

/// The files with the licences of third-party code in the program and the Python module for a target of the compiler.
pub(super) fn third_party(root: &Path, target: &str) -> Result<Vec<File>, String> {
    let documents =
        PathBuf::from(output(Command::new("rustc").args(["--print", "sysroot"]))?).join("share/doc/rust");
    let standard = Standard { folder: documents.join("licenses") };
    let libraries = LIBRARIES.into_iter().filter(|_| target.contains("linux"));
    let mut parts = libraries.map(|library| standard.part(library)).collect::<Result<Vec<Part>, _>>()?;
    parts.extend(crates(root, target, &standard)?);
    let rust = read(&documents.join("COPYRIGHT-library.html"))?;
    Ok(FILES.iter().zip([document(&parts), rust]).map(|(path, text)| File::new(*path, &text)).collect())
}

/// All crates except the crates of this project.
fn crates(root: &Path, target: &str, standard: &Standard) -> Result<Vec<Part>, String> {
    let dependencies = Crates::linked(root, target)?.dependencies;
    let published = dependencies.into_iter().filter(|found| found.checksum.is_some());
    published
        .map(|found| {
            let (name, licence) = (format!("{} {}", found.name, found.version), found.license());
            let folder = found.manifest_path.parent().unwrap_or(root);
            let paths = licences(&found.name, folder)?;
            let mut texts = paths.iter().map(|path| read(path)).collect::<Result<Vec<String>, String>>()?;
            let is_own = |path: &PathBuf| path.parent() == Some(folder);
            if !paths.iter().any(is_own) {
                texts.push(standard.text(&name, &licence, &found.authors.join(", "))?);
            }
            Ok(Part { name, licence, origin: found.repository, texts })
        })
        .collect()
}

/// The files with the licences of a crate, and of the third-party code in its subfolders. Skips tests and hidden folders,
/// which aren't part of the program.
fn licences(crate_name: &str, folder: &Path) -> Result<Vec<PathBuf>, String> {
    let name = |entry: &DirEntry| entry.file_name().to_string_lossy().to_lowercase();
    let is_part = |entry: &DirEntry| {
        let is_unused =
            |(owner, path): &(&str, &str)| *owner == crate_name && entry.path() == folder.join(path);
        let is_skipped =
            entry.file_type().is_dir() && (name(entry) == "tests" || name(entry).starts_with('.'));
        entry.depth() == 0 || !is_skipped && !UNUSED.iter().any(is_unused)
    };
    let is_licence = |entry: &DirEntry| {
        entry.file_type().is_file() && NAMES.iter().any(|start| name(entry).starts_with(start))
    };
    let entries = WalkDir::new(folder).sort_by_file_name().into_iter().filter_entry(is_part);
    let entries: Vec<DirEntry> = entries.collect::<Result<_, _>>().map_err(|error| error.to_string())?;
    Ok(entries.into_iter().filter(is_licence).map(DirEntry::into_path).collect())
}

fn read(path: &Path) -> Result<String, String> {
    let bytes = fs::read(path).map_err(|error| {
        format!(
            "{}: {error}\n  help: install the Rust toolchain with rustup, and run cargo fetch",
            path.display()
        )
    })?;
    Ok(String::from_utf8_lossy(&bytes).replace("\r\n", "\n"))
}

/// The standard texts of licences, in the documentation of the Rust toolchain.
struct Standard {
    folder: PathBuf,
}

impl Standard {
    /// A library with its name, licence, origin and copyright.
    fn part(&self, [name, licence, origin, copyright]: [&str; 4]) -> Result<Part, String> {
        let texts = vec![self.text(name, licence, copyright)?];
        let origin = Some(origin.to_owned());
        Ok(Part { name: name.to_owned(), licence: licence.to_owned(), origin, texts })
    }

    /// The texts for an SPDX expression, for code that is distributed without a text. One of several alternatives suffices.
    fn text(&self, name: &str, licence: &str, copyright: &str) -> Result<String, String> {
        let words = licence.split([' ', '(', ')']);
        let is_licence = |word: &&str| !matches!(*word, "" | "AND" | "OR" | "WITH");
        let found = words.filter(is_licence).map(|id| read(&self.folder.join(format!("{id}.txt"))));
        let is_choice = licence.contains(" OR ") && !licence.contains(" AND ");
        let (known, unknown): (Vec<_>, Vec<_>) = found.partition(Result::is_ok);
        let is_enough = unknown.is_empty() || is_choice && !known.is_empty();
        let texts: Result<Vec<String>, String> =
            if is_enough { known } else { unknown }.into_iter().collect();
        Ok(format!("{name}: {copyright}\n\n{}", texts?.join("\n\n")))
    }
}

/// The document: a list of all parts, and each different text once, with the parts that it applies to.
fn document(parts: &[Part]) -> String {
    let mut text =
        "The uavspec program and its Python module contain the following third-party code.\n\n".to_owned();
    let mut by_text: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for part in parts {
        let origin = part.origin.as_deref().map_or(String::new(), |origin| format!(", {origin}"));
        let _ = writeln!(text, "{}: {}{origin}", part.name, part.licence);
        for found in &part.texts {
            by_text.entry(found.trim()).or_default().push(&part.name);
        }
    }
    let mut texts: Vec<(Vec<&str>, &str)> = by_text.into_iter().map(|(text, names)| (names, text)).collect();
    texts.sort();
    for (mut names, found) in texts {
        // A crate may contain a text several times, so remove repeated names.
        names.dedup();
        let _ = write!(text, "\n{RULE}\n{}\n{RULE}\n\n{found}\n", names.join("\n"));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paths::repository;

    #[test]
    fn lists_each_text_once() {
        let part = |name: &str, texts: &[&str]| Part {
            name: name.to_owned(),
            licence: "MIT".to_owned(),
            origin: None,
            texts: texts.iter().map(|text| (*text).to_owned()).collect(),
        };
        let parts =
            [part("glider 1.0.0", &["Text A\n", "Text A"]), part("wing 2.0.0", &["Text B", "Text A"])];
        let text = document(&parts);
        assert!(text.contains("\nglider 1.0.0: MIT\nwing 2.0.0: MIT\n"), "{text}");
        assert!(text.contains(&format!("{RULE}\nglider 1.0.0\nwing 2.0.0\n{RULE}\n\nText A\n")), "{text}");
        assert_eq!(text.matches("Text A").count(), 1, "{text}");
    }

    #[test]
    fn lists_the_code_in_the_program() {
        let [crates, rust] =
            &third_party(repository(), "x86_64-unknown-linux-musl").expect("the licences")[..]
        else {
            panic!("expected two files")
        };
        let text = String::from_utf8_lossy(&crates.bytes);
        let list: Vec<&str> = text.lines().skip(2).take_while(|line| !line.is_empty()).collect();
        for name in ["libmimalloc-sys ", "libsqlite3-sys ", "mcap ", "musl:", "pyo3 ", "ring "] {
            assert!(list.iter().any(|line| line.starts_with(name)), "{name} is missing");
        }
        for name in ["cc ", "proptest ", "serde_derive ", "uavspec", "windows-sys "] {
            assert!(!list.iter().any(|line| line.starts_with(name)), "{name} is not part of the program");
        }
        assert!(text.contains("Rich Felker") && text.contains("THE SOFTWARE IS PROVIDED"));
        for owner in ["Daan Leijen", "Meta Platforms", "the fiat-crypto authors"] {
            assert!(text.contains(owner), "{owner} is missing");
        }
        assert!(!text.contains("Zetetic"), "sqlcipher is not part of the program");
        assert!(!rust.bytes.is_empty());
    }

    #[test]
    fn finds_the_licences_of_a_crate_and_of_the_code_in_it() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        for path in [
            "LICENSE-MIT",
            "COPYING",
            "README.md",
            "src/glider/LICENSE",
            "sqlcipher/LICENSE",
            "tests/wing/LICENSE",
            ".github/license.yml",
        ] {
            let path = folder.join(path);
            fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            fs::write(path, "").expect("a file");
        }
        let paths = |paths: &[&str]| Ok(paths.iter().map(|path| folder.join(path)).collect::<Vec<_>>());
        let all = ["COPYING", "LICENSE-MIT", "sqlcipher/LICENSE", "src/glider/LICENSE"];
        assert_eq!(licences("wing", folder), paths(&all));
        assert_eq!(licences("libsqlite3-sys", folder), paths(&[all[0], all[1], all[3]]));
    }

    #[test]
    fn reads_text_with_all_line_endings() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("LICENSE");
        fs::write(&path, "MIT\r\nText\n").expect("a file");
        assert_eq!(read(&path), Ok("MIT\nText\n".to_owned()));
    }
}
