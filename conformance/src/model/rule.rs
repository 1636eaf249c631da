//! What a rule says.

use std::fmt;

use serde::Serialize;

/// How much a rule binds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "UPPERCASE")]
pub enum Level {
    /// Derived, and shown without being judged.
    Info,
    /// What breaks it should be looked at.
    Should,
    /// What breaks it doesn't conform.
    Must,
}

impl fmt::Display for Level {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Self::Info => "INFO",
            Self::Should => "SHOULD",
            Self::Must => "MUST",
        })
    }
}

/// Whether what a rule says is beyond doubt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The specification lays it down.
    Normative,
    /// The specification contradicts itself; how, says the text.
    Disputed(&'static str),
    /// It follows from the specification, or from what it is for.
    Advisory,
}

impl fmt::Display for Status {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Self::Normative => "normative",
            Self::Disputed(_) => "disputed",
            Self::Advisory => "advisory",
        })
    }
}

/// The statement of a rule, by which findings and reports name it.
#[derive(Debug)]
pub struct Rule {
    /// Its id, which never changes its meaning and is never used again.
    pub id: &'static str,
    /// How much it binds.
    pub level: Level,
    /// Whether it is beyond doubt.
    pub status: Status,
    /// What has to hold.
    pub statement: &'static str,
    /// What lays it down.
    pub source: &'static str,
    /// What it is about.
    pub applies_to: &'static str,
    /// The harm that a violation does.
    pub why: &'static str,
    /// A violation: a message, or a value and its definition.
    pub example: &'static str,
    /// The way to correct a violation.
    pub fix: &'static str,
}

impl Rule {
    /// True if the rule applies to Flockwave sessions only.
    pub(crate) fn is_on_flockwave(&self) -> bool {
        self.id.starts_with("FW-")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_and_statuses_are_words_that_keep_to_columns() {
        let levels = [Level::Info, Level::Should, Level::Must].map(|level| format!("{level:7}|"));
        assert_eq!(levels, ["INFO   |", "SHOULD |", "MUST   |"]);
        let statuses = [Status::Normative, Status::Disputed("how"), Status::Advisory];
        assert_eq!(statuses.map(|status| status.to_string()), ["normative", "disputed", "advisory"]);
    }
}
