//! Runs third-party validators and generators with the published schemas.
//!
//! Each tool has an adapter, a small program in `xtask/interop/`. The adapter reads all schemas and cases from one file
//! and prints a verdict for each case ([`adapter`]). The verdicts are compared with the expected results ([`tally`]).
//! Every disagreement must be explained ([`known`]). The results are recorded ([`record`]) and published on a page of
//! the documentation ([`page`]).

mod adapter;
mod environment;
mod job;
mod known;
mod page;
mod record;
mod tally;
#[cfg(test)]
mod tests;
mod tool;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;

use self::adapter::End;
use self::environment::Installation;
use self::job::Jobs;
use self::known::{Classification, Known};
use self::record::Record;
use self::tally::Tally;
use self::tool::Tool;
use crate::paths::repository;

/// The maximum number of unexplained disagreements printed per tool.
const SHOWN: usize = 10;

/// Arguments of `interop`.
#[derive(Args)]
#[allow(clippy::struct_excessive_bools)] // options of a command line
pub(crate) struct Arguments {
    /// List the tools
    #[arg(long)]
    list: bool,
    /// Run these tools; fail if any cannot run
    #[arg(long, value_name = "TOOL", value_delimiter = ',')]
    only: Vec<String>,
    /// Run the tools that install and run quickly; fail if any cannot run
    #[arg(long, conflicts_with = "only")]
    quick: bool,
    /// Write nothing; fail if the results or the page are outdated
    #[arg(long)]
    check: bool,
    /// Install and compile nothing; skip tools that are not installed
    #[arg(long)]
    no_install: bool,
    /// Time limit for each tool, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 300)]
    limit: u64,
}

/// The paths of all files.
struct Paths {
    root: PathBuf,
}

impl Paths {
    fn new() -> Self {
        Self { root: repository().to_path_buf() }
    }

    fn source(&self) -> PathBuf {
        self.root.join("xtask/interop")
    }

    fn record(&self) -> PathBuf {
        self.source().join("results.json")
    }

    fn target(&self) -> PathBuf {
        self.root.join("target/interop")
    }

    fn generated(&self) -> PathBuf {
        self.root.join("generated")
    }

    fn page(&self) -> PathBuf {
        self.generated().join("docs/interop/README.md")
    }

    fn contents(&self) -> PathBuf {
        self.generated().join("docs/interop/contents.md")
    }
}

/// Runs the command. Returns true if all disagreements are explained and the page is up to date.
pub(crate) fn run(arguments: &Arguments) -> Result<bool, String> {
    let paths = Paths::new();
    let tools = tool::read(&paths.source().join("tools.toml"))?;
    let names: BTreeSet<&str> = tools.iter().map(|tool| tool.name.as_str()).collect();
    let known = Known::read(&paths.source().join("disagreements.toml"), &names)?;
    if arguments.list {
        list(&tools);
        return Ok(true);
    }
    let unknown: Vec<String> = arguments
        .only
        .iter()
        .filter(|name| !names.contains(name.as_str()))
        .map(|name| format!("`{name}`"))
        .collect();
    if !unknown.is_empty() {
        return Err(format!("unknown tool {}; list all tools with --list", unknown.join(", ")));
    }
    let is_selected = |tool: &&Tool| {
        (arguments.only.is_empty() || arguments.only.contains(&tool.name))
            && (!arguments.quick || tool.is_quick)
    };
    let selected: Vec<&Tool> = tools.iter().filter(is_selected).collect();
    let jobs = Jobs::read(&canonical(&paths.generated())?)?;
    let outcome = run_all(arguments, &paths, &selected, &jobs)?;
    let classification = known.classify(&outcome.tallies);
    let errors = known.check_beyond(&jobs.beyond_schemas());
    report(&paths, &outcome, &classification, &errors)?;

    let mut is_ok =
        classification.unexplained.is_empty() && classification.stale.is_empty() && errors.is_empty();
    if !outcome.not_run.is_empty() && (arguments.quick || !arguments.only.is_empty()) {
        eprintln!("error: not run: {}", outcome.not_run.join(", "));
        is_ok = false;
    }
    let mut record = Record::read(&paths.record())?;
    record.beyond = jobs.beyond_schemas();
    record.tools.retain(|name, _| names.contains(name.as_str()));
    for (name, tally) in &outcome.tallies {
        record.set(name, tally, classification.explained.get(name).cloned().unwrap_or_default());
    }
    Ok(publish(arguments.check, &paths, &tools, &known, &record)? && is_ok)
}

fn list(tools: &[Tool]) {
    for tool in tools {
        let quick = if tool.is_quick { ", quick" } else { "" };
        println!("{:28} {:?}, {}, draft {}{quick}", tool.name, tool.kind, tool.language, tool.draft);
    }
}

/// The results of all tools.
struct Outcome {
    tallies: BTreeMap<String, Tally>,
    not_run: Vec<String>,
}

