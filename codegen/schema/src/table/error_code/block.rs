//! Headings of error-code tables: `Warnings (codes 64-127)`.

use std::ops::RangeInclusive;

use uavspec_runtime::{ErrorClass, Severity};

use crate::diagnostic::Problem;

/// The codes that a heading reserves for the table that follows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// The heading without the range.
    pub title: String,
    /// The class of all codes.
    pub class: ErrorClass,
    /// The first and the last code.
    pub codes: RangeInclusive<u32>,
}

/// The names of classes in headings, in lower case and singular, with spaces instead of hyphens.
const CLASS_NAMES: &[(&str, ErrorClass)] = &[
    ("no error", ErrorClass::NoError),
    ("info", ErrorClass::Informational),
    ("information", ErrorClass::Informational),
    ("informational", ErrorClass::Informational),
    ("informational code", ErrorClass::Informational),
    ("informational message", ErrorClass::Informational),
    ("warning", ErrorClass::Warning),
    ("warning code", ErrorClass::Warning),
    ("warning condition", ErrorClass::Warning),
    ("warning message", ErrorClass::Warning),
    ("error", ErrorClass::Error),
    ("error condition", ErrorClass::Error),
    ("error message", ErrorClass::Error),
    ("fatal", ErrorClass::Fatal),
    ("fatal condition", ErrorClass::Fatal),
    ("fatal error", ErrorClass::Fatal),
    ("fatal error code", ErrorClass::Fatal),
    ("critical", ErrorClass::Fatal),
    ("critical condition", ErrorClass::Fatal),
    ("critical error", ErrorClass::Fatal),
    ("critical error code", ErrorClass::Fatal),
    ("uav specific", ErrorClass::UavSpecific),
    ("uav specific code", ErrorClass::UavSpecific),
    ("uav specific error", ErrorClass::UavSpecific),
    ("uav specific error code", ErrorClass::UavSpecific),
    ("user defined", ErrorClass::UserDefined),
    ("user defined code", ErrorClass::UserDefined),
    ("user defined error", ErrorClass::UserDefined),
    ("user defined error code", ErrorClass::UserDefined),
];

impl Block {
    /// Parses a heading, which contains a name, a range or both. The name and the range must agree.
    pub(super) fn parse(heading: &str) -> Result<Self, Problem> {
        let range = find_range(heading);
        let title = range.as_ref().map_or(heading, |range| heading[..range.start].trim_end_matches(is_joint));
        let named = class_named(title);
        let title = if title.is_empty() { heading } else { title }.to_owned();
        match (named, range) {
            (None, None) => Err(Problem::UnknownClass { heading: heading.to_owned() }),
            (Some(class), None) => Ok(Self { title, class, codes: class.codes() }),
            (named, Some(range)) => {
                let class = ErrorClass::of(range.first);
                let expected = named.filter(|named| !is_severity_of(*named, &range)).unwrap_or(class);
                let is_within =
                    expected == class && range.first <= range.last && class.codes().contains(&range.last);
                if is_within {
                    Ok(Self { title, class, codes: range.first..=range.last })
                } else {
                    let found = range.text;
                    let expected_codes = range_text(&expected.codes());
                    Err(Problem::ClassRange { class: expected.to_string(), found, expected: expected_codes })
                }
            }
        }
    }
}

/// True if the class matches the severity of all codes in the range. Codes from 256 on keep the severity of their low
/// byte, so vendors may group them by severity.
fn is_severity_of(class: ErrorClass, range: &HeadingRange) -> bool {
    let is_vendor = range.first > *ErrorClass::Fatal.codes().end();
    let is_one_severity = range.first >> 6 == range.last >> 6;
    let severity = match class {
        ErrorClass::Informational => Severity::Informational,
        ErrorClass::Warning => Severity::Warning,
        ErrorClass::Error => Severity::Error,
        ErrorClass::Fatal => Severity::Fatal,
        ErrorClass::NoError | ErrorClass::UavSpecific | ErrorClass::UserDefined => return false,
    };
    is_vendor && is_one_severity && Severity::of(range.first) == severity
}

/// The class whose name is exactly `title`.
fn class_named(title: &str) -> Option<ErrorClass> {
    let words = title.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty());
    let words: Vec<String> = words.map(|word| word.to_lowercase().trim_end_matches('s').to_owned()).collect();
    let name = words.join(" ");
    CLASS_NAMES.iter().find(|(known, _)| *known == name).map(|(_, class)| *class)
}

/// A range of codes in a heading.
struct HeadingRange {
    /// The start position in the heading.
    start: usize,
    first: u32,
    last: u32,
    /// The range as written.
    text: String,
}

/// True if `heading` contains a range. Only headings of error-code tables contain ranges.
pub(super) fn has_range(heading: &str) -> bool {
    find_range(heading).is_some()
}

/// True for characters between a title and its range.
fn is_joint(c: char) -> bool {
    c.is_whitespace() || matches!(c, '(' | '[' | ',' | ':' | ';' | '-' | '–' | '—')
}

