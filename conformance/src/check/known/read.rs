//! From the text of a list to its entries, and to every mistake in it.

use std::ops::Range;

use globset::escape;
use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};
use uavspec_codegen::SourceMap;
use uavspec_codegen::diagnostic::Level;
use uavspec_codegen::finding::Finding;
use uavspec_codegen::source::{SourceId, Span};

use super::{Entry, EntrySpans, Pattern, Selector};
use crate::model::{Date, Excuse, ExcuseKind};
use crate::rules::rule;

/// Every key of an entry.
const KEYS: &str = "keys are rule, subject, file or case, and reason, link, expires, message";

/// The entries of a list, and what is wrong with it, in the order of its lines.
pub(super) fn entries(sources: &SourceMap, source: SourceId) -> (Vec<Entry>, Vec<Finding>) {
    let mut reader = Reader { sources, whole: sources.span(source), mistakes: Vec::new() };
    let (table, errors) = DeTable::parse_recoverable(sources.text(source));
    for error in &errors {
        let span = reader.span(error.span().unwrap_or_default());
        reader.mistake("known-syntax", span, error.message(), "this is no TOML: correct it");
    }
    // What is made out of a broken text would only lead to more complaints.
    let mut entries = if errors.is_empty() { reader.list(table.get_ref()) } else { Vec::new() };
    reader.mistakes.sort_by_key(|mistake| mistake.span);
    entries.sort_by_key(|entry| entry.spans.header);
    (entries, reader.mistakes)
}

struct Reader<'s> {
    sources: &'s SourceMap,
    whole: Span,
    mistakes: Vec<Finding>,
}

