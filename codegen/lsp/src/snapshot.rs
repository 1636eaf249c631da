//! The definitions of a project at one point in time, and their findings.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use lsp_types::Location;
use uavspec_codegen::load::Loaded;
use uavspec_lint::{Settings, read_and_lint};
use uavspec_schema::diagnostic::Level;
use uavspec_schema::finding::Finding;
use uavspec_schema::msg::ast::{Definition, Part};
use uavspec_schema::msg::{self, Dialect, Kind};
use uavspec_schema::read::PackageInput;
use uavspec_schema::source::{SourceId, Span, stem};
use uavspec_schema::span::offset;
use uavspec_schema::{Form, MessageId, Schema};

use super::lines::{Encoding, Index, Lines};
use super::uri;

/// The rule about references to packages that the workspace doesn't contain.
const UNKNOWN_PACKAGE: &str = "unknown-package";

/// Definitions with the texts of open documents.
pub(super) struct Snapshot {
    /// The sources and packages.
    pub(super) loaded: Loaded,
    /// The schema. It is incomplete if the definitions contain errors.
    pub(super) schema: Schema,
    /// The findings of the parser and of `lint`, by location.
    pub(super) findings: Vec<Finding>,
    ids: BTreeMap<PathBuf, SourceId>,
    /// The lines of the sources, found lazily. A file may have thousands of findings that refer to it.
    lines: BTreeMap<SourceId, OnceLock<Arc<Index>>>,
    /// The messages of each source.
    messages: BTreeMap<SourceId, Vec<MessageId>>,
    encoding: Encoding,
}

impl Snapshot {
    /// Reads and checks definitions. `is_whole` is true if the project contains all packages that it refers to.
    pub(super) fn new(loaded: Loaded, settings: &Settings, is_whole: bool, encoding: Encoding) -> Self {
        let (schema, mut findings) =
            read_and_lint(&loaded.sources, &loaded.packages, &loaded.catalogues, settings);
        findings.extend(loaded.diagnostics.iter().map(Finding::from));
        findings.sort_by_key(|finding| finding.span.start);
        if !is_whole {
            for finding in findings.iter_mut().filter(|finding| finding.rule == UNKNOWN_PACKAGE) {
                finding.level = Level::Note;
            }
        }
        let ids = loaded.paths.iter().map(|(id, path)| (path.clone(), *id)).collect();
        let lines = loaded.paths.keys().map(|id| (*id, OnceLock::new())).collect();
        let mut messages: BTreeMap<_, Vec<_>> = BTreeMap::new();
        for (at, message) in schema.messages.iter().enumerate() {
            let id = loaded.sources.source_of(message.span);
            messages.entry(id).or_default().push(MessageId(offset(at)));
        }
        Self { loaded, schema, findings, ids, lines, messages, encoding }
    }

    /// True if the snapshot contains this file.
    pub(super) fn contains(&self, path: &Path) -> bool {
        self.ids.contains_key(path)
    }

    /// The text of a file as it was read.
    pub(super) fn text(&self, path: &Path) -> Option<&str> {
        self.ids.get(path).map(|id| self.loaded.sources.text(*id))
    }

    /// True if the file was read only because other packages refer to its package.
    pub(super) fn is_dependency(&self, path: &Path) -> bool {
        let Some(id) = self.ids.get(path) else { return false };
        let has_no_selected = |package: &PackageInput| package.select.as_ref().is_some_and(Vec::is_empty);
        self.loaded.packages.iter().any(|package| has_no_selected(package) && package.sources.contains(id))
    }

    /// The document at a path.
    pub(super) fn document(&self, path: &Path) -> Option<Document<'_>> {
        let id = *self.ids.get(path)?;
        let package = self.loaded.packages.iter().find(|package| package.sources.contains(&id));
        Some(Document { snapshot: self, id, package, lines: self.lines(id) })
    }

    /// All documents that contain definitions.
    pub(super) fn documents(&self) -> impl Iterator<Item = Document<'_>> {
        self.loaded.packages.iter().flat_map(move |package| {
            package.sources.iter().map(move |id| Document {
                snapshot: self,
                id: *id,
                package: Some(package),
                lines: self.lines(*id),
            })
        })
    }

    /// The path of a source, or `None` for the configuration file, which isn't a definition.
    pub(super) fn path(&self, id: SourceId) -> Option<&Path> {
        self.loaded.paths.get(&id).map(PathBuf::as_path)
    }

    pub(super) fn lines(&self, id: SourceId) -> Lines<'_> {
        let text = self.loaded.sources.text(id);
        match self.lines.get(&id) {
            Some(index) => {
                let index = index.get_or_init(|| Arc::new(Index::new(text)));
                Lines::with_index(text, Arc::clone(index), self.encoding)
            }
            // The configuration file.
            None => Lines::new(text, self.encoding),
        }
    }

    /// The location of a span.
    pub(super) fn location(&self, span: Span) -> Option<Location> {
        let id = self.loaded.sources.source_of(span);
        let uri = uri::from_path(self.path(id)?);
        Some(Location { uri, range: self.lines(id).range(self.offsets(id, span)) })
    }

    /// The byte offsets of a span in its source.
    pub(super) fn offsets(&self, id: SourceId, span: Span) -> Range<usize> {
        let start = self.loaded.sources.span(id).start;
        span.start.saturating_sub(start) as usize..span.end.saturating_sub(start) as usize
    }
}

