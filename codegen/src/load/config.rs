//! What to read and what to write: from `uavspec.toml`, or from the command line.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::Spanned;

use super::lint::{Lint, PlannedLint};
use super::mistake::misplaced;
use crate::emit::{self, EMITTERS, Emitter, Others, Output, emitter};
use crate::failure::Failure;
use crate::path::normalise;
use crate::schema::Form;

/// Names of the file, in the order in which they are looked for in a folder.
const FILE_NAMES: [&str; 2] = ["uavspec.toml", "definitions/uavspec.toml"];

/// A `uavspec.toml` that has been read.
#[derive(Debug)]
pub(crate) struct Config {
    /// Its folder: paths in it are relative to this.
    folder: PathBuf,
    /// Its own path, as it is shown.
    path: String,
    text: String,
    file: File,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    output: BTreeMap<Spanned<String>, Spanned<toml::Value>>,
    #[serde(default, rename = "package")]
    packages: Vec<Package>,
    #[serde(default)]
    lint: Lint,
    #[serde(default)]
    translations: Translations,
}

/// Catalogues of translations.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Translations {
    #[serde(default)]
    include: Vec<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(clippy::struct_field_names)] // the names are those of the file
struct Package {
    name: Spanned<String>,
    dialect: DialectName,
    include: Vec<String>,
    select: Option<Vec<Spanned<String>>>,
    ros_package: Option<String>,
    origin: Option<String>,
    revision: Option<String>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
enum DialectName {
    Px4,
    Ros2,
    Table,
}

/// What to read, and what to write where.
#[derive(Debug)]
pub(crate) struct Plan {
    /// Folder that the paths of sources are shown relative to; empty for that of the process.
    pub(crate) root: PathBuf,
    /// Packages.
    pub(crate) packages: Vec<PlannedPackage>,
    /// Outputs.
    pub(crate) outputs: Vec<PlannedOutput>,
    /// The configuration file, which diagnostics may point into: path and text.
    pub(crate) config: Option<(String, String)>,
    /// Rules and what is let stand.
    pub(crate) lint: PlannedLint,
    /// Patterns of catalogues of translations, and the folder that they are relative to.
    pub(crate) catalogues: (PathBuf, Vec<String>),
    /// The revision that its sources come from; that of the working tree, where absent.
    pub(crate) revision: Option<String>,
}

/// A package to be read.
#[derive(Debug)]
pub(crate) struct PlannedPackage {
    pub(crate) name: String,
    pub(crate) form: Form,
    pub(crate) inputs: Inputs,
    /// Wanted messages with their places in the configuration file.
    pub(crate) select: Option<Vec<(String, Range<usize>)>>,
    pub(crate) ros_package: Option<String>,
    pub(crate) origin: Option<String>,
    pub(crate) revision: Option<String>,
}

/// Where the sources of a package are.
#[derive(Debug)]
pub(crate) enum Inputs {
    /// Glob patterns below a folder.
    Patterns { folder: PathBuf, patterns: Vec<String> },
    /// Files, and folders that are searched.
    Paths(Vec<PathBuf>),
}

/// An emitter and its folder.
#[derive(Debug)]
pub(crate) struct PlannedOutput {
    pub(crate) path: PathBuf,
    pub(crate) output: Box<dyn Output>,
}

impl Config {
    /// Reads `path`, or the file that is found in the current folder or one above it.
    pub(crate) fn find(path: Option<&Path>) -> Result<Self, Failure> {
        if let Some(path) = path {
            return Self::read(path);
        }
        let current =
            std::env::current_dir().map_err(|error| Failure::new(format!("the current folder: {error}")))?;
        let candidates = current.ancestors().flat_map(|folder| FILE_NAMES.map(|name| folder.join(name)));
        let found = candidates.into_iter().find(|candidate| candidate.is_file());
        let Some(found) = found else {
            return Err(Failure::new("no uavspec.toml here or in any folder above").with_hint(
                "create one, name one with --config, or give --package, --dialect, --input and --out",
            ));
        };
        Self::read(found.strip_prefix(&current).unwrap_or(&found))
    }

    /// Reads the file at `path`.
    pub(crate) fn read(path: &Path) -> Result<Self, Failure> {
        let shown = path.display().to_string();
        let text =
            std::fs::read_to_string(path).map_err(|error| Failure::new(format!("{shown}: {error}")))?;
        let file: File = toml::from_str(&text).map_err(|error| unreadable(&shown, &text, &error))?;
        if file.packages.is_empty() {
            return Err(Failure::new(format!("{shown} names no package"))
                .with_hint("add a [[package]] with name, dialect and include"));
        }
        let folder = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
        Ok(Self { folder, path: shown, text, file })
    }

