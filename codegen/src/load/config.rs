//! Inputs and outputs, from `uavspec.toml` or the command line.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;
use uavspec_emit::{EMITTERS, Emitter, Others, Output, emitter};
use uavspec_schema::failure::Failure;
use uavspec_schema::path::normalise;
use uavspec_schema::wording::similar;
use uavspec_schema::{Dialect, Form, terminal};

use super::built_in::BuiltIn;
use super::lint::{Lint, PlannedLint};
use super::located::failure_at;

/// Names of the file, in search order.
const FILE_NAMES: [&str; 2] = ["uavspec.toml", "definitions/uavspec.toml"];

/// A parsed `uavspec.toml`.
#[derive(Debug)]
pub struct Config {
    /// The folder that contains the file. Paths in the file are relative to this folder.
    folder: PathBuf,
    /// The displayed path of the file.
    path: String,
    text: String,
    file: File,
}

// The comments of the fields are the descriptions in the JSON Schema and in the guide.

/// The packages to read, and the outputs to write. Paths and patterns are relative to the folder of this file.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("required" = ["package"]))]
pub(super) struct File {
    /// The outputs to generate: for each, a folder, or a table with the folder and options.
    #[serde(default)]
    #[schemars(schema_with = "super::schema::outputs")]
    output: BTreeMap<Spanned<String>, Spanned<toml::Value>>,
    /// The packages of definitions.
    #[serde(default, rename = "package")]
    #[schemars(length(min = 1))]
    packages: Vec<Package>,
    /// The rules of `uavspec lint`.
    #[serde(default)]
    lint: Lint,
    /// Translations of the texts in definitions.
    #[serde(default)]
    translations: Translations,
    /// Pairs of packages whose messages convert to each other.
    #[serde(default, rename = "conversion")]
    conversions: Vec<Conversion>,
}

/// A pair of packages to convert between.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Conversion {
    /// Name of the older package.
    #[schemars(with = "String")]
    from: Spanned<String>,
    /// Name of the newer package.
    #[schemars(with = "String")]
    to: Spanned<String>,
    /// File with hints.
    hints: Option<PathBuf>,
}

/// Translation catalogues.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Translations {
    /// Glob patterns of PO files, such as `["i18n/*.po"]`. The files don't have to exist yet.
    #[serde(default)]
    include: Vec<String>,
}

/// A package of definitions.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(clippy::struct_field_names)] // these are the names in the file
struct Package {
    /// Letters, digits and `_`, starting with a letter.
    #[schemars(with = "String")]
    name: Spanned<String>,
    /// The language of the definitions: `px4`, `ros2`, `table` for Markdown pages with tables of error codes, types and
    /// messages, or `events` for event metadata.
    dialect: DialectName,
    /// Glob patterns of the definition files, such as `["msg/*.msg"]`.
    include: Vec<String>,
    /// Names of the messages to generate, in addition to their nested messages. Default: all messages.
    #[schemars(with = "Option<Vec<String>>")]
    select: Option<Vec<Spanned<String>>>,
    /// Package name in ROS types and type hashes. Default: `px4_msgs` for a package `px4` of the dialect `px4`, otherwise
    /// the name.
    ros_package: Option<String>,
    /// Source of the definitions, shown in the documentation.
    origin: Option<String>,
    /// Revision of the source, shown in the documentation.
    revision: Option<String>,
    /// Folder with earlier releases of the package, from which the documentation shows the history of each definition.
    #[schemars(with = "Option<PathBuf>")]
    releases: Option<Spanned<PathBuf>>,
}

/// The form of definitions.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
pub(crate) enum DialectName {
    /// PX4 uORB messages
    Px4,
    /// ROS 2 interfaces
    Ros2,
    /// Markdown pages with tables of error codes, types and messages
    Table,
    /// Event metadata of PX4
    Events,
}

impl From<DialectName> for Form {
    fn from(dialect: DialectName) -> Self {
        match dialect {
            DialectName::Px4 => Self::Msg(Dialect::Px4),
            DialectName::Ros2 => Self::Msg(Dialect::Ros2),
            DialectName::Table => Self::Table,
            DialectName::Events => Self::Events,
        }
    }
}

/// The packages to read and the outputs to write.
#[derive(Debug, Default)]
pub struct Plan {
    /// The folder that displayed paths are relative to; empty for the current folder.
    pub(crate) root: PathBuf,
    /// The packages.
    pub packages: Vec<PlannedPackage>,
    /// The outputs.
    pub outputs: Vec<PlannedOutput>,
    /// The path and text of the configuration file, to which diagnostics may point.
    pub(crate) config: Option<(String, String)>,
    /// The configuration of lint rules.
    pub(crate) lint: PlannedLint,
    /// The glob patterns of translation catalogues, and the folder that they are relative to.
    pub(crate) catalogues: (PathBuf, Vec<String>),
    /// The conversions between packages.
    pub(crate) conversions: Vec<PlannedConversion>,
    /// The Git revision of the sources; `None` for the working tree.
    pub(crate) revision: Option<String>,
    /// The texts of the files that are open in an editor. These texts are read instead of the files.
    pub open: BTreeMap<PathBuf, String>,
    /// The built-in packages that supply definitions missing in the inputs.
    pub(crate) built_in: BuiltIn,
}

