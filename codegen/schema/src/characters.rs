//! Characters that are not allowed in definitions and pages, because they end lines in other tools or hide text. Outputs
//! don't contain them either.

use crate::diagnostic::{Diagnostic, Problem};
use crate::span::Span;

/// True for bidirectional controls and zero-width characters (Unicode 15, UAX #9 and general category Cf). U+200C and
/// U+200D are allowed: some scripts need them to join letters.
fn is_invisible(character: char) -> bool {
    matches!(character,
        '\u{061c}' | '\u{200b}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}'
        | '\u{2060}'..='\u{2069}' | '\u{feff}' | '\u{e0000}'..='\u{e007f}')
}

/// True for characters that outputs replace: control characters, line and paragraph separators, invisible characters,
/// and characters that change the direction of text. Invisible and directional characters have the property
/// `Default_Ignorable_Code_Point` or the general category Cf (Unicode 15). Joiners and variation selectors are allowed,
/// because scripts and emoji need them.
pub fn is_hidden(character: char) -> bool {
    if matches!(character, ' '..='~') {
        return false;
    }
    character.is_control()
        || is_invisible(character)
        || matches!(character,
            '\u{ad}' | '\u{34f}' | '\u{115f}' | '\u{1160}' | '\u{17b4}' | '\u{17b5}' | '\u{180b}'..='\u{180f}'
            | '\u{2028}' | '\u{2029}' | '\u{206a}'..='\u{206f}' | '\u{3164}' | '\u{fdd0}'..='\u{fdef}' | '\u{ffa0}'
            | '\u{fff0}'..='\u{fffb}' | '\u{1bca0}'..='\u{1bca3}' | '\u{1d173}'..='\u{1d17a}'
            | '\u{e0000}'..='\u{e0fff}')
        // Noncharacters, which XML forbids.
        || u32::from(character) & 0xfffe == 0xfffe
}

/// The name of a character that other tools treat as the end of a line.
fn line_separator(character: char) -> Option<&'static str> {
    match character {
        '\r' => Some("a carriage return"),
        '\u{0b}' => Some("a vertical tab"),
        '\u{0c}' => Some("a form feed"),
        '\u{1c}'..='\u{1e}' => Some("an information separator"),
        '\u{85}' => Some("a next-line character (U+0085)"),
        '\u{2028}' => Some("a line separator (U+2028)"),
        '\u{2029}' => Some("a paragraph separator (U+2029)"),
        _ => None,
    }
}

/// The maximum number of diagnostics per line. A line may contain millions of these characters.
const MAX_PER_LINE: usize = 100;

/// Reports invisible characters in a line of a page. Line separators are allowed in pages.
pub(crate) fn check_invisible(line: &str, span: Span, diagnostics: &mut Vec<Diagnostic>) {
    if line.is_ascii() {
        return;
    }
    let invisible = line.char_indices().filter(|(_, character)| is_invisible(*character));
    for (at, character) in invisible.take(MAX_PER_LINE) {
        let place = span.part(at..at + character.len_utf8());
        diagnostics.push(Diagnostic::new(Problem::InvisibleCharacter { code: character.into() }, place));
    }
}

/// Reports all disallowed characters in a line. A line of plain ASCII and tabs requires only a single pass over its
/// bytes.
pub(crate) fn check(line: &str, span: Span, diagnostics: &mut Vec<Diagnostic>) {
    if line.bytes().all(|byte| matches!(byte, b'\t' | b' '..=b'~')) {
        return;
    }
    let first = diagnostics.len();
    for (at, character) in line.char_indices() {
        if diagnostics.len() - first >= MAX_PER_LINE {
            return;
        }
        let place = span.part(at..at + character.len_utf8());
        let code = u32::from(character);
        if let Some(name) = line_separator(character) {
            diagnostics.push(Diagnostic::new(Problem::LineSeparator { name }, place));
        } else if is_invisible(character) {
            diagnostics.push(Diagnostic::new(Problem::InvisibleCharacter { code }, place));
        } else if character.is_control() && character != '\t' {
            diagnostics.push(Diagnostic::new(Problem::ControlCharacter { code }, place));
        }
    }
}
