//! Formatting of documents.

use lsp_types::TextEdit;
use similar::DiffTag;
use uavspec_lint::format::format;
use uavspec_schema::{Form, difference};

use super::lines::Lines;
use super::snapshot::Document;

/// The edits that format a document. `None` if it contains errors, or for JSON, which other programs format.
pub(super) fn edits(document: &Document<'_>) -> Option<Vec<TextEdit>> {
    let form = document.form().filter(|form| *form != Form::Events)?;
    let formatted = format(&document.snapshot.loaded.sources, document.id, form).ok()?;
    Some(replacement(&document.lines, &formatted.text))
}

/// The edits that replace a text. Lines that stay the same are not part of an edit.
pub(super) fn replacement(lines: &Lines<'_>, new: &str) -> Vec<TextEdit> {
    let (old, new) = (difference::lines(lines.text()), difference::lines(new));
    let operations = difference::operations(&old, &new);
    let changes = operations.iter().filter(|change| change.tag() != DiffTag::Equal);
    changes
        .map(|change| {
            let old = change.old_range();
            let range = lines.range(lines.start(old.start)..lines.start(old.end));
            TextEdit { range, new_text: new[change.new_range()].concat() }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use lsp_types::{Position, Range};

    use super::*;
    use crate::lines::Encoding;

    #[test]
    fn only_lines_that_differ_are_replaced() {
        let lines = Lines::new("a\nb\nc\nd", Encoding::Utf16);
        let edit = |first, last, text: &str| {
            let at = |line| Position { line, character: 0 };
            vec![TextEdit { range: Range { start: at(first), end: at(last) }, new_text: text.to_owned() }]
        };
        assert_eq!(replacement(&lines, "a\nb\nc\nd"), []);
        assert_eq!(replacement(&lines, "a\nB\nc\nd"), edit(1, 2, "B\n"));
        assert_eq!(replacement(&lines, "a\nd"), edit(1, 3, ""));
        assert_eq!(replacement(&lines, "a\nb\nx\nc\nd"), edit(2, 2, "x\n"));
        let end = Position { line: 3, character: 1 };
        let last = TextEdit {
            range: Range { start: Position { line: 3, character: 0 }, end },
            new_text: "d\n".to_owned(),
        };
        assert_eq!(replacement(&lines, "a\nb\nc\nd\n"), [last]);
    }
}
