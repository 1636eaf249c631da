//! Runs third-party validators and generators with the published schemas.
//!
//! Each tool has an adapter, a small program in `xtask/interop/`. The adapter reads all schemas and cases from one file
//! and prints a verdict for each case ([`adapter`]). The verdicts are compared with the expected results, and recorded
//! ([`tally`]). Every disagreement must be explained ([`known`]). The results are published on a page of the documentation
//! ([`page`]).

mod adapter;
mod job;
mod known;
mod page;
mod tally;
#[cfg(test)]
mod tests;
mod tool;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::time::{Duration, Instant};

use clap::Args;

use self::adapter::{End, install, script};
use self::job::Jobs;
use self::known::Known;
use self::tally::{Record, Tally};
use self::tool::{Tool, Tools};
use crate::paths::repository;

/// The folder of the adapters.
const SOURCE: &str = "xtask/interop";

/// The folder of the installed tools and their output.
const TARGET: &str = "target/interop";

/// The results of all tools.
const RECORD: &str = "xtask/interop/results.json";

/// The page of the documentation, and its entry in the table of contents.
const PAGE: &str = "generated/docs/interop/README.md";
const CONTENTS: &str = "generated/docs/interop/contents.md";

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

/// Runs the command. Returns true if all disagreements are explained and the page is up to date.
pub(crate) fn run(arguments: &Arguments) -> Result<bool, String> {
    let (tools, known) = configuration()?;
    if arguments.list {
        for tool in tools {
            let quick = if tool.is_quick { ", quick" } else { "" };
            println!("{:28} {:?}, {}, draft {}{quick}", tool.name, tool.kind, tool.language, tool.draft);
        }
        return Ok(true);
    }
    let is_tool = |name: &String| tools.iter().any(|tool| tool.name == *name);
    let unknown: Vec<&str> =
        arguments.only.iter().filter(|name| !is_tool(name)).map(String::as_str).collect();
    if !unknown.is_empty() {
        return Err(format!("unknown tool `{}`; list all tools with --list", unknown.join("`, `")));
    }
    let is_selected = |tool: &&Tool| {
        (arguments.only.is_empty() || arguments.only.contains(&tool.name))
            && (!arguments.quick || tool.is_quick)
    };
    let selected: Vec<&Tool> = tools.iter().filter(is_selected).collect();
    let jobs = Jobs::read(&repository().join("generated"))?;
    let mut tallies = run_all(arguments, &selected, &jobs)?;
    let mut errors = known.classify(&mut tallies);
    errors.extend(known.check_beyond(&jobs.beyond_schemas()));
    let missing = selected.iter().filter(|tool| !tallies.contains_key(&tool.name));
    let missing: Vec<&str> = missing.map(|tool| tool.name.as_str()).collect();
    let mut is_ok = report(&tallies, &missing, &errors)?;
    if !missing.is_empty() && (arguments.quick || !arguments.only.is_empty()) {
        eprintln!("error: not run: {}", missing.join(", "));
        is_ok = false;
    }
    let mut record: Record = job::parse(&repository().join(RECORD))?;
    record.beyond = jobs.beyond_schemas();
    record.tools.retain(|name, _| is_tool(name));
    record.tools.extend(tallies.into_iter().map(|(name, tally)| (name, tally.record)));
    Ok(publish(arguments.check, &tools, &known, &record)? && is_ok)
}

/// Reads the list of tools, and the known disagreements.
fn configuration() -> Result<(Vec<Tool>, Known), String> {
    let read = |name: &str| {
        fs::read_to_string(repository().join(SOURCE).join(name)).map_err(|error| format!("{name}: {error}"))
    };
    let Tools { tool: tools } =
        toml::from_str(&read("tools.toml")?).map_err(|error| format!("tools.toml: {error}"))?;
    let names = tools.iter().map(|tool| tool.name.as_str()).collect();
    let known = Known::parse(&read("disagreements.toml")?, &names);
    let known = known.map_err(|error| format!("disagreements.toml: {error}"))?;
    Ok((tools, known))
}