fn run_all(arguments: &Arguments, paths: &Paths, tools: &[&Tool], jobs: &Jobs) -> Result<Outcome, String> {
    let at = |error: std::io::Error| format!("{}: {error}", paths.target().display());
    let logs = paths.target().join("log");
    fs::create_dir_all(&logs).map_err(at)?;
    let target = canonical(&paths.target())?;
    let file = target.join("jobs.jsonl");
    fs::write(&file, jobs.text()).map_err(at)?;
    let mut installation =
        Installation::new(canonical(&paths.source())?, target.clone(), !arguments.no_install);
    let mut outcome = Outcome { tallies: BTreeMap::new(), not_run: Vec::new() };
    for tool in tools {
        let mut command = match installation.command(tool) {
            Ok(command) => command,
            Err(reason) => {
                println!("{:28} not run: {reason}", tool.name);
                outcome.not_run.push(tool.name.clone());
                continue;
            }
        };
        let work = target.join("work").join(&tool.name);
        fs::create_dir_all(&work).map_err(at)?;
        command.arg(&file).arg(&work);
        let log = logs.join(format!("{}.txt", tool.name));
        let answers = adapter::run(&mut command, &jobs.list, &log, Duration::from_secs(arguments.limit));
        let seconds = answers.time.as_secs_f64();
        let tally = Tally::of(tool, &jobs.list, answers);
        show(tool, &tally, seconds);
        if tally.end != End::Finished {
            println!("    {:?}; see {}", tally.end, log.display());
        }
        outcome.tallies.insert(tool.name.clone(), tally);
    }
    Ok(outcome)
}

/// Prints one line for the tool, and one for each package and form.
fn show(tool: &Tool, tally: &Tally, seconds: f64) {
    let version = tally.version.as_deref().unwrap_or("unknown version");
    println!("{:28} {version}, {seconds:.1} s", tool.name);
    for ((form, package), count) in &tally.counts {
        println!(
            "    {:12} {:7} {:6} agreed {:5} disagreed {:6} not run; {:4} schemas, {} failed",
            package,
            form.name(),
            count.agreed,
            count.disagreed,
            count.not_run,
            count.schemas,
            count.schemas_failed
        );
    }
}

fn report(
    paths: &Paths,
    outcome: &Outcome,
    classification: &Classification,
    errors: &[String],
) -> Result<(), String> {
    let mut all = String::new();
    for (tool, disagreements) in &classification.unexplained {
        println!("\n{tool}: {} unexplained disagreements", disagreements.len());
        for (index, found) in disagreements.iter().enumerate() {
            let line = format!("{} ({}): {} {}", found.place, found.form.name(), found.does, found.message);
            if index < SHOWN {
                println!("    {line}");
            }
            let _ = writeln!(all, "{tool}: {line}");
        }
    }
    let file = paths.target().join("unexplained.txt");
    fs::write(&file, all).map_err(|error| format!("{}: {error}", file.display()))?;
    if !classification.unexplained.is_empty() {
        println!(
            "\nFull list: target/interop/unexplained.txt. See xtask/interop/README.md on how to explain them."
        );
    }
    for message in classification.stale.iter().chain(errors) {
        eprintln!("error: xtask/interop/disagreements.toml: {message}");
    }
    let explained: usize = classification.explained.values().flat_map(BTreeMap::values).sum();
    let unexplained: usize = classification.unexplained.values().map(Vec::len).sum();
    let agreed: usize = outcome.tallies.values().map(|tally| tally.total().agreed).sum();
    eprintln!(
        "interop: {} tools, {agreed} verdicts agreed, {explained} disagreements explained, {unexplained} unexplained; {} \
         tools not run",
        outcome.tallies.len(),
        outcome.not_run.len()
    );
    Ok(())
}

/// Writes the results and the page, or prints what would change. Returns true if all files were up to date.
fn publish(
    is_check: bool,
    paths: &Paths,
    tools: &[Tool],
    known: &Known,
    record: &Record,
) -> Result<bool, String> {
    let files = [
        (paths.record(), record.text()),
        (paths.page(), page::text(tools, known, record)),
        (paths.contents(), page::CONTENTS.to_owned()),
    ];
    let mut is_fresh = true;
    for (path, text) in files {
        if fs::read_to_string(&path).is_ok_and(|found| found == text) {
            continue;
        }
        let shown = path.strip_prefix(&paths.root).unwrap_or(&path).display();
        if is_check {
            eprintln!("error: {shown} is outdated; run `cargo xtask interop`");
            is_fresh = false;
        } else {
            let at = |error: std::io::Error| format!("{shown}: {error}");
            path.parent().map_or(Ok(()), fs::create_dir_all).map_err(at)?;
            fs::write(&path, text).map_err(at)?;
            eprintln!("interop: {shown} written");
        }
    }
    Ok(is_fresh)
}

fn canonical(path: &Path) -> Result<PathBuf, String> {
    fs::canonicalize(path).map_err(|error| format!("{}: {error}", path.display()))
}
