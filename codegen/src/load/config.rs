//! What to read and what to write: from `uavspec.toml`, or from the command line.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::Spanned;

use super::lint::{Lint, PlannedLint};
use super::mistake::misplaced;
use super::path::normalise;
use crate::emit::{docs, json_schema, typescript, vectors};
use crate::failure::Failure;
use crate::schema::Form;

/// Names of the file, in the order in which they are looked for in a folder.
const FILE_NAMES: [&str; 2] = ["uavspec.toml", "definitions/uavspec.toml"];

/// A kind of output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum), value(rename_all = "snake_case"))]
pub(crate) enum Emitter {
    /// Rust modules.
    Rust,
    /// JSON Schemas.
    JsonSchema,
    /// Documentation: Markdown laid out for mdBook.
    Docs,
    /// Test vectors, as JSON.
    Vectors,
    /// TypeScript modules.
    #[cfg_attr(feature = "cli", value(name = "typescript"))]
    TypeScript,
    /// Python modules.
    Python,
}

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
    output: Outputs,
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

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Outputs {
    rust: Option<Output<RustTable>>,
    json_schema: Option<Output<JsonSchemaTable>>,
    docs: Option<Output<DocsTable>>,
    vectors: Option<Output<VectorsTable>>,
    typescript: Option<Output<TypeScriptTable>>,
    python: Option<Output<PythonTable>>,
}