/// The values of an entry.
#[derive(Default)]
struct Values<'t> {
    rule: Option<(&'t str, Span)>,
    subject: Option<(&'t str, Span)>,
    file: Option<(&'t str, Span)>,
    case: Option<(&'t str, Span)>,
    reason: Option<(&'t str, Span)>,
    link: Option<(&'t str, Span)>,
    message: Option<(&'t str, Span)>,
    expires: Option<(Date, Span)>,
}

impl Reader<'_> {
    fn span(&self, range: Range<usize>) -> Span {
        self.whole.part(range)
    }

    fn mistake(&mut self, id: &'static str, span: Span, message: impl Into<String>, help: &str) {
        let mut finding = Finding::new(id, Level::Error, span, message);
        finding.help(help);
        self.mistakes.push(finding);
    }

    fn list(&mut self, table: &DeTable<'_>) -> Vec<Entry> {
        let mut entries = Vec::new();
        for (key, value) in table {
            let kind =
                [ExcuseKind::Known, ExcuseKind::Flaky].into_iter().find(|kind| kind.name() == key.get_ref());
            let Some(kind) = kind else {
                let message = format!("a list has no `{}`", key.get_ref());
                let span = self.span(key.span());
                self.mistake("known-key", span, message, "start each entry with `[[known]]` or `[[flaky]]`");
                continue;
            };
            // Only what has a line of its own can be taken out and leave all else as it was.
            let Some(tables) = self.tables(value) else {
                let message = format!("`{kind}` is no list of tables");
                let help = format!("start each entry with a line `[[{kind}]]`");
                let span = self.span(key.span());
                self.mistake("known-type", span, message, &help);
                continue;
            };
            entries.extend(tables.iter().filter_map(|(header, table)| self.entry(kind, *header, table)));
        }
        entries
    }

    /// The tables of a list, each with its header; none where it is written in another way.
    fn tables<'t, 'i>(&self, value: &'t Spanned<DeValue<'i>>) -> Option<Vec<(Span, &'t DeTable<'i>)>> {
        let tables = value.get_ref().as_array()?.iter().map(|item| {
            let header = self.span(item.span());
            let has_header = self.sources.slice(header).starts_with("[[");
            item.get_ref().as_table().filter(|_| has_header).map(|table| (header, table))
        });
        tables.collect()
    }

    fn entry(&mut self, kind: ExcuseKind, header: Span, table: &DeTable<'_>) -> Option<Entry> {
        let before = self.mistakes.len();
        let values = self.values(table);
        // Of what is no string enough has been said.
        let is_mistyped = |keys: &[&str]| {
            keys.iter().any(|key| table.get(*key).is_some_and(|value| !value.get_ref().is_str()))
        };
        let names = if is_mistyped(&["rule", "case"]) { None } else { self.selector(&values, header) };
        let reason = if is_mistyped(&["reason"]) { None } else { self.reason(&values, header) };
        if let Some((link, span)) = values.link {
            self.line("link", link, span);
        }
        if self.mistakes.len() > before {
            return None;
        }
        let (names, selector) = names?;
        let end = table.values().map(|value| self.span(value.span()).end).max()?;
        Some(Entry {
            names,
            message: values.message.map(|(text, _)| text.to_owned()),
            excuse: Excuse {
                kind,
                reason: reason?.to_owned(),
                link: values.link.map(|(text, _)| text.to_owned()),
                expires: values.expires.map(|(date, _)| date),
            },
            spans: EntrySpans {
                header,
                selector,
                message: values.message.map(|(_, span)| span),
                expires: values.expires.map(|(_, span)| span),
                whole: Span { start: header.start, end },
            },
        })
    }

    fn values<'t>(&mut self, table: &'t DeTable<'_>) -> Values<'t> {
        let mut values = Values::default();
        for (key, value) in table {
            let spans = match key.get_ref().as_ref() {
                "rule" => &mut values.rule,
                "subject" => &mut values.subject,
                "file" => &mut values.file,
                "case" => &mut values.case,
                "reason" => &mut values.reason,
                "link" => &mut values.link,
                "message" => &mut values.message,
                "expires" => {
                    values.expires = self.date(value);
                    continue;
                }
                _ => {
                    let message = format!("an entry has no `{}`", key.get_ref());
                    let span = self.span(key.span());
                    self.mistake("known-key", span, message, KEYS);
                    continue;
                }
            };
            *spans = self.string(key, value);
        }
        values
    }

    fn string<'t>(
        &mut self,
        key: &Spanned<DeString<'_>>,
        value: &'t Spanned<DeValue<'_>>,
    ) -> Option<(&'t str, Span)> {
        let span = self.span(value.span());
        let text = value.get_ref().as_str();
        if text.is_none() {
            let message = format!("`{}` is a string, not this {}", key.get_ref(), value.get_ref().type_str());
            self.mistake("known-type", span, message, "put it in quotes");
        }
        text.map(|text| (text, span))
    }

    fn date(&mut self, value: &Spanned<DeValue<'_>>) -> Option<(Date, Span)> {
        let span = self.span(value.span());
        let datetime = value.get_ref().as_datetime().filter(|found| found.time.is_none());
        let date = datetime.and_then(|found| found.date);
        if date.is_none() {
            self.mistake("known-date", span, "`expires` is a date", "write it without quotes, as 2027-06-30");
        }
        date.map(|date| (Date { year: date.year, month: date.month, day: date.day }, span))
    }

    fn selector(&mut self, values: &Values<'_>, header: Span) -> Option<(Selector, Span)> {
        for (key, value) in [("subject", values.subject), ("file", values.file)] {
            if let Some((_, span)) = value.filter(|_| values.rule.is_none()) {
                let message = format!("`{key}` without `rule`");
                self.mistake(
                    "known-selector",
                    span,
                    message,
                    "it narrows a rule down: name the rule, or remove it",
                );
            }
        }
        match (values.rule, values.case) {
            (Some((id, span)), None) => {
                let rule = rule(id);
                if rule.is_none() {
                    self.mistake("known-rule", span, format!("no rule `{id}`"), "`uavspec rules` lists all");
                }
                let subject = self.pattern(values.subject, Pattern::for_names);
                let file = self.pattern(values.file, Pattern::for_paths);
                Some((Selector::Rule { rule: rule?, subject, file }, span))
            }
            (None, Some((_, span))) => {
                let case = self.pattern(values.case, Pattern::for_names)?;
                Some((Selector::Case(case), span))
            }
            (Some(_), Some((_, span))) => {
                let help = "leave one of them out: an entry names a rule or cases";
                self.mistake("known-selector", span, "`case` beside `rule`", help);
                None
            }
            (None, None) => {
                let help = "name a `rule`, or `case`s by a pattern";
                self.mistake("known-selector", header, "the entry names nothing", help);
                None
            }
        }
    }

    fn pattern(
        &mut self,
        value: Option<(&str, Span)>,
        read: fn(&str) -> Result<Pattern, String>,
    ) -> Option<Pattern> {
        let (text, span) = value?;
        read(text)
            .map_err(|error| {
                let help = format!("for the characters themselves write `{}`", escape(text));
                self.mistake("known-pattern", span, format!("`{text}` is no pattern: {error}"), &help);
            })
            .ok()
    }

    fn reason<'t>(&mut self, values: &Values<'t>, header: Span) -> Option<&'t str> {
        let help = "say why, so that others can tell when it no longer holds";
        let (reason, span) = values.reason.unwrap_or(("", header));
        if reason.trim().is_empty() {
            self.mistake("known-reason", span, "the entry has no `reason`", help);
            return None;
        }
        self.line("reason", reason, span).then_some(reason)
    }

    /// Whether a text is a line: reports show it as one, and control characters would change how they look.
    fn line(&mut self, key: &str, text: &str, span: Span) -> bool {
        let is_line = !text.chars().any(char::is_control);
        if !is_line {
            let message = format!("`{key}` has a line break or another control character");
            self.mistake("known-type", span, message, "write it in one line");
        }
        is_line
    }
}
