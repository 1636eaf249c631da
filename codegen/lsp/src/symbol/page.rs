//! Symbols of pages with tables.

use uavspec_schema::resolve::code_references;
use uavspec_schema::source::Span;
use uavspec_schema::table::type_table::{Body, Expression, ExpressionKind, Member};
use uavspec_schema::table::{self, error_code, type_table};
use uavspec_schema::{JsonMessageId, JsonTypeId, Schema};

use super::occurrence::{Occurrence, Symbol};
use crate::snapshot::Document;

/// All occurrences on a page.
pub(super) fn occurrences(document: &Document<'_>) -> Vec<Occurrence> {
    let Some(package) = document.package_index() else { return Vec::new() };
    let (page, _) = table::parse(&document.snapshot.loaded.sources, document.id);
    let mut finder = Finder { schema: &document.snapshot.schema, package, found: Vec::new() };
    let (tables, _) = error_code::read(&page);
    for row in tables.iter().flat_map(|table| &table.rows) {
        finder.push(Symbol::ErrorCode(package, row.code), row.span, true);
        for (code, span) in code_references(row.description) {
            finder.push(Symbol::ErrorCode(package, code), span, false);
        }
    }
    let (definitions, _) = type_table::read(&page);
    for definition in &definitions.types {
        finder.ty(definition.name, definition.span, true);
        match &definition.body {
            Body::Object(members) | Body::Tuple(members) => finder.members(members),
            Body::Named { ty, .. } => finder.expression(ty),
            Body::Set(_) => {}
        }
    }
    for message in &definitions.messages {
        finder.message(message.name, message.span, true);
        for part in &message.parts {
            part.answers.iter().for_each(|(name, span)| finder.message(name, *span, false));
            finder.members(&part.fields);
        }
    }
    finder.found
}

struct Finder<'s> {
    schema: &'s Schema,
    /// The index of the package.
    package: usize,
    found: Vec<Occurrence>,
}

impl Finder<'_> {
    fn members(&mut self, members: &[Member<'_>]) {
        members.iter().filter_map(|member| member.ty.as_ref()).for_each(|ty| self.expression(ty));
    }

    fn expression(&mut self, expression: &Expression) {
        match &expression.kind {
            ExpressionKind::Named(name) => self.ty(name, expression.span, false),
            ExpressionKind::List(element) | ExpressionKind::Map(element) => self.expression(element),
            ExpressionKind::Either(all) => all.iter().for_each(|expression| self.expression(expression)),
            _ => {}
        }
    }

    fn ty(&mut self, name: &str, span: Span, is_definition: bool) {
        let types = self.schema.packages[self.package].json_types.iter().copied();
        let id = types.into_iter().find(|id: &JsonTypeId| self.schema.json_type(*id).name == name);
        if let Some(id) = id {
            self.push(Symbol::JsonType(id), span, is_definition);
        }
    }

    fn message(&mut self, name: &str, span: Span, is_definition: bool) {
        let mut messages = self.schema.packages[self.package].json_messages.iter().copied();
        if let Some(id) = messages.find(|id: &JsonMessageId| self.schema.json_message(*id).name == name) {
            self.push(Symbol::JsonMessage(id), span, is_definition);
        }
    }

    fn push(&mut self, symbol: Symbol, span: Span, is_definition: bool) {
        self.found.push(Occurrence { symbol, span, is_definition });
    }
}
