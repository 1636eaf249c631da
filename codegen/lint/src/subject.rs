//! The input of rules: messages with their lines, and sources as text.

use std::collections::{BTreeSet, HashMap};

use uavspec_schema::msg::annotation::Annotation;
use uavspec_schema::msg::ast::{Definition, Line, Part};
use uavspec_schema::msg::{Dialect, Kind};
use uavspec_schema::resolve::PackageSource;
use uavspec_schema::source::{SourceId, SourceMap, Span};
use uavspec_schema::{Constant, Field, Form, Message, MessageId, Schema};

use super::rule::Scope;

/// A message, or a part of a service or action, with its lines.
#[derive(Debug)]
pub struct Subject<'a> {
    /// All sources.
    pub sources: &'a SourceMap,
    /// All messages.
    pub schema: &'a Schema,
    /// The dialect of the definition.
    pub dialect: Dialect,
    /// The message.
    pub message: &'a Message,
    /// The lines of the message.
    pub part: &'a Part<'a>,
    /// True if another message contains this message.
    pub is_nested: bool,
}

impl<'a> Subject<'a> {
    /// True if rules of this scope apply to the message.
    pub(crate) fn is_in(&self, scope: Scope) -> bool {
        let is_px4 = self.dialect == Dialect::Px4;
        match scope {
            Scope::All => true,
            Scope::Px4 => is_px4,
            Scope::Px4Messages => is_px4 && self.message.kind == Kind::Message,
        }
    }

    /// The location for findings about the whole message: its first line.
    pub(crate) fn head(&self) -> Span {
        self.part.lines.first().map_or(self.message.span.part(0..0), |line| line.span)
    }

    /// The fields with their lines.
    pub(crate) fn fields(&self) -> impl Iterator<Item = (&'a Field, &'a Line<'a>)> {
        self.message.fields.iter().filter_map(|field| Some((field, self.line(field.span)?)))
    }

    /// The constants with their lines.
    pub(crate) fn constants(&self) -> impl Iterator<Item = (&'a Constant, &'a Line<'a>)> {
        self.message.constants.iter().filter_map(|constant| Some((constant, self.line(constant.span)?)))
    }

    /// The lines with declarations, each with the text before the comment and the span of that text.
    pub(crate) fn declarations(&self) -> impl Iterator<Item = (&'a Line<'a>, &'a str, Span)> {
        let sources = self.sources;
        self.part.lines.iter().filter(|line| line.item.is_some()).map(move |line| {
            let end = line.comment.as_ref().map_or(line.span.end, |comment| comment.span.start);
            let place = Span { start: line.span.start, end };
            (line, sources.slice(place), place)
        })
    }

    /// The line that contains `span`.
    pub(crate) fn line(&self, span: Span) -> Option<&'a Line<'a>> {
        let after = self.part.lines.partition_point(|line| line.span.start <= span.start);
        self.part.lines.get(after.checked_sub(1)?)
    }
}

/// The annotations of a declaration, including annotations of command parameters.
pub(super) fn annotations<'l>(line: &'l Line<'_>) -> impl Iterator<Item = &'l Annotation<'l>> {
    let note = line.comment.as_ref().and_then(|comment| comment.note.as_ref());
    let notes = note.into_iter().flat_map(|note| std::iter::once(note).chain(&note.parameters));
    notes.flat_map(|note| &note.annotations)
}

/// A source as text.
#[derive(Debug)]
pub struct SourceText<'a> {
    /// The text.
    pub text: &'a str,
    /// The location.
    pub span: Span,
    /// The form of the source.
    pub form: Form,
}

impl<'a> SourceText<'a> {
    /// The lines without line ends, each with its span.
    pub(crate) fn lines(&self) -> impl Iterator<Item = (&'a str, Span)> {
        let span = self.span;
        self.text.split_inclusive('\n').scan(0, move |at, raw| {
            let line = raw.strip_suffix('\n').unwrap_or(raw);
            let line = line.strip_suffix('\r').unwrap_or(line);
            let place = span.part(*at..*at + line.len());
            *at += raw.len();
            Some((line, place))
        })
    }
}

/// All messages in sources without errors.
pub(super) fn subjects<'a>(
    sources: &'a SourceMap,
    schema: &'a Schema,
    parsed: &'a [PackageSource<'a>],
    broken: &BTreeSet<SourceId>,
) -> Vec<Subject<'a>> {
    let files: HashMap<(Span, Kind), &(&str, Kind, Span, Definition<'_>)> =
        parsed.iter().flat_map(|package| &package.files).map(|file| ((file.2, file.1), file)).collect();
    let nested: BTreeSet<MessageId> = schema.messages.iter().flat_map(Message::nested).collect();
    let subject = |(id, message): (u32, &'a Message)| {
        let Form::Msg(dialect) = parsed[message.package].input.form else { return None };
        let (stem, kind, _, definition) = files.get(&(message.span, message.kind))?;
        let suffix = message.name.strip_prefix(stem)?;
        let part = kind.part_suffixes().iter().position(|known| *known == suffix)?;
        let part = definition.parts.get(part)?;
        Some(Subject { sources, schema, dialect, message, part, is_nested: nested.contains(&MessageId(id)) })
    };
    let is_whole = |(_, message): &(u32, &Message)| !broken.contains(&sources.source_of(message.span));
    (0..).zip(&schema.messages).filter(is_whole).filter_map(subject).collect()
}

/// All sources as text.
pub(super) fn texts<'a>(sources: &'a SourceMap, parsed: &[PackageSource<'a>]) -> Vec<SourceText<'a>> {
    let mut texts = Vec::new();
    for package in parsed {
        let files = package.files.iter().map(|(_, _, span, _)| *span);
        for span in files.chain(package.pages.iter().map(|page| page.span)) {
            let text = sources.text(sources.source_of(span));
            texts.push(SourceText { text, span, form: package.input.form });
        }
    }
    texts
}
