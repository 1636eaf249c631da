//! What came of asking.

use std::collections::BTreeMap;
use std::fmt;
use std::time::Duration;

use super::case::Case;
use super::compare::Difference;
use super::protocol::Hello;
use crate::model::Excuse;

/// How many different remarks on manners are kept, the first by their texts; of more only the number. Which come first
/// in time depends on how processes take turns.
const MAX_REMARKS: usize = 20;

/// What came of a case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The answer was right.
    Pass,
    /// The answer was wrong, and where.
    Fail(Difference),
    /// The testee doesn't do this. That is no failure, and no pass.
    Unsupported,
    /// The process ended over it.
    Crashed {
        /// How it ended.
        how: String,
        /// What it said last on standard error.
        stderr: String,
    },
    /// No answer came in time.
    TimedOut {
        /// How long was waited.
        after: Duration,
        /// What it said last on standard error.
        stderr: String,
    },
    /// It failed, and a list of known failures lets that stand.
    Known {
        /// How it failed.
        failure: Box<Verdict>,
        /// Why that is let stand.
        excuse: Excuse,
    },
    /// It was not asked: the run ended before, or the answer is absent from a file.
    NotRun,
}

impl Verdict {
    /// Its name.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail(_) => "fail",
            Self::Unsupported => "unsupported",
            Self::Crashed { .. } => "crashed",
            Self::TimedOut { .. } => "timed out",
            Self::Known { .. } => "known",
            Self::NotRun => "not run",
        }
    }

    /// Whether it counts against the testee.
    pub const fn is_failure(&self) -> bool {
        matches!(self, Self::Fail(_) | Self::Crashed { .. } | Self::TimedOut { .. })
    }
}

/// What is said of it in a line; nothing that changes from run to run.
impl fmt::Display for Verdict {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fail(difference) => difference.fmt(formatter),
            Self::Crashed { how, .. } => write!(formatter, "{}: {how}", self.name()),
            Self::Known { failure, excuse } => write!(formatter, "{failure} ({}: {excuse})", excuse.kind),
            Self::Pass | Self::Unsupported | Self::TimedOut { .. } | Self::NotRun => {
                formatter.write_str(self.name())
            }
        }
    }
}

/// What a testee did against the protocol, each remark once with how often it applied.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ProtocolRemarks {
    /// What, and how often; by text.
    pub remarks: Vec<(String, usize)>,
    /// How many others there were.
    pub more: usize,
}

impl ProtocolRemarks {
    pub(super) fn remark(&mut self, what: String) {
        match self.remarks.binary_search_by(|(known, _)| known.cmp(&what)) {
            Ok(at) => self.remarks[at].1 += 1,
            Err(at) => self.remarks.insert(at, (what, 1)),
        }
        // One that goes never comes again: there are enough before it.
        if self.remarks.len() > MAX_REMARKS {
            self.more += self.remarks.pop().map_or(0, |(_, count)| count);
        }
    }

    /// Whether there is nothing to tell.
    pub fn are_good(&self) -> bool {
        self.remarks.is_empty()
    }
}

/// A whole run.
#[derive(Clone, Debug)]
pub struct Outcome<'c> {
    /// Who was asked; none where a file of answers doesn't say.
    pub hello: Option<Hello>,
    /// The cases with their verdicts.
    pub verdicts: Vec<(&'c Case, Verdict)>,
    /// What was against the protocol.
    pub protocol_remarks: ProtocolRemarks,
    /// How often the process had to be started again.
    pub restarts: u32,
    /// Why the run ended early.
    pub gave_up: Option<String>,
}

/// How many cases came to which verdict.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Right answers.
    pub passed: usize,
    /// Wrong answers, crashes and hangs.
    pub failed: usize,
    /// Failures that are let stand.
    pub known: usize,
    /// What the testee doesn't do.
    pub unsupported: usize,
    /// What it wasn't asked.
    pub not_run: usize,
}

impl Counts {
    fn add(&mut self, verdict: &Verdict) {
        match verdict {
            Verdict::Pass => self.passed += 1,
            Verdict::Unsupported => self.unsupported += 1,
            Verdict::NotRun => self.not_run += 1,
            Verdict::Known { .. } => self.known += 1,
            Verdict::Fail(_) | Verdict::Crashed { .. } | Verdict::TimedOut { .. } => self.failed += 1,
        }
    }
}

impl Outcome<'_> {
    /// The counts of all cases.
    pub fn counts(&self) -> Counts {
        let mut counts = Counts::default();
        self.verdicts.iter().for_each(|(_, verdict)| counts.add(verdict));
        counts
    }

    /// The counts for each op with its form, and type.
    pub fn table(&self) -> BTreeMap<(String, &str), Counts> {
        let mut table: BTreeMap<(String, &str), Counts> = BTreeMap::new();
        for (case, verdict) in &self.verdicts {
            table.entry((case.action(), &case.type_name)).or_default().add(verdict);
        }
        table
    }

    /// The cases that failed and count.
    pub fn failures(&self) -> impl Iterator<Item = (&Case, &Verdict)> {
        let failed = self.verdicts.iter().filter(|(_, verdict)| verdict.is_failure());
        failed.map(|(case, verdict)| (*case, verdict))
    }

    /// The cases that failed, and why that is let stand.
    pub fn known(&self) -> impl Iterator<Item = (&Case, &Excuse)> {
        self.verdicts.iter().filter_map(|(case, verdict)| match verdict {
            Verdict::Known { excuse, .. } => Some((*case, excuse)),
            _ => None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn remarks_are_the_same_in_whatever_order_they_come() {
        let all: Vec<String> =
            (0..90).map(|number| format!("an answer without a question: id {}", number % 30)).collect();
        let reported = |remarks: &mut dyn Iterator<Item = &String>| {
            let mut protocol_remarks = ProtocolRemarks::default();
            remarks.for_each(|remark| protocol_remarks.remark(remark.clone()));
            protocol_remarks
        };
        let first = reported(&mut all.iter());
        assert_eq!((first.remarks.len(), first.more), (MAX_REMARKS, 30));
        assert!(first.remarks.iter().all(|(_, count)| *count == 3) && first.remarks.is_sorted());
        assert_eq!(reported(&mut all.iter().rev()), first);
        assert_eq!(reported(&mut all[7..].iter().chain(&all[..7])), first);
    }
}
