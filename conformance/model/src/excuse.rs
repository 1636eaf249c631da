//! The excuses for known failures, which are attached to findings and results.

use std::fmt;

use uavspec_schema::Date;

/// The reason why a known failure doesn't count.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Excuse {
    /// The kind of failure: constant or occasional.
    pub kind: ExcuseKind,
    /// The reason, from the baseline.
    pub reason: String,
    /// A link to more information.
    pub link: Option<String>,
    /// The last day on which the failure doesn't count.
    pub expires: Option<Date>,
}

impl fmt::Display for Excuse {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.reason)?;
        if let Some(date) = self.expires {
            write!(formatter, " (until {date})")?;
        }
        self.link.as_ref().map_or(Ok(()), |link| write!(formatter, " {link}"))
    }
}

/// The kind of a known failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExcuseKind {
    /// It always fails.
    Known,
    /// It fails sometimes.
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
