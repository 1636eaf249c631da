//! Reads definitions from the files that a configuration file lists, or from a path.
//!
//! ```
//! let folder = tempfile::tempdir()?;
//! std::fs::write(folder.path().join("Wind.msg"), "float32 speed  # [m/s] Speed\n")?;
//! let (_, schema) = uavspec_codegen::load::read_definitions(folder.path())?;
//! assert_eq!(schema.messages[0].name, "Wind");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod built_in;
mod config;
mod dialect;
mod discovery;
mod files;
mod folder;
mod lint;
mod located;
mod schema;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use uavspec_lint::{Ignore, Settings};
use uavspec_schema::diagnostic::{Diagnostic, Problem, has_errors};
use uavspec_schema::failure::Failure;
use uavspec_schema::msg::Dialect;
use uavspec_schema::source::{SourceId, SourceMap};
use uavspec_schema::translation::{self, Translations};
use uavspec_schema::{Form, Schema, render};

use self::built_in::BuiltIn;
pub(crate) use self::config::DialectName;
pub use self::config::{Config, Inputs, Plan, PlannedPackage};
pub use self::dialect::detected;
pub use self::discovery::{
    FoundPackage, by_package, entries, find_packages, is_msg_file, msg_file, package_name,
};
use self::files::definitions_at;
pub use self::files::{
    Loaded, is_definition, literal_base, load, load_into, load_named, load_with_catalogues,
};
pub use self::folder::manifest_name;
pub use self::schema::configuration_schema;

/// Definitions that were read from a path.
#[derive(Debug)]
pub struct Definitions {
    /// The sources.
    pub sources: SourceMap,
    /// The schema.
    pub schema: Schema,
    /// The paths of definitions that refer to a package outside this path. These definitions aren't part of the schema.
    pub left_out: Vec<String>,
    /// The names of the built-in packages that supply definitions missing at the path.
    pub built_in: Vec<String>,
}

/// Reads definitions from a configuration file, a folder that contains one, or files and folders of PX4 messages or ROS 2
/// packages. The dialect is detected.
///
/// Fails if the definitions contain errors; ignores warnings.
pub fn read_definitions(path: impl AsRef<Path>) -> Result<(SourceMap, Schema), Failure> {
    let Definitions { sources, schema, .. } = read_definitions_as(path.as_ref(), None)?;
    Ok((sources, schema))
}

/// Like [`read_definitions`], but with a given dialect unless the path has a configuration file.
pub fn read_definitions_as(path: &Path, dialect: Option<Dialect>) -> Result<Definitions, Failure> {
    read_plan(&plan_at(path, dialect)?)
}

/// Like [`read_definitions_as`], but ROS 2 definitions also include built-in packages that are missing at the path,
/// because captures contain their messages. Messages that differ between distributions of ROS 2 are omitted.
pub fn read_definitions_for_captures(path: &Path, dialect: Option<Dialect>) -> Result<Definitions, Failure> {
    read_plan(&Plan { built_in: BuiltIn::All, ..plan_at(path, dialect)? })
}

fn read_plan(plan: &Plan) -> Result<Definitions, Failure> {
    let loaded = load(plan)?;
    if plan.config.is_none() {
        return complete(loaded);
    }
    let (schema, mut diagnostics) = uavspec_schema::read::read(&loaded.sources, &loaded.packages);
    diagnostics.extend(loaded.diagnostics);
    fail_on_errors(&diagnostics, &loaded.sources)?;
    let built_in = loaded.built_in;
    Ok(Definitions { sources: loaded.sources, schema, left_out: Vec::new(), built_in })
}

/// Like [`read_definitions`], but also reads the translations. Fails if the translations contain errors.
pub fn read_definitions_translated(
    path: impl AsRef<Path>,
) -> Result<(SourceMap, Schema, Translations), Failure> {
    let (loaded, schema, translations, diagnostics) = read_translated(&plan_at(path.as_ref(), None)?)?;
    fail_on_errors(&diagnostics, &loaded.sources)?;
    Ok((loaded.sources, schema, translations))
}

/// Reads the definitions in files and folders. ROS packages in separate folders remain separate packages.
///
/// Fails if the definitions contain errors other than references to packages outside the inputs; ignores warnings.
pub fn read_package(name: &str, form: Form, inputs: &[PathBuf]) -> Result<Definitions, Failure> {
    complete(load(&Plan::from_arguments(name, form, inputs, Path::new(""), &[]))?)
}

