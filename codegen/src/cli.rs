//! The command line that an `xtask` embeds, here and in other workspaces.
//!
//! ```no_run
//! fn main() -> std::process::ExitCode {
//!     uavspec_codegen::cli::main()
//! }
//! ```
//!
//! A build script calls [`generate`] instead, which prints nothing.
//!
//! Exit status: 0 all is well; 1 mistakes in the definitions, or stale output or layout with `--check`;
//! 2 the command can't be carried out: wrong usage, missing input, unwritable output.

mod breaking;
mod config;
mod format;
mod lint;
mod load;
mod output;
mod report;
mod revision;
pub mod rewrite;
mod translate;

use std::fmt;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::thread;
use std::time::Instant;

use clap::{Args, Parser, Subcommand, ValueEnum};

use self::config::{Config, Emitter, EmitterOptions, Plan, PlannedOutput};
pub use self::format::FmtArgs;
use self::load::Loaded;
use self::output::{Difference, Folder};
use crate::diagnostic::{Diagnostic, Level, has_errors};
use crate::emit::{self, OutputFile};
use crate::render;
use crate::schema::{Form, Schema};
use crate::source::SourceMap;
use crate::translation::{self, Translations};

/// Makes drone interface specifications executable: reads `.msg` definitions and specification
/// tables, and generates Rust types, JSON Schemas, documentation, test vectors, TypeScript and Python from them.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

/// The commands, to be embedded among those of another command line.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Generate Rust types, JSON Schemas, documentation, test vectors, TypeScript and Python from the definitions.
    Codegen(CodegenArgs),
    /// Lay out definitions and error-code tables: spacing, comments, annotations, columns.
    Fmt(FmtArgs),
    /// Print the model of the definitions as JSON.
    Inspect(InspectArgs),
    /// Find what should be written otherwise in the definitions, and mend what can be.
    Lint(lint::LintArgs),
    /// Bring catalogues of translations up to date with the definitions, or begin one.
    Translate(translate::TranslateArgs),
    /// Compare the definitions with an earlier state, and say what breaks whom.
    Breaking(breaking::BreakingArgs),
}

/// Arguments of `codegen`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  cargo xtask codegen                 generate what uavspec.toml says
  cargo xtask codegen --check         write nothing; fail where output is stale
  cargo xtask codegen --package px4 --dialect px4 --input msg --out generated --emit rust,docs

Without --package, the file uavspec.toml (or definitions/uavspec.toml) is looked for here and in each folder above.
With --package, each emitter writes to a folder of its name below --out.")]
pub struct CodegenArgs {
    /// Write nothing; list what differs and fail if anything does.
    #[arg(long)]
    check: bool,
    /// The configuration file, where it is not found by itself.
    #[arg(long, value_name = "FILE", conflicts_with = "package")]
    config: Option<PathBuf>,
    #[command(flatten)]
    package: Option<PackageArgs>,
    /// Folder for the output.
    #[arg(long, value_name = "DIR", requires = "package")]
    out: Option<PathBuf>,
    /// What to generate.
    #[arg(long, value_name = "KIND", value_delimiter = ',', requires = "package", default_values = ["rust", "json_schema", "docs"])]
    emit: Vec<Emitter>,
}

/// Arguments of `inspect`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  cargo xtask inspect                 the model of what uavspec.toml names
  cargo xtask inspect --package px4 --dialect px4 --input msg/BatteryStatus.msg")]
pub struct InspectArgs {
    #[command(flatten)]
    definitions: DefinitionsArgs,
}

/// Which definitions a command reads.
#[derive(Args, Debug)]
struct DefinitionsArgs {
    /// The configuration file, where it is not found by itself.
    #[arg(long, value_name = "FILE", conflicts_with = "package")]
    config: Option<PathBuf>,
    #[command(flatten)]
    package: Option<PackageArgs>,
}

impl DefinitionsArgs {
    /// The package that is given, or else what the configuration file says.
    fn plan(&self) -> Result<Plan, Failure> {
        match &self.package {
            Some(package) => Ok(package.plan(Path::new(""), &[])),
            None => Config::find(self.config.as_deref())?.plan(),
        }
    }
}

