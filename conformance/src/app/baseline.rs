//! Baselines on the command line: lists of known failures.

use std::collections::BTreeSet;
use std::error::Error;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use clap::Args;
use uavspec_check::baseline::{
    Lists, NewEntry, Scope, Stale, Sums, excuse_findings, new_list, rule_outcomes, unread_outcome,
};
use uavspec_model::text::{plural, terminal};
use uavspec_model::{Extent, Reason};
use uavspec_report::{About, CheckedCapture, Subject, Verdict};
use uavspec_schema::Date;
use uavspec_schema::diagnostic::Level;
use uavspec_schema::stage::{Stage, folder_of};

use super::Status;
use super::outputs::Output;

/// Arguments of commands that read baselines.
#[derive(Args, Debug)]
pub(super) struct BaselineArgs {
    /// Baseline: a list of known failures (repeatable).
    ///
    /// Known failures don't fail the run. If an entry no longer applies, the run fails with status 4.
    #[arg(long, value_name = "FILE")]
    baseline: Vec<PathBuf>,
    /// Remove or update outdated entries of the baselines.
    ///
    /// Other entries and comments stay unchanged. If the messages of an entry have no common prefix, split the entry by
    /// hand. Until then, the run fails.
    #[arg(long, requires = "baseline")]
    fix_baseline: bool,
    /// Write a new baseline of all failures that are not known yet.
    ///
    /// The file must not exist. State the reason for each entry, then pass the file with --baseline.
    #[arg(long, value_name = "FILE")]
    write_baseline: Option<PathBuf>,
}

/// The baselines of a run.
pub(super) struct Baselines {
    /// The lists; updated by `--fix-baseline`.
    pub(super) lists: Lists,
    /// The entries that the run showed to be outdated, each as a reason for failure.
    pub(super) stale: Vec<Reason>,
    today: Date,
    is_fixing: bool,
}

impl BaselineArgs {
    /// The baselines to read.
    pub(super) fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.baseline.iter().map(PathBuf::as_path)
    }

    /// The baseline to write.
    pub(super) fn outputs(&self) -> impl Iterator<Item = Output<'_>> {
        self.write_baseline.iter().map(|path| Output::new("--write-baseline", path))
    }

    /// Reads the baselines. Errors are printed.
    pub(super) fn read(&self) -> Result<Baselines, Status> {
        let print_error = |error: String| {
            terminal::eprintln!("{error}");
            Status::Usage
        };
        let lists = Lists::read(&self.baseline).map_err(|error| print_error(error.to_string()))?;
        if let Some(path) = self.write_baseline.as_deref().filter(|path| path.exists()) {
            let help = "use --baseline and --fix-baseline to update a baseline, or choose another name";
            return Err(print_error(format!(
                "error: {}: the file exists\n  help: {help}",
                terminal::path(path)
            )));
        }
        let today = Date::today().map_err(|error| print_error(format!("error: {error}")))?;
        Ok(Baselines { lists, stale: Vec::new(), today, is_fixing: self.fix_baseline })
    }

    /// Starts the baseline for `--write-baseline`, if requested.
    pub(super) fn new_baseline(&self) -> Option<NewBaseline> {
        let path = self.write_baseline.clone()?;
        Some(NewBaseline { path, entries: BTreeSet::new(), is_too_long: false })
    }
}

/// The baseline for `--write-baseline` under construction.
pub(super) struct NewBaseline {
    path: PathBuf,
    entries: BTreeSet<NewEntry>,
    is_too_long: bool,
}

/// The maximum number of entries in a new baseline. Baselines with more entries exceed the maximum size of a baseline.
const MAX_NEW_ENTRIES: usize = 10_000;

impl NewBaseline {
    /// Adds an entry for each failure and warning that no baseline names.
    pub(super) fn add(&mut self, subject: &Subject) {
        let findings = subject.findings.iter();
        let failed = findings.filter(|found| matches!(found.verdict, Verdict::Fail | Verdict::Warn));
        for found in failed {
            self.insert(NewEntry::Rule { rule: found.rule.to_owned(), subject: found.subject.clone() });
        }
        if let About::Testee(testee) = &subject.about {
            let failed = testee.cases.iter().filter(|case| case.verdict.is_failure() && case.known.is_none());
            failed.for_each(|case| self.insert(NewEntry::Case(case.name.clone())));
        }
    }

    fn insert(&mut self, entry: NewEntry) {
        if self.entries.len() < MAX_NEW_ENTRIES {
            self.entries.insert(entry);
        } else {
            self.is_too_long |= !self.entries.contains(&entry);
        }
    }