/// An output: its folder, or a table of the folder and options.
#[derive(Debug, Deserialize)]
#[serde(
    untagged,
    expecting = "expected a path, or a table of `path` and `root`, `readme` (rust), `base` (json_schema, vectors), `title`, `rules`, `contents` (docs) or `form` (typescript)"
)]
enum Output<T> {
    Path(PathBuf),
    Table(T),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RustTable {
    path: PathBuf,
    root: Option<String>,
    readme: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct JsonSchemaTable {
    path: PathBuf,
    base: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct DocsTable {
    path: PathBuf,
    title: Option<String>,
    #[serde(default)]
    rules: bool,
    /// Files with parts of the table of contents, as mdBook writes it.
    #[serde(default)]
    contents: OneOrMany,
}

/// A path, or a list of them.
#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "expected a path, or a list of paths")]
enum OneOrMany {
    One(PathBuf),
    Many(Vec<PathBuf>),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct VectorsTable {
    path: PathBuf,
    base: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TypeScriptTable {
    path: PathBuf,
    #[serde(default)]
    form: FormName,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PythonTable {
    path: PathBuf,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
enum FormName {
    #[default]
    Source,
    Compiled,
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
    pub(crate) select: Option<Vec<(String, std::ops::Range<usize>)>>,
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
    pub(crate) emitter: EmitterOptions,
}

/// An emitter with its options.
#[derive(Debug)]
pub(crate) enum EmitterOptions {
    Rust(RustOptions),
    JsonSchema(json_schema::Options),
    Docs(DocsOptions),
    Vectors(vectors::Options),
    TypeScript(typescript::Options),
    Python,
}

/// Options of the emitter of documentation.
#[derive(Debug)]
pub(crate) struct DocsOptions {
    options: docs::Options,
    /// Files with parts of the table of contents, which are read when the documentation is made: commands that
    /// make none don't need them.
    contents: Vec<PathBuf>,
}

/// Options of the Rust emitter, which may be absent from the build.
#[derive(Debug)]
pub(crate) struct RustOptions {
    /// Name of the file at the root of the module tree.
    #[cfg_attr(not(feature = "rust"), allow(dead_code))]
    pub(crate) root: String,
    /// A page to be the documentation of the root.
    #[cfg_attr(not(feature = "rust"), allow(dead_code))]
    pub(crate) readme: Option<String>,
}

impl<T> Output<T> {
    fn table(self, of_path: impl FnOnce(PathBuf) -> T) -> T {
        match self {
            Self::Path(path) => of_path(path),
            Self::Table(table) => table,
        }
    }
}

impl Default for OneOrMany {
    fn default() -> Self {
        Self::Many(Vec::new())
    }
}

impl OneOrMany {
    fn paths(&self) -> &[PathBuf] {
        match self {
            Self::One(path) => std::slice::from_ref(path),
            Self::Many(paths) => paths,
        }
    }
}

impl DocsOptions {
    /// All that the emitter wants to know.
    pub(crate) fn read(&self) -> Result<docs::Options, Failure> {
        let read = |path: &PathBuf| {
            std::fs::read_to_string(path).map_err(|error| {
                Failure::new(format!("{}: {error}", path.display()))
                    .with_hint("`output.docs.contents` names it: make it first, or take it out")
            })
        };
        let more_contents = self.contents.iter().map(read).collect::<Result<String, Failure>>()?;
        Ok(docs::Options { more_contents, ..self.options.clone() })
    }
}

impl RustOptions {
    fn new(root: Option<String>, readme: Option<String>) -> Self {
        Self { root: root.unwrap_or_else(|| "mod.rs".to_owned()), readme }
    }
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
        let outputs = self.file.output;
        let mut planned = Vec::new();
        let mut schema_base = None;
        let (mut schemas, mut vectors) = (None, None);
        let mut plan = |path: &Path, emitter| {
            planned.push(PlannedOutput { path: normalise(&folder.join(path)), emitter });
        };
        if let Some(output) = outputs.rust {
            let RustTable { path, root, readme } =
                output.table(|path| RustTable { path, root: None, readme: None });
            plan(&path, EmitterOptions::Rust(RustOptions::new(root, readme)));
        }
        if let Some(output) = outputs.json_schema {
            let JsonSchemaTable { path, base } = output.table(|path| JsonSchemaTable { path, base: None });
            schema_base.clone_from(&base);
            schemas = Some(path.clone());
            plan(&path, EmitterOptions::JsonSchema(json_schema_options(base)));
        }
        if let Some(output) = outputs.vectors {
            let VectorsTable { path, base } = output.table(|path| VectorsTable { path, base: None });
            vectors = Some(path.clone());
            // They refer to the schemas that are emitted beside them.
            plan(&path, EmitterOptions::Vectors(vectors_options(base.or(schema_base))));
        }
        if let Some(output) = outputs.docs {
            let DocsTable { path, title, rules, contents } = output.table(|path| DocsTable {
                path,
                title: None,
                rules: false,
                contents: OneOrMany::default(),
            });
            let contents = contents.paths().iter().map(|path| folder.join(path)).collect();
            let beside = docs::Beside {
                schemas: schemas.map(|folder| seen_from(&path, &folder)),
                vectors: vectors.map(|folder| seen_from(&path, &folder)),
            };
            let options = docs::Options { rules, beside, ..docs_options(title) };
            plan(&path, EmitterOptions::Docs(DocsOptions { options, contents }));
        }
        if let Some(output) = outputs.typescript {
            let TypeScriptTable { path, form } =
                output.table(|path| TypeScriptTable { path, form: FormName::default() });
            let form = match form {
                FormName::Source => typescript::Form::Source,
                FormName::Compiled => typescript::Form::Compiled,
            };
            plan(&path, EmitterOptions::TypeScript(typescript::Options { form }));
        }
        if let Some(output) = outputs.python {
            let PythonTable { path } = output.table(|path| PythonTable { path });
            plan(&path, EmitterOptions::Python);
        }
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
        Ok(Plan {
            root: normalise(&root),
            packages,
            outputs: planned,
            config,
            lint,
            catalogues,
            revision: None,
        })
    }
}

fn json_schema_options(base: Option<String>) -> json_schema::Options {
    let default = json_schema::Options::default();
    json_schema::Options { base: base.unwrap_or(default.base) }
}

fn vectors_options(base: Option<String>) -> vectors::Options {
    vectors::Options { schemas: json_schema_options(base) }
}

fn docs_options(title: Option<String>) -> docs::Options {
    let default = docs::Options::default();
    docs::Options { title: title.unwrap_or(default.title), ..default }
}

/// A configuration file that can't be read, shown like any other mistake.
fn unreadable(path: &str, text: &str, error: &toml::de::Error) -> Failure {
    match error.span() {
        Some(range) => misplaced(path, text, range, error.message())
            .with_hint("the README of uavspec lists all keys, under \"Use it in your build\""),
        None => Failure::new(format!("{path}: {}", error.message())),
    }
}

impl Plan {
    /// A plan for one package, without a file.
    pub(crate) fn from_arguments(
        name: &str,
        form: Form,
        inputs: &[PathBuf],
        out: &Path,
        emit: &[Emitter],
    ) -> Self {
        let outputs = emit
            .iter()
            .map(|emitter| match emitter {
                Emitter::Rust => ("rust", EmitterOptions::Rust(RustOptions::new(None, None))),
                Emitter::JsonSchema => ("json_schema", EmitterOptions::JsonSchema(json_schema_options(None))),
                Emitter::Docs => (
                    "docs",
                    EmitterOptions::Docs(DocsOptions { options: docs_options(None), contents: Vec::new() }),
                ),
                Emitter::Vectors => ("vectors", EmitterOptions::Vectors(vectors_options(None))),
                Emitter::TypeScript => {
                    ("typescript", EmitterOptions::TypeScript(typescript::Options::default()))
                }
                Emitter::Python => ("python", EmitterOptions::Python),
            })
            .map(|(folder, emitter)| PlannedOutput { path: out.join(folder), emitter })
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

/// The path of the folder `to` as an address in a page of the folder `from`, by their texts alone.
fn seen_from(from: &Path, to: &Path) -> String {
    let (from, to) = (normalise(from), normalise(to));
    let shared = from.components().zip(to.components()).take_while(|(left, right)| left == right).count();
    let up = from.components().skip(shared).map(|_| "..".to_owned());
    let down = to.components().skip(shared).map(|part| part.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_seen_from_each_other() {
        for (from, to, expected) in [
            ("../generated/docs", "../generated/schemas", "../schemas"),
            ("docs/messages", "./schemas", "../../schemas"),
            ("docs", "docs/schemas", "schemas"),
        ] {
            assert_eq!(seen_from(Path::new(from), Path::new(to)), expected);
        }
    }
}
