//! The last defence of a whole output.

use std::borrow::Cow;
use std::io::{self, Write};
use std::mem;

use super::command::Command;
use super::shown::escape;
use crate::characters::is_hidden;

/// The start of a terminal sequence.
pub(super) const ESCAPE: char = '\u{1b}';

/// The maximum length of a style's sequence, in bytes. The longest style sets two colours and all effects.
const MAX_STYLE_LEN: usize = 64;

/// Escapes hidden characters and commands of CI systems in an output with several lines and without colours.
pub fn guarded(text: &str) -> Cow<'_, str> {
    let mut command = Command::default();
    let first = text.char_indices().find(|(_, character)| must_escape(*character, &mut command));
    let Some((at, _)) = first else { return Cow::Borrowed(text) };
    let mut guarded = String::with_capacity(text.len() + 16);
    guarded.push_str(&text[..at]);
    let mut command = Command::default();
    // Preceding characters determine which of the following characters start a command.
    text[..at].chars().for_each(|character| _ = must_escape(character, &mut command));
    text[at..].chars().for_each(|character| put(character, &mut command, &mut guarded));
    Cow::Owned(guarded)
}

fn must_escape(character: char, command: &mut Command) -> bool {
    command.is_completed_by(character) || is_hidden(character) && !matches!(character, '\n' | '\t')
}

fn put(character: char, command: &mut Command, text: &mut String) {
    if must_escape(character, command) {
        escape(character, text);
    } else {
        text.push(character);
    }
}

/// Passes on lines, tabs, colours and text effects. Escapes other control characters, invisible characters and commands
/// of CI systems.
#[derive(Debug, Default)]
struct Filter {
    command: Command,
    /// A terminal sequence that may set a style.
    style: String,
}

impl Filter {
    fn push_all(&mut self, mut rest: &str, text: &mut String) {
        while let Some(character) = rest.chars().next() {
            // Most characters are in parts that need no escapes.
            let length = match self.command {
                Command::Text if self.style.is_empty() => {
                    rest.bytes().take_while(|byte| Command::is_plain(*byte)).count()
                }
                _ => 0,
            };
            if length == 0 {
                self.push(character, text);
                rest = &rest[character.len_utf8()..];
            } else {
                text.push_str(&rest[..length]);
                rest = &rest[length..];
            }
        }
    }

    fn push(&mut self, character: char, text: &mut String) {
        match (self.style.len(), character) {
            (0, ESCAPE) | (1, '[') | (2..MAX_STYLE_LEN, '0'..='9' | ';' | ':') => self.style.push(character),
            (0, _) => put(character, &mut self.command, text),
            (2.., 'm') => {
                text.push_str(&mem::take(&mut self.style));
                text.push(character);
            }
            _ => {
                for character in mem::take(&mut self.style).chars() {
                    put(character, &mut self.command, text);
                }
                self.push(character, text);
            }
        }
    }
}

/// A writer that passes on lines, tabs, colours and text effects. It escapes other control characters, invisible
/// characters and commands of CI systems.
#[derive(Debug)]
pub struct Guard<W> {
    to: W,
    filter: Filter,
    /// The start of a character whose other bytes are in the next buffer.
    incomplete: Vec<u8>,
}

impl<W> Guard<W> {
    /// Creates a guard for a writer.
    pub fn new(to: W) -> Self {
        Self { to, filter: Filter::default(), incomplete: Vec::new() }
    }

