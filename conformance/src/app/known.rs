//! Lists of known failures on the command line.

use std::error::Error;
use std::path::PathBuf;

use clap::Args;
use uavspec_codegen::diagnostic::Level;

use super::Status;
use crate::check::known::{Checked, Lists, Scope, Stale, excuse_findings, rule_outcomes, unread_outcome};
use crate::model::{Date, Extent, Reason};
use crate::report::{CheckedCapture, Unreadable};

/// Arguments of commands that know such lists.
#[derive(Args, Debug)]
pub(super) struct KnownArgs {
    /// A list of known failures and flaky results, which then don't count; may be given several times. An entry
    /// that no longer holds true fails the run.
    #[arg(long, value_name = "FILE")]
    known: Vec<PathBuf>,
    /// Take out of these lists what no longer holds true, and keep all else as it is. What only a person can mend stays,
    /// and fails the run.
    #[arg(long, requires = "known")]
    fix_known: bool,
}

/// Lists as they are used in a run.
pub(super) struct Known {
    /// The lists, as they are after the run.
    pub(super) lists: Lists,
    /// Why they don't hold true after the run, entry by entry.
    pub(super) stale: Vec<Reason>,
    today: Date,
    is_fixing: bool,
}

impl KnownArgs {
    /// Reads the lists; what is wrong with them has been told.
    pub(super) fn read(&self) -> Result<Known, Status> {
        let print_error = |error: String| {
            anstream::eprintln!("{error}");
            Status::Usage
        };
        let lists = Lists::read(&self.known).map_err(|error| print_error(error.to_string()))?;
        let today = Date::today().map_err(|error| print_error(format!("error: {error}")))?;
        Ok(Known { lists, stale: Vec::new(), today, is_fixing: self.fix_known })
    }
}

impl Known {
    /// Tells which entries don't hold true, or takes them out of their files. What a person has to mend stays, and is
    /// told.
    pub(super) fn settle(&mut self, scope: Scope, checked: &[Checked<'_>]) -> Status {
        let stale = self.lists.find_stale(scope, checked, self.today);
        if stale.is_empty() {
            return Status::Conforms;
        }
        if !self.is_fixing {
            self.report_stale(&stale, "--fix-known mends it");
            return Status::Stale;
        }
        if let Err(error) = self.fix(&stale) {
            anstream::eprintln!("{error}");
            self.stale = self.lists.reasons(&stale);
            return Status::Usage;
        }
        let left = self.lists.find_stale(scope, checked, self.today);
        if left.is_empty() {
            return Status::Conforms;
        }
        self.report_stale(&left, "its messages have no beginning in common, so write an entry for each");
        Status::Stale
    }

    fn report_stale(&mut self, stale: &[Stale], help: &str) {
        self.stale = self.lists.reasons(stale);
        anstream::eprint!("{}", self.lists.render(stale, Level::Error, true));
        anstream::eprintln!("error: a list of known failures no longer holds true\n  help: {help}");
    }

    /// Holds the lists against what was found in sources, and notes at each finding what excuses it.
    pub(super) fn settle_sources(
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
        let status = self.settle(Scope::Rules, &checked);
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
        anstream::eprint!("{}", self.lists.render(&stale, Level::Note, true));
        anstream::eprintln!(
            "mended: the entries above are gone, or have the new message; do their reasons still hold?"
        );
        self.lists = fixed;
        Ok(())
    }
}
