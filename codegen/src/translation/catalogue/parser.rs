//! Reads catalogues, line by line.

use std::collections::BTreeSet;

use super::entry::{Catalogue, Entry, Places};
use crate::diagnostic::{Diagnostic, Problem};
use crate::source::{SourceId, SourceMap, Span};

/// Reads a catalogue: its entries, the place of each, and what is wrong with it. What can't be read is left out.
pub(crate) fn parse(sources: &SourceMap, id: SourceId) -> (Catalogue, Vec<Places>, Vec<Diagnostic>) {
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

/// What introduces a string, and what part of an entry that is.
const KEYWORDS: [(&str, Part); 3] =
    [("msgctxt", Part::Context), ("msgid", Part::Id), ("msgstr", Part::Translation)];

#[derive(Default)]
struct Parser {
    catalogue: Catalogue,
    places: Vec<Places>,
    diagnostics: Vec<Diagnostic>,
    entry: Entry,
    place: Places,
    /// The last part that was begun, to which a line with nothing but a string adds.
    part: Option<Part>,
    /// Whether the entry has its `msgid`.
    has_id: bool,
    /// Whether the entry has its `msgstr`: it ends with that.
    has_translation: bool,
    /// Whether any of it couldn't be read.
    is_broken: bool,
    /// The line with the last keyword.
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

    /// A keyword and a string, or a string alone.
    fn strings(&mut self, text: &str, span: Span, is_obsolete: bool, is_previous: bool) {
        let rest = text.trim_start();
        let word = rest.split(|character: char| character == '"' || character.is_whitespace()).next();
        let word = word.unwrap_or_default();
        let string = rest[word.len()..].trim_start();
        if word.starts_with("msgid_plural") || word.starts_with("msgstr[") {
            let hint = "texts of definitions have one form: give it one `msgid` and one `msgstr`";
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
                "write `msgctxt`, `msgid` or `msgstr` and a string between quotes; comments begin with `#`";
            return self.refuse("a line that is no part of an entry", span, hint);
        };
        if !word.is_empty() {
            self.begin(part, span, is_obsolete);
        }
        // The strings of a part may go on for several lines.
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
            let hint = "an entry is `msgctxt`, `msgid` and `msgstr`, in this order, each of them once";
            self.refuse("an entry whose parts are not in their order", span, hint);
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
        let is_whole = self.has_id && self.has_translation && !self.is_broken;
        (self.part, self.has_id, self.has_translation, self.is_broken) = (None, false, false, false);
        if !is_whole {
            return;
        }
        if entry.context.is_none() {
            place.context = place.id;
        }
        // Each flag stands once, whatever was merged.
        let mut known = BTreeSet::new();
        entry.flags.retain(|flag| known.insert(flag.clone()));
        self.catalogue.entries.push(entry);
        self.places.push(place);
    }

    fn finish(mut self) -> (Catalogue, Vec<Places>, Vec<Diagnostic>) {
        let has_part = self.has_id || self.entry.context.is_some() || self.entry.previous_id.is_some();
        if has_part && !self.has_translation {
            let hint = "give it a `msgstr`, with an empty string where it isn't translated yet";
            self.refuse("an entry that isn't complete", self.keyword, hint);
        }
        if self.has_translation {
            self.end_entry();
        } else {
            self.catalogue.end = std::mem::take(&mut self.entry.comments);
        }
        (self.catalogue, self.places, self.diagnostics)
    }

    /// Reports what is wrong with an entry; what comes of that is not reported.
    fn refuse(&mut self, what: &'static str, span: Span, hint: &str) {
        if std::mem::replace(&mut self.is_broken, true) {
            return;
        }
        let problem = Problem::MalformedCatalogue { what };
        self.diagnostics.push(Diagnostic::new(problem, span).with_hint(hint));
    }
}

fn span_len(span: Span) -> usize {
    (span.end - span.start) as usize
}

/// What is wrong with a string, and what to do about it.
type Refusal = (&'static str, &'static str);

/// The text that a string between quotes stands for.
fn unquote(string: &str) -> Result<String, Refusal> {
    let inner = string.strip_prefix('"').ok_or(("no string", "write it between quotes: `\"…\"`"))?;
    let mut text = String::with_capacity(inner.len());
    let mut characters = inner.chars();
    loop {
        match characters.next() {
            None => {
                return Err((
                    "a string that isn't closed",
                    "close it in the same line; a string may go on in the next line with another `\"…\"`",
                ));
            }
            Some('"') if characters.as_str().is_empty() => return Ok(text),
            Some('"') => {
                return Err((
                    "text after a string",
                    "end the line after the string; a quote within it is `\\\"`",
                ));
            }
            Some('\\') => text.push(match characters.next() {
                Some('n') => '\n',
                Some('t') => '\t',
                Some('r') => '\r',
                Some(character @ ('"' | '\\')) => character,
                _ => {
                    return Err((
                        "an escape that isn't known",
                        "known are `\\n`, `\\t`, `\\r`, `\\\"` and `\\\\`",
                    ));
                }
            }),
            Some(character) => text.push(character),
        }
    }
}
