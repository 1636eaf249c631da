//! Named items in definitions, and their occurrences.

mod occurrence;
mod page;

use std::collections::HashMap;
use std::ops::Range;

use uavspec_schema::msg::annotation::Note;
use uavspec_schema::msg::ast::{Element, Field, Item, Line};
use uavspec_schema::msg::constraint::Argument;
use uavspec_schema::msg::statement::{Prefix, Statement};
use uavspec_schema::source::Span;
use uavspec_schema::{Form, Message, MessageId};

pub(super) use self::occurrence::{Occurrence, Symbol};
use super::events;
use super::snapshot::{Document, Snapshot};

/// All occurrences in a document, by location.
pub(super) fn occurrences(document: &Document<'_>) -> Vec<Occurrence> {
    let mut found = match document.tree() {
        Some(tree) => {
            let mut found = Vec::new();
            for (part, (id, _)) in tree.parts.iter().zip(document.messages_of(&tree)) {
                let mut finder = Finder::new(document, id);
                part.lines.iter().for_each(|line| finder.line(line));
                found.append(&mut finder.found);
            }
            found
        }
        None if document.form() == Some(Form::Events) => events::occurrences(document),
        None => page::occurrences(document),
    };
    found.sort_by_key(|occurrence| occurrence.span);
    found
}

/// The occurrence at a byte offset of a document.
pub(super) fn at(document: &Document<'_>, offset: usize) -> Option<Occurrence> {
    let place = document.span(offset..offset).start;
    occurrences(document).into_iter().find(|found| found.span.start <= place && place <= found.span.end)
}

/// The location of a symbol's name in its definition. A message is defined by its file, so its location is the start of
/// the file.
pub(super) fn definition(snapshot: &Snapshot, symbol: &Symbol) -> Option<Span> {
    let declaration = declaration(snapshot, symbol)?;
    let path = snapshot.path(snapshot.loaded.sources.source_of(declaration))?;
    let written = snapshot.document(path).into_iter().flat_map(|document| occurrences(&document));
    let mut names = written.filter(|found| found.is_definition && found.symbol == *symbol);
    Some(names.next().map_or(declaration, |name| name.span))
}

/// The location of a symbol's declaration.
fn declaration(snapshot: &Snapshot, symbol: &Symbol) -> Option<Span> {
    let schema = &snapshot.schema;
    let start = |span: Span| Span { start: span.start, end: span.start };
    Some(match symbol {
        Symbol::Message(id) => start(schema.message(*id).span),
        Symbol::Field(id, at) => schema.message(*id).fields.get(*at)?.span,
        Symbol::Constant(id, at) => schema.message(*id).constants.get(*at)?.span,
        Symbol::Prefix(id, prefix) => {
            let constants = &schema.message(*id).constants;
            constants.iter().find(|constant| has_prefix(&constant.name, prefix))?.span
        }
        Symbol::ErrorCode(package, code) => {
            let tables = schema.packages.get(*package)?.error_tables.iter();
            tables.flat_map(|table| &table.codes).find(|found| found.code == *code)?.span
        }
        Symbol::JsonType(id) => schema.json_type(*id).span,
        Symbol::JsonMessage(id) => schema.json_message(*id).span,
        Symbol::Event(package, component, event) => {
            schema.packages.get(*package)?.components.get(*component)?.events.get(*event)?.span
        }
        Symbol::EventEnum(package, reference) => schema.packages.get(*package)?.event_enum(*reference).span,
    })
}

/// True if a constant belongs to a prefix.
pub(super) fn has_prefix(constant: &str, prefix: &str) -> bool {
    constant.strip_prefix(prefix).is_some_and(|rest| rest.starts_with('_'))
}

/// Finds the occurrences in a message, or in a part of a service or action.
struct Finder<'d, 's> {
    document: &'d Document<'s>,
    id: MessageId,
    message: &'s Message,
    /// The indices of the fields, by name.
    fields: HashMap<&'s str, usize>,
    /// The indices of the constants, by name.
    constants: HashMap<&'s str, usize>,
    found: Vec<Occurrence>,
}

impl<'d, 's> Finder<'d, 's> {
    fn new(document: &'d Document<'s>, id: MessageId) -> Self {
        let message = document.snapshot.schema.message(id);
        let fields = message.fields.iter().map(|field| field.name.as_str()).zip(0..).collect();
        let constants = message.constants.iter().map(|constant| constant.name.as_str()).zip(0..).collect();
        Self { document, id, message, fields, constants, found: Vec::new() }
    }