/// A package given on the command line instead of a file.
#[derive(Args, Clone, Debug)]
pub struct PackageArgs {
    /// Name of the package.
    #[arg(long, value_name = "NAME", required = false, requires_all = ["dialect", "input"])]
    package: String,
    /// How the definitions are written.
    #[arg(long, required = false, requires = "package")]
    dialect: Dialect,
    /// Files, or folders that are searched for definitions.
    #[arg(long, value_name = "PATH", num_args = 1.., required = false, requires = "package")]
    input: Vec<PathBuf>,
}

impl PackageArgs {
    fn plan(&self, out: &Path, emit: &[Emitter]) -> Plan {
        Plan::from_arguments(&self.package, self.dialect.into(), &self.input, out, emit)
    }
}

/// How definitions are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Dialect {
    /// PX4 uORB messages.
    Px4,
    /// ROS 2 interfaces.
    Ros2,
    /// Pages with specification tables.
    Table,
}

impl From<Dialect> for Form {
    fn from(dialect: Dialect) -> Self {
        match dialect {
            Dialect::Px4 => Self::Msg(crate::msg::Dialect::Px4),
            Dialect::Ros2 => Self::Msg(crate::msg::Dialect::Ros2),
            Dialect::Table => Self::Table,
        }
    }
}

/// Why a command can't be carried out, with what to do about it.
#[derive(Debug)]
pub struct Failure {
    message: String,
    hint: Option<String>,
}

impl std::error::Error for Failure {}

impl Failure {
    fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), hint: None }
    }

    fn with_hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "error: {}", self.message)?;
        self.hint.as_ref().map_or(Ok(()), |hint| write!(formatter, "\n  help: {hint}"))
    }
}

/// What [`generate`] read and wrote.
#[derive(Debug)]
pub struct Generated {
    /// The configuration file and all files that were read.
    pub inputs: Vec<PathBuf>,
    /// Files that were written or removed, as they were not what they should be.
    pub changed: Vec<PathBuf>,
    /// Warnings, rendered; empty where there are none.
    pub warnings: String,
}

impl Generated {
    /// Tells Cargo to run the build script again when an input changes.
    pub fn print_rerun_if_changed(&self) {
        for input in &self.inputs {
            println!("cargo::rerun-if-changed={}", input.display());
        }
    }
}

/// Generates what the configuration file at `config` says: for build scripts.
///
/// ```no_run
/// let generated = uavspec_codegen::cli::generate("uavspec.toml").unwrap_or_else(|failure| panic!("{failure}"));
/// generated.print_rerun_if_changed();
/// ```
pub fn generate(config: impl AsRef<Path>) -> Result<Generated, Failure> {
    let config = config.as_ref();
    let plan = Config::find(Some(config))?.plan()?;
    let (loaded, schema, translations, diagnostics) = read_translated(&plan)?;
    let rendered = render::render(&diagnostics, &loaded.sources, false);
    if has_errors(&diagnostics) {
        return Err(Failure::new(format!("the definitions have mistakes\n{rendered}")));
    }
    let changed = output::write(&emit_all(&plan, &schema, &translations, &loaded.sources)?)?;
    let mut inputs = loaded.files;
    inputs.insert(0, config.to_path_buf());
    Ok(Generated {
        inputs,
        changed: changed.into_iter().map(Difference::into_path).collect(),
        warnings: rendered,
    })
}

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
        _ => Ok(Plan::from_arguments("px4", Dialect::Px4.into(), &[path.to_path_buf()], Path::new(""), &[])),
    }
}

fn refuse_mistakes(diagnostics: &[Diagnostic], sources: &SourceMap) -> Result<(), Failure> {
    if !has_errors(diagnostics) {
        return Ok(());
    }
    let rendered = render::render(diagnostics, sources, false);
    Err(Failure::new(format!("the definitions have mistakes\n{rendered}")))
}

/// The whole command line of an `xtask` that does nothing else.
pub fn main() -> ExitCode {
    Cli::parse().command.run()
}

