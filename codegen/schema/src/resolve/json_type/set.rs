//! Reads the values of a set: integers or strings.

use std::collections::BTreeSet;

use uavspec_runtime::Scalar;

use crate::diagnostic::{Diagnostic, Problem};
use crate::json_type::{SetValue, SetValues};
use crate::msg::literal::{LiteralError, parse_scalar};
use crate::source::Span;
use crate::table::type_table::{Entry, is_number};
use crate::value::Value;

/// The largest exponent of a power of 2 in a value.
const MAX_SHIFT: i128 = 62;

/// Characters that occur in numbers and expressions, but not in names that start with a digit.
const OPERATORS: &str = "<>*^|&~(),_×−²³¹⁰⁴⁵⁶⁷⁸⁹⁻";

/// The hint for numbers that are not integers of a set.
const HINT: &str = "write an integer, such as `3`, `0x1f` or `1 << 4`; quote the value if it is a string";

/// A value as written.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
enum Written<'e> {
    Integer(i64),
    String(&'e str),
    /// A number that a set can't contain.
    Invalid(&'e str),
}

/// The values of the set `name`. A quoted integer is a string.
pub(super) fn values(
    name: &str,
    entries: &[Entry<'_>],
    span: Span,
    diagnostics: &mut Vec<Diagnostic>,
) -> SetValues {
    let (mut known, mut integers, mut strings) = (BTreeSet::new(), Vec::new(), Vec::new());
    for entry in entries {
        let description = entry.description.to_owned();
        let written = read(entry, diagnostics);
        match written {
            Written::Integer(value) => integers.push(SetValue { value, description }),
            Written::String(value) => strings.push(SetValue { value: value.to_owned(), description }),
            Written::Invalid(_) => {}
        }
        if !known.insert(written) {
            let problem = Problem::DuplicateValue { value: entry.value.to_owned() };
            diagnostics.push(Diagnostic::new(problem, entry.span));
        }
    }
    if !integers.is_empty() && !strings.is_empty() {
        diagnostics.push(Diagnostic::new(Problem::MixedSet { name: name.to_owned() }, span));
    }
    if integers.is_empty() { SetValues::Strings(strings) } else { SetValues::Integers(integers) }
}

fn read<'e>(entry: &Entry<'e>, diagnostics: &mut Vec<Diagnostic>) -> Written<'e> {
    let text = entry.value;
    if let Some(quoted) = text.strip_prefix('"').and_then(|text| text.strip_suffix('"')) {
        return Written::String(quoted);
    }
    let value = match text.split_once("<<") {
        Some((base, shift)) => shifted(base.trim(), shift.trim()),
        None => parse_scalar(text, Scalar::Int64),
    };
    let text_of_problem = text.to_owned();
    let type_name = "integer".to_owned();
    let problem = match value {
        Ok(value) => match value.as_int().and_then(|value| i64::try_from(value).ok()) {
            Some(value) => return Written::Integer(value),
            None => Problem::InvalidLiteral { text: text_of_problem, type_name },
        },
        Err(LiteralError::Range { min, max }) => {
            Problem::ConstantOutOfRange { text: text_of_problem, type_name, min, max }
        }
        Err(LiteralError::Form) if is_numeric(text) => {
            Problem::InvalidLiteral { text: text_of_problem, type_name }
        }
        Err(LiteralError::Form) => return Written::String(text),
    };
    diagnostics.push(Diagnostic::new(problem, entry.span).with_hint(HINT));
    Written::Invalid(text)
}

/// The value of `base << shift`.
fn shifted(base: &str, shift: &str) -> Result<Value, LiteralError> {
    let integer = |text| parse_scalar(text, Scalar::Int64)?.as_int().ok_or(LiteralError::Form);
    let (base, shift) = (integer(base)?, integer(shift)?);
    let value = base.checked_mul(1 << shift.clamp(0, MAX_SHIFT + 1)).ok_or(LiteralError::Form)?;
    if shift < 0 {
        return Err(LiteralError::Form);
    }
    parse_scalar(&value.to_string(), Scalar::Int64)
}

