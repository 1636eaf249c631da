//! Arguments shared by several commands.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use uavspec_emit::Emitter;
use uavspec_schema::failure::Failure;
use uavspec_schema::source::SourceId;
use uavspec_schema::terminal;

use crate::load::{Config, DialectName, Loaded, Plan};

/// The definitions that a command reads.
#[derive(Args, Debug)]
pub(super) struct DefinitionsArgs {
    /// Configuration file [default: nearest uavspec.toml]
    #[arg(long, value_name = "FILE", conflicts_with = "package")]
    pub(super) config: Option<PathBuf>,
    #[command(flatten)]
    pub(super) package: Option<PackageArgs>,
}

impl DefinitionsArgs {
    /// The plan for the package given on the command line, or otherwise for the packages in the configuration file.
    pub(super) fn plan(&self) -> Result<Plan, Failure> {
        match &self.package {
            Some(package) => Ok(package.plan(Path::new(""), &[])),
            None => Config::find(self.config.as_deref())?.plan(),
        }
    }
}

/// Files to which a command is limited. It still reads the whole packages, because definitions refer to each other.
#[derive(Args, Clone, Debug)]
pub(super) struct FilesArgs {
    /// Only these files of the packages [default: all files]
    #[arg(value_name = "FILE")]
    files: Vec<PathBuf>,
}

impl FilesArgs {
    /// The sources of the files; `None` for all sources. Prints a warning for each file that is in no package, because
    /// tools such as pre-commit pass all files of a repository.
    pub(super) fn sources(&self, loaded: &Loaded) -> Result<Option<BTreeSet<SourceId>>, Failure> {
        if self.files.is_empty() {
            return Ok(None);
        }
        let mut known: BTreeMap<PathBuf, Vec<SourceId>> = BTreeMap::new();
        for (source, path) in &loaded.paths {
            known.entry(real_path(path)?).or_default().push(*source);
        }
        let mut selected = BTreeSet::new();
        for file in &self.files {
            match known.get(&real_path(file)?) {
                Some(sources) => selected.extend(sources),
                None => terminal::eprintln!(
                    "warning: {} doesn't belong to a package; skipped",
                    terminal::path(file)
                ),
            }
        }
        Ok(Some(selected))
    }
}

/// The path of a file, with links resolved.
fn real_path(path: &Path) -> Result<PathBuf, Failure> {
    fs::canonicalize(path).map_err(|error| Failure::new(format!("{}: {error}", terminal::path(path))))
}

/// A package given on the command line instead of a configuration file.
#[derive(Args, Clone, Debug)]
pub(super) struct PackageArgs {
    /// Name for the definitions in --input, which are read instead of uavspec.toml
    #[arg(long, value_name = "NAME", required = false, requires_all = ["dialect", "input"])]
    pub(super) package: String,
    /// Language of the definitions in --input
    #[arg(long, required = false, requires = "package")]
    pub(super) dialect: DialectName,
    /// Definition files, or folders to search
    #[arg(long, value_name = "PATH", num_args = 1.., required = false, requires = "package")]
    pub(super) input: Vec<PathBuf>,
}

impl PackageArgs {
    pub(super) fn plan(&self, out: &Path, emit: &[&Emitter]) -> Plan {
        Plan::from_arguments(&self.package, self.dialect.into(), &self.input, out, emit)
    }
}
