//! Text of definitions, escaped for Markdown and HTML.

use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};

use crate::characters::is_hidden;

/// Escapes multi-line text, but keeps paragraphs and simple lists.
pub fn block(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len() + 16);
    for (index, line) in text.lines().enumerate() {
        if index > 0 {
            escaped.push('\n');
        }
        let line = line.trim();
        let line = match line.strip_prefix("- ").or_else(|| line.strip_prefix("* ")) {
            Some(item) => {
                escaped.push_str("- ");
                item.trim_start()
            }
            None => line,
        };
        escape(line, &mut escaped);
    }
    escaped
}

/// Escapes text and puts it on one line, for table cells.
pub fn inline(text: &str) -> String {
    let lines: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    let mut escaped = String::with_capacity(text.len() + 16);
    escape(&lines.join(" "), &mut escaped);
    escaped
}

/// Formats a name or value as code.
pub fn code(text: &str) -> String {
    let text: String =
        text.chars().map(|c| if matches!(c, '`' | '\n') { '\'' } else { visible(c) }).collect();
    format!("`{text}`")
}

/// Escapes text and attribute values for XML and HTML.
pub fn xml(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            _ => escaped.push(visible(character)),
        }
    }
    escaped
}

/// The characters of paths that are encoded in URLs.
const ENCODED: &AsciiSet = &NON_ALPHANUMERIC.remove(b'-').remove(b'.').remove(b'_').remove(b'~').remove(b'/');

/// Encodes a path or fragment for a URL.
pub fn percent_encoded(text: &str) -> String {
    utf8_percent_encode(text, ENCODED).to_string()
}

/// The first sentence of the text, truncated to `limit` characters.
pub fn gist(text: &str, limit: usize) -> String {
    let sentence = &text[..sentence_end(text)];
    let Some((cut, _)) = sentence.char_indices().nth(limit) else { return sentence.to_owned() };
    let end = sentence[..cut].rfind(char::is_whitespace).unwrap_or(cut);
    format!("{} …", sentence[..end].trim_end())
}

/// The end of the first sentence: before white space followed by a capital letter, or at an empty line.
fn sentence_end(text: &str) -> usize {
    let paragraph = text.find("\n\n").unwrap_or(text.len());
    let mut ends = text[..paragraph].match_indices(['.', '!', '?']).map(|(at, _)| at);
    let is_end = |at: &usize| {
        let rest = &text[at + 1..paragraph];
        let next = rest.trim_start();
        next.len() < rest.len() && next.starts_with(char::is_uppercase) && !is_abbreviated(&text[..*at])
    };
    ends.find(is_end).map_or(paragraph, |at| at + 1)
}

/// True if the text ends with an abbreviation such as `e.g`, whose full stop doesn't end a sentence.
fn is_abbreviated(text: &str) -> bool {
    let word = text.rsplit(char::is_whitespace).next().unwrap_or_default().trim_start_matches(['(', '[']);
    word.contains('.') || matches!(word, "cf" | "etc" | "vs")
}

fn escape(line: &str, out: &mut String) {
    let mut rest = line;
    let mut previous = ' ';
    // No URL starts before this position.
    let mut searched = 0;
    while let Some(character) = rest.chars().next() {
        let at = line.len() - rest.len();
        if at >= searched && !previous.is_alphanumeric() {
            match address(rest) {
                Ok(address) => {
                    // Enclose a bare URL, because it causes a warning in rustdoc.
                    out.push('<');
                    out.push_str(address);
                    out.push('>');
                    rest = &rest[address.len()..];
                    previous = '>';
                    continue;
                }
                Err(len) => searched = at + len,
            }
        }
        let next = rest[character.len_utf8()..].chars().next().unwrap_or(' ');
        let is_at_start = rest.len() == line.len();
        if needs_escape(character, previous, next, is_at_start) || is_ordinal_mark(line, rest, character) {
            out.push('\\');
        }
        out.push(visible(character));
        previous = character;
        rest = &rest[character.len_utf8()..];
    }
}

