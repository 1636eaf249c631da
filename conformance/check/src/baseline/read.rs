//! Parses the text of a list into entries, and reports all errors in it.

use std::ops::Range;

use globset::escape;
use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};
use uavspec_model::{Excuse, ExcuseKind};
use uavspec_rules::rule;
use uavspec_schema::Date;
use uavspec_schema::SourceMap;
use uavspec_schema::diagnostic::Level;
use uavspec_schema::finding::Finding;
use uavspec_schema::source::{SourceId, Span};

use super::{Entry, EntrySpans, Pattern, Selector};

/// The allowed keys of an entry, for error messages.
const KEYS: &str = "expected rule, subject, file, case, reason, link, expires or message";

/// The entries and the errors of a list, in line order.
pub(super) fn entries(sources: &SourceMap, source: SourceId) -> (Vec<Entry>, Vec<Finding>) {
    let mut reader = Reader { sources, whole: sources.span(source), mistakes: Vec::new() };
    let (table, errors) = DeTable::parse_recoverable(sources.text(source));
    for error in &errors {
        let span = reader.span(error.span().unwrap_or_default());
        reader.mistake("baseline-syntax", span, error.message(), "correct the TOML syntax");
    }
    // A partly parsed list would only cause follow-up errors.
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
                let message = format!("unknown key `{}`", key.get_ref());
                let span = self.span(key.span());
                let help = "start each entry with `[[known]]` or `[[flaky]]`";
                self.mistake("baseline-key", span, message, help);
                continue;
            };
            // Only an entry with a separate header line can be removed without other changes.
            let Some(tables) = self.tables(value) else {
                let message = format!("`{kind}`: expected an array of tables");
                let help = format!("start each entry with a line `[[{kind}]]`");
                let span = self.span(key.span());
                self.mistake("baseline-type", span, message, &help);
                continue;
            };
            entries.extend(tables.iter().filter_map(|(header, table)| self.entry(kind, *header, table)));
        }
        entries
    }

    /// The tables of a list, each with its header. `None` if the list has a different form.
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
        // Values of a wrong type have been reported already.
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
                    let message = format!("unknown key `{}` in an entry", key.get_ref());
                    let span = self.span(key.span());
                    self.mistake("baseline-key", span, message, KEYS);
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
            let message =
                format!("`{}`: expected a string, found type {}", key.get_ref(), value.get_ref().type_str());
            self.mistake("baseline-type", span, message, "put the value in quotes");
        }
        text.map(|text| (text, span))
    }

    fn date(&mut self, value: &Spanned<DeValue<'_>>) -> Option<(Date, Span)> {
        let span = self.span(value.span());
        let datetime = value.get_ref().as_datetime().filter(|found| found.time.is_none());
        let date = datetime.and_then(|found| found.date);
        if date.is_none() {
            self.mistake(
                "baseline-date",
                span,
                "`expires`: expected a date",
                "write it without quotes, e.g. 2027-06-30",
            );
        }
        date.map(|date| (Date { year: date.year, month: date.month, day: date.day }, span))
    }

    fn selector(&mut self, values: &Values<'_>, header: Span) -> Option<(Selector, Span)> {
        for (key, value) in [("subject", values.subject), ("file", values.file)] {
            if let Some((_, span)) = value.filter(|_| values.rule.is_none()) {
                let message = format!("`{key}` without `rule`");
                self.mistake(
                    "baseline-selector",
                    span,
                    message,
                    "add a `rule` to the entry, or remove this key",
                );
            }
        }
        match (values.rule, values.case) {
            (Some((id, span)), None) => {
                let rule = rule(id);
                if rule.is_none() {
                    self.mistake(
                        "baseline-rule",
                        span,
                        format!("unknown rule `{id}`"),
                        "`uavspec rules` lists all rules",
                    );
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
                let help = "remove one of them: an entry applies to either a rule or cases";
                self.mistake("baseline-selector", span, "`case` and `rule` in one entry", help);
                None
            }
            (None, None) => {
                let help = "add a `rule`, or a `case` pattern";
                self.mistake("baseline-selector", header, "the entry has neither `rule` nor `case`", help);
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
                let help = format!("to match this text literally, write `{}`", escape(text));
                self.mistake("baseline-pattern", span, format!("invalid pattern `{text}`: {error}"), &help);
            })
            .ok()
    }

    fn reason<'t>(&mut self, values: &Values<'t>, header: Span) -> Option<&'t str> {
        let help = "explain the failure, so others know when to remove the entry";
        let (reason, span) = values.reason.unwrap_or(("", header));
        if reason.trim().is_empty() {
            self.mistake("baseline-reason", span, "the entry has no `reason`", help);
            return None;
        }
        self.line("reason", reason, span).then_some(reason)
    }

    /// True if the text is a single line without control characters. Reports print it unchanged.
    fn line(&mut self, key: &str, text: &str, span: Span) -> bool {
        let is_line = !text.chars().any(char::is_control);
        if !is_line {
            let message = format!("`{key}` contains a line break or another control character");
            self.mistake("baseline-type", span, message, "write it on one line without control characters");
        }
        is_line
    }
}
