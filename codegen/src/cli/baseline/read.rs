//! Parses a baseline.

use std::path::Path;

use globset::{Glob, GlobMatcher};
use serde::Deserialize;
use toml::Spanned;
use toml::value::Datetime;
use uavspec_dynamic::breaking;
use uavspec_schema::failure::Failure;
use uavspec_schema::source::{SourceId, SourceMap, Span};
use uavspec_schema::wording::similar;
use uavspec_schema::{Date, render, terminal};

/// A baseline.
#[derive(Debug)]
pub(super) struct List {
    /// The text of the list.
    pub(super) sources: SourceMap,
    source: SourceId,
    /// The entries, in file order.
    pub(super) entries: Vec<Entry>,
}

/// An entry of a list.
#[derive(Debug)]
pub(super) struct Entry {
    pub(super) rule: String,
    pub(super) subject: Subject,
    /// The number of findings; `None` for any number.
    pub(super) count: Option<usize>,
    pub(super) expires: Option<Date>,
    pub(super) spans: Spans,
}

/// The subjects that an entry matches.
#[derive(Debug)]
pub(super) enum Subject {
    Exact(String),
    Pattern(GlobMatcher),
}

/// The locations of an entry's parts.
#[derive(Debug)]
pub(super) struct Spans {
    pub(super) subject: Span,
    pub(super) count: Option<Span>,
    pub(super) expires: Option<Span>,
    /// The span from the header to the end of the last value.
    pub(super) whole: Span,
}

/// The content of the file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    #[serde(default)]
    known: Vec<Spanned<WrittenEntry>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenEntry {
    rule: Spanned<String>,
    subject: Spanned<String>,
    count: Option<Spanned<usize>>,
    reason: Spanned<String>,
    link: Option<Spanned<String>>,
    expires: Option<Spanned<Datetime>>,
}

impl List {
    /// Parses the list in the file at `path`.
    pub(super) fn parse(path: &Path, bytes: Vec<u8>) -> Result<Self, Failure> {
        let mut sources = SourceMap::default();
        let source = sources.add(terminal::path(path), bytes).map_err(|diagnostic| {
            Failure::new(render::plain(&diagnostic.problem.to_string(), diagnostic.span, &sources))
        })?;
        let whole = sources.span(source);
        let failure = |span: Span, message: &str| Failure::new(render::plain(message, span, &sources));
        let written: Written = toml::from_str(sources.text(source))
            .map_err(|error| failure(whole.part(error.span().unwrap_or_default()), error.message()))?;
        // Only an entry with a header line can be removed without other changes.
        let has_header =
            |entry: &&Spanned<WrittenEntry>| sources.slice(whole.part(entry.span())).starts_with("[[");
        if let Some(entry) = written.known.iter().find(|entry| !has_header(entry)) {
            let message = "expected an array of tables";
            return Err(failure(whole.part(entry.span()), message)
                .with_hint("start each entry with a line `[[known]]`"));
        }
        let entries: Result<Vec<Entry>, EntryError> =
            written.known.into_iter().map(|entry| Entry::new(entry, whole)).collect();
        let entries = match entries {
            Ok(entries) => entries,
            Err((span, message, help)) => return Err(failure(span, &message).with_hint(help)),
        };
        Ok(Self { sources, source, entries })
    }

    /// The text of the file.
    pub(super) fn text(&self) -> &str {
        self.sources.text(self.source)
    }

    /// The range of a span in the text.
    pub(super) fn range(&self, span: Span) -> std::ops::Range<usize> {
        let start = self.sources.span(self.source).start;
        (span.start - start) as usize..(span.end - start) as usize
    }
}

/// An error in an entry: the location, the message and the advice.
type EntryError = (Span, String, String);

impl Entry {
    fn new(written: Spanned<WrittenEntry>, whole: Span) -> Result<Self, EntryError> {
        let header = whole.part(written.span());
        let WrittenEntry { rule, subject, count, reason, link, expires } = written.into_inner();
        let ends = [Some(rule.span()), Some(subject.span()), Some(reason.span())].into_iter().chain([
            count.as_ref().map(Spanned::span),
            link.as_ref().map(Spanned::span),
            expires.as_ref().map(Spanned::span),
        ]);
        let end = ends.flatten().map(|range| whole.part(range).end).max().unwrap_or(header.end);
        check_rule(&rule, whole)?;
        check_reason(&reason, whole)?;
        let spans = Spans {
            subject: whole.part(subject.span()),
            count: count.as_ref().map(|count| whole.part(count.span())),
            expires: expires.as_ref().map(|expires| whole.part(expires.span())),
            whole: Span { start: header.start, end },
        };
        let expires = expires.map(|expires| date(&expires, whole)).transpose()?;
        let subject = Subject::new(subject.get_ref())
            .map_err(|error| (spans.subject, error, "correct the pattern".to_owned()))?;
        Ok(Self { rule: rule.into_inner(), subject, count: count.map(Spanned::into_inner), expires, spans })
    }
}

fn check_rule(rule: &Spanned<String>, whole: Span) -> Result<(), EntryError> {
    let id = rule.get_ref();
    if uavspec_lint::rule(id).is_some() || breaking::rule(id).is_some() {
        return Ok(());
    }
    let ids =
        || uavspec_lint::RULES.iter().map(|rule| rule.id).chain(breaking::RULES.iter().map(|rule| rule.id));
    let help = match similar(id, ids()) {
        Some(similar) => format!("did you mean `{similar}`?"),
        None => format!("the rules are {}", ids().collect::<Vec<_>>().join(", ")),
    };
    Err((whole.part(rule.span()), format!("unknown rule `{id}`"), help))
}

fn check_reason(reason: &Spanned<String>, whole: Span) -> Result<(), EntryError> {
    if !reason.get_ref().trim().is_empty() {
        return Ok(());
    }
    let help = "explain the findings, so others know when to remove the entry";
    Err((whole.part(reason.span()), "the entry has no `reason`".to_owned(), help.to_owned()))
}

fn date(expires: &Spanned<Datetime>, whole: Span) -> Result<Date, EntryError> {
    let Datetime { date: Some(date), time: None, .. } = expires.get_ref() else {
        let help = "write it without quotes, e.g. 2027-06-30";
        return Err((whole.part(expires.span()), "`expires`: expected a date".to_owned(), help.to_owned()));
    };
    Ok(Date { year: date.year, month: date.month, day: date.day })
}

impl Subject {
    /// Parses a subject. Most lists contain many exact subjects, which need no compiled pattern.
    fn new(text: &str) -> Result<Self, String> {
        if !text.contains(['*', '?', '[', ']', '{', '}', '\\']) {
            return Ok(Self::Exact(text.to_owned()));
        }
        let glob = Glob::new(text).map_err(|error| format!("invalid pattern `{text}`: {}", error.kind()))?;
        Ok(Self::Pattern(glob.compile_matcher()))
    }
}
