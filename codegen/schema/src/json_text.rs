//! JSON for terminals, logs and files.
//!
//! JSON may contain any character, but a terminal or a CI system may act on some of them. They are written as escapes
//! such as `\u202e`, so readers of the JSON get the original text.

use std::io::{self, Write};

use serde::Serialize;
use serde_json::ser::{CharEscape, CompactFormatter, Formatter, PrettyFormatter, Serializer};

use crate::characters::is_hidden;
use crate::terminal::Command;

/// Formats a value on several lines, with a final line break.
pub fn pretty(value: &(impl Serialize + ?Sized)) -> String {
    text(|to| write_pretty(value, to))
}

/// Writes a value on several lines, with a final line break. Fails for a value whose keys aren't strings.
pub fn write_pretty(value: &(impl Serialize + ?Sized), to: &mut dyn Write) -> io::Result<()> {
    value.serialize(&mut Serializer::with_formatter(&mut *to, Escaping(PrettyFormatter::new())))?;
    writeln!(to)
}

/// Formats a value on one line.
pub fn compact(value: &(impl Serialize + ?Sized)) -> String {
    text(|to| Ok(value.serialize(&mut Serializer::with_formatter(to, Escaping(CompactFormatter)))?))
}

/// The written text; empty for a value whose keys aren't strings. Writing to memory can't fail.
fn text(write: impl FnOnce(&mut Vec<u8>) -> io::Result<()>) -> String {
    let mut text = Vec::new();
    write(&mut text).map_or_else(|_| String::new(), |()| String::from_utf8(text).unwrap_or_default())
}

/// Escapes hidden characters and commands in strings.
struct Escaping<F>(F);

impl<F: Formatter> Formatter for Escaping<F> {
    fn write_string_fragment<W: Write + ?Sized>(&mut self, to: &mut W, text: &str) -> io::Result<()> {
        // A quotation mark precedes.
        let mut command = Command::Text;
        let mut start = 0;
        for (at, character) in text.char_indices() {
            let is_invisible = is_hidden(character) || matches!(character, '\u{200c}' | '\u{200d}');
            if is_invisible || command.is_completed_by(character) {
                self.0.write_string_fragment(to, &text[start..at])?;
                for unit in character.encode_utf16(&mut [0; 2]) {
                    write!(to, "\\u{unit:04x}")?;
                }
                start = at + character.len_utf8();
            }
        }
        self.0.write_string_fragment(to, &text[start..])
    }

    fn write_char_escape<W: Write + ?Sized>(&mut self, to: &mut W, escape: CharEscape) -> io::Result<()> {
        self.0.write_char_escape(to, escape)
    }

    fn begin_array<W: Write + ?Sized>(&mut self, to: &mut W) -> io::Result<()> {
        self.0.begin_array(to)
    }

    fn end_array<W: Write + ?Sized>(&mut self, to: &mut W) -> io::Result<()> {
        self.0.end_array(to)
    }

    fn begin_array_value<W: Write + ?Sized>(&mut self, to: &mut W, is_first: bool) -> io::Result<()> {
        self.0.begin_array_value(to, is_first)
    }

    fn end_array_value<W: Write + ?Sized>(&mut self, to: &mut W) -> io::Result<()> {
        self.0.end_array_value(to)
    }

    fn begin_object<W: Write + ?Sized>(&mut self, to: &mut W) -> io::Result<()> {
        self.0.begin_object(to)
    }

    fn end_object<W: Write + ?Sized>(&mut self, to: &mut W) -> io::Result<()> {
        self.0.end_object(to)
    }

    fn begin_object_key<W: Write + ?Sized>(&mut self, to: &mut W, is_first: bool) -> io::Result<()> {
        self.0.begin_object_key(to, is_first)
    }

    fn begin_object_value<W: Write + ?Sized>(&mut self, to: &mut W) -> io::Result<()> {
        self.0.begin_object_value(to)
    }

    fn end_object_value<W: Write + ?Sized>(&mut self, to: &mut W) -> io::Result<()> {
        self.0.end_object_value(to)
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
