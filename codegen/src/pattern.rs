//! Checks that all JSON Schema validators interpret a regular expression in the same way, and finds example strings
//! that match it.

use regex_syntax::ParserBuilder;
use regex_syntax::hir::{Class, Hir, HirKind};

/// Syntax that is supported only by Rust's dialect, or only by the ECMA-262 dialect, which JSON Schema uses.
const FOREIGN: [&str; 11] = ["(?", "\\A", "\\z", "\\Z", "\\x{", "\\p", "\\P", "[:", "&&", "--", "~~"];

/// The maximum length of an example.
const MAX_EXAMPLE_LEN: usize = 1_000;

/// True if all dialects interpret the regular expression in the same way.
pub(crate) fn is_known(pattern: &str) -> bool {
    let plain = pattern.replace("(?:", "(");
    FOREIGN.iter().all(|foreign| !plain.contains(foreign)) && parse(pattern).is_some()
}

/// True if a part of the text matches the regular expression.
pub(crate) fn is_match(pattern: &str, text: &str) -> bool {
    regex_lite::Regex::new(pattern).is_ok_and(|regex| regex.is_match(text))
}

/// A short text that matches a regular expression, or `None` if no such text is found.
pub(crate) fn example(pattern: &str) -> Option<String> {
    let mut text = String::new();
    append(&parse(pattern)?, &mut text)?;
    is_match(pattern, &text).then_some(text)
}

/// Parses a regular expression, with ASCII-only classes as in ECMA-262: `\d` matches only ASCII digits.
fn parse(pattern: &str) -> Option<Hir> {
    ParserBuilder::new().unicode(false).utf8(false).build().parse(pattern).ok()
}

fn append(hir: &Hir, text: &mut String) -> Option<()> {
    match hir.kind() {
        HirKind::Empty | HirKind::Look(_) => {}
        HirKind::Literal(literal) => text.push_str(std::str::from_utf8(&literal.0).ok()?),
        HirKind::Class(class) => text.push(character(class)?),
        HirKind::Repetition(repetition) => {
            for _ in 0..repetition.min {
                append(&repetition.sub, text)?;
            }
        }
        HirKind::Capture(capture) => append(&capture.sub, text)?,
        HirKind::Concat(parts) => parts.iter().try_for_each(|part| append(part, text))?,
        HirKind::Alternation(parts) => append(parts.first()?, text)?,
    }
    (text.len() <= MAX_EXAMPLE_LEN).then_some(())
}

/// A letter or digit if the class contains one, otherwise another visible character in the class, or a space.
fn character(class: &Class) -> Option<char> {
    let Class::Bytes(class) = class else { return None };
    let contains =
        |byte: u8| class.ranges().iter().any(|range| (range.start()..=range.end()).contains(&byte));
    let mut letters = (b'a'..=b'z').chain(b'A'..=b'Z').chain(b'0'..=b'9');
    let found = letters
        .find(|byte| contains(*byte))
        .or_else(|| (b'!'..=b'~').chain([b' ']).find(|byte| contains(*byte)));
    found.map(char::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn examples_satisfy_their_pattern() {
        for (pattern, expected) in [
            ("^[^/]+$", "a"),
            ("^[A-Z]{2,8}-[A-Z]{2,8}$", "AA-AA"),
            (r"^\d+(\.\d+){0,2}$", "0"),
            ("glider", "glider"),
            ("^(north|south)$", "north"),
            ("", ""),
        ] {
            assert!(is_known(pattern), "{pattern}");
            assert_eq!(example(pattern).as_deref(), Some(expected), "{pattern}");
        }
    }

    #[test]
    fn rejects_syntax_that_dialects_interpret_differently() {
        for pattern in ["(?i)a", r"\Aa", r"\p{L}", "[[:alpha:]]", "(", "[a&&b]", "a{2", r"(?<n>a)"] {
            assert!(!is_known(pattern), "{pattern}");
        }
        assert!(is_known("(?:a|b)c"));
    }
}
