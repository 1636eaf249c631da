//! Definitions from files: those that a configuration file names, or those at a path.
//!
//! ```
//! let folder = tempfile::tempdir()?;
//! std::fs::write(folder.path().join("Wind.msg"), "float32 speed  # [m/s] Speed\n")?;
//! let (_, schema) = uavspec_codegen::load::read_definitions(folder.path())?;
//! assert_eq!(schema.messages[0].name, "Wind");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod config;
mod files;
mod lint;
mod mistake;

use std::path::Path;

pub(crate) use self::config::{Config, Inputs, Plan};
pub(crate) use self::files::{
    Loaded, is_definition, literal_base, load, load_beside, load_named, load_with_catalogues,
};
pub(crate) use self::lint::PresetName;
use crate::diagnostic::{Diagnostic, has_errors};
use crate::failure::Failure;
use crate::msg::Dialect;
use crate::render;
use crate::schema::{Form, Schema};
use crate::source::SourceMap;
use crate::translation::{self, Translations};

/// Reads definitions for whoever judges by them: a configuration file, a folder with one, or files and folders
/// of PX4's messages. Mistakes in them are a failure, warnings are not.
pub fn read_definitions(path: impl AsRef<Path>) -> Result<(SourceMap, Schema), Failure> {
    let (loaded, schema, diagnostics) = read(&plan_at(path.as_ref())?)?;
    refuse_mistakes(&diagnostics, &loaded.sources)?;
    Ok((loaded.sources, schema))
}

/// Reads definitions as [`read_definitions`] does, and their translations, in which mistakes are a failure, too.
pub fn read_definitions_translated(
    path: impl AsRef<Path>,
) -> Result<(SourceMap, Schema, Translations), Failure> {
    let (loaded, schema, translations, diagnostics) = read_translated(&plan_at(path.as_ref())?)?;
    refuse_mistakes(&diagnostics, &loaded.sources)?;
    Ok((loaded.sources, schema, translations))
}

/// What to read at a path, as [`read_definitions`] takes it.
fn plan_at(path: &Path) -> Result<Plan, Failure> {
    let file = if path.is_file() { Some(path.to_path_buf()) } else { Config::in_folder(path) };
    match file {
        Some(file) if file.extension().is_some_and(|extension| extension == "toml") => {
            Config::read(&file)?.plan()
        }
        _ => Ok(Plan::from_arguments(
            "px4",
            Form::Msg(Dialect::Px4),
            &[path.to_path_buf()],
            Path::new(""),
            &[],
        )),
    }
}

fn refuse_mistakes(diagnostics: &[Diagnostic], sources: &SourceMap) -> Result<(), Failure> {
    if !has_errors(diagnostics) {
        return Ok(());
    }
    let rendered = render::render(diagnostics, sources, false);
    Err(Failure::new(format!("the definitions have mistakes\n{rendered}")))
}

pub(crate) fn read(plan: &Plan) -> Result<(Loaded, Schema, Vec<Diagnostic>), Failure> {
    let mut loaded = load(plan)?;
    let (schema, mut diagnostics) = crate::read::read(&loaded.sources, &loaded.packages);
    diagnostics.append(&mut loaded.diagnostics);
    Ok((loaded, schema, diagnostics))
}

/// Definitions, their translations, and all that is to be said of both.
pub(crate) type Translated = (Loaded, Schema, Translations, Vec<Diagnostic>);

pub(crate) fn read_translated(plan: &Plan) -> Result<Translated, Failure> {
    let mut loaded = load_with_catalogues(plan)?;
    let (schema, mut diagnostics) = crate::read::read(&loaded.sources, &loaded.packages);
    diagnostics.append(&mut loaded.diagnostics);
    let mut translations = Translations::default();
    // Translations of what can't be read would seem to name nothing.
    if !has_errors(&diagnostics) {
        let (resolved, mut found) = translation::resolve(&loaded.sources, &schema, &loaded.catalogues);
        translations = resolved;
        diagnostics.append(&mut found);
    }
    Ok((loaded, schema, translations, diagnostics))
}
