//! Checks that all JSON Schema validators interpret a regular expression in the same way, and finds example strings
//! that match it.

use regex_syntax::ParserBuilder;
use regex_syntax::hir::{Class, Hir, HirKind};

/// Characters that may follow a backslash, in addition to `\xHH` and `\uHHHH`. JSON Schema validators set the flag `u`
/// of ECMA-262. With this flag, other escapes are errors, or have a different meaning than in Rust.
const ESCAPED: &str = "^$\\.*+?()[]{}|/dDwWfnrtv";

/// Escapes for word boundaries, which can't be part of a class.
const BOUNDARIES: &str = "bB";

/// The maximum length of an example.
const MAX_EXAMPLE_LEN: usize = 1_000;

/// True if all dialects interpret the regular expression in the same way.
///
/// `.` is accepted as an exception, because patterns often contain it. In Rust, `.` matches all characters except `\n`.
/// In ECMA-262, `.` doesn't match `\r`, U+2028 and U+2029 either.
pub(crate) fn is_known(pattern: &str) -> bool {
    is_shared(pattern) && parse(pattern).is_some()
}

/// True if the regular expression contains only syntax of both Rust's dialect and the ECMA-262 dialect, which JSON Schema
/// uses.
fn is_shared(pattern: &str) -> bool {
    let mut rest = pattern;
    let mut can_repeat = false;
    while let Some(character) = rest.chars().next() {
        let after = &rest[character.len_utf8()..];
        let end = match character {
            '\\' => after_escape(after, BOUNDARIES),
            '[' => after_class(after),
            '(' => Some(after.strip_prefix("?:").unwrap_or(after)),
            '*' | '+' | '?' | '{' if can_repeat => after_quantifier(rest),
            '*' | '+' | '?' | '{' | ']' | '}' => None,
            _ => Some(after),
        };
        let Some(end) = end else { return false };
        let is_boundary = character == '\\' && after.starts_with(['b', 'B']);
        can_repeat = !is_boundary && !matches!(character, '^' | '$' | '(' | '|' | '*' | '+' | '?' | '{');
        rest = end;
    }
    true
}

/// The text after an escape, if the escape is shared. `text` starts after the backslash, and `others` contains further
/// characters that may be escaped.
fn after_escape<'t>(text: &'t str, others: &str) -> Option<&'t str> {
    let character = text.chars().next()?;
    let digits = match character {
        'x' => 2,
        'u' => 4,
        _ if ESCAPED.contains(character) || others.contains(character) => 0,
        _ => return None,
    };
    let rest = &text[character.len_utf8()..];
    let code = rest.get(..digits)?;
    code.bytes().all(|byte| byte.is_ascii_hexdigit()).then(|| &rest[digits..])
}

/// The text after a class, if the class is shared. `text` starts after the opening bracket. Only Rust has nested classes
/// and operators in classes, and only ECMA-262 has empty classes.
fn after_class(text: &str) -> Option<&str> {
    let mut rest = text.strip_prefix('^').unwrap_or(text);
    if rest.starts_with(']') {
        return None;
    }
    loop {
        let character = rest.chars().next()?;
        let after = &rest[character.len_utf8()..];
        rest = match character {
            ']' => return Some(after),
            '\\' => after_escape(after, "-")?,
            '[' => return None,
            '&' | '-' | '~' if after.starts_with(character) => return None,
            _ => after,
        };
    }
}

/// The text after a quantifier, if the quantifier is shared.
fn after_quantifier(text: &str) -> Option<&str> {
    let rest = match text.strip_prefix('{') {
        Some(bounds) => {
            let (bounds, rest) = bounds.split_once('}')?;
            let (min, max) = bounds.split_once(',').unwrap_or((bounds, ""));
            let is_number = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
            (!min.is_empty() && is_number(min) && is_number(max)).then_some(rest)?
        }
        None => text.get(1..)?,
    };
    // A `?` makes the quantifier lazy.
    Some(rest.strip_prefix('?').unwrap_or(rest))
}

/// True if a part of the text matches the regular expression.
pub fn is_match(pattern: &str, text: &str) -> bool {
    regex_lite::Regex::new(pattern).is_ok_and(|regex| regex.is_match(text))
}

/// A short text that matches a regular expression, or `None` if no such text is found.
pub fn example(pattern: &str) -> Option<String> {
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
            (r"^\/[a\-z]+?\x41\u0042$", "/aAB"),
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
        for pattern in [r"a\-b", r"\#", r"\&", r"\~", r"\a", r"\x{41}", r"\x4", "a}", "a]", "[]a]", "[a[b]]"]
        {
            assert!(!is_known(pattern), "{pattern}");
        }
        for pattern in ["a**", "a{2}{3}", "a*?+", "^*", r"\b+", "(*a)", "a|+", "a{,2}"] {
            assert!(!is_known(pattern), "{pattern}");
        }
        for pattern in ["(?:a|b)c", "a--b", "[a-]", "a{2,}?", r"\ba"] {
            assert!(is_known(pattern), "{pattern}");
        }
    }
}