    /// The file that was read.
    pub(crate) fn file(&self) -> &Path {
        Path::new(&self.path)
    }

    /// The file in `folder`, where there is one.
    pub(crate) fn in_folder(folder: &Path) -> Option<PathBuf> {
        FILE_NAMES.iter().map(|name| folder.join(name)).find(|path| path.is_file())
    }

    /// The same for definitions in another folder.
    pub(crate) fn moved_to(mut self, folder: PathBuf) -> Self {
        self.folder = folder;
        self
    }

    pub(crate) fn plan(self) -> Result<Plan, Failure> {
        let folder = &self.folder;
        // Definitions in a folder of their own are shown from the folder above: `definitions/px4/…`.
        let root = if folder.ends_with("definitions") { folder.join("..") } else { folder.clone() };
        let outputs = outputs(self.file.output, folder)
            .map_err(|(range, message)| unreadable_at(&self.path, &self.text, range, &message))?;
        let packages = self
            .file
            .packages
            .into_iter()
            .map(|package| PlannedPackage {
                name: package.name.into_inner(),
                form: match package.dialect {
                    DialectName::Px4 => Form::Msg(crate::msg::Dialect::Px4),
                    DialectName::Ros2 => Form::Msg(crate::msg::Dialect::Ros2),
                    DialectName::Table => Form::Table,
                },
                inputs: Inputs::Patterns { folder: folder.clone(), patterns: package.include },
                select: package.select.map(|names| {
                    names.into_iter().map(|name| (name.get_ref().clone(), name.span())).collect()
                }),
                ros_package: package.ros_package,
                origin: package.origin,
                revision: package.revision,
            })
            .collect();
        let lint = self.file.lint.plan(folder, &self.path, &self.text)?;
        let config = Some((self.path, self.text));
        let catalogues = (folder.clone(), self.file.translations.include);
        Ok(Plan { root: normalise(&root), packages, outputs, config, lint, catalogues, revision: None })
    }
}

/// A configuration file that can't be read, shown like any other mistake.
fn unreadable(path: &str, text: &str, error: &toml::de::Error) -> Failure {
    match error.span() {
        Some(range) => unreadable_at(path, text, range, error.message()),
        None => Failure::new(format!("{path}: {}", error.message())),
    }
}

/// Like [`unreadable`], for a mistake at `range`.
fn unreadable_at(path: &str, text: &str, range: Range<usize>, message: &str) -> Failure {
    misplaced(path, text, range, message).with_hint("the guide lists all keys in \"Use it in your build\"")
}

/// The outputs of the tables `output.NAME`, in the order of [`EMITTERS`]; else what is wrong, and where.
fn outputs(
    tables: BTreeMap<Spanned<String>, Spanned<toml::Value>>,
    folder: &Path,
) -> Result<Vec<PlannedOutput>, (Range<usize>, String)> {
    let mut configured = BTreeMap::new();
    for (name, value) in tables {
        let emitter = emitter(name.get_ref()).map_err(|message| (name.span(), message))?;
        let range = value.span();
        let table = emitter.table(value.into_inner()).map_err(|message| (range.clone(), message))?;
        configured.insert(emitter.name, (range, table));
    }
    let tables = configured.iter().map(|(name, (_, table))| (*name, table.clone())).collect();
    let read = |(emitter, (range, table)): (&Emitter, &(Range<usize>, emit::Table))| {
        let mut output = emitter.read(table.options.clone()).map_err(|message| (range.clone(), message))?;
        output.complete(&Others { folder, path: &table.path, tables: &tables });
        Ok(PlannedOutput { path: normalise(&folder.join(&table.path)), output })
    };
    EMITTERS.iter().filter_map(|emitter| Some((emitter, configured.get(emitter.name)?))).map(read).collect()
}

impl Plan {
    /// A plan for one package, without a file.
    pub(crate) fn from_arguments(
        name: &str,
        form: Form,
        inputs: &[PathBuf],
        out: &Path,
        emit: &[&Emitter],
    ) -> Self {
        let outputs = emit
            .iter()
            .map(|emitter| PlannedOutput { path: out.join(emitter.name), output: emitter.default() })
            .collect();
        let package = PlannedPackage {
            name: name.to_owned(),
            form,
            inputs: Inputs::Paths(inputs.to_vec()),
            select: None,
            ros_package: None,
            origin: None,
            revision: None,
        };
        Self {
            root: PathBuf::new(),
            packages: vec![package],
            outputs,
            config: None,
            lint: PlannedLint::default(),
            catalogues: (PathBuf::new(), Vec::new()),
            revision: None,
        }
    }
}
