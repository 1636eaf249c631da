//! Known failures, as findings and results carry them.

use std::fmt;

use super::Date;

/// Why a failure doesn't count.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Excuse {
    /// Whether it always fails.
    pub kind: ExcuseKind,
    /// Why it is let stand.
    pub reason: String,
    /// Where more is said of it.
    pub link: Option<String>,
    /// The last day that it is let stand.
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

/// What an entry says of that which it names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExcuseKind {
    /// It fails.
    Known,
    /// It fails now and then.
    Flaky,
}

impl ExcuseKind {
    /// Its name, in lists and reports.
    pub(crate) const fn name(self) -> &'static str {
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