    fn line(&mut self, line: &Line<'_>) {
        let message = self.message;
        let note = line.comment.as_ref().and_then(|comment| comment.note.as_ref());
        match line.item.as_deref() {
            Some(Item::Field(field)) => {
                let span = field.ty.span.to(field.name.span);
                // The fields are in the order of their lines.
                let Ok(at) = message.fields.binary_search_by_key(&span, |known| known.span) else { return };
                self.define(Symbol::Field(self.id, at), field.name.span);
                self.reference(field, &message.fields[at]);
                if let Some(note) = note {
                    self.note(note);
                }
            }
            Some(Item::Constant(constant)) => {
                let span = constant.name.span.to(constant.value_span);
                let found = message.constants.binary_search_by_key(&span, |known| known.span);
                let Ok(at) = found else { return };
                self.define(Symbol::Constant(self.id, at), constant.name.span);
                for note in note.iter().flat_map(|note| &note.parameters) {
                    self.note(note);
                }
            }
            None => {}
        }
    }

    /// Adds the message that the type of a field refers to.
    fn reference(&mut self, field: &Field<'_>, resolved: &uavspec_schema::Field) {
        let (Element::Message { name, .. }, uavspec_schema::Element::Message(id)) =
            (field.ty.element, resolved.ty.element)
        else {
            return;
        };
        let text = self.document.text(field.ty.span);
        if let Some(at) = text.find(name) {
            // Skip the package, which precedes the name and may contain it.
            let at = text.rfind('/').map_or(at, |slash| slash + 1);
            self.push(Symbol::Message(id), field.ty.span.part(at..at + name.len()));
        }
    }

    /// Adds the constants and fields that annotations refer to.
    fn note(&mut self, note: &Note<'_>) {
        for annotation in &note.annotations {
            let text = self.document.text(annotation.span);
            match &annotation.statement {
                Statement::Enum(prefixes) | Statement::Flags(prefixes) => {
                    let mut from = 0;
                    for prefix in prefixes {
                        let Some((owner, name, range)) = self.prefix(prefix, text, from) else {
                            continue;
                        };
                        from = range.end;
                        self.push(
                            Symbol::Prefix(owner, prefix.prefix.to_owned()),
                            annotation.span.part(range),
                        );
                        if let Some(range) = name {
                            self.push(Symbol::Message(owner), annotation.span.part(range));
                        }
                    }
                }
                Statement::Count(name) => {
                    let found = self.field(name);
                    self.name(found, name, annotation.span, "@count".len());
                }
                Statement::Constraint(kind, Argument::Name(name), _) => {
                    let found = self.constant(name);
                    self.name(found, name, annotation.span, "@".len() + kind.name.len());
                }
                Statement::Attribute(attribute, value) => {
                    // The attribute refers to a field or a constant.
                    let Some(name) = value.strip_prefix('@') else { continue };
                    let found = self.field(name).or_else(|| self.constant(name));
                    self.name(found, name, annotation.span, "@".len() + attribute.name.len());
                }
                _ => {}
            }
        }
    }

    fn field(&self, name: &str) -> Option<Symbol> {
        self.fields.get(name).map(|at| Symbol::Field(self.id, *at))
    }

    fn constant(&self, name: &str) -> Option<Symbol> {
        self.constants.get(name).map(|at| Symbol::Constant(self.id, *at))
    }

    /// Adds a symbol whose name is written in an annotation, after a byte offset.
    fn name(&mut self, symbol: Option<Symbol>, name: &str, annotation: Span, from: usize) {
        if let Some((symbol, range)) = symbol.zip(word(self.document.text(annotation), name, from)) {
            self.push(symbol, annotation.part(range));
        }
    }

    /// The message that defines the constants of a prefix, and the ranges of its name and of the prefix in the
    /// annotation's text.
    fn prefix(
        &self,
        prefix: &Prefix<'_>,
        text: &str,
        from: usize,
    ) -> Option<(MessageId, Option<Range<usize>>, Range<usize>)> {
        let Some(name) = prefix.message else {
            return Some((self.id, None, word(text, prefix.prefix, from)?));
        };
        let schema = &self.document.snapshot.schema;
        let package = &schema.packages[self.message.package];
        let owner = package.messages.iter().find(|id| schema.message(**id).name == *name)?;
        let written = word(text, name, from)?;
        let start = written.end + 1;
        Some((*owner, Some(written), start..start + prefix.prefix.len()))
    }

    fn define(&mut self, symbol: Symbol, span: Span) {
        self.found.push(Occurrence { symbol, span, is_definition: true });
    }

    fn push(&mut self, symbol: Symbol, span: Span) {
        self.found.push(Occurrence { symbol, span, is_definition: false });
    }
}

/// The range of a whole word in a text, after a byte offset.
fn word(text: &str, word: &str, from: usize) -> Option<Range<usize>> {
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let found = text.get(from..)?.match_indices(word).map(|(at, _)| from + at..from + at + word.len());
    // A `_` or `*` may follow a prefix.
    found.into_iter().find(|range| {
        !text[..range.start].ends_with(is_part) && !text[range.end..].starts_with(char::is_alphanumeric)
    })
}
