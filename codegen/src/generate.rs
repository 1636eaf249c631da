//! Generation of output from a configuration file, for build scripts and the command line.

mod guard;
mod output;

use std::path::{Path, PathBuf};

use uavspec_dynamic::conversion::{Answer, Conversions, answer};
use uavspec_emit::Input;
use uavspec_schema::diagnostic::Level;
use uavspec_schema::failure::Failure;
use uavspec_schema::finding::Finding;
use uavspec_schema::parallel::in_parallel;
use uavspec_schema::translation::Translations;
use uavspec_schema::{Schema, render};

pub(crate) use self::output::{Difference, Folder, compare, write};
use crate::load::{Config, Loaded, Plan, fail_on_errors, read_translated};

/// The result of [`generate`].
#[derive(Debug)]
pub struct Generated {
    /// The configuration file and all files that were read.
    pub inputs: Vec<PathBuf>,
    /// Files that were written or removed because they were outdated.
    pub changed: Vec<PathBuf>,
    /// Rendered warnings; empty if there are none.
    pub warnings: String,
}

impl Generated {
    /// Tells Cargo to run the build script again when an input changes.
    #[allow(clippy::disallowed_macros, reason = "Cargo reads the output, which has one path per line")]
    pub fn print_rerun_if_changed(&self) {
        for input in &self.inputs {
            println!("cargo::rerun-if-changed={}", watchable(input).to_string_lossy());
        }
    }
}

/// The path itself, or its closest folder whose path has no line breaks. Cargo interprets each line of the output as an
/// instruction.
fn watchable(path: &Path) -> &Path {
    let has_break =
        |path: &Path| path.as_os_str().as_encoded_bytes().iter().any(|byte| matches!(byte, b'\n' | b'\r'));
    path.ancestors()
        .find(|path| !has_break(path))
        .filter(|path| !path.as_os_str().is_empty())
        .unwrap_or(Path::new("."))
}

/// Generates the outputs of the configuration file at `config`. Intended for build scripts.
///
/// ```no_run
/// let generated = uavspec_codegen::generate("uavspec.toml").unwrap_or_else(|failure| panic!("{failure}"));
/// generated.print_rerun_if_changed();
/// ```
pub fn generate(config: impl AsRef<Path>) -> Result<Generated, Failure> {
    let config = config.as_ref();
    let plan = Config::find(Some(config))?.plan()?;
    let (loaded, schema, translations, diagnostics) = read_translated(&plan)?;
    fail_on_errors(&diagnostics, &loaded.sources)?;
    let warnings = render::render(&diagnostics, &loaded.sources, false);
    let folders = emit_all(&plan, &loaded, &schema, &translations)?;
    let mut inputs = loaded.files;
    inputs.insert(0, config.to_path_buf());
    let changed = write(&folders, &inputs)?;
    Ok(Generated { inputs, changed: changed.into_iter().map(Difference::into_path).collect(), warnings })
}

/// Runs the emitters of the plan. Fails if a name in the definitions is not a file name on all systems.
pub(crate) fn emit_all(
    plan: &Plan,
    loaded: &Loaded,
    schema: &Schema,
    translations: &Translations,
) -> Result<Vec<Folder>, Failure> {
    let Loaded { sources, releases, .. } = loaded;
    guard::check_names(schema, sources)?;
    let conversions = conversions(schema, loaded)?;
    let input = Input { schema, translations, sources, releases, conversions: &conversions };
    in_parallel(&plan.outputs, |output| {
        Ok(Folder { path: output.path.clone(), files: output.output.emit(input)? })
    })
}

/// The conversions that the plan requests. Fails if a hint has a mistake.
fn conversions(schema: &Schema, loaded: &Loaded) -> Result<Vec<Conversions>, Failure> {
    let answers = answer(&loaded.sources, schema, &loaded.conversions);
    let mistakes = answers.iter().flat_map(Answer::mistakes).map(|mistake| {
        let mut finding = Finding::new("hint-invalid", Level::Error, mistake.span, mistake.message);
        finding.help(mistake.help);
        finding
    });
    let mistakes: Vec<Finding> = mistakes.collect();
    if !mistakes.is_empty() {
        let rendered = render::findings(&mistakes, &loaded.sources, false);
        return Err(Failure::new(format!("the hints contain errors\n{rendered}")));
    }
    Ok(answers.into_iter().flat_map(|answer| answer.conversions).collect())
}