impl Command {
    /// Carries out the command and reports on standard error.
    pub fn run(self) -> ExitCode {
        let result = match self {
            Self::Codegen(args) => codegen(&args),
            Self::Fmt(args) => format::run(&args),
            Self::Inspect(args) => inspect(&args),
            Self::Lint(args) => lint::run(&args),
            Self::Translate(args) => translate::run(&args),
            Self::Breaking(args) => breaking::run(&args),
        };
        match result {
            Ok(true) => ExitCode::SUCCESS,
            Ok(false) => ExitCode::from(1),
            Err(failure) => {
                anstream::eprintln!("{failure}");
                ExitCode::from(2)
            }
        }
    }
}

fn codegen(args: &CodegenArgs) -> Result<bool, Failure> {
    let started = Instant::now();
    let plan = match &args.package {
        Some(package) => {
            let Some(out) = &args.out else {
                return Err(
                    Failure::new("--package needs --out DIR").with_hint("name a folder for the output")
                );
            };
            package.plan(out, &args.emit)
        }
        None => Config::find(args.config.as_deref())?.plan()?,
    };
    let (loaded, schema, translations, diagnostics) = read_translated(&plan)?;
    report("codegen", &loaded, &diagnostics, "nothing written");
    if has_errors(&diagnostics) {
        return Ok(false);
    }
    let folders = emit_all(&plan, &schema, &translations, &loaded.sources)?;
    if args.check {
        let differences = output::compare(&folders)?;
        for difference in &differences {
            anstream::eprintln!("{difference}");
        }
        let summary = match differences.len() {
            0 => "up to date".to_owned(),
            count => format!("{}; run `cargo xtask codegen`", plural(count, "stale file")),
        };
        summarise(&loaded, &schema, &folders, &summary, started);
        return Ok(differences.is_empty());
    }
    let differences = output::write(&folders)?;
    let removed =
        differences.iter().filter(|difference| matches!(difference, Difference::Orphaned(_))).count();
    let summary = format!("{} written, {removed} removed", differences.len() - removed);
    summarise(&loaded, &schema, &folders, &summary, started);
    Ok(true)
}

fn inspect(args: &InspectArgs) -> Result<bool, Failure> {
    let plan = args.definitions.plan()?;
    let (loaded, schema, diagnostics) = read(&plan)?;
    report("inspect", &loaded, &diagnostics, "nothing printed");
    if has_errors(&diagnostics) {
        return Ok(false);
    }
    let mut text = serde_json::to_string_pretty(&emit::inspect::schema(&schema))
        .map_err(|error| Failure::new(error.to_string()))?;
    text.push('\n');
    // A reader that has seen enough closes the pipe: that is no failure.
    let _ = std::io::stdout().write_all(text.as_bytes());
    Ok(true)
}

fn read(plan: &Plan) -> Result<(Loaded, Schema, Vec<Diagnostic>), Failure> {
    let mut loaded = load::load(plan)?;
    let (schema, mut diagnostics) = crate::read::read(&loaded.sources, &loaded.packages);
    diagnostics.append(&mut loaded.diagnostics);
    Ok((loaded, schema, diagnostics))
}

/// Definitions, their translations, and all that is to be said of both.
type Translated = (Loaded, Schema, Translations, Vec<Diagnostic>);

