//! Baselines: lists of known findings, so that a project with many old findings sees only the new ones.
//!
//! ```toml
//! [[known]]
//! rule = "unit-missing"
//! subject = "px4/Airspeed.confidence"    # a definition or one of its fields; a glob pattern
//! count = 1                              # optional; default: any number
//! reason = "found when the list was written"
//! link = "https://example.org/issues/7"  # optional
//! expires = 2027-06-30                   # optional; the last day on which the entry applies
//! ```
//!
//! A finding is recognised by its rule and subject, so it stays known if its line moves. If a subject has more findings
//! than `count`, all of them are reported, because it is unknown which of them are new.
//!
//! An entry is outdated if it has expired, if it matches nothing, or if there are fewer findings than `count`. One list
//! serves `lint` and `breaking`: each command ignores the entries for rules that it doesn't apply.

mod edit;
mod matching;
mod read;
mod subject;

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use clap::Args;
use uavspec_schema::failure::Failure;
use uavspec_schema::finding::Finding;
use uavspec_schema::rewrite::{self, Change};
use uavspec_schema::source::SourceMap;
use uavspec_schema::wording::plural;
use uavspec_schema::{Date, render, terminal};

use self::matching::{Found, Matches};
use self::read::List;
pub(super) use self::subject::Subjects;
use super::print::print_rendered;

/// Arguments for baselines.
#[derive(Args, Debug)]
pub(super) struct BaselineArgs {
    /// Baseline: a list of known findings, which are not reported
    ///
    /// If an entry is outdated, the command fails with status 4.
    #[arg(long, value_name = "FILE")]
    baseline: Option<PathBuf>,
    /// Remove or update outdated entries of the baseline
    #[arg(long, requires = "baseline")]
    fix_baseline: bool,
    /// Write all findings to a baseline
    ///
    /// If the file exists, its comments and the reasons of its entries are kept.
    #[arg(long, value_name = "FILE", conflicts_with = "baseline")]
    write_baseline: Option<PathBuf>,
}

/// The result of a comparison with a list.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Compared {
    /// The number of known findings, which were removed.
    pub(super) known: usize,
    /// True if an entry is outdated.
    pub(super) is_outdated: bool,
}

impl BaselineArgs {
    /// The list that is read or written.
    pub(super) fn file(&self) -> Option<&Path> {
        self.write_baseline.as_deref().or(self.baseline.as_deref())
    }

    /// Removes the known findings, and prints the outdated entries. Only entries of rules for which `is_applied` is
    /// true can be outdated.
    pub(super) fn compare(
        &self,
        command: &str,
        findings: &mut Vec<Finding>,
        subjects: Subjects<'_>,
        is_applied: &dyn Fn(&str) -> bool,
    ) -> Result<Compared, Failure> {
        let Some(path) = self.file() else {
            return Ok(Compared::default());
        };
        let today = Date::today().map_err(Failure::new)?;
        let found = Found::new(findings, subjects);
        let mut list = self.list(path)?;
        let mut matches = Matches::new(&list, &found, today, is_applied);
        let is_writing = self.write_baseline.is_some();
        if is_writing || (self.fix_baseline && !matches.outdated.is_empty()) {
            let text = edit::updated(&list, &matches, &found, is_writing);
            write(path, list.text(), &text)?;
            let outdated = matches.outdated.len();
            list = List::parse(path, text.into_bytes())?;
            matches = Matches::new(&list, &found, today, is_applied);
            let entries = plural(list.entries.len(), "entry").replace("entrys", "entries");
            let change = if is_writing {
                format!("wrote {} in {entries}", plural(matches.known(&found), "known finding"))
            } else {
                format!("removed or updated {outdated} outdated, {entries} left")
            };
            terminal::eprintln!("{command}: {}: {change}", terminal::path(path));
        }
        for surplus in &matches.surplus {
            terminal::eprintln!("note: {surplus}");
        }
        print_outdated(&list, &matches);
        let compared = Compared { known: matches.known(&found), is_outdated: !matches.outdated.is_empty() };
        matches.retain_new(&found, findings);
        Ok(compared)
    }

    /// Reads the list. A list that is about to be written may be absent.
    fn list(&self, path: &Path) -> Result<List, Failure> {
        match fs::read(path) {
            Ok(bytes) => List::parse(path, bytes),
            Err(error) if error.kind() == ErrorKind::NotFound && self.write_baseline.is_some() => {
                List::parse(path, Vec::new())
            }
            Err(error) => Err(Failure::new(format!("{}: {error}", terminal::path(path)))
                .with_hint("`--write-baseline FILE` writes a baseline")),
        }
    }
}

/// The text of a list after a run without findings, which removes all entries.
pub fn without_findings(bytes: Vec<u8>) -> Result<String, Failure> {
    let list = List::parse(Path::new("known.toml"), bytes)?;
    let found = Found::new(&[], Subjects::new(&SourceMap::default(), &[]));
    // Without findings, each entry is removed, whether or not it has expired.
    let today = Date { year: 1970, month: 1, day: 1 };
    let matches = Matches::new(&list, &found, today, &|_| true);
    Ok(edit::updated(&list, &matches, &found, false))
}

fn print_outdated(list: &List, matches: &Matches) {
    if matches.outdated.is_empty() {
        return;
    }
    let findings: Vec<Finding> =
        matches.outdated.iter().map(|outdated| outdated.finding(&list.entries[outdated.entry])).collect();
    print_rendered(|styled| render::findings(&findings, &list.sources, styled));
    terminal::eprintln!(
        "error: the baseline is out of date\n  help: run again with --fix-baseline to update it"
    );
}

fn write(path: &Path, old: &str, new: &str) -> Result<(), Failure> {
    let shown = terminal::path(path);
    let failed = |error: std::io::Error| {
        Failure::new(format!("{shown}: {error}")).with_hint("check that the file and its folder are writable")
    };
    if old == new {
        return Ok(());
    }
    match fs::canonicalize(path) {
        Ok(path) => {
            let change = Change { path, shown, old: old.to_owned(), new: new.to_owned() };
            rewrite::write(&[change])
        }
        Err(error) if error.kind() == ErrorKind::NotFound => fs::write(path, new).map_err(failed),
        Err(error) => Err(failed(error)),
    }
}
