//! The packages of the workspace that a change can affect.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::Args;
use serde::Deserialize;
use uavspec_schema::terminal;

use crate::command::{self, cargo};
use crate::paths::repository;

#[derive(Args)]
#[command(after_help = "Examples:
  cargo xtask affected HEAD~1
  cargo test $(cargo xtask affected main)

Prints the arguments for cargo that select the changed packages and all packages that depend on them. A change outside of \
all packages, such as one of Cargo.lock, affects the whole workspace; a page next to Cargo.toml affects none.")]
pub(crate) struct Arguments {
    /// Git revision to compare the working tree with
    revision: String,
}

/// A package, as `cargo metadata` describes it.
#[derive(Deserialize)]
struct Package {
    name: String,
    manifest_path: PathBuf,
    dependencies: Vec<Dependency>,
}

#[derive(Deserialize)]
struct Dependency {
    name: String,
    /// `dev`, `build` or none.
    kind: Option<String>,
}

#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Package>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<bool, String> {
    let metadata = output(cargo(), &["metadata", "--no-deps", "--format-version=1"])?;
    let metadata: Metadata = serde_json::from_str(&metadata).map_err(|error| error.to_string())?;
    let changed = output("git", &["diff", "--name-only", "--end-of-options", &arguments.revision, "--"])?;
    let new = output("git", &["ls-files", "--others", "--exclude-standard"])?;
    let paths: Vec<&Path> = changed.lines().chain(new.lines()).map(Path::new).collect();
    let selected = match affected(&metadata.packages, &paths) {
        None => "--workspace".to_owned(),
        Some(names) => names.iter().map(|name| format!("-p {name}")).collect::<Vec<_>>().join(" "),
    };
    terminal::println!("{selected}");
    Ok(true)
}

fn output(program: impl AsRef<OsStr>, arguments: &[&str]) -> Result<String, String> {
    command::output(Command::new(program).args(arguments).current_dir(repository()))
}

/// The names of the packages that changes of some files affect. `None` means all packages.
fn affected<'p>(packages: &'p [Package], paths: &[&Path]) -> Option<BTreeSet<&'p str>> {
    let mut names = BTreeSet::new();
    for path in paths {
        let path = repository().join(path);
        let folder = |package: &'p Package| package.manifest_path.parent().filter(|it| path.starts_with(it));
        let owner = packages.iter().filter(|package| folder(package).is_some());
        match owner.max_by_key(|package| package.manifest_path.components().count()) {
            Some(package) => _ = names.insert(package.name.as_str()),
            None if path.extension().is_some_and(|it| it == "md") => {}
            None => return None,
        }
    }
    let dependents = |names: &BTreeSet<&str>, is_test: bool| -> Vec<&'p str> {
        let depends = |package: &&Package| {
            package.dependencies.iter().any(|dependency| {
                names.contains(dependency.name.as_str())
                    && (dependency.kind.as_deref() == Some("dev")) == is_test
            })
        };
        packages.iter().filter(depends).map(|package| package.name.as_str()).collect()
    };
    loop {
        let known = names.len();
        names.extend(dependents(&names, false));
        if names.len() == known {
            break;
        }
    }
    // The tests of these packages use an affected package, but other packages don't use the tests.
    names.extend(dependents(&names, true));
    Some(names)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dependents_are_affected_and_users_of_tests_are_not() {
        let package = |name: &str, dependencies: &[(&str, Option<&str>)]| Package {
            name: name.to_owned(),
            manifest_path: repository().join(name).join("Cargo.toml"),
            dependencies: dependencies
                .iter()
                .map(|(name, kind)| Dependency { name: (*name).to_owned(), kind: kind.map(str::to_owned) })
                .collect(),
        };
        let packages = [
            package("model", &[]),
            package("model/rules", &[]),
            package("check", &[("model", None)]),
            package("program", &[("check", Some("build"))]),
            package("helpers", &[("model/rules", Some("dev"))]),
            package("user", &[("helpers", None)]),
        ];
        let names = |paths: &[&str]| {
            let paths: Vec<&Path> = paths.iter().map(Path::new).collect();
            affected(&packages, &paths).map(|names| names.into_iter().collect::<Vec<_>>())
        };
        assert_eq!(names(&["model/src/lib.rs"]), Some(vec!["check", "model", "program"]));
        assert_eq!(names(&["model/rules/src/lib.rs"]), Some(vec!["helpers", "model/rules"]));
        assert_eq!(names(&["README.md"]), Some(vec![]));
        assert_eq!(names(&["user/a", "Cargo.lock"]), None);
    }
}