    /// Escapes bytes. Invalid UTF-8 becomes U+FFFD.
    fn escaped(&mut self, bytes: &[u8]) -> String {
        let mut text = String::with_capacity(bytes.len() + 16);
        let joined;
        let mut rest = bytes;
        if !self.incomplete.is_empty() {
            joined = [mem::take(&mut self.incomplete).as_slice(), bytes].concat();
            rest = &joined;
        }
        while !rest.is_empty() {
            let (valid, invalid) = match std::str::from_utf8(rest) {
                Ok(valid) => (valid, None),
                // The bytes up to here are valid, so nothing is lost.
                Err(error) => {
                    (std::str::from_utf8(&rest[..error.valid_up_to()]).unwrap_or_default(), Some(error))
                }
            };
            self.filter.push_all(valid, &mut text);
            rest = &rest[valid.len()..];
            match invalid.map(|error| error.error_len()) {
                None => break,
                Some(None) => {
                    self.incomplete = rest.to_vec();
                    break;
                }
                Some(Some(length)) => {
                    self.filter.push(char::REPLACEMENT_CHARACTER, &mut text);
                    rest = &rest[length..];
                }
            }
        }
        text
    }
}

impl<W: Write> Write for Guard<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let text = self.escaped(bytes);
        self.to.write_all(text.as_bytes())?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn written(parts: &[&[u8]]) -> String {
        let mut guard = Guard::new(Vec::new());
        for part in parts {
            guard.write_all(part).expect("written");
        }
        String::from_utf8(guard.to).expect("UTF-8")
    }

    #[test]
    fn passes_lines_and_styles_but_escapes_the_rest() {
        let text = "a\tb\n\u{1b}[1m\u{1b}[31mred\u{1b}[0m é";
        assert_eq!(written(&[text.as_bytes()]), text);
        assert_eq!(written(&[b"a\x1b]0;title\x07b"]), r"a\u{1b}]0;title\u{7}b");
        assert_eq!(written(&[b"\x1b[2J\x1b\x1b[mx"]), "\\u{1b}[2J\\u{1b}\u{1b}[mx");
        assert_eq!(written(&["a\r\u{9b}31m\u{202e}\u{2028}".as_bytes()]), r"a\r\u{9b}31m\u{202e}\u{2028}");
        let long = format!("\u{1b}[{}m", "1;".repeat(100));
        assert!(written(&[long.as_bytes()]).starts_with(r"\u{1b}[1;"));
    }

    #[test]
    fn escapes_commands_at_the_start_of_each_line() {
        assert_eq!(written(&[b"a ::x\n::error::y\n  ::z::"]), "a ::x\n::\\u{65}rror::y\n  ::\\u{7a}::");
        // Terminals ignore styles when they print text, and some CI systems remove styles.
        assert_eq!(written(&[b"\x1b[1m::error::y"]), "\u{1b}[1m::\\u{65}rror::y");
        let second_place = "  ::: b.msg:2:1\n";
        assert_eq!(written(&[second_place.as_bytes()]), second_place);
        assert_eq!(written(&[b"a ##v", b"so[x"]), r"a ##vso\u{5b}x");
    }

    #[test]
    fn joins_characters_and_styles_across_writes() {
        let text = "é🛩\u{1b}[31mx";
        let parts: Vec<&[u8]> = text.as_bytes().chunks(1).collect();
        assert_eq!(written(&parts), text);
        assert_eq!(written(&[b"a\xffb\xf0\x9f", b"c"]), "a\u{fffd}b\u{fffd}c");
    }

    proptest! {
        #[test]
        fn is_the_same_for_each_character_and_for_all_at_once(text in "([a-c:#\\[ \t\n\u{1b}m1é\u{7}]|vso){0,40}") {
            let characters: Vec<String> = text.chars().map(String::from).collect();
            let parts: Vec<&[u8]> = characters.iter().map(String::as_bytes).collect();
            prop_assert_eq!(written(&parts), written(&[text.as_bytes()]));
            if !text.contains(ESCAPE) {
                prop_assert_eq!(written(&[text.as_bytes()]), guarded(&text));
            }
        }
    }

    #[test]
    fn guards_documents() {
        assert!(matches!(guarded("a\n  b: c"), Cow::Borrowed(_)));
        assert_eq!(guarded("a\n::b\u{1b}[1m\n##[x"), "a\n::\\u{62}\\u{1b}[1m\n##\\u{5b}x");
        assert_eq!(guarded("::b"), r"::\u{62}");
    }
}