/// Reads definitions. Omits definitions that refer to a package outside the inputs.
fn complete(mut loaded: Loaded) -> Result<Definitions, Failure> {
    fail_on_errors(&loaded.diagnostics, &loaded.sources)?;
    let mut left_out = Vec::new();
    loop {
        let (schema, diagnostics) = uavspec_schema::read::read(&loaded.sources, &loaded.packages);
        let is_incomplete = |diagnostic: &&Diagnostic| {
            matches!(diagnostic.problem, Problem::UnknownPackage { .. } | Problem::UnknownType { .. })
        };
        let incomplete: BTreeSet<SourceId> = diagnostics
            .iter()
            .filter(is_incomplete)
            .map(|diagnostic| loaded.sources.source_of(diagnostic.span))
            .collect();
        // The remaining definitions may refer to omitted definitions, which are now unknown types.
        if incomplete.is_empty() || left_out.is_empty() && !refers_to_package(&diagnostics) {
            fail_on_errors(&diagnostics, &loaded.sources)?;
            let built_in = loaded.built_in;
            return Ok(Definitions { sources: loaded.sources, schema, left_out, built_in });
        }
        left_out.extend(incomplete.iter().map(|id| loaded.sources.path(*id).to_owned()));
        for package in &mut loaded.packages {
            package.sources.retain(|id| !incomplete.contains(id));
        }
    }
}

/// True if a definition refers to a package outside the inputs.
fn refers_to_package(diagnostics: &[Diagnostic]) -> bool {
    diagnostics.iter().any(|diagnostic| matches!(diagnostic.problem, Problem::UnknownPackage { .. }))
}

/// The files that [`read_definitions`] and [`read_definitions_translated`] read from this path, including the
/// configuration file.
pub fn definition_files(path: impl AsRef<Path>) -> Result<Vec<PathBuf>, Failure> {
    let plan = plan_at(path.as_ref(), None)?;
    let mut files = load_with_catalogues(&plan)?.files;
    files.extend(plan.config.map(|(path, _)| PathBuf::from(path)));
    Ok(files)
}

/// The plan for a path given to [`read_definitions`].
fn plan_at(path: &Path, dialect: Option<Dialect>) -> Result<Plan, Failure> {
    let file = if path.is_file() { Some(path.to_path_buf()) } else { Config::in_folder(path) };
    if let Some(file) = file.filter(|file| file.extension().is_some_and(|extension| extension == "toml")) {
        return Config::read(&file)?.plan();
    }
    let (detected, name) = detected(&definitions_at(path)?);
    let dialect = dialect.unwrap_or(detected);
    let name = if dialect == detected { name } else { dialect.name().to_owned() };
    Ok(Plan::from_arguments(&name, Form::Msg(dialect), &[path.to_path_buf()], Path::new(""), &[]))
}

pub(crate) fn fail_on_errors(diagnostics: &[Diagnostic], sources: &SourceMap) -> Result<(), Failure> {
    if !has_errors(diagnostics) {
        return Ok(());
    }
    let rendered = render::render(diagnostics, sources, false);
    Err(Failure::new(format!("the definitions contain errors\n{rendered}")))
}

/// The settings of a lint run.
pub fn lint_settings(plan: &Plan, loaded: &Loaded) -> Settings {
    let ignores = plan.lint.ignores.iter().map(|ignore| Ignore {
        rule: ignore.rule.clone(),
        sources: ignore.files.as_ref().map(|files| {
            let matching = loaded.paths.iter().filter(|(_, path)| files.is_match(path));
            matching.map(|(source, _)| *source).collect::<BTreeSet<SourceId>>()
        }),
        reason: ignore.reason.clone(),
        span: loaded.config.unwrap_or_default().part(ignore.range.clone()),
    });
    Settings {
        preset: plan.lint.preset,
        levels: plan.lint.levels.clone(),
        ignores: ignores.collect(),
        conversions: loaded.conversions.clone(),
    }
}

pub(crate) fn read(plan: &Plan) -> Result<(Loaded, Schema, Vec<Diagnostic>), Failure> {
    let mut loaded = load(plan)?;
    let (schema, mut diagnostics) = uavspec_schema::read::read(&loaded.sources, &loaded.packages);
    diagnostics.append(&mut loaded.diagnostics);
    Ok((loaded, schema, diagnostics))
}

/// Definitions, their translations, and the diagnostics of both.
pub(crate) type Translated = (Loaded, Schema, Translations, Vec<Diagnostic>);

pub(crate) fn read_translated(plan: &Plan) -> Result<Translated, Failure> {
    let mut loaded = load_with_catalogues(plan)?;
    let (schema, mut diagnostics) = uavspec_schema::read::read(&loaded.sources, &loaded.packages);
    diagnostics.append(&mut loaded.diagnostics);
    let mut translations = Translations::default();
    // If definitions can't be read, their translations would appear to be unknown.
    if !has_errors(&diagnostics) {
        let (resolved, mut found) = translation::resolve(&loaded.sources, &schema, &loaded.catalogues);
        translations = resolved;
        diagnostics.append(&mut found);
    }
    Ok((loaded, schema, translations, diagnostics))
}