fn read_translated(plan: &Plan) -> Result<Translated, Failure> {
    let mut loaded = load::load_with_catalogues(plan)?;
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

/// Runs the emitters that the plan names.
fn emit_all(
    plan: &Plan,
    schema: &Schema,
    translations: &Translations,
    sources: &SourceMap,
) -> Result<Vec<Folder>, Failure> {
    side_by_side(&plan.outputs, |output: &PlannedOutput| {
        let files = match &output.emitter {
            EmitterOptions::Rust(options) => emit_rust(schema, sources, options)?,
            EmitterOptions::JsonSchema(options) => emit::json_schema::emit(schema, options),
            EmitterOptions::Docs(options) => {
                emit::docs::emit(schema, translations, sources, &options.read()?)
            }
            EmitterOptions::Vectors(options) => emit::vectors::emit(schema, options),
            EmitterOptions::TypeScript(options) => emit::typescript::emit(schema, translations, options),
            EmitterOptions::Python => emit::python::emit(schema, translations),
        };
        Ok(Folder { path: output.path.clone(), files })
    })
}

/// Does the same for each of `items` at once, and gives the results in their order.
fn side_by_side<'i, T: Sync, R: Send>(
    items: &'i [T],
    work: impl Fn(&'i T) -> Result<R, Failure> + Sync,
) -> Result<Vec<R>, Failure> {
    thread::scope(|scope| {
        let work = &work;
        let threads: Vec<_> = items.iter().map(|item| scope.spawn(move || work(item))).collect();
        // A panic in a thread is a defect here, and goes on in the caller.
        let join = |thread: thread::ScopedJoinHandle<'_, _>| {
            thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        };
        threads.into_iter().map(join).collect()
    })
}

#[cfg(feature = "rust")]
#[allow(clippy::unnecessary_wraps)] // the other build's can fail
fn emit_rust(
    schema: &Schema,
    sources: &SourceMap,
    options: &config::RustOptions,
) -> Result<Vec<OutputFile>, Failure> {
    let options = emit::rust::Options { root: options.root.clone(), readme: options.readme.clone() };
    Ok(emit::rust::emit(schema, sources, &options))
}

#[cfg(not(feature = "rust"))]
fn emit_rust(_: &Schema, _: &SourceMap, _: &config::RustOptions) -> Result<Vec<OutputFile>, Failure> {
    Err(Failure::new("this build can't emit Rust").with_hint("enable the feature `rust` of uavspec-codegen"))
}

/// Prints a text to standard error, with colours where they are shown. A stream that takes them out would
/// write each stretch between two of them by itself, which takes as long as all the rest.
fn print_rendered(render: impl FnOnce(bool) -> String) {
    let is_plain = anstream::AutoStream::choice(&std::io::stderr()) == anstream::ColorChoice::Never;
    let _ = if is_plain {
        std::io::stderr().write_all(render(false).as_bytes())
    } else {
        anstream::stderr().write_all(render(true).as_bytes())
    };
}

/// Prints all diagnostics, and how many there are.
fn report(command: &str, loaded: &Loaded, diagnostics: &[Diagnostic], consequence: &str) {
    if diagnostics.is_empty() {
        return;
    }
    print_rendered(|styled| render::render(diagnostics, &loaded.sources, styled));
    let count = |level| diagnostics.iter().filter(|diagnostic| diagnostic.level() == level).count();
    let (errors, warnings) = (count(Level::Error), count(Level::Warning));
    let mut files: Vec<_> =
        diagnostics.iter().map(|diagnostic| loaded.sources.source_of(diagnostic.span)).collect();
    files.sort_unstable();
    files.dedup();
    let counts: Vec<String> = [(errors, "error"), (warnings, "warning")]
        .into_iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, what)| plural(count, what))
        .collect();
    let consequence = if errors > 0 { format!("; {consequence}") } else { String::new() };
    let place = format!("{} of {}", files.len(), plural(loaded.files.len(), "file"));
    anstream::eprintln!("{command}: {} in {place}{consequence}", counts.join(", "));
}

fn summarise(loaded: &Loaded, schema: &Schema, folders: &[Folder], result: &str, started: Instant) {
    let messages: usize =
        schema.packages.iter().map(|package| package.messages.len() + package.json_messages.len()).sum();
    let codes: usize =
        schema.packages.iter().flat_map(|package| &package.error_tables).map(|table| table.codes.len()).sum();
    let outputs: usize = folders.iter().map(|folder| folder.files.len()).sum();
    anstream::eprintln!(
        "codegen: {} read, {}, {}, {}: {result} ({} ms)",
        plural(loaded.files.len(), "file"),
        plural(messages, "message"),
        plural(codes, "error code"),
        plural(outputs, "output"),
        started.elapsed().as_millis(),
    );
}

fn plural(count: usize, what: &str) -> String {
    if count == 1 { format!("1 {what}") } else { format!("{count} {what}s") }
}
