//! Definitions, references and highlights of symbols.

use lsp_types::{DocumentHighlight, DocumentHighlightKind, Location};

use super::snapshot::{Document, Snapshot};
use super::symbol::{self, Occurrence, Symbol, has_prefix};

/// The location of the definition of the symbol at a byte offset.
pub(super) fn definition(document: &Document<'_>, offset: usize) -> Option<Location> {
    let found = symbol::at(document, offset)?;
    document.snapshot.location(symbol::definition(document.snapshot, &found.symbol)?)
}

/// The locations of all occurrences of the symbol at a byte offset, in all packages.
pub(super) fn references(document: &Document<'_>, offset: usize, with_definition: bool) -> Vec<Location> {
    let Some(found) = symbol::at(document, offset) else { return Vec::new() };
    let snapshot = document.snapshot;
    let is_meant = |occurrence: &Occurrence| {
        (with_definition || !occurrence.is_definition)
            && refers_to(snapshot, &occurrence.symbol, &found.symbol)
    };
    let all = snapshot.documents().flat_map(|document| symbol::occurrences(&document));
    let mut places: Vec<Location> =
        all.filter(is_meant).filter_map(|occurrence| snapshot.location(occurrence.span)).collect();
    // Add the definition separately. A message is defined by its file, which contains no name to point to.
    if let (true, Symbol::Message(_)) = (with_definition, &found.symbol) {
        let definition = symbol::definition(snapshot, &found.symbol);
        places.extend(definition.and_then(|span| snapshot.location(span)));
    }
    places
}

/// The occurrences of the symbol at a byte offset in its document.
pub(super) fn highlights(document: &Document<'_>, offset: usize) -> Vec<DocumentHighlight> {
    let Some(found) = symbol::at(document, offset) else { return Vec::new() };
    let all = symbol::occurrences(document).into_iter();
    all.filter(|occurrence| refers_to(document.snapshot, &occurrence.symbol, &found.symbol))
        .map(|occurrence| DocumentHighlight {
            range: document.range(occurrence.span),
            kind: Some(if occurrence.is_definition {
                DocumentHighlightKind::Write
            } else {
                DocumentHighlightKind::Read
            }),
        })
        .collect()
}

/// True if an occurrence refers to the wanted symbol. A prefix also refers to each constant that starts with it.
fn refers_to(snapshot: &Snapshot, written: &Symbol, wanted: &Symbol) -> bool {
    match (written, wanted) {
        (Symbol::Prefix(message, prefix), Symbol::Constant(owner, at)) if message == owner => {
            let constant = &snapshot.schema.message(*owner).constants[*at];
            has_prefix(&constant.name, prefix)
        }
        _ => written == wanted,
    }
}