/// A pair of packages to convert between.
#[derive(Debug)]
pub(crate) struct PlannedConversion {
    pub(crate) from: String,
    pub(crate) to: String,
    /// The file with hints.
    pub(crate) hints: Option<PathBuf>,
}

/// A package to read.
#[derive(Debug)]
pub struct PlannedPackage {
    /// The name.
    pub name: String,
    /// The location of the name in the configuration file.
    pub(crate) name_range: Option<Range<usize>>,
    pub(crate) form: Form,
    pub(crate) inputs: Inputs,
    /// Selected messages, with their locations in the configuration file.
    pub(crate) select: Option<Vec<(String, Range<usize>)>>,
    pub(crate) ros_package: Option<String>,
    pub(crate) origin: Option<String>,
    pub(crate) revision: Option<String>,
    /// The folder with earlier releases of the package.
    pub(crate) releases: Option<PathBuf>,
}

impl PlannedPackage {
    /// A package in which all messages are selected.
    pub fn new(name: &str, form: Form, inputs: Inputs) -> Self {
        Self {
            name: name.to_owned(),
            name_range: None,
            form,
            inputs,
            select: None,
            ros_package: None,
            origin: None,
            revision: None,
            releases: None,
        }
    }
}

/// The location of a package's definitions.
#[derive(Debug)]
pub enum Inputs {
    /// Glob patterns relative to a folder.
    Patterns {
        /// The folder.
        folder: PathBuf,
        /// The patterns.
        patterns: Vec<String>,
    },
    /// Files, and folders to search.
    Paths(Vec<PathBuf>),
    /// Files that were found.
    Files(Vec<PathBuf>),
}

/// An emitter and its output folder.
#[derive(Debug)]
pub struct PlannedOutput {
    pub(crate) path: PathBuf,
    pub(crate) output: Box<dyn Output>,
}

impl Config {
    /// Reads `path`, or the nearest configuration file in the current folder or above.
    pub(crate) fn find(path: Option<&Path>) -> Result<Self, Failure> {
        if let Some(path) = path {
            return Self::read(path);
        }
        let current = std::env::current_dir()
            .map_err(|error| Failure::new(format!("cannot determine the current folder: {error}")))?;
        let candidates = current.ancestors().flat_map(|folder| FILE_NAMES.map(|name| folder.join(name)));
        let found = candidates.into_iter().find(|candidate| candidate.is_file());
        let Some(found) = found else {
            return Err(Failure::new("no uavspec.toml in the current folder or any parent folder")
                .with_hint(
                    "create one, pass --config, or pass all of --package, --dialect, --input and --out",
                ));
        };
        Self::read(found.strip_prefix(&current).unwrap_or(&found))
    }

    /// Reads the file at `path`.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let shown = terminal::path(path);
        let text =
            std::fs::read_to_string(path).map_err(|error| Failure::new(format!("{shown}: {error}")))?;
        Self::parse(path, text)
    }

    /// Parses the text of the file at `path`.
    pub fn parse(path: &Path, text: String) -> Result<Self, Failure> {
        let shown = terminal::path(path);
        let file: File = toml::from_str(&text).map_err(|error| unreadable(&shown, &text, &error))?;
        if file.packages.is_empty() {
            return Err(Failure::new(format!("{shown} has no packages"))
                .with_hint("add a [[package]] with `name`, `dialect` and `include`"));
        }
        let folder = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
        Ok(Self { folder, path: path.to_string_lossy().into_owned(), text, file })
    }

    /// The path of the file.
    pub(crate) fn file(&self) -> &Path {
        Path::new(&self.path)
    }

    /// The configuration file in `folder`, if one exists.
    pub fn in_folder(folder: &Path) -> Option<PathBuf> {
        FILE_NAMES.iter().map(|name| folder.join(name)).find(|path| path.is_file())
    }

    /// Applies this configuration to the definitions in another folder.
    pub(crate) fn moved_to(mut self, folder: PathBuf) -> Self {
        self.folder = folder;
        self
    }

    /// Resolves paths, and checks all values that don't depend on the definitions.
    pub fn plan(self) -> Result<Plan, Failure> {
        let folder = &self.folder;
        // Paths in a `definitions` folder are displayed relative to its parent: `definitions/px4/…`.
        let root = if folder.ends_with("definitions") { folder.join("..") } else { folder.clone() };
        let outputs = outputs(self.file.output, folder)
            .map_err(|(range, message)| unreadable_at(&self.path, &self.text, range, &message))?;
        let conversions = conversions(self.file.conversions, &self.file.packages, folder)
            .map_err(|(range, message)| unreadable_at(&self.path, &self.text, range, &message))?;
        for package in &self.file.packages {
            let dialect = match package.dialect {
                DialectName::Table => "table",
                DialectName::Events => "events",
                _ => continue,
            };
            if let Some(releases) = &package.releases {
                let message = format!("a package of the `{dialect}` dialect has no `releases`");
                return Err(unreadable_at(&self.path, &self.text, releases.span(), &message));
            }
        }
        let packages = self
            .file
            .packages
            .into_iter()
            .map(|package| PlannedPackage {
                name_range: Some(package.name.span()),
                name: package.name.into_inner(),
                form: package.dialect.into(),
                inputs: Inputs::Patterns { folder: folder.clone(), patterns: package.include },
                select: package.select.map(|names| {
                    names.into_iter().map(|name| (name.get_ref().clone(), name.span())).collect()
                }),
                ros_package: package.ros_package,
                origin: package.origin,
                revision: package.revision,
                releases: package.releases.map(|releases| folder.join(releases.into_inner())),
            })
            .collect();
        let lint = self.file.lint.plan(folder, &self.path, &self.text)?;
        let config = Some((self.path, self.text));
        let catalogues = (folder.clone(), self.file.translations.include);
        Ok(Plan {
            root: normalise(&root),
            packages,
            outputs,
            config,
            lint,
            catalogues,
            conversions,
            ..Plan::default()
        })
    }
}

