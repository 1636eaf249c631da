//! Edits of findings, applied to texts.

use std::collections::{BTreeMap, BTreeSet};

use crate::finding::{Edit, Finding};
use crate::source::{SourceId, SourceMap};

/// The texts that change when all `findings` are mended, by source. Where edits of two findings touch, the
/// second isn't mended: mending once more does that.
pub fn apply(findings: &[Finding], sources: &SourceMap) -> BTreeMap<SourceId, String> {
    let mut by_source: BTreeMap<SourceId, BTreeSet<&Edit>> = BTreeMap::new();
    for finding in findings {
        let Some(first) = finding.fix.first() else { continue };
        let chosen = by_source.entry(sources.source_of(first.span)).or_default();
        if finding.fix.iter().all(|edit| chosen.contains(edit) || is_apart(edit, chosen)) {
            chosen.extend(&finding.fix);
        }
    }
    let text = |(source, edits): (SourceId, BTreeSet<&Edit>)| {
        let whole = sources.span(source);
        let text = sources.text(source);
        let mut mended = String::with_capacity(text.len());
        let mut at = 0;
        for edit in edits {
            let start = (edit.span.start - whole.start) as usize;
            mended.push_str(&text[at..start]);
            mended.push_str(&edit.text);
            at = (edit.span.end - whole.start) as usize;
        }
        mended.push_str(&text[at..]);
        (source, mended)
    };
    by_source.into_iter().map(text).collect()
}

/// Whether an edit touches none of those that are chosen, which don't touch each other.
fn is_apart(edit: &Edit, chosen: &BTreeSet<&Edit>) -> bool {
    let before =
        chosen.range::<&Edit, _>(..edit).next_back().is_none_or(|other| other.span.end < edit.span.start);
    before && chosen.range::<&Edit, _>(edit..).next().is_none_or(|other| edit.span.end < other.span.start)
}
