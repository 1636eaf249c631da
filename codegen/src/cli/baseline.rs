//! Baselines on the command line, for all commands that report findings.

mod definitions;
mod subject;

use std::path::{Path, PathBuf};

use clap::Args;
use uavspec_lint::baseline::{Lists, Scope, Sums};
use uavspec_schema::diagnostic::Level;
use uavspec_schema::failure::Failure;
use uavspec_schema::finding::Finding;
use uavspec_schema::identity::Identity;
use uavspec_schema::{Date, render, terminal};

pub(super) use self::definitions::compare;
pub(super) use self::subject::Subjects;
use super::print::print_rendered;

/// Arguments for baselines.
#[derive(Args, Debug)]
pub struct BaselineArgs {
    /// Baseline: a list of known findings, which don't make the run fail (repeatable)
    ///
    /// If an entry no longer applies, the run fails with status 4.
    #[arg(long, value_name = "FILE")]
    baseline: Vec<PathBuf>,
    /// Remove or update entries of the baselines that no longer apply
    ///
    /// Other entries and comments stay unchanged. If the messages of an entry have no common prefix, split the entry by
    /// hand. Until then, the run fails.
    #[arg(long, requires = "baseline")]
    fix_baseline: bool,
    /// Add all findings that no baseline lists to this baseline, so that they count as known
    ///
    /// If the file exists, its comments and the reasons for its entries are kept, and entries that no longer apply are
    /// removed or updated. Then write a reason into each new entry.
    #[arg(long, value_name = "FILE")]
    write_baseline: Option<PathBuf>,
}

/// The baselines of a run.
#[derive(Debug)]
pub struct Baselines {
    /// The lists.
    pub lists: Lists,
    today: Date,
    fixes_all: bool,
    /// The findings about entries that no longer apply.
    pub outdated: Vec<Finding>,
}

impl BaselineArgs {
    /// The baselines that are inputs. They are either only read, or changed by `--fix-baseline`.
    pub fn inputs(&self) -> impl Iterator<Item = &Path> {
        let output = self.output().and_then(Identity::of);
        let is_output = move |path: &Path| {
            output.as_ref().is_some_and(|output| Identity::of(path).is_some_and(|path| path.is_same(output)))
        };
        self.baseline.iter().map(PathBuf::as_path).filter(move |path| !is_output(path))
    }

    /// The baseline to write.
    pub fn output(&self) -> Option<&Path> {
        self.write_baseline.as_deref()
    }

    /// Reads the baselines. `rules` contains the valid rule ids in addition to the rules of `lint` and `breaking`; if
    /// it is empty, other ids aren't checked.
    pub fn read(&self, rules: &[&'static str]) -> Result<Baselines, Failure> {
        let today = Date::today().map_err(Failure::new)?;
        let lists = Lists::read(&self.baseline, self.output(), rules)?;
        Ok(Baselines { lists, today, fixes_all: self.fix_baseline, outdated: Vec::new() })
    }
}

impl Baselines {
    /// True if [`Baselines::update`] must precede [`Lists::find`], because it may remove entries.
    pub fn is_updated(&self) -> bool {
        self.fixes_all && !self.lists.is_empty() || self.lists.has_target()
    }

    /// Fixes the entries that no longer apply, in the files that the options name.
    pub fn update(&mut self, sums: &Sums) -> Result<(), Failure> {
        let stale = self.lists.stale(sums, self.today);
        let is_fixed = |finding: &&Finding| {
            let is_fixed = self.fixes_all && finding.level == Level::Error;
            !finding.fix.is_empty() && (is_fixed || self.lists.is_in_target(finding))
        };
        let mut fixes: Vec<Finding> = stale.iter().filter(is_fixed).cloned().collect();
        self.outdated = stale;
        if fixes.is_empty() {
            return Ok(());
        }
        let lists = self.lists.updated(&fixes)?;
        lists.write(&self.lists)?;
        for fix in &mut fixes {
            fix.level = Level::Note;
        }
        self.print(&fixes);
        terminal::eprintln!(
            "fixed: the entries above were removed or updated; check that the reasons still apply"
        );
        self.lists = lists;
        Ok(())
    }

    /// Prints the entries that no longer apply. Returns true if there are any.
    pub fn finish(&mut self, sums: &Sums) -> bool {
        let mut stale = self.lists.stale(sums, self.today);
        self.lists.limit(sums);
        self.print(&stale);
        stale.retain(|finding| finding.level == Level::Error);
        let is_fixable = stale.iter().any(|finding| !finding.fix.is_empty());
        self.outdated = stale;
        if !self.outdated.is_empty() {
            let help = if is_fixable {
                "run again with --fix-baseline to update it"
            } else {
                "the messages have no common prefix: write one entry for each message"
            };
            terminal::error("a baseline is out of date", Some(help));
        }
        !self.outdated.is_empty()
    }

    /// Compares the baselines with results that are in memory, and updates them if the options request this. `count`
    /// adds all results to the sums. Returns true if a baseline is out of date.
    pub fn compare(&mut self, scope: Scope<'_>, count: impl Fn(&Lists, &mut Sums)) -> Result<bool, Failure> {
        let counted = |lists: &Lists| {
            let mut sums = lists.sums(scope);
            count(lists, &mut sums);
            sums
        };
        if self.is_updated() {
            self.update(&counted(&self.lists))?;
        }
        Ok(self.finish(&counted(&self.lists)))
    }

    /// Writes the entries that were added to the baseline of `--write-baseline`.
    pub fn write(&self) -> Result<(), Failure> {
        let Some((path, count)) = self.lists.added() else { return Ok(()) };
        self.lists.updated(&[])?.write(&self.lists)?;
        let entries = if count == 1 { "1 new entry".to_owned() } else { format!("{count} new entries") };
        terminal::eprintln!("{path}: {entries}; state the reason for each one");
        Ok(())
    }

    fn print(&self, findings: &[Finding]) {
        print_rendered(|styled| render::findings(findings, self.lists.sources(), styled));
    }
}
