//! Escapes text for display on one line.

use std::path::Path;

use super::command::Command;
use crate::characters::is_hidden;

/// The maximum length of a displayed text, in characters.
pub const MAX_SHOWN: usize = 1_000;

/// Escapes text for display on one line, and truncates it. Invisible characters, line breaks, direction changes,
/// terminal sequences and commands of CI systems become escapes such as `\u{202e}`.
///
/// ```
/// use uavspec_schema::terminal::shown;
///
/// assert_eq!(shown("a\n::error::b"), r"a\n::error::b");
/// assert_eq!(shown("::error::\u{1b}[31m"), r"::\u{65}rror::\u{1b}[31m");
/// ```
pub fn shown(text: &str) -> String {
    shown_up_to(MAX_SHOWN, text)
}

/// A path for display on one line.
pub fn path(path: impl AsRef<Path>) -> String {
    shown_up_to(usize::MAX, &path.as_ref().to_string_lossy())
}

pub(super) fn shown_up_to(limit: usize, text: &str) -> String {
    let is_plain = |byte| Command::is_plain(byte) && !matches!(byte, b'\t' | b':');
    if text.len() <= limit && text.bytes().all(is_plain) {
        return text.to_owned();
    }
    let mut shown = String::with_capacity(text.len().min(limit));
    let mut command = Command::default();
    for (count, character) in text.chars().enumerate() {
        if count == limit {
            shown.push('…');
            break;
        }
        // Joiners are invisible on their own. Other white space may break lines.
        let is_invisible = is_hidden(character)
            || matches!(character, '\u{200c}' | '\u{200d}')
            || character.is_whitespace() && character != ' ';
        // A text may be wrapped at each space. An escaped line break doesn't start a line.
        if character == ' ' {
            command = Command::default();
        }
        if is_invisible || command.is_completed_by(character) {
            escape(character, &mut shown);
        } else {
            shown.push(character);
        }
    }
    shown
}

pub(super) fn escape(character: char, text: &mut String) {
    match character {
        '\n' | '\r' | '\t' | '\0' => text.extend(character.escape_debug()),
        _ => text.extend(character.escape_unicode()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escapes_control_characters_and_truncates() {
        assert_eq!(
            shown("a\u{1b}[31m\n\"b\" \\ 'c' \u{202e}d é 🛩"),
            "a\\u{1b}[31m\\n\"b\" \\ 'c' \\u{202e}d é 🛩"
        );
        assert_eq!(
            shown("a\u{200d}\u{a0}\u{2028}\u{9b}e\u{301}"),
            "a\\u{200d}\\u{a0}\\u{2028}\\u{9b}e\u{301}"
        );
        let long = "é".repeat(10_000);
        assert_eq!(shown(&long).chars().count(), MAX_SHOWN + 1);
        assert_eq!(shown(""), "");
    }

    #[test]
    fn escapes_commands_of_ci_systems() {
        for (text, expected) in [
            ("::error::x", r"::\u{65}rror::x"),
            (" ::error::x", r" ::\u{65}rror::x"),
            ("a ::error::x", r"a ::\u{65}rror::x"),
            ("a::b", "a::b"),
            (":: error::", ":: error::"),
            (":::error::", ":::error::"),
            ("x ##vso[task.complete]", r"x ##vso\u{5b}task.complete]"),
            ("###[error]", r"###\u{5b}error]"),
            ("#[error]", "#[error]"),
            ("##teamcity[message]", r"##teamcity\u{5b}message]"),
            ("## a [b]", "## a [b]"),
        ] {
            assert_eq!(shown(text), expected);
        }
    }
}
