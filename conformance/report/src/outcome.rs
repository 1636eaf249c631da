//! The outcome of a run: a kind, a sentence and an exit status.

use serde::Serialize;
use uavspec_check::Share;
use uavspec_model::text::plural;

use super::totals::Totals;
use super::{Action, Counts, Unreadable};

/// The start of the sentence if no MUST or SHOULD rule is violated.
pub(super) const NO_VIOLATIONS: &str = "no violations found";

/// The outcome of a run or a subject.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct Outcome {
    /// The kind.
    pub kind: OutcomeKind,
    /// The exit status. An incomplete outcome has status 0 if the user allows it.
    pub status: u8,
    /// The outcome as a sentence.
    pub text: String,
    /// Further remarks.
    pub remarks: Vec<String>,
}

/// A kind of outcome. The values are in ascending precedence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum OutcomeKind {
    /// Everything was checked, and no rule of level MUST is violated.
    Conforms,
    /// Everything was read, and no rule of level MUST is violated. Some topics, types or cases weren't fully checked.
    #[serde(rename = "partial coverage")]
    Partial,
    /// Nothing was checked.
    #[serde(rename = "not checked")]
    Nothing,
    /// An entry of a baseline no longer applies.
    #[serde(rename = "out of date")]
    Stale,
    /// Some data can't be read, or too little was checked.
    Incomplete,
    /// A rule of level MUST is violated.
    #[serde(rename = "does not conform")]
    DoesNotConform,
    /// A file can't be opened, or a testee or server failed.
    Failed,
}

impl OutcomeKind {
    /// All kinds, the best first.
    pub(crate) const ALL: [Self; 7] = [
        Self::Conforms,
        Self::Partial,
        Self::Nothing,
        Self::Stale,
        Self::Incomplete,
        Self::DoesNotConform,
        Self::Failed,
    ];

    /// The exit status.
    pub const fn status(self) -> u8 {
        match self {
            Self::Conforms | Self::Partial => 0,
            Self::DoesNotConform => 1,
            Self::Failed => 3,
            Self::Stale => 4,
            Self::Nothing => 5,
            Self::Incomplete => 6,
        }
    }

    /// The name in all reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Conforms => "conforms",
            Self::Partial => "partial coverage",
            Self::Nothing => "not checked",
            Self::Stale => "out of date",
            Self::Incomplete => "incomplete",
            Self::DoesNotConform => "does not conform",
            Self::Failed => "failed",
        }
    }
}

impl Outcome {
    /// Creates an outcome without remarks.
    pub(crate) fn new(kind: OutcomeKind, text: impl Into<String>) -> Self {
        Self { kind, status: kind.status(), text: text.into(), remarks: Vec::new() }
    }

    /// True if a run with this outcome succeeds.
    pub fn is_success(&self) -> bool {
        self.status == 0
    }

    /// The outcome for a testee, based on its cases and the number of protocol violations.
    pub(super) fn for_testee(counts: Counts, violations: usize, gave_up: Option<&str>) -> Self {
        let (checked, all) = (counts.checked(), counts.all());
        match gave_up {
            Some(reason) => Self::new(OutcomeKind::Failed, format!("Failed: {reason}")),
            None if counts.failed > 0 => Self::new(
                OutcomeKind::DoesNotConform,
                format!("Does not conform: {} of {checked} cases failed", counts.failed),
            ),
            None if violations > 0 => {
                Self::new(OutcomeKind::DoesNotConform, "Does not conform: violates the test protocol")
            }
            None if checked == 0 => Self::new(OutcomeKind::Nothing, "Nothing was checked"),
            None if checked < all => {
                let cases = Share::of(checked, all).text("case");
                let text = format!("{NO_VIOLATIONS}, partial coverage: {cases} checked");
                Self::new(OutcomeKind::Partial, capitalized(&text))
            }
            None => Self::new(OutcomeKind::Conforms, "Conforms"),
        }
    }

    /// The last line of a terminal report: the outcome's text, starting with a lower-case letter.
    pub(super) fn last_line(&self) -> String {
        let mut characters = self.text.chars();
        let first = characters.next().map(|first| first.to_ascii_lowercase());
        first.into_iter().chain(characters).collect()
    }

    /// The outcome for a whole run.
    pub(super) fn for_run(
        action: Action,
        totals: &Totals,
        unreadable: &[Unreadable],
        remarks: Vec<String>,
    ) -> Self {
        let mut outcome = Self::for_subjects(action, totals);
        if !remarks.is_empty() && outcome.kind < OutcomeKind::DoesNotConform {
            let text = "Does not conform";
            outcome = Self { remarks: outcome.remarks, ..Self::new(OutcomeKind::DoesNotConform, text) };
        }
        if !unreadable.is_empty() {
            let text = match (action, unreadable.len()) {
                (Action::Probe, _) => "Failed: the server did not complete the probe".to_owned(),
                (_, 1) => "Failed: 1 file can't be opened".to_owned(),
                (_, count) => format!("Failed: {count} files can't be opened"),
            };
            let rest = if totals.subjects == 0 { Vec::new() } else { vec![outcome.text] };
            outcome = Self { remarks: rest, ..Self::new(OutcomeKind::Failed, text) };
        }
        outcome.remarks.extend(remarks);
        outcome
    }

    fn for_subjects(action: Action, totals: &Totals) -> Self {
        if let Some(only) = totals.only() {
            return only.outcome.clone();
        }
        // A testee without checked cases doesn't affect the outcome of other testees.
        let Some(worst) = totals.worst() else {
            return Self::new(OutcomeKind::Nothing, "Nothing was checked");
        };
        let (count, status) = totals.with(worst);
        let (must, should) = totals.violated();
        let noun = if action == Action::Probe { "servers" } else { "files" };
        let files = format!("{count} of {} {noun}", totals.subjects);
        let warnings = (should > 0).then(|| plural(should, "warning"));
        let text = match (worst, warnings) {
            (OutcomeKind::Conforms | OutcomeKind::Nothing, None) => "Conforms".to_owned(),
            (OutcomeKind::Conforms | OutcomeKind::Nothing, Some(warnings)) => {
                format!("Conforms, with {warnings}")
            }
            (OutcomeKind::Partial, warnings) => {
                let found = warnings.as_deref().unwrap_or(NO_VIOLATIONS);
                capitalized(&format!("{found}, partial coverage of {files}"))
            }
            (OutcomeKind::Stale, _) => "A baseline is out of date".to_owned(),
            (OutcomeKind::DoesNotConform, _) if totals.has_testees() => "Does not conform".to_owned(),
            (OutcomeKind::DoesNotConform, _) => {
                format!("Does not conform: {must} MUST, {should} SHOULD ({files})")
            }
            (OutcomeKind::Incomplete, _) => format!("Incomplete: {files}"),
            (OutcomeKind::Failed, _) => "Failed: a testee failed".to_owned(),
        };
        Self { status, remarks: totals.remarks(), ..Self::new(worst, text) }
    }
}

/// A text with a capital first letter.
pub(super) fn capitalized(text: &str) -> String {
    let mut characters = text.chars();
    let first = characters.next().map(|first| first.to_ascii_uppercase());
    first.into_iter().chain(characters).collect()
}

#[cfg(test)]
mod tests;
