//! Descriptions, with links to the names that they mention.

use std::ops::Range;

use uavspec_schema::MessageId;
use uavspec_schema::translation::MessageText;

use super::language::{marked, marked_block};
use super::markdown::{code, href, inline, link};
use super::site::{Part, Site};

/// The context of a description.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scope<'p, 's> {
    pub(super) site: &'p Site<'s>,
    /// Path of the page.
    pub(super) from: &'p str,
    /// Index of the package whose names are resolved.
    pub(super) package: usize,
    /// The message whose parts are looked up by name.
    pub(super) message: MessageId,
    /// The part of the message that the description is about. A description doesn't link to the part it describes.
    at: Option<Part>,
}

impl<'p, 's> Scope<'p, 's> {
    /// The scope of texts about a message.
    pub(super) fn of(site: &'p Site<'s>, id: MessageId) -> Self {
        Self::on(site, site.path(id), id)
    }

    /// The scope of texts about a message on the page `from`.
    pub(super) fn on(site: &'p Site<'s>, from: &'p str, id: MessageId) -> Self {
        Self { site, from, package: site.schema.message(id).package, message: id, at: None }
    }

    /// The scope of texts about a part of the message.
    pub(super) fn at(self, part: Part) -> Self {
        Self { at: Some(part), ..self }
    }

    /// A text of the message on one line, for a table cell.
    pub(super) fn inline_of(self, text: MessageText) -> String {
        let text = self.site.localized_of(self.message, text);
        marked(&self.inline(text.text), text.tag)
    }

    /// A text of the message, with its paragraphs and simple lists.
    pub(super) fn block_of(self, text: MessageText) -> String {
        let text = self.site.localized_of(self.message, text);
        marked_block(&self.block(text.text), text.tag)
    }

    /// Formats a description on one line, for a table cell. Paragraphs are separated by line breaks.
    pub(super) fn inline(self, text: &str) -> String {
        let paragraphs: Vec<String> = text.split("\n\n").map(|paragraph| self.line(paragraph)).collect();
        paragraphs.join("<br>")
    }

    /// Formats a description of several lines, with its paragraphs and simple lists.
    pub(super) fn block(self, text: &str) -> String {
        let lines: Vec<String> = text.lines().map(|line| self.line_of_block(line.trim())).collect();
        lines.join("\n")
    }

    fn line_of_block(self, line: &str) -> String {
        match line.strip_prefix("- ").or_else(|| line.strip_prefix("* ")) {
            Some(item) => format!("- {}", self.line(item.trim_start())),
            None => self.line(line),
        }
    }

    fn line(self, text: &str) -> String {
        with_links(text, |_, word| self.target(word))
    }

    /// The link for a word, if it is a name.
    fn target(self, word: &str) -> Option<String> {
        let href = match word.split_once('.') {
            Some((message, part)) => self.part_of(self.other(message)?, part)?,
            None if word.contains('_') => match self.site.part_named(self.message, word) {
                Some(part) if Some(part) == self.at => return None,
                Some(part) => self.site.href(self.from, self.message, part),
                None => self.page(self.other(word)?),
            },
            None if is_compound(word) => self.page(self.other(word)?),
            None => return None,
        };
        Some(link(&code(word), &href))
    }

    /// The message with this name, unless it is the current one.
    fn other(self, name: &str) -> Option<MessageId> {
        self.site.message_named(self.package, name).filter(|id| *id != self.message)
    }

    fn page(self, id: MessageId) -> String {
        href(self.from, self.site.path(id), "")
    }

    fn part_of(self, id: MessageId, name: &str) -> Option<String> {
        let part: Part = self.site.part_named(id, name)?;
        Some(self.site.href(self.from, id, part))
    }
}

/// True if a name can't be an ordinary word. False for names such as `Event`, because a sentence may start with such a
/// word.
pub(super) fn is_compound(name: &str) -> bool {
    let capitals = name.chars().filter(char::is_ascii_uppercase).count();
    capitals > 1 && capitals < name.len()
}

/// Formats a text on one line. `target` receives the previous word and the current word, and may return a link.
pub(super) fn with_links(text: &str, target: impl Fn(&str, &str) -> Option<String>) -> String {
    let mut linked = String::with_capacity(text.len() + 16);
    let mut from = 0;
    let mut previous = "";
    for range in words(text) {
        let word = &text[range.clone()];
        if let Some(link) = target(previous, word) {
            push(&text[from..range.start], &mut linked);
            linked.push_str(&link);
            from = range.end;
        }
        previous = word;
    }
    push(text[from..].trim_end(), &mut linked);
    linked
}

/// Appends part of a text, with its leading and trailing white space.
fn push(piece: &str, to: &mut String) {
    if !to.is_empty() && piece.starts_with(char::is_whitespace) {
        to.push(' ');
    }
    let escaped = inline(piece);
    to.push_str(&escaped);
    if !escaped.is_empty() && piece.ends_with(char::is_whitespace) {
        to.push(' ');
    }
}

/// Ranges of the words, without surrounding punctuation.
fn words(text: &str) -> impl Iterator<Item = Range<usize>> {
    let starts = |at: usize| text[at..].find(|c: char| !c.is_whitespace()).map(|skipped| at + skipped);
    let mut next = 0;
    std::iter::from_fn(move || {
        let start = starts(next)?;
        let end = text[start..].find(char::is_whitespace).map_or(text.len(), |len| start + len);
        next = end;
        let word = &text[start..end];
        let core = word.trim_start_matches(['(', '[', '{', '"', '\'', '`']);
        let start = end - core.len();
        let core = core.trim_end_matches(['.', ',', ';', ':', '!', '?', ')', ']', '}', '"', '\'', '`']);
        Some(start..start + core.len())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_words_and_escapes_the_rest() {
        let target =
            |previous: &str, word: &str| (word == "x" || previous == "code").then(|| format!("<{word}>"));
        assert_eq!(with_links("x", target), "<x>");
        assert_eq!(with_links("a (x), |x| and code 12.", target), r"a (<x>), \|x\| and code <12>.");
        assert_eq!(with_links(" [x]\n x* ", target), r"\[<x>\] x\*");
        assert_eq!(with_links("http://a.org/x x", target), "<http://a.org/x> <x>");
        assert_eq!(with_links("", target), "");
    }

    #[test]
    fn recognizes_compound_names() {
        assert!(is_compound("BatteryStatus"));
        assert!(!is_compound("Event"));
        assert!(!is_compound("GPS"));
    }
}
