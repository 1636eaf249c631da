//! The crates of a program, from `cargo tree` and `Cargo.lock`. `cargo metadata` would add crates that only tests and
//! other programs of the workspace use, because it combines the features of all of them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use serde::Deserialize;

use crate::command::cargo;
use crate::platform::FEATURES;

/// The crate of the program.
const PROGRAM: &str = "uavspec";

/// The parts of a line of `cargo tree`: the depth and the crate, the licence, and the repository.
const FORMAT: &str = "{p}\t{l}\t{r}";

/// A crate.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Crate {
    pub(crate) name: String,
    pub(crate) version: String,
    /// The licence, as an SPDX expression.
    pub(crate) license: String,
    pub(crate) repository: Option<String>,
    /// The SHA-256 checksum of the published archive.
    pub(crate) checksum: Option<String>,
    /// The package URLs of the direct dependencies.
    pub(super) uses: BTreeSet<String>,
}

impl Crate {
    /// The package URL.
    pub(crate) fn purl(&self) -> String {
        format!("pkg:cargo/{}@{}", self.name, self.version)
    }
}

/// A program and its crates.
#[derive(Debug)]
pub(crate) struct Crates {
    pub(super) program: Crate,
    /// Sorted by package URL.
    pub(crate) dependencies: Vec<Crate>,
}

/// The content of `Cargo.lock`.
#[derive(Deserialize)]
struct Lock {
    package: Vec<LockedPackage>,
}

#[derive(Deserialize)]
struct LockedPackage {
    name: String,
    version: String,
    checksum: Option<String>,
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
        let (program, mut crates) = parse(&tree(root, selection)?)?;
        let lock = root.join("Cargo.lock");
        let text = std::fs::read_to_string(&lock).map_err(|error| format!("{}: {error}", lock.display()))?;
        let lock: Lock = toml::from_str(&text).map_err(|error| format!("{}: {error}", lock.display()))?;
        for LockedPackage { name, version, checksum } in lock.package {
            let known = Crate { name, version, ..Crate::default() };
            if let Some(found) = crates.get_mut(&known.purl()) {
                found.checksum = checksum;
            }
        }
        let program = crates.remove(&program).ok_or("cargo tree lists no crates")?;
        Ok(Self { program, dependencies: crates.into_values().collect() })
    }
}

/// Parses the output of `cargo tree`: the package URL of the program, and all crates by package URL.
fn parse(tree: &str) -> Result<(String, BTreeMap<String, Crate>), String> {
    let mut crates: BTreeMap<String, Crate> = BTreeMap::new();
    // The package URLs from the program to the current line.
    let mut path: Vec<String> = Vec::new();
    for line in tree.lines().filter(|line| !line.is_empty()) {
        let (depth, found) =
            line_of_tree(line).ok_or_else(|| format!("unexpected line of cargo tree: {line}"))?;
        let purl = found.purl();
        path.truncate(depth);
        if let Some(parent) = path.last().and_then(|parent| crates.get_mut(parent)) {
            parent.uses.insert(purl.clone());
        }
        crates.entry(purl.clone()).or_insert(found);
        path.push(purl);
    }
    Ok((path.into_iter().next().unwrap_or_default(), crates))
}

/// The depth and the crate of a line.
fn line_of_tree(line: &str) -> Option<(usize, Crate)> {
    let (depth, line) = line.split_at(line.find(|character: char| !character.is_ascii_digit())?);
    let mut parts = line.split('\t');
    let mut words = parts.next()?.split(' ');
    let (name, version) = (words.next()?, words.next()?.strip_prefix('v')?);
    let license = parts.next().filter(|license| !license.is_empty())?;
    // `(*)` marks a crate whose dependencies are listed above.
    let repository = parts.next()?.trim_end_matches("(*)").trim_end();
    let found = Crate {
        name: name.to_owned(),
        version: version.to_owned(),
        license: expression(license),
        repository: (!repository.is_empty()).then(|| repository.to_owned()),
        ..Crate::default()
    };
    Some((depth.parse().ok()?, found))
}

/// The SPDX expression of a licence. Old manifests write a slash instead of `OR`.
fn expression(license: &str) -> String {
    license.split('/').map(str::trim).collect::<Vec<_>>().join(" OR ")
}

/// Runs `cargo tree`.
fn tree(root: &Path, selection: &[&str]) -> Result<String, String> {
    let mut command = Command::new(cargo());
    command.args(["tree", "--locked"]).args(selection);
    command.args(["--prefix", "depth", "--format", FORMAT, "--package", PROGRAM, "--manifest-path"]);
    let output = command
        .arg(root.join("Cargo.toml"))
        .output()
        .map_err(|error| format!("cannot run cargo: {error}"))?;
    if !output.status.success() {
        return Err(format!("cargo tree failed: {}", String::from_utf8_lossy(&output.stderr).trim_end()));
    }
    String::from_utf8(output.stdout).map_err(|_| "cargo tree printed invalid UTF-8".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_the_output_of_cargo_tree() {
        let tree = "0glider v1.0.0 (/glider)\tMIT\t\n\
                    1wing v2.1.0\tMIT/Apache-2.0\thttps://example.org/wing\n\
                    2rib v0.3.0 (proc-macro)\tZlib\thttps://example.org/rib\n\
                    1rib v0.3.0 (proc-macro)\tZlib\thttps://example.org/rib (*)\n";
        let (program, crates) = parse(tree).expect("crates");
        assert_eq!(program, "pkg:cargo/glider@1.0.0");
        let uses = |purl: &str| crates[purl].uses.iter().map(String::as_str).collect::<Vec<_>>();
        assert_eq!(uses(&program), ["pkg:cargo/rib@0.3.0", "pkg:cargo/wing@2.1.0"]);
        assert_eq!(uses("pkg:cargo/wing@2.1.0"), ["pkg:cargo/rib@0.3.0"]);
        assert_eq!(crates[&program].repository, None);
        assert_eq!(crates["pkg:cargo/rib@0.3.0"].repository.as_deref(), Some("https://example.org/rib"));
        assert!(parse("0glider v1.0.0\t\t\n").is_err(), "a crate without a licence");
    }

    #[test]
    fn converts_old_licences_to_expressions() {
        assert_eq!(expression("MIT / Apache-2.0"), "MIT OR Apache-2.0");
        assert_eq!(expression("(MIT OR Apache-2.0) AND Unicode-3.0"), "(MIT OR Apache-2.0) AND Unicode-3.0");
    }
}
