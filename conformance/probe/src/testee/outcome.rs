//! The results of a run.

use std::collections::BTreeMap;
use std::fmt;
use std::time::Duration;

use serde::Serialize;
use uavspec_model::Excuse;

use super::case::Case;
use super::compare::Difference;
use super::protocol::Hello;

/// The maximum number of stored remarks. The alphabetically first remarks are stored, because the chronological order
/// depends on process scheduling. Further remarks are only counted.
const MAX_REMARKS: usize = 20;

/// The result of a case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The response was correct.
    Pass,
    /// The response was wrong.
    Fail(Difference),
    /// The testee doesn't support the case. This counts as neither a pass nor a failure.
    Unsupported,
    /// The process ended because of the case.
    Crashed {
        /// The exit status or the error.
        how: String,
        /// The last part of standard error.
        stderr: String,
    },
    /// There was no response in time.
    TimedOut {
        /// The time limit.
        after: Duration,
        /// The last part of standard error.
        stderr: String,
    },
    /// A failure that a baseline excuses.
    Known {
        /// The failure.
        failure: Box<Verdict>,
        /// The entry that excuses the failure.
        excuse: Excuse,
    },
    /// The case was not run: the run ended early, or the file contains no response to the case.
    NotRun,
}

impl Verdict {
    /// The name of the verdict.
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

    /// True if the verdict counts against the testee.
    pub const fn is_failure(&self) -> bool {
        matches!(self, Self::Fail(_) | Self::Crashed { .. } | Self::TimedOut { .. })
    }
}

/// A one-line description, without details that differ between runs.
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

/// Violations of the protocol. Each distinct text appears once, with its number of occurrences.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ProtocolRemarks {
    /// Texts and numbers of occurrences, sorted by text.
    pub remarks: Vec<(String, usize)>,
    /// The number of remarks that are not listed.
    pub more: usize,
}

impl ProtocolRemarks {
    pub(super) fn remark(&mut self, what: String) {
        match self.remarks.binary_search_by(|(known, _)| known.cmp(&what)) {
            Ok(at) => self.remarks[at].1 += 1,
            Err(at) => self.remarks.insert(at, (what, 1)),
        }
        // A dropped text doesn't return, because the list is full of texts that sort before it.
        if self.remarks.len() > MAX_REMARKS {
            self.more += self.remarks.pop().map_or(0, |(_, count)| count);
        }
    }

    /// True if there are no remarks.
    pub fn is_empty(&self) -> bool {
        self.remarks.is_empty()
    }
}

/// The result of a run.
#[derive(Clone, Debug)]
pub struct Outcome<'c> {
    /// The introduction of the testee; `None` if a response file contains no hello.
    pub hello: Option<Hello>,
    /// The cases and their verdicts.
    pub verdicts: Vec<(&'c Case, Verdict)>,
    /// The violations of the protocol.
    pub protocol_remarks: ProtocolRemarks,
    /// The number of restarts of the testee.
    pub restarts: u32,
    /// The reason why the run ended early.
    pub gave_up: Option<String>,
}

/// The number of cases with each result.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct Counts {
    /// Correct responses.
    #[serde(rename = "pass")]
    pub passed: u64,
    /// Wrong responses, crashes and hangs.
    #[serde(rename = "fail")]
    pub failed: u64,
    /// Failures that are in a baseline.
    pub known: u64,
    /// Cases that the testee doesn't support.
    pub unsupported: u64,
    /// Cases that were not run.
    pub not_run: u64,
}

impl Counts {
    /// The number of cases with a result.
    pub fn checked(self) -> u64 {
        self.passed + self.failed + self.known
    }

    /// The number of all cases.
    pub fn all(self) -> u64 {
        self.checked() + self.unsupported + self.not_run
    }

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

    /// The counts for each combination of op, format and type.
    pub fn table(&self) -> BTreeMap<(String, &str), Counts> {
        let mut table: BTreeMap<(String, &str), Counts> = BTreeMap::new();
        for (case, verdict) in &self.verdicts {
            table.entry((case.action(), &case.type_name)).or_default().add(verdict);
        }
        table
    }

    /// The cases that failed without an excuse.
    pub fn failures(&self) -> impl Iterator<Item = (&Case, &Verdict)> {
        let failed = self.verdicts.iter().filter(|(_, verdict)| verdict.is_failure());
        failed.map(|(case, verdict)| (*case, verdict))
    }

    /// The cases with an excused failure, and the excuses.
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
    fn lists_the_same_remarks_for_any_arrival_order() {
        let all: Vec<String> =
            (0..90).map(|number| format!("unexpected response with id {}", number % 30)).collect();
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