/// The failure for an unparsable configuration file.
fn unreadable(path: &str, text: &str, error: &toml::de::Error) -> Failure {
    match error.span() {
        Some(range) => unreadable_at(path, text, range, error.message()),
        None => Failure::new(format!("{path}: {}", error.message())),
    }
}

/// Like [`unreadable`], for an error at `range`.
fn unreadable_at(path: &str, text: &str, range: Range<usize>, message: &str) -> Failure {
    failure_at(path, text, range, message)
        .with_hint("the guide lists all keys in the chapter \"Keys of uavspec.toml\"")
}

/// The outputs of the `output.NAME` tables, in the order of [`EMITTERS`]. Errors contain a location and a message.
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
    let read = |(emitter, (range, table)): (&Emitter, &(Range<usize>, uavspec_emit::Table))| {
        let mut output = emitter.read(table.options.clone()).map_err(|message| (range.clone(), message))?;
        output.complete(&Others { folder, path: &table.path, tables: &tables });
        Ok(PlannedOutput { path: normalise(&folder.join(&table.path)), output })
    };
    EMITTERS.iter().filter_map(|emitter| Some((emitter, configured.get(emitter.name)?))).map(read).collect()
}

/// Checks the packages of the `conversion` tables. Errors contain a location and a message.
fn conversions(
    tables: Vec<Conversion>,
    packages: &[Package],
    folder: &Path,
) -> Result<Vec<PlannedConversion>, (Range<usize>, String)> {
    let mut planned: Vec<PlannedConversion> = Vec::new();
    for Conversion { from, to, hints } in tables {
        for name in [&from, &to] {
            check_package(name, packages)?;
        }
        if from.get_ref() == to.get_ref() {
            return Err((to.span(), "`from` and `to` are the same package".to_owned()));
        }
        let pair = |from: &str, to: &str| (from.min(to).to_owned(), from.max(to).to_owned());
        let found = pair(from.get_ref(), to.get_ref());
        if planned.iter().any(|other| pair(&other.from, &other.to) == found) {
            let message = format!("the conversion between `{}` and `{}` is repeated", found.0, found.1);
            return Err((from.span(), message));
        }
        let hints = hints.map(|path| normalise(&folder.join(path)));
        planned.push(PlannedConversion { from: from.into_inner(), to: to.into_inner(), hints });
    }
    Ok(planned)
}

/// Checks that `name` is the name of a package with `.msg` files.
fn check_package(name: &Spanned<String>, packages: &[Package]) -> Result<(), (Range<usize>, String)> {
    let found = packages.iter().find(|package| package.name.get_ref() == name.get_ref());
    let Some(package) = found else {
        let names = packages.iter().map(|package| package.name.get_ref().as_str());
        let advice = similar(name.get_ref(), names);
        let advice = advice.map_or_else(String::new, |known| format!("; did you mean `{known}`?"));
        return Err((name.span(), format!("no package `{}`{advice}", name.get_ref())));
    };
    if matches!(package.dialect, DialectName::Table) {
        return Err((name.span(), "packages of specification pages can't be converted".to_owned()));
    }
    Ok(())
}

impl Plan {
    /// A plan for one package, without a configuration file.
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
        let package = PlannedPackage::new(name, form, Inputs::Paths(inputs.to_vec()));
        Self { outputs, ..Self::of_packages(vec![package]) }
    }

    /// A plan for packages, without outputs and without a configuration file.
    pub fn of_packages(packages: Vec<PlannedPackage>) -> Self {
        Self { packages, ..Self::default() }
    }
}
