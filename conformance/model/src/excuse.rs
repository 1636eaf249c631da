//! The excuses for known failures, which are attached to findings and results.

use std::fmt;

use serde::Serialize;
use uavspec_schema::Date;

use crate::text::shown;

/// An entry of a baseline.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[schemars(rename = "Known")]
pub struct Excuse {
    /// `known` for a failure that always occurs, `flaky` for a failure that sometimes occurs.
    #[schemars(with = "String")]
    pub kind: ExcuseKind,
    /// The reason.
    pub reason: String,
    /// A link, such as to an issue.
    pub link: Option<String>,
    /// The last day on which the entry applies, such as `2027-06-30`.
    #[schemars(with = "Option<String>")]
    pub expires: Option<Date>,
}

impl fmt::Display for Excuse {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&shown(&self.reason))?;
        if let Some(date) = self.expires {
            write!(formatter, " (until {date})")?;
        }
        self.link.as_ref().map_or(Ok(()), |link| write!(formatter, " {}", shown(link)))
    }
}

/// The kind of a known failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ExcuseKind {
    /// The failure always occurs.
    Known,
    /// The failure occurs sometimes.
    Flaky,
}

impl ExcuseKind {
    /// The name in lists and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Known => "known",
            Self::Flaky => "flaky",
        }
    }
}

impl fmt::Display for ExcuseKind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}
