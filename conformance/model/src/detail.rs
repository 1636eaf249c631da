//! Details of a violation.

use std::fmt;

use uavspec_runtime::{Constraint, ConstraintKind, Number};
use uavspec_schema::Restriction;

/// The maximum number of documented values to list.
const MAX_LISTED: usize = 12;

/// The maximum number of bytes in an excerpt.
const MAX_BYTES: usize = 32;

/// The details of a violation.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Detail {
    /// The location in the record: the path of a field, such as `events[2].id`, or a JSON pointer, such as
    /// `/msg/events/2/id`. Empty for the whole record.
    pub path: String,
    /// The affected part of the subject, printed before the message. Empty for the whole subject.
    pub part: String,
    /// A description of the violation.
    pub message: String,
    /// The expected value; may be empty.
    pub expected: String,
    /// The actual value; may be empty.
    pub actual: String,
    /// The checked bytes or text, shortened; may be empty.
    pub excerpt: String,
    /// The time of the record in µs, by the clock of the capture.
    pub time: Option<u64>,
    /// The log time of the record in ns, if it is in a bag.
    pub log_time: Option<u64>,
    /// The sequence number that the bag states for the record.
    pub sequence: Option<u32>,
    /// The connection of the record; empty if the capture isn't a session.
    pub connection: String,
    /// The request to which the record belongs, shortened; may be empty.
    pub request: String,
    /// The rule or message type whose requests reproduce the finding if a probe sends only them; may be empty.
    pub only: String,
    /// True if the specification contradicts itself about this case. False if the contradiction concerns all cases of
    /// the rule.
    pub is_disputed: bool,
}

impl From<String> for Detail {
    fn from(message: String) -> Self {
        Self::new(message)
    }
}

impl Detail {
    /// Creates a detail with a message.
    pub fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), ..Self::default() }
    }

    /// Creates a detail with an expected and an actual value.
    pub fn differs(expected: impl fmt::Display, actual: impl fmt::Display) -> Self {
        let (expected, actual) = (expected.to_string(), actual.to_string());
        Self::new(format!("expected {expected}, found {actual}")).expected(expected).actual(actual)
    }

    /// Sets the expected value.
    #[must_use]
    pub fn expected(self, expected: impl Into<String>) -> Self {
        Self { expected: expected.into(), ..self }
    }

    /// Sets the actual value.
    #[must_use]
    pub fn actual(self, actual: impl Into<String>) -> Self {
        Self { actual: actual.into(), ..self }
    }

    /// Sets whether the specification contradicts itself about this case.
    #[must_use]
    pub fn disputed(self, is_disputed: bool) -> Self {
        Self { is_disputed, ..self }
    }

    /// Sets both the path in the record and the part of the subject to `path`.
    #[must_use]
    pub fn at(self, path: impl Into<String>) -> Self {
        let path = path.into();
        Self { part: path.clone(), path, ..self }
    }

    /// Sets the path in the record but not the part of the subject. Use this if the subject or part describes the
    /// location in other words.
    #[must_use]
    pub fn located(self, path: impl Into<String>) -> Self {
        Self { path: path.into(), ..self }
    }

    /// Sets the excerpt.
    #[must_use]
    pub fn excerpt(self, excerpt: impl Into<String>) -> Self {
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

/// Formats bytes in hexadecimal, such as `01 ff`, shortened to `MAX_BYTES`.
pub fn hexadecimal(bytes: &[u8]) -> String {
    let mut text: Vec<String> = bytes.iter().take(MAX_BYTES).map(|byte| format!("{byte:02x}")).collect();
    if bytes.len() > MAX_BYTES {
        text.push("…".to_owned());
    }
    text.join(" ")
}

impl Detail {
    /// Creates a detail for a number that violates a constraint.
    pub fn number(rule: ConstraintKind, found: Number, restriction: &Restriction) -> Self {
        let Constraint { low, high, count, known, is_flags, .. } = restriction.constraint();
        let expected = match (rule, low, high) {
            (ConstraintKind::Range, Some(low), Some(high)) => format!("{low} to {high}"),
            (ConstraintKind::Range, Some(low), None) => format!("{low} or more"),
            (ConstraintKind::Range, None, Some(high)) => format!("at most {high}"),
            (ConstraintKind::Count, ..) => format!("at most {}", count.unwrap_or_default()),
            (ConstraintKind::Enum, ..) => {
                let known = known.unwrap_or_default();
                let listed: Vec<String> = known.iter().take(MAX_LISTED).map(ToString::to_string).collect();
                let more = if known.len() > MAX_LISTED { ", …" } else { "" };
                format!("{} {}{more}", if is_flags { "bits of" } else { "one of" }, listed.join(", "))
            }
            (ConstraintKind::Nan, ..) => "a number".to_owned(),
            _ => String::new(),
        };
        let text = Explained { rule, found, restriction }.to_string();
        // Reports print the rule separately.
        let text = text.rsplit_once(" (PX-").map_or(text.as_str(), |(text, _)| text);
        Self::new(text).expected(expected).actual(found.to_string())
    }
}

/// The description of a constraint violation, as in the errors of generated types.
struct Explained<'r> {
    rule: ConstraintKind,
    found: Number,
    restriction: &'r Restriction,
}

impl fmt::Display for Explained<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.rule.explain(self.found, Some(&self.restriction.constraint()), None, formatter)
    }
}