    /// Writes the baseline. `command` is the command line of the run. Errors are printed.
    pub(super) fn write(&self, command: &str) -> Status {
        let path = terminal::path(&self.path);
        if self.is_too_long {
            let problem = format!("{path}: not written: more than {MAX_NEW_ENTRIES} different failures");
            terminal::error(problem, None);
            return Status::Unreadable;
        }
        let text = new_list(&self.entries, command);
        match create_new(&self.path, &text) {
            Ok(()) => {
                let failures = plural(self.entries.len(), "failure");
                terminal::eprintln!("{path}: {failures}; state the reason for each one");
                Status::Conforms
            }
            Err(error) => {
                terminal::error(format_args!("{path}: can't write the baseline: {error}"), None);
                Status::Unreadable
            }
        }
    }
}

/// Writes a new file completely or not at all. Fails if the file exists.
fn create_new(path: &Path, text: &str) -> io::Result<()> {
    let stage = Stage::new(folder_of(path))?;
    let mut file = stage.file(None)?;
    file.write_all(text.as_bytes())?;
    file.persist_noclobber(path)?;
    Ok(())
}

impl Baselines {
    /// True if the baselines are updated before they are applied.
    pub(super) fn is_fixing(&self) -> bool {
        self.is_fixing && !self.lists.is_empty()
    }

    /// Fixes the entries that no longer apply in their files. Errors are printed.
    pub(super) fn update(&mut self, sums: &Sums) -> Result<(), Status> {
        let stale = self.lists.stale(sums, self.today);
        if stale.is_empty() {
            return Ok(());
        }
        self.fix(&stale).map_err(|error| {
            terminal::eprintln!("{error}");
            self.stale = self.lists.reasons(&stale);
            Status::Usage
        })
    }

    /// Prints the entries that no longer apply.
    pub(super) fn finish(&mut self, sums: &Sums) -> Status {
        let stale = self.lists.stale(sums, self.today);
        if stale.is_empty() {
            return Status::Conforms;
        }
        self.stale = self.lists.reasons(&stale);
        let help = if self.is_fixing {
            "the messages have no common prefix: write one entry for each message"
        } else {
            "run again with --fix-baseline to update it"
        };
        terminal::print_error(format_args!("{}", self.lists.render(&stale, Level::Error, true)));
        terminal::error("a baseline is out of date", Some(help));
        Status::Stale
    }

    /// Compares the baselines with results that are in memory. `count` adds all results.
    pub(super) fn compare(&mut self, scope: Scope, count: impl Fn(&Lists, &mut Sums)) -> Status {
        let counted = |lists: &Lists| {
            let mut sums = lists.sums(scope);
            count(lists, &mut sums);
            sums
        };
        if self.is_fixing()
            && let Err(status) = self.update(&counted(&self.lists))
        {
            return status;
        }
        self.finish(&counted(&self.lists))
    }

    /// Attaches the matching entry to each known finding.
    pub(super) fn excuse(&self, capture: &mut CheckedCapture) {
        if !self.lists.is_empty() {
            excuse_findings(&self.lists, &capture.path, &mut capture.result.findings);
        }
    }

    fn fix(&mut self, stale: &[Stale]) -> Result<(), Box<dyn Error>> {
        let stale: Vec<Stale> = stale.iter().filter(|stale| stale.is_fixable()).cloned().collect();
        if stale.is_empty() {
            return Ok(());
        }
        let fixed = self.lists.fixed(&stale)?;
        fixed.write(&self.lists)?;
        terminal::print_error(format_args!("{}", self.lists.render(&stale, Level::Note, true)));
        terminal::eprintln!(
            "fixed: the entries above were removed or updated; check that the reasons still apply"
        );
        self.lists = fixed;
        Ok(())
    }
}

/// Counts the results of a capture.
pub(super) fn count_capture(lists: &Lists, sums: &mut Sums, capture: &CheckedCapture) {
    if lists.is_empty() {
        return;
    }
    for checked in rule_outcomes(&capture.path, &capture.result.findings) {
        lists.count(sums, &checked);
    }
    if capture.result.extent == Extent::Unreadable {
        count_unread(lists, sums, &capture.path);
    }
}

/// Counts a file that can't be read.
pub(super) fn count_unread(lists: &Lists, sums: &mut Sums, path: &str) {
    for checked in unread_outcome(path) {
        lists.count(sums, &checked);
    }
}