/// Runs the tools. The result omits tools that can't run.
fn run_all(arguments: &Arguments, tools: &[&Tool], jobs: &Jobs) -> Result<BTreeMap<String, Tally>, String> {
    let at = |error: std::io::Error| format!("{TARGET}: {error}");
    let target = repository().join(TARGET);
    fs::create_dir_all(target.join("log")).map_err(at)?;
    let file = target.join("jobs.jsonl");
    fs::write(&file, jobs.text()).map_err(at)?;
    let mut tallies = BTreeMap::new();
    for tool in tools {
        if let Err(reason) = install(tool, !arguments.no_install) {
            println!("{:28} not run: {reason}", tool.name);
            continue;
        }
        let work = target.join("work").join(&tool.name);
        fs::create_dir_all(&work).map_err(at)?;
        let mut command = script("run", tool);
        command.arg(&file).arg(&work);
        let log = target.join(format!("log/{}.txt", tool.name));
        let started = Instant::now();
        let answers = adapter::run(&mut command, &jobs.list, &log, Duration::from_secs(arguments.limit));
        let tally = Tally::of(tool, &jobs.list, &answers);
        show(tool, &tally, started.elapsed().as_secs_f64());
        if answers.end != End::Finished {
            println!("    {:?} {}; see {}", answers.end, answers.reason, log.display());
        }
        tallies.insert(tool.name.clone(), tally);
    }
    Ok(tallies)
}

/// Prints one line for the tool, and one for each package and form.
fn show(tool: &Tool, tally: &Tally, seconds: f64) {
    println!("{:28} {}, {seconds:.1} s", tool.name, tally.record.version);
    for (form, counts) in &tally.record.counts {
        for (package, count) in counts {
            println!(
                "    {package:12} {:7} {:6} agreed {:5} disagreed {:6} not run; {:4} schemas, {} failed",
                form.name(),
                count.agreed,
                count.disagreed,
                count.not_run,
                count.schemas,
                count.schemas_failed
            );
        }
    }
}

/// Prints the unexplained disagreements, the errors and a summary. Returns true if there are no unexplained
/// disagreements and no errors.
fn report(tallies: &BTreeMap<String, Tally>, missing: &[&str], errors: &[String]) -> Result<bool, String> {
    let mut all = String::new();
    for (tool, Tally { disagreements, .. }) in tallies.iter().filter(|(_, it)| !it.disagreements.is_empty()) {
        println!("\n{tool}: {} unexplained disagreements", disagreements.len());
        for (index, found) in disagreements.iter().enumerate() {
            let line = format!("{} ({}): {} {}", found.place, found.form.name(), found.does, found.message);
            if index < SHOWN {
                println!("    {line}");
            }
            let _ = writeln!(all, "{tool}: {line}");
        }
    }
    let file = repository().join(TARGET).join("unexplained.txt");
    fs::write(&file, &all).map_err(|error| format!("{}: {error}", file.display()))?;
    if !all.is_empty() {
        println!("\nFull list: {TARGET}/unexplained.txt. See {SOURCE}/README.md on how to explain them.");
    }
    for message in errors {
        eprintln!("error: {SOURCE}/disagreements.toml: {message}");
    }
    let records = || tallies.values().map(|tally| &tally.record);
    let explained: usize = records().flat_map(|record| record.explained.values()).sum();
    let counts = records().flat_map(|record| record.counts.values()).flat_map(BTreeMap::values);
    let agreed: usize = counts.map(|count| count.agreed).sum();
    eprintln!(
        "interop: {} tools, {agreed} verdicts agreed, {explained} disagreements explained, {} unexplained; {} tools not run",
        tallies.len(),
        tallies.values().map(|tally| tally.disagreements.len()).sum::<usize>(),
        missing.len()
    );
    Ok(all.is_empty() && errors.is_empty())
}

/// Writes the results and the page, or prints the differences. Returns true if all files were up to date.
fn publish(is_check: bool, tools: &[Tool], known: &Known, record: &Record) -> Result<bool, String> {
    let files = [
        (RECORD, record.text()),
        (PAGE, page::text(tools, known, record)),
        (CONTENTS, page::CONTENTS.to_owned()),
    ];
    let mut is_fresh = true;
    for (shown, text) in files {
        let path = repository().join(shown);
        if fs::read_to_string(&path).is_ok_and(|found| found == text) {
            continue;
        }
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
