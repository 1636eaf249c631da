//! The crates of a program, selected by `cargo tree`. `cargo metadata` describes the crates. It combines the features
//! of all packages, so it also lists crates that only tests and other programs of the workspace use.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde::Deserialize;

use crate::command::{cargo, output};
use crate::platform::FEATURES;

/// The crate of the program.
const PROGRAM: &str = "uavspec";

/// A crate, as `cargo metadata` and `Cargo.lock` describe it.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Crate {
    pub(crate) name: String,
    pub(crate) version: String,
    license: Option<String>,
    pub(crate) repository: Option<String>,
    pub(crate) authors: Vec<String>,
    pub(crate) manifest_path: PathBuf,
    /// The SHA-256 checksum of the published archive.
    pub(crate) checksum: Option<String>,
    /// The package URLs of the direct dependencies.
    #[serde(skip)]
    pub(super) uses: BTreeSet<String>,
}

impl Crate {
    /// The package URL.
    pub(crate) fn purl(&self) -> String {
        purl(&self.name, &self.version)
    }

    /// The licence, as an SPDX expression. Old manifests write a slash instead of `OR`.
    pub(crate) fn license(&self) -> String {
        let license = self.license.as_deref().unwrap_or_default();
        license.split('/').map(str::trim).collect::<Vec<_>>().join(" OR ")
    }
}

fn purl(name: &str, version: &str) -> String {
    format!("pkg:cargo/{name}@{version}")
}

/// A program and its crates.
#[derive(Debug)]
pub(crate) struct Crates {
    pub(super) program: Crate,
    /// Sorted by package URL.
    pub(crate) dependencies: Vec<Crate>,
}

/// The output of `cargo metadata`, or the content of `Cargo.lock`.
#[derive(Deserialize)]
struct Packages {
    #[serde(alias = "packages")]
    package: Vec<Crate>,
}

impl Crates {
    /// Reads the crates that are necessary to compile the program, on all systems and with all features.
    pub(super) fn read(root: &Path) -> Result<Self, String> {
        Self::parse(root, &["--edges", "normal,build", "--target", "all", "--all-features"])
    }

    /// Reads the crates that are linked into the program and the Python module for a target of the compiler.
    pub(crate) fn linked(root: &Path, target: &str) -> Result<Self, String> {
        let features = format!("{FEATURES},uavspec-python/module");
        let module = ["--package", "uavspec-python", "--features", &features];
        Self::parse(root, &[&["--edges", "normal,no-proc-macro", "--target", target], &module[..]].concat())
    }

    fn parse(root: &Path, selection: &[&str]) -> Result<Self, String> {
        let run = |arguments: &[&str]| {
            let mut command = Command::new(cargo());
            output(
                command.args(arguments).arg("--locked").arg("--manifest-path").arg(root.join("Cargo.toml")),
            )
        };
        let tree = ["tree", "--prefix", "depth", "--format", "{p}", "--package", PROGRAM];
        let (program, mut uses) = parse(&run(&[&tree, selection].concat())?)?;
        let metadata = run(&["metadata", "--all-features", "--format-version", "1"])?;
        let metadata: Packages = serde_json::from_str(&metadata).map_err(|error| error.to_string())?;
        let lock = root.join("Cargo.lock");
        let text = fs::read_to_string(&lock).map_err(|error| format!("{}: {error}", lock.display()))?;
        let lock: Packages = toml::from_str(&text).map_err(|error| format!("{}: {error}", lock.display()))?;
        let mut checksums: BTreeMap<String, Option<String>> =
            lock.package.into_iter().map(|found| (found.purl(), found.checksum)).collect();
        let mut crates = BTreeMap::new();
        for mut found in metadata.package {
            let purl = found.purl();
            let Some(uses) = uses.remove(&purl) else { continue };
            if found.license.is_none() {
                return Err(format!("{purl} names no licence"));
            }
            found.uses = uses;
            found.checksum = checksums.remove(&purl).flatten();
            crates.insert(purl, found);
        }
        if let Some(missing) = uses.keys().next() {
            return Err(format!("cargo metadata does not list {missing}"));
        }
        let program = crates.remove(&program).ok_or("cargo tree lists no crates")?;
        Ok(Self { program, dependencies: crates.into_values().collect() })
    }
}

/// The package URLs of the crates, each with the crates that it uses.
type Uses = BTreeMap<String, BTreeSet<String>>;

/// Parses the output of `cargo tree`: the package URL of the program, and all crates.
fn parse(tree: &str) -> Result<(String, Uses), String> {
    let mut crates = Uses::new();
    // The package URLs from the program to the current line.
    let mut path: Vec<String> = Vec::new();
    for line in tree.lines().filter(|line| !line.is_empty()) {
        let (depth, purl) =
            line_of_tree(line).ok_or_else(|| format!("unexpected line of cargo tree: {line}"))?;
        path.truncate(depth);
        if let Some(uses) = path.last().and_then(|parent| crates.get_mut(parent)) {
            uses.insert(purl.clone());
        }
        crates.entry(purl.clone()).or_default();
        path.push(purl);
    }
    Ok((path.into_iter().next().unwrap_or_default(), crates))
}

/// The depth and the package URL of a line such as `2rib v0.3.0 (proc-macro) (*)`.
fn line_of_tree(line: &str) -> Option<(usize, String)> {
    let (depth, line) = line.split_at(line.find(|character: char| !character.is_ascii_digit())?);
    let mut words = line.split(' ');
    Some((depth.parse().ok()?, purl(words.next()?, words.next()?.strip_prefix('v')?)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_the_output_of_cargo_tree() {
        let tree = "0glider v1.0.0 (/glider)\n1wing v2.1.0\n2rib v0.3.0 (proc-macro)\n1rib v0.3.0 (proc-macro) (*)\n";
        let (program, crates) = parse(tree).expect("crates");
        assert_eq!(program, "pkg:cargo/glider@1.0.0");
        let uses = |purl: &str| crates[purl].iter().map(String::as_str).collect::<Vec<_>>();
        assert_eq!(uses(&program), ["pkg:cargo/rib@0.3.0", "pkg:cargo/wing@2.1.0"]);
        assert_eq!(uses("pkg:cargo/wing@2.1.0"), ["pkg:cargo/rib@0.3.0"]);
        assert!(parse("0glider 1.0.0\n").is_err(), "no version");
    }

    #[test]
    fn converts_old_licences_to_expressions() {
        let convert =
            |license: &str| Crate { license: Some(license.to_owned()), ..Crate::default() }.license();
        assert_eq!(convert("MIT / Apache-2.0"), "MIT OR Apache-2.0");
        assert_eq!(convert("(MIT OR Apache-2.0) AND Unicode-3.0"), "(MIT OR Apache-2.0) AND Unicode-3.0");
    }
}
