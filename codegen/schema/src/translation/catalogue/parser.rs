//! Line-based parser for catalogues.

use std::collections::BTreeSet;

use super::entry::{Catalogue, Entry, Places};
use crate::diagnostic::{Diagnostic, Problem};
use crate::source::{SourceId, SourceMap, Span};

/// Parses a catalogue into its entries, their locations, and the problems found. Unreadable entries are skipped.
pub fn parse(sources: &SourceMap, id: SourceId) -> (Catalogue, Vec<Places>, Vec<Diagnostic>) {
    let mut parser = Parser::default();
    let whole = sources.span(id);
    let mut at = 0;
    for line in sources.text(id).split_inclusive('\n') {
        let text = line.trim();
        let start = at + line.len() - line.trim_start().len();
        parser.line(text, whole.part(start..start + text.len()));
        at += line.len();
    }
    parser.finish()
}

/// The parts of an entry that are strings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    PreviousContext,
    PreviousId,
    Context,
    Id,
    Translation,
}

/// Keywords and the parts that they introduce.
const KEYWORDS: [(&str, Part); 3] =
    [("msgctxt", Part::Context), ("msgid", Part::Id), ("msgstr", Part::Translation)];

#[derive(Default)]
struct Parser {
    catalogue: Catalogue,
    places: Vec<Places>,
    diagnostics: Vec<Diagnostic>,
    entry: Entry,
    place: Places,
    /// The current part, which continues on lines that contain only a string.
    part: Option<Part>,
    /// True if the entry has its `msgid`.
    has_id: bool,
    /// True if the entry has its `msgstr`, which is the last part.
    has_translation: bool,
    /// True if part of the entry is unreadable.
    is_invalid: bool,
    /// The line of the last keyword.
    keyword: Span,
}

impl Parser {
    fn line(&mut self, text: &str, span: Span) {
        if text.is_empty() {
            self.part = None;
            if self.has_translation {
                self.end_entry();
            }
        } else if let Some(rest) = text.strip_prefix("#~|") {
            self.strings(rest, span, true, true);
        } else if let Some(rest) = text.strip_prefix("#~") {
            self.strings(rest, span, true, false);
        } else if let Some(rest) = text.strip_prefix("#|") {
            self.strings(rest, span, false, true);
        } else if text.starts_with('#') {
            self.comment(text);
        } else {
            self.strings(text, span, false, false);
        }
    }

    fn comment(&mut self, text: &str) {
        if self.has_translation {
            self.end_entry();
        }
        self.part = None;
        let entry = &mut self.entry;
        if let Some(note) = text.strip_prefix("#.") {
            entry.notes.push(note.trim().to_owned());
        } else if let Some(reference) = text.strip_prefix("#:") {
            entry.references.push(reference.trim().to_owned());
        } else if let Some(flags) = text.strip_prefix("#,") {
            let flags = flags.split(',').map(str::trim).filter(|flag| !flag.is_empty());
            entry.flags.extend(flags.map(str::to_owned));
        } else {
            entry.comments.push(text.to_owned());
        }
    }

    /// Parses a keyword with a string, or a string alone.
    fn strings(&mut self, text: &str, span: Span, is_obsolete: bool, is_previous: bool) {
        let rest = text.trim_start();
        let word = rest.split(|character: char| character == '"' || character.is_whitespace()).next();
        let word = word.unwrap_or_default();
        let string = rest[word.len()..].trim_start();
        if word.starts_with("msgid_plural") || word.starts_with("msgstr[") {
            let hint = "plural forms are not supported; write one `msgid` and one `msgstr`";
            self.refuse("an entry with plural forms", span, hint);
            self.has_translation |= word.starts_with("msgstr");
            self.part = None;
            return;
        }
        let part = match KEYWORDS.iter().find(|(keyword, _)| *keyword == word) {
            Some((_, Part::Context)) if is_previous => Some(Part::PreviousContext),
            Some((_, Part::Id)) if is_previous => Some(Part::PreviousId),
            Some((_, part)) if !is_previous => Some(*part),
            None if word.is_empty() => self.part,
            _ => None,
        };
        let Some(part) = part else {
            let hint =
                "write `msgctxt`, `msgid` or `msgstr` and a quoted string, or start a comment with `#`";
            return self.refuse("an unrecognized line", span, hint);
        };
        if !word.is_empty() {
            self.begin(part, span, is_obsolete);
        }
        // A part may consist of strings on several lines.
        let place = span.part(span_len(span) - string.len()..span_len(span));
        match unquote(string) {
            Ok(text) => self.add(part, &text, place),
            Err((what, hint)) => self.refuse(what, place, hint),
        }
    }

