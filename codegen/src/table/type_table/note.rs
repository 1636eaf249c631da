//! Descriptions in the tables of a page: their annotations and the rest.

use std::ops::Range;

use crate::diagnostic::{Diagnostic, Problem};
use crate::msg::annotation::{self, Note};
use crate::source::Span;
use crate::table::text::Text;

/// What to say of an annotation that pages don't have.
const KNOWN: &str = "it stays part of the text; known are range, length, unique, pattern and format";

/// Reads the annotations of what `text` says from the position `from` on.
pub(super) fn read_note<'p>(text: &'p Text, from: usize, diagnostics: &mut Vec<Diagnostic>) -> Note<'p> {
    // The reader counts from the start of what it is given; where that was written is known here.
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
                // Where it should stand is known in the text, which may be written with other marks.
                *head = None;
                diagnostic.with_hint("annotations come first in a description")
            }
            _ => diagnostic,
        }
    }));
    note
}
