//! The `fmt` command, which formats definitions and pages.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

use clap::Args;
use uavspec_lint::format::{self, Formatted};
use uavspec_schema::failure::Failure;
use uavspec_schema::rewrite::{self, Change};
use uavspec_schema::source::{SourceId, SourceMap};
use uavspec_schema::wording::plural;
use uavspec_schema::{difference, terminal};

use super::arguments::{DefinitionsArgs, FilesArgs};
use super::print::{protect_inputs, report};
use super::stopwatch::Stopwatch;
use crate::load::{self, Loaded, Plan};

/// Arguments of `fmt`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  cargo xtask fmt            format all files that uavspec.toml lists
  cargo xtask fmt --check    print the changes as a patch; fail if there are any
  cargo xtask fmt msg/Wind.msg
  cargo xtask fmt --package px4 --dialect px4 --input msg srv/Arm.srv

Formatting changes white space, the order and spelling of annotations, and the columns of tables. Formatting never \
changes the meaning of a definition. Files with errors are left unchanged.")]
pub struct FmtArgs {
    /// Print the changes as a patch instead of writing; fail if there are any
    #[arg(long)]
    check: bool,
    #[command(flatten)]
    definitions: DefinitionsArgs,
    #[command(flatten)]
    files: FilesArgs,
}

pub(super) fn run(args: &FmtArgs) -> Result<bool, Failure> {
    let started = Stopwatch::start();
    let plan = args.definitions.plan()?;
    let (changes, loaded) = changes(&plan, &args.files)?;
    report("fmt", &loaded, &loaded.diagnostics, "these files stay unchanged");
    let result = if args.check {
        protect_inputs(loaded.inputs(&plan))?;
        print(&changes);
        let advice = if changes.is_empty() { "" } else { "; run `fmt`" };
        format!("{} unformatted{advice}", changes.len())
    } else {
        rewrite::write(&changes)?;
        format!("{} formatted", changes.len())
    };
    let read = plural(loaded.files.len(), "file");
    terminal::eprintln!("fmt: {read} read, {result} ({} ms)", started.milliseconds());
    Ok(loaded.diagnostics.is_empty() && (changes.is_empty() || !args.check))
}

/// Formats the selected files in memory. Adds the diagnostics of files with errors to the returned `Loaded`.
fn changes(plan: &Plan, files: &FilesArgs) -> Result<(Vec<Change>, Loaded), Failure> {
    let mut loaded = load::load_named(plan)?;
    let selected = files.sources(&loaded)?;
    let is_selected = |id: &SourceId| selected.as_ref().is_none_or(|selected| selected.contains(id));
    let sources = &loaded.sources;
    loaded.diagnostics.retain(|diagnostic| is_selected(&sources.source_of(diagnostic.span)));
    let mut changes = Vec::new();
    let mut seen = BTreeSet::new();
    for package in &loaded.packages {
        for id in package.sources.iter().filter(|id| is_selected(id)) {
            let Some(path) = loaded.paths.get(id) else { continue };
            let shown = loaded.sources.path(*id);
            // Format a linked file only once, even if several links lead to it.
            let path = fs::canonicalize(path).map_err(|error| Failure::new(format!("{shown}: {error}")))?;
            if !seen.insert(path.clone()) {
                continue;
            }
            match format::format(&loaded.sources, *id, package.form) {
                Ok(formatted) => changes.extend(change(&loaded.sources, *id, path, formatted)),
                Err(mut found) => loaded.diagnostics.append(&mut found),
            }
        }
    }
    Ok((changes, loaded))
}

fn change(sources: &SourceMap, id: SourceId, path: PathBuf, formatted: Formatted) -> Option<Change> {
    let (shown, old) = (sources.path(id).to_owned(), sources.text(id).to_owned());
    if formatted.is_kept {
        terminal::eprintln!("fmt: {shown} stays unchanged, because formatting would change its meaning");
    }
    (formatted.text != old).then_some(Change { path, shown, old, new: formatted.text })
}

/// Prints the differences as a patch.
fn print(changes: &[Change]) {
    for Change { shown, old, new, .. } in changes {
        terminal::print(format_args!("{}", difference::patch(shown, old, new)));
    }
}
