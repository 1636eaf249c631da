//! What validators and generators of other makers make of the published schemas.
//!
//! Each tool has an adapter, a small program of its own language below `xtask/interop/`. It reads all schemas and all
//! cases from one file and writes a verdict on each case ([`adapter`]); here they are compared with what is true
//! ([`tally`]), and every disagreement has to be explained ([`known`]). The results are kept ([`record`]) and told on a
//! page of the documentation ([`page`]).

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
use self::known::{Judgement, Known};
use self::record::Record;
use self::tally::Tally;
use self::tool::Tool;
use crate::place::repository;

/// How many unexplained disagreements of a tool are shown.
const SHOWN: usize = 10;

/// Arguments of `interop`.
#[derive(Args)]
#[allow(clippy::struct_excessive_bools)] // options of a command line
pub(crate) struct Arguments {
    /// List the tools.
    #[arg(long)]
    list: bool,
    /// Run these tools; one that can't be run is a failure.
    #[arg(long, value_name = "TOOL", value_delimiter = ',')]
    only: Vec<String>,
    /// Run the tools that take little time to install and run; one that can't be run is a failure.
    #[arg(long, conflicts_with = "only")]
    quick: bool,
    /// Write nothing, and fail where the results or the page would change.
    #[arg(long)]
    check: bool,
    /// Install and compile nothing: what isn't there is not run.
    #[arg(long)]
    no_install: bool,
    /// Seconds that a tool may take.
    #[arg(long, value_name = "SECONDS", default_value_t = 300)]
    limit: u64,
}

/// Where everything is.
struct Places {
    root: PathBuf,
}

impl Places {
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

/// Whether everything is as it has to be.
pub(crate) fn run(arguments: &Arguments) -> Result<bool, String> {
    let places = Places::new();
    let tools = tool::read(&places.source().join("tools.toml"))?;
    let names: BTreeSet<&str> = tools.iter().map(|tool| tool.name.as_str()).collect();
    let known = Known::read(&places.source().join("disagreements.toml"), &names)?;
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
        return Err(format!("there is no tool {}; --list shows all", unknown.join(", ")));
    }
    let is_wanted = |tool: &&Tool| {
        (arguments.only.is_empty() || arguments.only.contains(&tool.name))
            && (!arguments.quick || tool.is_quick)
    };
    let wanted: Vec<&Tool> = tools.iter().filter(is_wanted).collect();
    let jobs = Jobs::read(&canonical(&places.generated())?)?;
    let outcome = run_all(arguments, &places, &wanted, &jobs)?;
    let judgement = known.judge(&outcome.tallies);
    let mistakes = known.check_beyond(&jobs.beyond_schemas());
    report(&places, &outcome, &judgement, &mistakes)?;

    let mut is_good = judgement.unexplained.is_empty() && judgement.stale.is_empty() && mistakes.is_empty();
    if !outcome.not_run.is_empty() && (arguments.quick || !arguments.only.is_empty()) {
        eprintln!("error: not run: {}", outcome.not_run.join(", "));
        is_good = false;
    }
    let mut record = Record::read(&places.record())?;
    record.beyond = jobs.beyond_schemas();
    record.tools.retain(|name, _| names.contains(name.as_str()));
    for (name, tally) in &outcome.tallies {
        record.set(name, tally, judgement.explained.get(name).cloned().unwrap_or_default());
    }
    Ok(publish(arguments.check, &places, &tools, &known, &record)? && is_good)
}

fn list(tools: &[Tool]) {
    for tool in tools {
        let quick = if tool.is_quick { ", quick" } else { "" };
        println!("{:28} {:?}, {}, draft {}{quick}", tool.name, tool.kind, tool.language, tool.draft);
    }
}

/// What came of all tools.
struct Outcome {
    tallies: BTreeMap<String, Tally>,
    not_run: Vec<String>,
}

fn run_all(arguments: &Arguments, places: &Places, tools: &[&Tool], jobs: &Jobs) -> Result<Outcome, String> {
    let at = |error: std::io::Error| format!("{}: {error}", places.target().display());
    let logs = places.target().join("log");
    fs::create_dir_all(&logs).map_err(at)?;
    let target = canonical(&places.target())?;
    let file = target.join("jobs.jsonl");
    fs::write(&file, jobs.text()).map_err(at)?;
    let mut installation =
        Installation::new(canonical(&places.source())?, target.clone(), !arguments.no_install);
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

/// A line for a tool, and one for each package and form.
fn show(tool: &Tool, tally: &Tally, seconds: f64) {
    let version = tally.version.as_deref().unwrap_or("of unknown version");
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
    places: &Places,
    outcome: &Outcome,
    judgement: &Judgement,
    mistakes: &[String],
) -> Result<(), String> {
    let mut all = String::new();
    for (tool, disagreements) in &judgement.unexplained {
        println!("\n{tool}: {} disagreements that nothing explains", disagreements.len());
        for (index, found) in disagreements.iter().enumerate() {
            let line = format!("{} ({}): {} {}", found.place, found.form.name(), found.does, found.message);
            if index < SHOWN {
                println!("    {line}");
            }
            let _ = writeln!(all, "{tool}: {line}");
        }
    }
    let file = places.target().join("unexplained.txt");
    fs::write(&file, all).map_err(|error| format!("{}: {error}", file.display()))?;
    if !judgement.unexplained.is_empty() {
        println!(
            "\nAll of them are in target/interop/unexplained.txt; xtask/interop/README.md tells how they are explained."
        );
    }
    for message in judgement.stale.iter().chain(mistakes) {
        eprintln!("error: xtask/interop/disagreements.toml: {message}");
    }
    let explained: usize = judgement.explained.values().flat_map(BTreeMap::values).sum();
    let unexplained: usize = judgement.unexplained.values().map(Vec::len).sum();
    let agreed: usize = outcome.tallies.values().map(|tally| tally.total().agreed).sum();
    eprintln!(
        "interop: {} tools, {agreed} verdicts agreed, {explained} disagreements explained, {unexplained} not; {} \
         tools not run",
        outcome.tallies.len(),
        outcome.not_run.len()
    );
    Ok(())
}

/// Writes the results and the page, or says what would change. Returns whether all is fresh.
fn publish(
    is_check: bool,
    places: &Places,
    tools: &[Tool],
    known: &Known,
    record: &Record,
) -> Result<bool, String> {
    let files = [
        (places.record(), record.text()),
        (places.page(), page::text(tools, known, record)),
        (places.contents(), page::CONTENTS.to_owned()),
    ];
    let mut is_fresh = true;
    for (path, text) in files {
        if fs::read_to_string(&path).is_ok_and(|found| found == text) {
            continue;
        }
        let shown = path.strip_prefix(&places.root).unwrap_or(&path).display();
        if is_check {
            eprintln!("error: {shown} isn't up to date: run `cargo xtask interop`");
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
