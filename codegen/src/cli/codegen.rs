//! The `codegen` command, which writes output or compares it with existing files.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use uavspec_emit::{EMITTERS, Emitter, emitter};
use uavspec_schema::diagnostic::has_errors;
use uavspec_schema::failure::Failure;
use uavspec_schema::wording::plural;
use uavspec_schema::{Package, Schema, terminal};

use super::arguments::PackageArgs;
use super::print::report;
use super::stopwatch::Stopwatch;
use crate::generate::{self, Difference, Folder, emit_all};
use crate::load::{Config, Loaded, read_translated};

/// The text below the options in `codegen --help`.
const EXAMPLES: &str = "Examples:
  cargo xtask codegen            generate the outputs that uavspec.toml lists
  cargo xtask codegen --check    write nothing; fail if output is stale
  cargo xtask codegen --package px4 --dialect px4 --input msg --out generated

Without --package, the command reads the nearest uavspec.toml or definitions/uavspec.toml, in the current folder or a \
parent folder. With --package, each emitter writes to the subfolder of --out named after the emitter. Nothing is \
written outside the output folders, and links inside them are not followed.

Output options in uavspec.toml, as keys of the table [output.NAME]:";

/// Arguments of `codegen`.
#[derive(Args, Debug)]
#[command(after_help = after_help())]
pub struct CodegenArgs {
    /// Write nothing; list stale files and fail if there are any
    #[arg(long)]
    check: bool,
    /// Configuration file [default: nearest uavspec.toml]
    #[arg(long, value_name = "FILE", conflicts_with = "package")]
    config: Option<PathBuf>,
    #[command(flatten)]
    package: Option<PackageArgs>,
    /// Folder for the output
    #[arg(long, value_name = "DIR", requires = "package")]
    out: Option<PathBuf>,
    /// Outputs to generate
    #[arg(long, value_name = "KIND", value_delimiter = ',', requires = "package", value_parser = emitters(),
        default_values = ["rust", "json_schema", "docs"])]
    emit: Vec<&'static Emitter>,
}

/// The values of `--emit`.
fn emitters() -> impl TypedValueParser<Value = &'static Emitter> {
    let values = EMITTERS.iter().map(|emitter| PossibleValue::new(emitter.name).help(emitter.help));
    PossibleValuesParser::new(values).try_map(|name| emitter(&name))
}

/// The examples, and the options of each emitter.
fn after_help() -> String {
    let mut text = EXAMPLES.to_owned();
    for emitter in EMITTERS {
        for (key, meaning) in emitter.options() {
            let _ = write!(text, "\n  {}.{key}\n      {meaning}", emitter.name);
        }
    }
    text
}

pub(super) fn run(args: &CodegenArgs) -> Result<bool, Failure> {
    let started = Stopwatch::start();
    let plan = match &args.package {
        Some(package) => {
            let Some(out) = &args.out else {
                return Err(
                    Failure::new("--package requires --out DIR").with_hint("choose a folder for the output")
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
    if !loaded.built_in.is_empty() {
        terminal::eprintln!("codegen: the built-in definitions of {}", loaded.built_in.join(", "));
    }
    let folders = emit_all(&plan, &loaded, &schema, &translations)?;
    let config = plan.config.iter().map(|(path, _)| PathBuf::from(path));
    let inputs: Vec<PathBuf> = loaded.files.iter().cloned().chain(config).collect();
    if args.check {
        let differences = generate::compare(&folders, &inputs)?;
        for difference in &differences {
            terminal::eprintln!("{difference}");
        }
        let summary = match differences.len() {
            0 => "up to date".to_owned(),
            count => format!("{}; run `codegen`", plural(count, "stale file")),
        };
        summarise(&loaded, &schema, &folders, &summary, started);
        return Ok(differences.is_empty());
    }
    let differences = generate::write(&folders, &inputs)?;
    let removed =
        differences.iter().filter(|difference| matches!(difference, Difference::Orphaned(_))).count();
    let summary = format!("{} written, {removed} removed", differences.len() - removed);
    summarise(&loaded, &schema, &folders, &summary, started);
    Ok(true)
}

fn summarise(loaded: &Loaded, schema: &Schema, folders: &[Folder], result: &str, started: Stopwatch) {
    let total = |count: fn(&Package) -> usize| schema.packages.iter().map(count).sum::<usize>();
    let messages = total(|package| package.messages.len() + package.json_messages.len());
    let codes = total(|package| package.error_tables.iter().map(|table| table.codes.len()).sum());
    let events = total(|package| package.components.iter().map(|component| component.events.len()).sum());
    let outputs: usize = folders.iter().map(|folder| folder.files.len()).sum();
    let found = [(messages, "message"), (codes, "error code"), (events, "event")];
    let found = found.into_iter().filter(|(count, _)| *count > 0).map(|(count, name)| plural(count, name));
    let counts = [plural(loaded.files.len(), "file") + " read"].into_iter().chain(found);
    terminal::eprintln!(
        "codegen: {}, {}: {result} ({} ms)",
        counts.collect::<Vec<_>>().join(", "),
        plural(outputs, "output"),
        started.milliseconds(),
    );
}