fn needs_escape(character: char, previous: char, next: char, is_at_start: bool) -> bool {
    match character {
        '\\' | '`' | '*' | '[' | ']' | '<' | '>' | '|' | '~' | '$' => true,
        // An underscore within a word has no meaning in Markdown, and most names contain one.
        '_' => !(previous.is_alphanumeric() && next.is_alphanumeric()),
        '&' => next == '#' || next.is_alphabetic(),
        '#' | '+' | '-' | '=' => is_at_start,
        _ => false,
    }
}

/// True for a `.` or `)` that would start a list because it follows a number at the start of a line.
fn is_ordinal_mark(line: &str, rest: &str, character: char) -> bool {
    let before = &line[..line.len() - rest.len()];
    matches!(character, '.' | ')') && !before.is_empty() && before.bytes().all(|byte| byte.is_ascii_digit())
}

/// The URL at the start of `text`. If there is none, the error is a number of bytes: no URL starts in these first bytes
/// of `text`.
fn address(text: &str) -> Result<&str, usize> {
    if !text.starts_with("http://") && !text.starts_with("https://") {
        return Err(0);
    }
    let end = text
        .find(|c: char| c.is_whitespace() || matches!(c, '<' | '>' | '"' | '`' | '|' | '\\'))
        .unwrap_or(text.len());
    let address = text[..end].trim_end_matches(['.', ',', ';', ':', '!', '?', ')', ']', '\'']);
    match address.bytes().rposition(|byte| !byte.is_ascii_graphic()) {
        // Each URL that starts before this byte contains it.
        Some(last) => Err(last + 1),
        None if address.len() > "https://".len() => Ok(address),
        None => Err(0),
    }
}

/// Replaces hidden characters, which could disguise text, with U+FFFD, and a tab with a space.
pub fn visible(character: char) -> char {
    match character {
        '\t' => ' ',
        _ if is_hidden(character) => char::REPLACEMENT_CHARACTER,
        _ => character,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn replaces_control_characters_in_code() {
        assert_eq!(code("a`b\nc\0d\u{1}e"), "`a'b'c\u{fffd}d\u{fffd}e`");
    }

    #[test]
    fn gist_is_the_first_sentence() {
        assert_eq!(gist("One (e.g. This). Two.", 99), "One (e.g. This).");
        assert_eq!(gist("Version 2.10 of it", 99), "Version 2.10 of it");
        assert_eq!(gist("One\n\nTwo", 99), "One");
        assert_eq!(gist("Many words in one", 9), "Many …");
        assert_eq!(gist("", 9), "");
    }

    #[test]
    fn markup_is_escaped() {
        assert_eq!(inline("[x] a|b <b> *c* `d` e_f _g_"), r"\[x\] a\|b \<b\> \*c\* \`d\` e_f \_g\_");
        assert_eq!(inline("# no heading\n1. no list"), r"\# no heading 1. no list");
        assert_eq!(block("1. no list\n+ nor this\n- but this"), "1\\. no list\n\\+ nor this\n- but this");
        assert_eq!(inline("a\u{202e}b\u{7}"), "a\u{fffd}b\u{fffd}");
        assert_eq!(inline("&amp; & b"), r"\&amp; & b");
    }

    #[test]
    fn urls_become_links() {
        assert_eq!(inline("see http://x.org/a_b."), "see <http://x.org/a_b>.");
        assert_eq!(inline("(https://x.org)"), "(<https://x.org>)");
        assert_eq!(inline("http://é/http://x.org"), "http://é/<http://x.org>");
        assert_eq!(inline("http:// xhttp://x.org"), "http:// xhttp://x.org");
    }

    #[test]
    fn urls_with_non_ascii_characters_stay_text() {
        let text = "http://".repeat(100_000) + "é";
        assert_eq!(inline(&text), text);
    }
}
