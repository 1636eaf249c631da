//! Updates the text of a list. Comments and unaffected entries stay unchanged, byte for byte.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::ops::Range;

use globset::escape;

use super::matching::{Found, Matches, Reason};
use super::read::List;

/// The first line of a new baseline.
const HEAD: &str = "# Baseline. `lint` and `breaking` report only findings that are not in this list.\n";

/// The reason in new entries.
const REASON: &str = "found when the list was written";

/// The text of a list without outdated entries. If `is_writing`, all findings of the run are added.
pub(super) fn updated(list: &List, matches: &Matches, found: &Found, is_writing: bool) -> String {
    let mut edits: Vec<(Range<usize>, String)> = Vec::new();
    let mut removed = BTreeSet::new();
    for outdated in &matches.outdated {
        let spans = &list.entries[outdated.entry].spans;
        if let (Reason::Fewer(count), Some(span)) = (&outdated.reason, spans.count) {
            edits.push((list.range(span), count.to_string()));
        } else {
            removed.insert(outdated.entry);
            edits.push((extent(list.text(), list.range(spans.whole)), String::new()));
        }
    }
    if is_writing {
        for (at, entry) in list.entries.iter().enumerate().filter(|(at, _)| matches.has_surplus[*at]) {
            if let Some(span) = entry.spans.count.filter(|_| !removed.contains(&at)) {
                edits.push((list.range(span), matches.counts[at].to_string()));
            }
        }
    }
    let mut text = apply(list.text(), edits);
    if is_writing {
        if text.is_empty() {
            text.push_str(HEAD);
        }
        for (group, changes) in &found.groups {
            if matches.entry(group).is_none_or(|entry| removed.contains(&entry)) {
                let (subject, rule) = group;
                // Writing to a `String` can't fail.
                let _ = write!(
                    text,
                    "\n[[known]]\nrule = \"{rule}\"\nsubject = {}\ncount = {}\nreason = \"{REASON}\"\n",
                    toml::Value::String(escape(subject)),
                    changes.len()
                );
            }
        }
    }
    text
}

/// The lines of an entry, with the comments directly above it and the empty line below it.
fn extent(text: &str, entry: Range<usize>) -> Range<usize> {
    let line_start = |at: usize| text[..at].rfind('\n').map_or(0, |newline| newline + 1);
    let mut start = line_start(entry.start);
    while start > 0 {
        let above = line_start(start - 1);
        // The comment at the start of the file concerns the whole list.
        if above == 0 || !text[above..start].starts_with('#') {
            break;
        }
        start = above;
    }
    let mut end = text[entry.end..].find('\n').map_or(text.len(), |newline| entry.end + newline + 1);
    if text[end..].starts_with('\n') {
        end += 1;
    }
    start..end
}

fn apply(text: &str, mut edits: Vec<(Range<usize>, String)>) -> String {
    edits.sort_by_key(|(range, _)| range.start);
    let mut new = String::with_capacity(text.len());
    let mut at = 0;
    for (range, value) in edits {
        new.push_str(&text[at..range.start.max(at)]);
        new.push_str(&value);
        at = range.end.max(at);
    }
    new + &text[at..]
}
