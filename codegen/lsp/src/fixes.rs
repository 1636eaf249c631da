//! Quick fixes, and an action that fixes all findings of a document.

use lsp_types::{CodeAction, CodeActionKind, CodeActionResponse, Range, TextEdit, Uri, WorkspaceEdit};
use uavspec_lint::apply;
use uavspec_schema::finding::{Edit, Finding};

use super::diagnostics::diagnostic;
use super::format::replacement;
use super::snapshot::{Document, Snapshot};
use super::uri;

/// The kind of the action that fixes all findings.
pub(super) fn fix_all() -> CodeActionKind {
    CodeActionKind::new("source.fixAll.uavspec")
}

/// The actions for a part of a document. `only` selects kinds of actions.
pub(super) fn actions(
    document: &Document<'_>,
    range: Range,
    only: Option<&[CodeActionKind]>,
) -> Vec<CodeActionResponse> {
    let is_wanted = |kind: &CodeActionKind| {
        only.is_none_or(|only| only.iter().any(|wanted| includes(&wanted.to_string(), &kind.to_string())))
    };
    let mut actions = Vec::new();
    if is_wanted(&CodeActionKind::QuickFix) {
        actions.extend(quick_fixes(document, range));
    }
    if is_wanted(&fix_all()) {
        actions.extend(fix_of_all(document));
    }
    actions.into_iter().map(CodeActionResponse::CodeAction).collect()
}

/// True if a kind of actions includes another kind: `source` includes `source.fixAll`.
fn includes(wanted: &str, kind: &str) -> bool {
    kind.strip_prefix(wanted).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// The fixes of the findings that touch a range.
fn quick_fixes(document: &Document<'_>, range: Range) -> Vec<CodeAction> {
    let wanted = document.lines.offsets(range);
    let is_touched = |finding: &&Finding| {
        let span = document.snapshot.offsets(document.id, finding.span);
        !finding.fix.is_empty() && span.start <= wanted.end && wanted.start <= span.end
    };
    findings(document)
        .filter(is_touched)
        .map(|finding| CodeAction {
            title: format!("Fix {}: {}", finding.rule, summary(document, &finding.fix)),
            kind: Some(CodeActionKind::QuickFix),
            diagnostics: Some(vec![diagnostic(document.snapshot, finding, document.range(finding.span))]),
            is_preferred: Some(true),
            edit: Some(edit(document, finding.fix.iter().map(|edit| text_edit(document, edit)).collect())),
            ..CodeAction::default()
        })
        .collect()
}

/// The action that fixes all findings of a document.
fn fix_of_all(document: &Document<'_>) -> Option<CodeAction> {
    let fixable: Vec<Finding> =
        findings(document).filter(|finding| !finding.fix.is_empty()).cloned().collect();
    let fixed = apply(&fixable, &document.snapshot.loaded.sources);
    let edits = replacement(&document.lines, fixed.get(&document.id)?);
    Some(CodeAction {
        title: "Fix all findings that have a fix".to_owned(),
        kind: Some(fix_all()),
        edit: Some(edit(document, edits)),
        ..CodeAction::default()
    })
}

/// The findings of a document. Editors request the findings of each open document, so other documents aren't searched.
fn findings<'d>(document: &'d Document<'_>) -> impl Iterator<Item = &'d Finding> {
    let Snapshot { findings, loaded, .. } = document.snapshot;
    let first = findings.partition_point(|finding| finding.span.start < document.whole().start);
    findings[first..].iter().take_while(|finding| loaded.sources.source_of(finding.span) == document.id)
}

/// The text that a fix inserts or removes.
fn summary(document: &Document<'_>, edits: &[Edit]) -> String {
    let shown = |edit: &Edit| match (edit.text.trim(), document.text(edit.span).trim()) {
        ("", "") => "remove white space".to_owned(),
        ("", old) => format!("remove `{old}`"),
        (new, _) => format!("write `{new}`"),
    };
    edits.iter().map(shown).collect::<Vec<_>>().join(", ")
}

fn text_edit(document: &Document<'_>, edit: &Edit) -> TextEdit {
    TextEdit { range: document.range(edit.span), new_text: edit.text.clone() }
}

/// The edit of one document.
fn edit(document: &Document<'_>, edits: Vec<TextEdit>) -> WorkspaceEdit {
    let uri: Option<Uri> = document.snapshot.path(document.id).map(uri::from_path);
    WorkspaceEdit { changes: uri.map(|uri| [(uri, edits)].into()), ..WorkspaceEdit::default() }
}
