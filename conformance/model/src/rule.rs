//! Rules, their levels and their statuses.

use std::fmt;

use serde::Serialize;

/// The level of a rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "UPPERCASE")]
pub enum Level {
    /// Findings are only shown.
    Info,
    /// A violation is a warning.
    Should,
    /// Data that violates the rule does not conform.
    Must,
}

impl Level {
    /// The name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Info => "INFO",
            Self::Should => "SHOULD",
            Self::Must => "MUST",
        }
    }
}

impl fmt::Display for Level {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

/// The authority of a rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The specification requires the rule.
    Normative,
    /// The specification contradicts itself. Contains a description of the contradiction. Data that follows one part of
    /// the specification must not fail, so the level is never [`Level::Must`].
    Disputed(&'static str),
    /// The specification requires the rule, but contradicts itself about some cases. Contains a description of these
    /// cases. Findings in these cases are disputed.
    DisputedCases(&'static str),
    /// The rule follows from the specification or its purpose.
    Advisory,
}

/// The name of [`Status::Disputed`].
pub const DISPUTED: &str = "disputed";

impl fmt::Display for Status {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Self::Normative | Self::DisputedCases(_) => "normative",
            Self::Disputed(_) => DISPUTED,
            Self::Advisory => "advisory",
        })
    }
}

/// A rule, without its check.
#[derive(Debug)]
pub struct Rule {
    /// The id. The meaning of an id never changes, and ids are never reused.
    pub id: &'static str,
    /// A short unique name in words, for tables of contents.
    pub name: &'static str,
    /// The level.
    pub level: Level,
    /// The authority.
    pub status: Status,
    /// The requirement.
    pub statement: &'static str,
    /// The part of the specification that requires the rule.
    pub source: &'static str,
    /// The data to which the rule applies.
    pub applies_to: &'static str,
    /// The harm that a violation causes.
    pub why: &'static str,
    /// An example of a violation: messages, or a value with its definition.
    pub example: &'static str,
    /// The way to correct a violation.
    pub fix: &'static str,
}

impl Rule {
    /// True if the rule applies to Flockwave sessions only.
    pub fn is_on_flockwave(&self) -> bool {
        self.id.starts_with("FW-")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_and_statuses_are_padded_words() {
        let levels = [Level::Info, Level::Should, Level::Must].map(|level| format!("{level:7}|"));
        assert_eq!(levels, ["INFO   |", "SHOULD |", "MUST   |"]);
        let statuses = [Status::Normative, Status::Disputed("how"), Status::Advisory];
        assert_eq!(statuses.map(|status| status.to_string()), ["normative", "disputed", "advisory"]);
    }
}