/// The last range in `heading`: after the word "code" or "codes", or in parentheses.
fn find_range(heading: &str) -> Option<HeadingRange> {
    let lower = heading.to_ascii_lowercase();
    let words = lower.rmatch_indices("code").map(|(at, word)| (at, at + word.len()));
    let parentheses = lower.rmatch_indices(['(', '[']).map(|(at, _)| (at, at + 1));
    words.chain(parentheses).find_map(|(start, after)| {
        let rest = &lower[after..];
        let rest = rest.strip_prefix('s').unwrap_or(rest);
        let (first, last, rest) = range(rest.trim_start())?;
        let end = lower.len() - rest.len();
        let text = &heading[after..end];
        let text = text.strip_prefix(['s', 'S']).unwrap_or(text).trim().to_owned();
        Some(HeadingRange { start, first, last, text })
    })
}

/// Parses `64-127`, `32768 and above` or `0`, and returns the rest, which is empty or starts with a closing
/// parenthesis.
fn range(text: &str) -> Option<(u32, u32, &str)> {
    let (first, rest) = number(text)?;
    let after = rest.trim_start();
    let dash =
        ["-", "–", "—", "to ", "through ", "..."].into_iter().find_map(|dash| after.strip_prefix(dash));
    let open = ["and above", "and up", "or above", "and higher", "or higher", "onwards", "+"];
    let (last, rest) = if let Some(second) = dash {
        number(second.trim_start())?
    } else if let Some(rest) = open.into_iter().find_map(|open| after.strip_prefix(open)) {
        (u32::MAX, rest)
    } else {
        (first, rest)
    };
    let is_whole = rest.is_empty() || rest.starts_with([')', ']']);
    is_whole.then_some((first, last, rest))
}

fn number(text: &str) -> Option<(u32, &str)> {
    let len = text.bytes().take_while(u8::is_ascii_digit).count();
    let (digits, rest) = text.split_at(len);
    Some((parse_code(digits)?, rest))
}

/// Formats a range of codes as in headings: `64-127`, `32768 and above`, `0`.
pub(crate) fn range_text(range: &RangeInclusive<u32>) -> String {
    match (*range.start(), *range.end()) {
        (first, u32::MAX) => format!("{first} and above"),
        (first, last) if first == last => first.to_string(),
        (first, last) => format!("{first}-{last}"),
    }
}

/// Parses a decimal code. Rejects signs and leading zeros, which other tools may interpret differently.
pub(crate) fn parse_code(text: &str) -> Option<u32> {
    let is_plain = text.bytes().all(|byte| byte.is_ascii_digit()) && (text == "0" || !text.starts_with('0'));
    text.parse().ok().filter(|_| is_plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_contain_a_class_a_range_or_both() {
        for (heading, title, class, codes) in [
            ("No error (code 0)", "No error", ErrorClass::NoError, 0..=0),
            ("Informational messages", "Informational messages", ErrorClass::Informational, 1..=63),
            ("WARNINGS (codes 64–127)", "WARNINGS", ErrorClass::Warning, 64..=127),
            ("Warnings: codes 64 to 100", "Warnings", ErrorClass::Warning, 64..=100),
            ("Errors (128-191)", "Errors", ErrorClass::Error, 128..=191),
            ("Critical errors (Codes 192 - 255)", "Critical errors", ErrorClass::Fatal, 192..=255),
            ("UAV-specific error codes", "UAV-specific error codes", ErrorClass::UavSpecific, 256..=32_767),
            ("Vendor X (codes 512-767)", "Vendor X", ErrorClass::UavSpecific, 512..=767),
            ("Warnings (codes 576-639)", "Warnings", ErrorClass::UavSpecific, 576..=639),
            (
                "User-defined error codes (codes 32768 and above)",
                "User-defined error codes",
                ErrorClass::UserDefined,
                32_768..=u32::MAX,
            ),
            ("Codes 70-80", "Codes 70-80", ErrorClass::Warning, 70..=80),
        ] {
            assert_eq!(
                Block::parse(heading),
                Ok(Block { title: title.to_owned(), class, codes }),
                "{heading}"
            );
        }
    }

    #[test]
    fn a_heading_without_class_or_range_is_unknown() {
        for heading in [
            "",
            "Error codes",
            "Lemons",
            "Lemons (codes 1, 2)",
            "Lemons (codes 64-",
            "Lemons (codes 99999999999-1)",
            "Codes",
            "Änderungen",
        ] {
            assert!(matches!(Block::parse(heading), Err(Problem::UnknownClass { .. })), "{heading}");
        }
    }

    #[test]
    fn name_and_range_must_agree() {
        for (heading, name, found, expected) in [
            ("Warnings (codes 64-128)", "warning", "64-128", "64-127"),
            ("Warnings (codes 128-191)", "warning", "128-191", "64-127"),
            ("Warnings (codes 127 - 64)", "warning", "127 - 64", "64-127"),
            ("Warnings (codes 512-575)", "warning", "512-575", "64-127"),
            ("Vendor X (codes 255-511)", "fatal", "255-511", "192-255"),
            ("UAV-specific error codes (codes 256 and above)", "UAV-specific", "256 and above", "256-32767"),
            ("User-defined (code 5)", "user-defined", "5", "32768 and above"),
        ] {
            let problem = Problem::ClassRange {
                class: name.to_owned(),
                found: found.to_owned(),
                expected: expected.to_owned(),
            };
            assert_eq!(Block::parse(heading), Err(problem), "{heading}");
        }
    }
}
