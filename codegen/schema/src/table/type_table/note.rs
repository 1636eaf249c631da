//! Reads the annotations in descriptions of tables.

use std::ops::Range;

use crate::diagnostic::{Diagnostic, Problem};
use crate::msg::annotation::{self, Note};
use crate::source::Span;
use crate::table::text::Text;

/// The hint for an annotation that pages don't support.
const KNOWN: &str = "uavspec treats it as text; known annotations: range, length, unique, pattern, format";

/// Reads the annotations of `text`, starting at the position `from`.
pub(super) fn read_note<'p>(text: &'p Text, from: usize, diagnostics: &mut Vec<Diagnostic>) -> Note<'p> {
    // Convert positions in the plain text to source locations.
    let place = |span: Span| {
        let part: Range<usize> = from + span.start as usize..from + span.end as usize;
        text.part(part)
    };
    let mut found = Vec::new();
    let mut note = annotation::read_description(&text.as_str()[from..], Span::default(), &mut found);
    for annotation in &mut note.annotations {
        annotation.span = place(annotation.span);
    }
    diagnostics.extend(found.into_iter().map(|mut diagnostic| {
        diagnostic.span = place(diagnostic.span);
        match &mut diagnostic.problem {
            Problem::UnknownAnnotation { .. } => diagnostic.with_hint(KNOWN),
            Problem::AnnotationAfterText { head, .. } => {
                // The source may contain markup, so the plain text doesn't determine where to insert a fix.
                *head = None;
                diagnostic.with_hint("put annotations at the start of the description")
            }
            _ => diagnostic,
        }
    }));
    note
}
