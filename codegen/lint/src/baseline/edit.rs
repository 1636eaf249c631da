//! Edits the text of lists, and keeps everything else unchanged, byte for byte.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use uavspec_schema::finding::{Edit, Finding};
use uavspec_schema::source::{SourceId, Span};

use super::pattern::{Pattern, exact};
use super::{Entry, Lists};
use crate::edited;

/// The first line of a new list.
const HEAD: &str = "# Known findings, which don't count. State the reason for each one.\n";

impl Lists {
    /// The text of each list, with the fixes applied and the added entries appended.
    pub(super) fn texts_with(&self, fixes: &[Finding]) -> BTreeMap<SourceId, String> {
        let edits: BTreeSet<&Edit> = fixes.iter().flat_map(|finding| &finding.fix).collect();
        let text = |source: SourceId| {
            let mut end = 0;
            // Don't change a value of an entry that is removed.
            let is_apart = |edit: &&Edit| {
                let is_apart = self.sources.source_of(edit.span) == source && edit.span.start >= end;
                end = if is_apart { edit.span.end } else { end };
                is_apart
            };
            let edits: Vec<&Edit> = edits.iter().copied().filter(is_apart).collect();
            let mut text = edited(&self.sources, source, edits.iter().copied());
            if edits.iter().any(|edit| edit.text.is_empty()) {
                text.truncate(text.trim_end().len() + line(&text[text.trim_end().len()..]));
            }
            if self.target == Some(source) {
                append(&mut text, &self.entries[self.num_read..]);
            }
            (source, text)
        };
        self.files.iter().map(|(source, _)| text(*source)).collect()
    }

    /// The edit that removes an entry.
    pub(super) fn removal(&self, at: usize) -> Edit {
        let spans = |entry: &Entry| entry.spans.whole;
        let entry = spans(&self.entries[at]);
        let source = self.sources.source_of(entry);
        let whole = self.sources.span(source);
        let range = |span: Span| (span.start - whole.start) as usize..(span.end - whole.start) as usize;
        let near = |at: Option<usize>| {
            let span = spans(self.entries[..self.num_read].get(at?)?);
            (self.sources.source_of(span) == source).then(|| range(span))
        };
        let before = near(at.checked_sub(1)).map_or(0, |before| before.end);
        let after = near(Some(at + 1)).map(|after| after.start);
        let lines = extent(self.sources.text(source), range(entry), before, after);
        Edit { span: whole.part(lines), text: String::new() }
    }
}

/// The length of the first line.
fn line(text: &str) -> usize {
    text.find('\n').map_or(text.len(), |end| end + 1)
}

/// The lines of an entry between `before` and `after`, with the comments directly above and directly below. Comments at
/// the start of the list are kept, because they may apply to the whole list. Blank lines above the entry are kept.
fn extent(text: &str, entry: Range<usize>, before: usize, after: Option<usize>) -> Range<usize> {
    let is_comment = |line: &&str| line.trim_start().starts_with('#');
    let line_start = |at: usize| text[..at].rfind('\n').map_or(0, |end| end + 1);
    let floor = if before == 0 { 0 } else { before + line(&text[before..]) };
    let mut start = line_start(entry.start);
    let above = text[floor..start].split_inclusive('\n').rev().take_while(is_comment);
    let above: usize = above.map(str::len).sum();
    if above < start {
        start -= above;
    }
    let mut end = entry.end + line(&text[entry.end..]);
    let below: usize = text[end..].split_inclusive('\n').take_while(is_comment).map(str::len).sum();
    // Keep comments directly above the next entry, because they are about that entry.
    if after.is_none_or(|after| line_start(after) != end + below) {
        end += below;
    }
    if text[..start].lines().next_back().is_none_or(|line| line.trim().is_empty()) {
        let blank = text[end..].split_inclusive('\n').take_while(|line| line.trim().is_empty());
        end += blank.map(str::len).sum::<usize>();
    }
    start..end
}

/// A text as a TOML string.
pub(super) fn quote(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// Appends the entries that a run adds.
fn append(text: &mut String, added: &[Entry]) {
    if text.is_empty() {
        text.push_str(HEAD);
    } else if !added.is_empty() && !text.ends_with('\n') {
        text.push('\n');
    }
    let table = |entry: &Entry| {
        let name = match &entry.name {
            Some(Pattern::Exact(name)) => quote(&exact(std::slice::from_ref(name))),
            _ => quote("*"),
        };
        let count = entry.count.map_or_else(String::new, |count| format!("count = {count}\n"));
        let keys = match &entry.rule {
            Some(rule) => format!("rule = {}\nsubject = {name}", quote(rule)),
            None => format!("case = {name}"),
        };
        format!("\n[[known]]\n{keys}\n{count}reason = {}\n", quote(&entry.reason))
    };
    let mut tables: Vec<String> = added.iter().map(table).collect();
    tables.sort();
    text.push_str(&tables.concat());
}