    fn begin(&mut self, part: Part, span: Span, is_obsolete: bool) {
        let is_next = self.has_translation && part != Part::Translation;
        if is_next {
            self.end_entry();
        }
        let is_out_of_order = match part {
            Part::Translation => !self.has_id || self.has_translation,
            Part::PreviousContext => self.entry.previous_context.is_some() || self.has_id,
            Part::PreviousId => self.entry.previous_id.is_some() || self.has_id,
            Part::Context => self.entry.context.is_some() || self.has_id,
            Part::Id => self.has_id,
        };
        if is_out_of_order {
            let hint = "write `msgctxt`, `msgid` and `msgstr` once each, in this order";
            self.refuse("an entry with its parts out of order", span, hint);
        }
        self.keyword = span;
        self.part = Some(part);
        self.entry.is_obsolete |= is_obsolete;
        match part {
            Part::PreviousContext => self.entry.previous_context = Some(String::new()),
            Part::PreviousId => self.entry.previous_id = Some(String::new()),
            Part::Context => self.entry.context = Some(String::new()),
            Part::Id => self.has_id = true,
            Part::Translation => self.has_translation = true,
        }
    }

    fn add(&mut self, part: Part, text: &str, span: Span) {
        let Self { entry, place, .. } = self;
        let mut unused = span;
        let (string, place) = match part {
            Part::PreviousContext => (entry.previous_context.get_or_insert_default(), &mut unused),
            Part::PreviousId => (entry.previous_id.get_or_insert_default(), &mut unused),
            Part::Context => (entry.context.get_or_insert_default(), &mut place.context),
            Part::Id => (&mut entry.id, &mut place.id),
            Part::Translation => (&mut entry.translation, &mut place.translation),
        };
        string.push_str(text);
        *place = if *place == Span::default() { span } else { place.to(span) };
    }

    fn end_entry(&mut self) {
        let mut entry = std::mem::take(&mut self.entry);
        let mut place = std::mem::take(&mut self.place);
        let is_whole = self.has_id && self.has_translation && !self.is_invalid;
        (self.part, self.has_id, self.has_translation, self.is_invalid) = (None, false, false, false);
        if !is_whole {
            return;
        }
        if entry.context.is_none() {
            place.context = place.id;
        }
        // Remove repeated flags, which merge tools may write.
        let mut known = BTreeSet::new();
        entry.flags.retain(|flag| known.insert(flag.clone()));
        self.catalogue.entries.push(entry);
        self.places.push(place);
    }

    fn finish(mut self) -> (Catalogue, Vec<Places>, Vec<Diagnostic>) {
        let has_part = self.has_id || self.entry.context.is_some() || self.entry.previous_id.is_some();
        if has_part && !self.has_translation {
            let hint = "add a `msgstr`, with an empty string if there is no translation yet";
            self.refuse("an incomplete entry", self.keyword, hint);
        }
        if self.has_translation {
            self.end_entry();
        } else {
            self.catalogue.end = std::mem::take(&mut self.entry.comments);
        }
        (self.catalogue, self.places, self.diagnostics)
    }

    /// Reports a problem in an entry, unless a problem in this entry was already reported.
    fn refuse(&mut self, what: &'static str, span: Span, hint: &str) {
        if std::mem::replace(&mut self.is_invalid, true) {
            return;
        }
        let problem = Problem::MalformedCatalogue { what };
        self.diagnostics.push(Diagnostic::new(problem, span).with_hint(hint));
    }
}

fn span_len(span: Span) -> usize {
    (span.end - span.start) as usize
}

/// A problem in a string, and a hint.
type Refusal = (&'static str, &'static str);

/// Unquotes and unescapes a string.
fn unquote(string: &str) -> Result<String, Refusal> {
    let inner =
        string.strip_prefix('"').ok_or(("an unquoted text", "enclose the text in quotes: `\"…\"`"))?;
    let mut text = String::with_capacity(inner.len());
    let mut characters = inner.chars();
    loop {
        match characters.next() {
            None => {
                return Err((
                    "an unterminated string",
                    "close the string on the same line; continue a long text with another `\"…\"` on the next line",
                ));
            }
            Some('"') if characters.as_str().is_empty() => return Ok(text),
            Some('"') => {
                return Err((
                    "text after a string",
                    "end the line after the string; write a quote inside the string as `\\\"`",
                ));
            }
            Some('\\') => text.push(match characters.next() {
                Some('n') => '\n',
                Some('t') => '\t',
                Some('r') => '\r',
                Some(character @ ('"' | '\\')) => character,
                _ => {
                    return Err((
                        "an unknown escape sequence",
                        "valid escape sequences are `\\n`, `\\t`, `\\r`, `\\\"` and `\\\\`",
                    ));
                }
            }),
            Some(character) => text.push(character),
        }
    }
}
