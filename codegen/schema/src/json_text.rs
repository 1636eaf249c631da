//! JSON for terminals, logs and files.
//!
//! JSON may contain any character, but a terminal or a CI system may act on some of them. These characters are written
//! as escapes such as `\u202e`, so readers of the JSON get the original text.

use std::io::{self, Write};

use serde::Serialize;

use crate::characters::is_hidden;
use crate::terminal::Command;

/// Formats a value on several lines, with a final line break.
pub fn pretty(value: &(impl Serialize + ?Sized)) -> String {
    text(|to| write_pretty(value, to))
}

/// Writes a value on several lines, with a final line break. Fails for a value whose keys aren't strings.
#[allow(clippy::disallowed_methods, reason = "the replacement")]
pub fn write_pretty(value: &(impl Serialize + ?Sized), to: &mut dyn Write) -> io::Result<()> {
    serde_json::to_writer_pretty(Escaping(&mut *to), value)?;
    writeln!(to)
}

/// Formats a value on one line.
pub fn compact(value: &(impl Serialize + ?Sized)) -> String {
    text(|to| Ok(serde_json::to_writer(Escaping(to), value)?))
}

/// The text that `write` writes. Empty for a value whose keys aren't strings. Writing to memory
/// can't fail.
fn text(write: impl FnOnce(&mut Vec<u8>) -> io::Result<()>) -> String {
    let mut text = Vec::new();
    write(&mut text).map_or_else(|_| String::new(), |()| String::from_utf8(text).unwrap_or_default())
}

/// Escapes hidden characters and commands in the parts of JSON that the serializer writes.
struct Escaping<W>(W);

impl<W: Write> Write for Escaping<W> {
    fn write(&mut self, part: &[u8]) -> io::Result<usize> {
        // The serializer never splits a character, so this can't fail.
        let text = str::from_utf8(part).map_err(io::Error::other)?;
        // In a string, a quotation mark precedes the text, so the text doesn't start a line.
        let mut command = Command::Text;
        let mut start = 0;
        for (at, character) in text.char_indices() {
            let is_invisible = is_hidden(character) || matches!(character, '\u{200c}' | '\u{200d}');
            // Keep line breaks: they are between values, because line breaks in strings are already
            // escaped.
            if character != '\n' && (is_invisible || command.is_completed_by(character)) {
                self.0.write_all(&part[start..at])?;
                for unit in character.encode_utf16(&mut [0; 2]) {
                    write!(self.0, "\\u{unit:04x}")?;
                }
                start = at + character.len_utf8();
            }
        }
        self.0.write_all(&part[start..])?;
        Ok(part.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    #[test]
    fn escapes_hidden_characters_without_loss() {
        let value =
            json!({ "a\u{202e}": ["\u{1b}[1m\u{9b}\u{2028}\u{e0041}\u{200d}##vso[x", "é\n\"\\🛩"], "b": {} });
        for text in [pretty(&value), compact(&value)] {
            assert!(!text.contains(['\u{202e}', '\u{9b}', '\u{2028}', '\u{e0041}', '\u{200d}']), "{text}");
            assert!(
                text.contains(r"\udb40\udc41\u200d##vso\u005bx") && text.contains("é\\n\\\"\\\\🛩"),
                "{text}"
            );
            assert_eq!(serde_json::from_str::<Value>(&text).expect("JSON"), value);
        }
    }

    #[test]
    fn has_the_layout_of_serde_json() {
        let value = json!({ "a": [1, {}, [], { "b": null }], "c": "::d" });
        assert_eq!(pretty(&value), serde_json::to_string_pretty(&value).expect("JSON") + "\n");
        assert_eq!(compact(&value), value.to_string());
    }
}