/// True if a text is a number or an arithmetic expression rather than a name. Dates, versions and spans, such as `1-5`,
/// are names.
fn is_numeric(text: &str) -> bool {
    let unsigned = text.trim_start_matches(['+', '-', '\u{2212}', '(', '~', ' ']);
    let is_based = ["0x", "0X", "0b", "0B", "0o", "0O"].iter().any(|base| unsigned.starts_with(base));
    let is_operator = |c: char| OPERATORS.contains(c);
    let is_part =
        |c: char| c.is_ascii_hexdigit() || is_operator(c) || matches!(c, 'x' | 'X' | '.' | '-' | ' ' | '+');
    is_number(text)
        || unsigned.starts_with(|c: char| c.is_ascii_digit())
            && (is_based || text.len() > unsigned.len() || text.contains(is_operator))
            && text.chars().all(is_part)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(values: &[&str]) -> (SetValues, Vec<&'static str>) {
        let entries: Vec<Entry<'_>> =
            values.iter().map(|value| Entry { value, span: Span::default(), description: "" }).collect();
        let mut diagnostics = Vec::new();
        let found = super::values("Flag", &entries, Span::default(), &mut diagnostics);
        (found, diagnostics.iter().map(|diagnostic| diagnostic.problem.code()).collect())
    }

    #[test]
    fn integers_may_have_a_base_or_a_shift() {
        for (text, expected) in [
            ("3", 3),
            ("-1", -1),
            ("+7", 7),
            ("0x1F", 31),
            ("-0x10", -16),
            ("0b101", 5),
            ("0o17", 15),
            ("1_000", 1_000),
            ("1 << 4", 16),
            ("0x3<<2", 12),
            ("1 << 62", 1 << 62),
            ("9223372036854775807", i64::MAX),
            ("-9223372036854775808", i64::MIN),
        ] {
            let (found, codes) = set(&[text]);
            let value = SetValue { value: expected, description: String::new() };
            assert_eq!((found, codes), (SetValues::Integers(vec![value]), vec![]), "{text}");
        }
    }

    #[test]
    fn other_numbers_are_errors() {
        for text in [
            "0.5",
            "1.0",
            "1e3",
            "-0.5",
            ".5",
            "2^3",
            "2**3",
            "2\u{2076}\u{b3}",
            "1 << -1",
            "1 << 0.5",
            "1,000",
            "0x",
            "1 | 2",
            "(1)",
            "~1",
            "\u{2212}1",
            "1__0",
            "4 >> 1",
            "1 <<",
        ] {
            assert_eq!(set(&[text]).1, ["invalid-literal"], "{text}");
        }
        for text in
            ["9223372036854775808", "-9223372036854775809", "0xffffffffffffffff", "1 << 63", "1 << 200"]
        {
            assert_eq!(set(&[text]).1, ["constant-out-of-range"], "{text}");
        }
    }

    #[test]
    fn names_and_quoted_values_are_strings() {
        for text in [
            "good",
            "3d",
            "2.4GHz",
            "1st",
            "1-5",
            "2026-01-31",
            "1.2.3",
            "16-bit",
            "<none>",
            "a << b",
            "inf",
            "0",
            "1.5",
        ] {
            let quoted = format!("\"{text}\"");
            let written = if matches!(text, "0" | "1.5") { quoted.as_str() } else { text };
            let value = SetValue { value: text.to_owned(), description: String::new() };
            assert_eq!(set(&[written]), (SetValues::Strings(vec![value]), vec![]), "{written}");
        }
    }

    #[test]
    fn equal_values_and_mixed_kinds_are_errors() {
        assert_eq!(set(&["1", "0x1", "1 << 0"]).1, ["duplicate-value", "duplicate-value"]);
        assert_eq!(set(&["a", "\"a\""]).1, ["duplicate-value"]);
        assert_eq!(set(&["1", "\"1\""]).1, ["mixed-set"]);
        assert_eq!(set(&["0x1", "0.5"]).1, ["invalid-literal"]);
    }
}
