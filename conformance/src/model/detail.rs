//! What is said of a breach.

use std::fmt;

use uavspec_codegen::schema::Restriction;
use uavspec_runtime::{Constraint, Number, Rule};

/// How many documented values are listed.
const MAX_LISTED: usize = 12;

/// How many bytes of an excerpt are shown.
const MAX_BYTES: usize = 32;

/// What is said of a breach.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Detail {
    /// Where in the record: the path of a field, as `events[2].id`, or in JSON a pointer, as `/msg/events/2/id`. Empty
    /// where it is about the whole of it.
    pub path: String,
    /// Which part of the subject, as it stands before the words; empty where the subject says it all.
    pub part: String,
    /// What is the matter, in words.
    pub message: String,
    /// What should have been, where that can be said alone; may be empty.
    pub expected: String,
    /// What was found in its place; may be empty.
    pub actual: String,
    /// The bytes or the text that were judged, shortened; may be empty.
    pub excerpt: String,
}

impl Detail {
    /// What is the matter, in words.
    pub(crate) fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), ..Self::default() }
    }

    /// One was found in the place of the other.
    pub(crate) fn differs(expected: impl fmt::Display, actual: impl fmt::Display) -> Self {
        let (expected, actual) = (expected.to_string(), actual.to_string());
        Self::new(format!("expected {expected}, found {actual}")).expected(expected).actual(actual)
    }

    /// With what should have been.
    #[must_use]
    pub(crate) fn expected(self, expected: impl Into<String>) -> Self {
        Self { expected: expected.into(), ..self }
    }

    /// With what was found.
    #[must_use]
    pub(crate) fn actual(self, actual: impl Into<String>) -> Self {
        Self { actual: actual.into(), ..self }
    }

    /// With the part of the subject that it is about, which its path names.
    #[must_use]
    pub(crate) fn at(self, path: impl Into<String>) -> Self {
        let path = path.into();
        Self { part: path.clone(), path, ..self }
    }

    /// With its place in the record, where the subject says that in other words, or the part does.
    #[must_use]
    pub(crate) fn located(self, path: impl Into<String>) -> Self {
        Self { path: path.into(), ..self }
    }

    /// With what was judged.
    #[must_use]
    pub(crate) fn excerpt(self, excerpt: impl Into<String>) -> Self {
        Self { excerpt: excerpt.into(), ..self }
    }
}

impl fmt::Display for Detail {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.part.is_empty() {
            write!(formatter, "{}: ", self.part)?;
        }
        formatter.write_str(&self.message)
    }
}

/// Bytes as an excerpt shows them, in hexadecimal: `01 ff`, and of many the first.
pub(crate) fn hexadecimal(bytes: &[u8]) -> String {
    let mut text: Vec<String> = bytes.iter().take(MAX_BYTES).map(|byte| format!("{byte:02x}")).collect();
    if bytes.len() > MAX_BYTES {
        text.push("…".to_owned());
    }
    text.join(" ")
}

impl Detail {
    /// A number breaks a rule.
    pub(crate) fn number(rule: Rule, found: Number, restriction: &Restriction) -> Self {
        let Constraint { low, high, count, known, is_flags, .. } = restriction.constraint();
        let expected = match (rule, low, high) {
            (Rule::Range, Some(low), Some(high)) => format!("{low} to {high}"),
            (Rule::Range, Some(low), None) => format!("{low} or more"),
            (Rule::Range, None, Some(high)) => format!("{high} at most"),
            (Rule::Count, ..) => format!("{} at most", count.unwrap_or_default()),
            (Rule::Enum, ..) => {
                let known = known.unwrap_or_default();
                let listed: Vec<String> = known.iter().take(MAX_LISTED).map(ToString::to_string).collect();
                let more = if known.len() > MAX_LISTED { ", …" } else { "" };
                format!("{} {}{more}", if is_flags { "bits of" } else { "one of" }, listed.join(", "))
            }
            (Rule::Nan, ..) => "a number".to_owned(),
            _ => String::new(),
        };
        let text = Explained { rule, found, restriction }.to_string();
        // The rule stands beside it in any report.
        let text = text.rsplit_once(" (PX-").map_or(text.as_str(), |(text, _)| text);
        Self::new(text).expected(expected).actual(found.to_string())
    }
}

/// What a number should have been, in the words that generated types use.
struct Explained<'r> {
    rule: Rule,
    found: Number,
    restriction: &'r Restriction,
}

impl fmt::Display for Explained<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.rule.explain(self.found, Some(&self.restriction.constraint()), None, formatter)
    }
}
