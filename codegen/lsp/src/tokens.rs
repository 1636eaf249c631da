//! Semantic tokens.

use lsp_types::{Position, SemanticToken, SemanticTokenModifiers, SemanticTokenTypes, SemanticTokensLegend};
use uavspec_schema::Form;
use uavspec_schema::msg::ast::Item;
use uavspec_schema::source::Span;

use super::snapshot::Document;
use super::symbol::{self, Symbol};

/// The kinds of tokens, in the order of the legend.
#[derive(Clone, Copy)]
enum Kind {
    Type,
    Struct,
    Property,
    EnumMember,
    Comment,
    Decorator,
    Number,
}

/// The names of [`Kind`], in its order.
const KINDS: [SemanticTokenTypes; 7] = [
    SemanticTokenTypes::Type,
    SemanticTokenTypes::Struct,
    SemanticTokenTypes::Property,
    SemanticTokenTypes::EnumMember,
    SemanticTokenTypes::Comment,
    SemanticTokenTypes::Decorator,
    SemanticTokenTypes::Number,
];

/// The bit of the modifier for definitions.
const DEFINITION: u32 = 1;

/// The kinds and modifiers of tokens.
pub(super) fn legend() -> SemanticTokensLegend {
    SemanticTokensLegend {
        token_types: KINDS.iter().map(ToString::to_string).collect(),
        token_modifiers: vec![SemanticTokenModifiers::Definition.to_string()],
    }
}

/// A part of a document with a kind.
#[derive(Clone, Copy)]
struct Part {
    span: Span,
    kind: Kind,
    is_definition: bool,
}

/// The tokens of a document, each relative to the previous one. Editors highlight JSON without help.
pub(super) fn tokens(document: &Document<'_>) -> Vec<SemanticToken> {
    if document.form() == Some(Form::Events) {
        return Vec::new();
    }
    let mut parts = syntax(document);
    parts.extend(symbol::occurrences(document).into_iter().map(|occurrence| Part {
        span: occurrence.span,
        kind: match occurrence.symbol {
            Symbol::Message(_) | Symbol::JsonType(_) | Symbol::JsonMessage(_) | Symbol::Event(..) => {
                Kind::Struct
            }
            Symbol::Field(..) => Kind::Property,
            Symbol::Constant(..) | Symbol::Prefix(..) => Kind::EnumMember,
            Symbol::ErrorCode(..) => Kind::Number,
            Symbol::EventEnum(..) => Kind::Type,
        },
        is_definition: occurrence.is_definition,
    }));
    // Paint the parts onto the bytes of the text. A later part lies within an earlier one: a symbol within an annotation,
    // an annotation within a comment.
    let text = document.lines.text();
    let mut painted: Vec<Option<usize>> = vec![None; text.len()];
    for (at, part) in parts.iter().enumerate() {
        let range = document.snapshot.offsets(document.id, part.span);
        painted[range].fill(Some(at));
    }
    let mut tokens = Vec::new();
    let (mut start, mut last) = (0, Position::default());
    let bytes: Vec<(Option<usize>, bool)> =
        painted.into_iter().zip(text.bytes().map(|byte| byte == b'\n')).collect();
    for run in bytes.chunk_by(|left, right| left.0 == right.0 && !left.1 && !right.1) {
        let range = start..start + run.len();
        start = range.end;
        let Some(part) = run[0].0.map(|at| parts[at]).filter(|_| !run[0].1) else { continue };
        let position = document.lines.position(range.start);
        let is_same_line = position.line == last.line;
        tokens.push(SemanticToken {
            delta_line: position.line - last.line,
            delta_start: position.character - if is_same_line { last.character } else { 0 },
            length: document.lines.encoding().len(&text[range]),
            token_type: part.kind as u32,
            token_modifiers_bitset: if part.is_definition { DEFINITION } else { 0 },
        });
        last = position;
    }
    tokens
}

/// Comments, annotations, types and values.
fn syntax(document: &Document<'_>) -> Vec<Part> {
    let Some(tree) = document.tree() else { return Vec::new() };
    let mut parts = Vec::new();
    let mut push = |span, kind| parts.push(Part { span, kind, is_definition: false });
    for line in tree.parts.iter().flat_map(|part| &part.lines) {
        match line.item.as_deref() {
            Some(Item::Field(field)) => push(field.ty.span, Kind::Type),
            Some(Item::Constant(constant)) => {
                let before = Span { start: line.span.start, end: constant.name.span.start };
                let text = document.text(before);
                let start = text.len() - text.trim_start().len();
                push(before.part(start..text.trim_end().len().max(start)), Kind::Type);
                push(constant.value_span, Kind::Number);
            }
            None => {}
        }
        let Some(comment) = &line.comment else { continue };
        push(comment.span, Kind::Comment);
        let notes = comment.note.iter().flat_map(|note| std::iter::once(note).chain(&note.parameters));
        notes
            .flat_map(|note| &note.annotations)
            .for_each(|annotation| push(annotation.span, Kind::Decorator));
    }
    parts
}
