//! Lists of known failures on the command line.

use std::collections::BTreeSet;
use std::error::Error;
use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use uavspec_codegen::diagnostic::Level;
use uavspec_codegen::emit::docs::markdown::plural;

use super::Status;
use super::outputs::Output;
use crate::check::known::{
    Checked, Lists, NewEntry, Scope, Stale, excuse_findings, new_list, rule_outcomes, unread_outcome,
};
use crate::model::{Date, Extent, Reason};
use crate::report::{About, CheckedCapture, Report, Unreadable, Verdict};
use crate::text::terminal;

/// Arguments of commands that read lists of known failures.
#[derive(Args, Debug)]
pub(super) struct KnownArgs {
    /// List of known failures (repeatable).
    ///
    /// Known failures don't fail the run. If an entry no longer applies, the run fails with status 4.
    #[arg(long, value_name = "FILE")]
    known: Vec<PathBuf>,
    /// Remove or update outdated list entries.
    ///
    /// Other entries and comments stay unchanged. If the messages of an entry have no common prefix, split the entry by
    /// hand. Until then, the run fails.
    #[arg(long, requires = "known")]
    fix_known: bool,
    /// Write a new list of all failures that are not known yet.
    ///
    /// The file must not exist. State the reason for each entry, then pass the list with --known.
    #[arg(long, value_name = "FILE")]
    init_known: Option<PathBuf>,
}

/// The lists of a run.
pub(super) struct Known {
    /// The lists; updated by `--fix-known`.
    pub(super) lists: Lists,
    /// The entries that the run showed to be outdated, each as a reason for failure.
    pub(super) stale: Vec<Reason>,
    today: Date,
    is_fixing: bool,
}

impl KnownArgs {
    /// The lists that exist.
    pub(super) fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.known.iter().map(PathBuf::as_path)
    }

    /// The list to write.
    pub(super) fn outputs(&self) -> impl Iterator<Item = Output<'_>> {
        self.init_known.iter().map(|path| Output::new("--init-known", path))
    }

    /// Reads the lists. Errors are printed.
    pub(super) fn read(&self) -> Result<Known, Status> {
        let print_error = |error: String| {
            terminal::eprintln!("{error}");
            Status::Usage
        };
        let lists = Lists::read(&self.known).map_err(|error| print_error(error.to_string()))?;
        if let Some(path) = self.init_known.as_deref().filter(|path| path.exists()) {
            let help = "use --known and --fix-known to update a list, or choose another name";
            return Err(print_error(format!(
                "error: {}: the file exists\n  help: {help}",
                terminal::path(path)
            )));
        }
        let today = Date::today().map_err(|error| print_error(format!("error: {error}")))?;
        Ok(Known { lists, stale: Vec::new(), today, is_fixing: self.fix_known })
    }
}

impl KnownArgs {
    /// Writes the list for `--init-known`. Errors are printed.
    pub(super) fn init(&self, report: &Report) -> Status {
        let Some(path) = &self.init_known else { return Status::Conforms };
        let entries = new_entries(report);
        let text = new_list(&entries, &report.command);
        let written = File::create_new(path).and_then(|mut file| file.write_all(text.as_bytes()));
        match written {
            Ok(()) => {
                let failures = plural(entries.len() as u64, "failure");
                terminal::eprintln!("{}: {failures}; state the reason for each one", terminal::path(path));
                Status::Conforms
            }
            Err(error) => {
                terminal::error(
                    format_args!("{}: can't write the list: {error}", terminal::path(path)),
                    None,
                );
                Status::Unreadable
            }
        }
    }
}

/// An entry for each failure and warning that no list names.
fn new_entries(report: &Report) -> BTreeSet<NewEntry> {
    let mut entries = BTreeSet::new();
    for subject in &report.subjects {
        let findings = subject.findings.iter();
        entries.extend(
            findings
                .filter(|found| matches!(found.verdict, Verdict::Fail | Verdict::Warn))
                .map(|found| NewEntry::Rule { rule: found.rule.to_owned(), subject: found.subject.clone() }),
        );
        if let About::Testee(testee) = &subject.about {
            let failed = testee.cases.iter().filter(|case| case.verdict.is_failure() && case.known.is_none());
            entries.extend(failed.map(|case| NewEntry::Case(case.name.clone())));
        }
    }
    entries
}

impl Known {
    /// Prints the entries that no longer apply, or fixes them in their files. Entries without an automatic fix are
    /// printed.
    pub(super) fn finish(&mut self, scope: Scope, checked: &[Checked<'_>]) -> Status {
        let stale = self.lists.find_stale(scope, checked, self.today);
        if stale.is_empty() {
            return Status::Conforms;
        }
        if !self.is_fixing {
            self.report_stale(&stale, "run again with --fix-known to update the list");
            return Status::Stale;
        }
        if let Err(error) = self.fix(&stale) {
            terminal::eprintln!("{error}");
            self.stale = self.lists.reasons(&stale);
            return Status::Usage;
        }
        let left = self.lists.find_stale(scope, checked, self.today);
        if left.is_empty() {
            return Status::Conforms;
        }
        self.report_stale(&left, "the messages have no common prefix: write one entry for each message");
        Status::Stale
    }

    fn report_stale(&mut self, stale: &[Stale], help: &str) {
        self.stale = self.lists.reasons(stale);
        terminal::print_error(format_args!("{}", self.lists.render(stale, Level::Error, true)));
        terminal::error("a list of known failures is out of date", Some(help));
    }

    /// Compares the lists with the findings, and attaches the matching entry to each known finding.
    pub(super) fn finish_captures(
        &mut self,
        captures: &mut [CheckedCapture],
        unread: &[Unreadable],
    ) -> Status {
        if self.lists.is_empty() {
            return Status::Conforms;
        }
        let mut checked: Vec<Checked<'_>> =
            unread.iter().flat_map(|file| unread_outcome(&file.path)).collect();
        for capture in captures.iter() {
            checked.extend(rule_outcomes(&capture.path, &capture.result.findings));
            if capture.result.extent == Extent::Unreadable {
                checked.extend(unread_outcome(&capture.path));
            }
        }
        let status = self.finish(Scope::Rules, &checked);
        for capture in captures {
            excuse_findings(&self.lists, &capture.path, &mut capture.result.findings);
        }
        status
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
