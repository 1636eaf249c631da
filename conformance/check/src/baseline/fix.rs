//! Removes stale entries from lists and keeps everything else unchanged, byte for byte.
//!
//! An entry extends from its header to its last value, and includes the comments directly above and directly below.
//! Comments that aren't adjacent to an entry are kept. Comments at the start of a list are kept as well, since they may
//! concern the whole list.

use std::collections::BTreeMap;
use std::ops::Range;

use uavspec_schema::source::{SourceId, Span};

use super::pattern::exact;
use super::{Entry, Lists, Stale, StaleReason};

/// The maximum length of a `message` value that a fix writes, in characters. A longer text would become stale more
/// often.
const MAX_MESSAGE: usize = 120;

/// The new text of each list that changes.
pub(super) fn texts(lists: &Lists, stale: &[Stale]) -> BTreeMap<SourceId, String> {
    let mut removed = vec![false; lists.entries.len()];
    let mut values: BTreeMap<usize, Vec<(Span, String)>> = BTreeMap::new();
    for Stale { entry, reason } in stale.iter().filter(|stale| stale.is_fixable()) {
        match reason {
            StaleReason::FailsOtherwise { common, .. } => {
                let span = lists.entries[*entry].spans.message;
                values.entry(*entry).or_default().extend(span.map(|span| (span, quoted_start(common))));
            }
            StaleReason::PassesInPart { failing, .. } => {
                let span = lists.entries[*entry].spans.selector;
                values.entry(*entry).or_default().push((span, quote(exact(failing))));
            }
            StaleReason::Passes | StaleReason::MatchesNothing | StaleReason::Idle | StaleReason::Expired => {
                removed[*entry] = true;
            }
        }
    }
    let mut texts = BTreeMap::new();
    for id in &lists.ids {
        let whole = lists.sources.span(*id);
        let is_here = |entry: &Entry| lists.sources.source_of(entry.spans.header) == *id;
        let entries = || lists.entries.iter().enumerate().filter(|(_, entry)| is_here(entry));
        let extents: Vec<(Range<usize>, bool)> =
            entries().map(|(at, entry)| (range(entry.spans.whole, whole), removed[at])).collect();
        let text = lists.sources.text(*id);
        let mut edits = removals(text, &extents);
        for (at, _) in entries().filter(|(at, _)| !removed[*at]) {
            let new = values.remove(&at).unwrap_or_default();
            edits.extend(new.into_iter().map(|(span, value)| (range(span, whole), value)));
        }
        if !edits.is_empty() {
            texts.insert(*id, apply(text, edits));
        }
    }
    texts
}

fn range(span: Span, whole: Span) -> Range<usize> {
    (span.start - whole.start) as usize..(span.end - whole.start) as usize
}

/// The start of a message, as a TOML string.
fn quoted_start(message: &str) -> String {
    let end = message.char_indices().nth(MAX_MESSAGE).map_or(message.len(), |(end, _)| end);
    quote(message[..end].to_owned())
}

/// A text as a TOML string.
pub(super) fn quote(text: String) -> String {
    toml::Value::String(text).to_string()
}

/// A line of a list.
pub(super) struct Line {
    range: Range<usize>,
    is_blank: bool,
    is_comment: bool,
    /// The index of the line's entry.
    owner: Option<usize>,
}

/// The parts to remove from a text. The entries are in order. The flag is true if the entry must be removed.
fn removals(text: &str, entries: &[(Range<usize>, bool)]) -> Vec<(Range<usize>, String)> {
    let lines = lines(text, entries);
    let is_removed = |line: &Line| line.owner.is_some_and(|owner| entries[owner].1);
    let mut removals = Vec::new();
    let mut at = 0;
    while at < lines.len() {
        if !is_removed(&lines[at]) {
            at += 1;
            continue;
        }
        let mut start = at;
        let mut end = at;
        while at < lines.len() && (is_removed(&lines[at]) || lines[at].is_free_blank()) {
            at += 1;
            if is_removed(&lines[at - 1]) {
                end = at;
            }
        }
        // Merge the blank lines around removed entries. Leave no blank lines at the start and end of the list.
        if at == lines.len() {
            end = at;
            while start > 0 && lines[start - 1].is_free_blank() {
                start -= 1;
            }
        } else if start == 0 || lines[start - 1].is_free_blank() {
            end = at;
        }
        removals.push((lines[start].range.start..lines[end - 1].range.end, String::new()));
    }
    removals
}

impl Line {
    /// True for a blank line outside of entries.
    fn is_free_blank(&self) -> bool {
        self.is_blank && self.owner.is_none()
    }

    fn is_free_comment(&self) -> bool {
        self.is_comment && self.owner.is_none()
    }
}

/// The lines of a text, each with its entry.
fn lines(text: &str, entries: &[(Range<usize>, bool)]) -> Vec<Line> {
    let mut start = 0;
    let mut lines: Vec<Line> = Vec::new();
    for line in text.split_inclusive('\n') {
        let range = start..start + line.len();
        start = range.end;
        let owner = entries.partition_point(|(entry, _)| entry.end <= range.start);
        let is_inside = entries.get(owner).is_some_and(|(entry, _)| entry.start < range.end);
        let (is_blank, is_comment) = (line.trim().is_empty(), line.trim_start().starts_with('#'));
        lines.push(Line { range, is_blank, is_comment, owner: is_inside.then_some(owner) });
    }
    // Comments directly above a header, unless they start the list.
    for at in (1..lines.len()).rev() {
        if lines[at].owner.is_some() && lines[at - 1].is_free_comment() {
            lines[at - 1].owner = lines[at].owner;
        }
    }
    let head = lines.iter().take_while(|line| line.is_comment).count();
    lines.iter_mut().take(head).for_each(|line| line.owner = None);
    // Comments directly below the last value.
    for at in 1..lines.len() {
        if lines[at - 1].owner.is_some() && lines[at].is_free_comment() {
            lines[at].owner = lines[at - 1].owner;
        }
    }
    lines
}

fn apply(text: &str, mut edits: Vec<(Range<usize>, String)>) -> String {
    edits.sort_by_key(|(range, _)| range.start);
    let mut new = String::with_capacity(text.len());
    let mut at = 0;
    for (range, with) in edits {
        new.push_str(&text[at..range.start]);
        new.push_str(&with);
        at = range.end;
    }
    new.push_str(&text[at..]);
    new
}