/// A document of a snapshot.
pub(super) struct Document<'s> {
    pub(super) snapshot: &'s Snapshot,
    pub(super) id: SourceId,
    /// The package of the definitions, or `None` for catalogues, hints, and definitions that can't be read.
    pub(super) package: Option<&'s PackageInput>,
    pub(super) lines: Lines<'s>,
}

impl<'s> Document<'s> {
    /// The range of a span in this document.
    pub(super) fn range(&self, span: Span) -> lsp_types::Range {
        self.lines.range(self.snapshot.offsets(self.id, span))
    }

    /// The span between two byte offsets.
    pub(super) fn span(&self, range: Range<usize>) -> Span {
        self.whole().part(range)
    }

    /// The span of the document.
    pub(super) fn whole(&self) -> Span {
        self.snapshot.loaded.sources.span(self.id)
    }

    /// The text within a span.
    pub(super) fn text(&self, span: Span) -> &'s str {
        self.snapshot.loaded.sources.slice(span)
    }

    /// The form of the definitions, or `None` for a document without a package.
    pub(super) fn form(&self) -> Option<Form> {
        self.package.map(|package| package.form)
    }

    /// The dialect of a `.msg`, `.srv` or `.action` file.
    pub(super) fn dialect(&self) -> Option<Dialect> {
        match self.form()? {
            Form::Msg(dialect) => Some(dialect),
            Form::Table | Form::Events => None,
        }
    }

    /// The index of the package in the schema.
    pub(super) fn package_index(&self) -> Option<usize> {
        let name = &self.package?.name;
        self.snapshot.schema.packages.iter().position(|package| package.name == *name)
    }

    /// The syntax tree of a `.msg`, `.srv` or `.action` file.
    pub(super) fn tree(&self) -> Option<Definition<'s>> {
        let sources = &self.snapshot.loaded.sources;
        let kind = Kind::of(sources.path(self.id))?;
        Some(msg::parse(sources, self.id, kind, self.dialect()?).0)
    }

    /// The messages that the file defines, and their locations: one message, or the parts of a service or action.
    pub(super) fn messages(&self) -> Vec<(MessageId, Span)> {
        self.tree().map(|tree| self.messages_of(&tree)).unwrap_or_default()
    }

    /// Like [`Self::messages`], for the syntax tree of the file.
    pub(super) fn messages_of(&self, tree: &Definition<'_>) -> Vec<(MessageId, Span)> {
        let Some(package) = self.package_index() else { return Vec::new() };
        let path = self.snapshot.loaded.sources.path(self.id);
        let suffixes = Kind::of(path).map_or(&[][..], Kind::part_suffixes);
        let schema = &self.snapshot.schema;
        let whole = self.whole();
        let message = |(part, suffix): (&Part<'_>, &&str)| {
            let name = format!("{}{suffix}", stem(path));
            let is_meant = |id: &&MessageId| {
                let message = schema.message(**id);
                message.package == package && message.name == name && message.span == whole
            };
            let id = *self.snapshot.messages.get(&self.id)?.iter().find(is_meant)?;
            let span = match part.lines.as_slice() {
                [first, .., last] => first.span.to(last.span),
                [only] => only.span,
                [] => whole,
            };
            Some((id, span))
        };
        tree.parts.iter().zip(suffixes).filter_map(message).collect()
    }

    /// The message, or the part of a service or action, at a location.
    pub(super) fn message_at(&self, at: Span) -> Option<MessageId> {
        let messages = self.messages().into_iter();
        messages.rev().find(|(_, span)| span.start <= at.start).map(|(id, _)| id)
    }
}
