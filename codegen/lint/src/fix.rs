//! Applies the fixes of findings.

use std::collections::{BTreeMap, BTreeSet};

use uavspec_schema::finding::{Edit, Finding};
use uavspec_schema::source::{SourceId, SourceMap};

/// Applies the fixes of all findings, and returns the changed texts by source. If the edits of two findings touch each
/// other, only the first finding is fixed. The second finding is left for the next pass.
pub fn apply(findings: &[Finding], sources: &SourceMap) -> BTreeMap<SourceId, String> {
    let mut by_source: BTreeMap<SourceId, BTreeSet<&Edit>> = BTreeMap::new();
    for finding in findings {
        let Some(first) = finding.fix.first() else { continue };
        let chosen = by_source.entry(sources.source_of(first.span)).or_default();
        if finding.fix.iter().all(|edit| chosen.contains(edit) || is_apart(edit, chosen)) {
            chosen.extend(&finding.fix);
        }
    }
    by_source.into_iter().map(|(source, edits)| (source, edited(sources, source, edits))).collect()
}

/// The text of a source with edits, which must be sorted and must not overlap.
pub fn edited<'e>(
    sources: &SourceMap,
    source: SourceId,
    edits: impl IntoIterator<Item = &'e Edit>,
) -> String {
    let whole = sources.span(source);
    let text = sources.text(source);
    let mut edited = String::with_capacity(text.len());
    let mut at = 0;
    for edit in edits {
        let start = (edit.span.start - whole.start) as usize;
        edited.push_str(&text[at..start]);
        edited.push_str(&edit.text);
        at = (edit.span.end - whole.start) as usize;
    }
    edited.push_str(&text[at..]);
    edited
}

/// True if an edit touches none of the chosen edits. The chosen edits must not touch each other.
fn is_apart(edit: &Edit, chosen: &BTreeSet<&Edit>) -> bool {
    let before =
        chosen.range::<&Edit, _>(..edit).next_back().is_none_or(|other| other.span.end < edit.span.start);
    before && chosen.range::<&Edit, _>(edit..).next().is_none_or(|other| edit.span.end < other.span.start)
}
