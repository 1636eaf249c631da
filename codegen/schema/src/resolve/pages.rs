//! Resolves the error codes, types and messages on pages.

use super::package::PackageSource;
use super::resolver::{Resolver, offset};
use super::{error_codes, json_type};
use crate::diagnostic::{Diagnostic, Problem};
use crate::span::Span;
use crate::{Form, JsonMessageId, JsonTypeId};

impl<'s> Resolver<'s> {
    pub(super) fn tables(&mut self, packages: &[PackageSource<'s>]) {
        for (index, source) in packages.iter().enumerate() {
            if source.input.form == Form::Table {
                self.pages(index, source);
            }
        }
    }

    fn pages(&mut self, index: usize, source: &PackageSource<'_>) {
        let (tables, mut diagnostics) = error_codes::resolve(&source.pages);
        let first = JsonTypeId(offset(self.schema.json_types.len()));
        let mut found =
            json_type::resolve(&source.pages, (index, &source.input.name), first.0, !tables.is_empty());
        for (page, has_types) in source.pages.iter().zip(found.has_definitions) {
            let is_within = |span: Span| page.span.start <= span.start && span.end <= page.span.end;
            let has_codes = tables.iter().any(|table| is_within(table.span))
                || diagnostics.iter().any(|diagnostic| is_within(diagnostic.span));
            if !has_types && !has_codes {
                let heading = page.headings.first().map_or(page.span.part(0..0), |first| first.text.span());
                self.report(Diagnostic::new(Problem::NoTable, heading));
            }
        }
        self.diagnostics.append(&mut diagnostics);
        self.diagnostics.append(&mut found.diagnostics);
        let package = &mut self.schema.packages[index];
        package.error_tables = tables;
        package.json_types = (first.0..).zip(&found.types).map(|(id, _)| JsonTypeId(id)).collect();
        let messages = offset(self.schema.json_messages.len());
        package.json_messages = (messages..).zip(&found.messages).map(|(id, _)| JsonMessageId(id)).collect();
        self.schema.json_types.append(&mut found.types);
        self.schema.json_messages.append(&mut found.messages);
    }
}
