//! Parses the text of a list into entries, and reports all mistakes in it.

use globset::escape;
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use uavspec_dynamic::breaking;
use uavspec_schema::diagnostic::Level;
use uavspec_schema::finding::Finding;
use uavspec_schema::source::{SourceId, Span};
use uavspec_schema::wording::similar;
use uavspec_schema::{Date, SourceMap};

use super::{Entry, Pattern, Spans};
use crate::RULES;

/// The keys of an entry.
const KEYS: [&str; 9] = ["rule", "subject", "file", "case", "count", "message", "reason", "link", "expires"];

/// The entries and the mistakes of a list, in line order.
pub(super) fn entries(
    sources: &SourceMap,
    source: SourceId,
    rules: &[&'static str],
) -> (Vec<Entry>, Vec<Finding>) {
    let mut reader = Reader { sources, whole: sources.span(source), rules, mistakes: Vec::new() };
    let (table, errors) = DeTable::parse_recoverable(sources.text(source));
    for error in &errors {
        let span = reader.whole.part(error.span().unwrap_or_default());
        reader.mistake("baseline-syntax", span, error.message(), "correct the TOML syntax");
    }
    // Skip a partly parsed list, which would only cause follow-up errors.
    let mut entries = if errors.is_empty() { reader.list(table.get_ref()) } else { Vec::new() };
    reader.mistakes.sort_by_key(|mistake| mistake.span);
    entries.sort_by_key(|entry| entry.spans.header);
    (entries, reader.mistakes)
}

struct Reader<'s> {
    sources: &'s SourceMap,
    whole: Span,
    rules: &'s [&'static str],
    mistakes: Vec<Finding>,
}

/// A value with its location.
type Located<T> = Option<(T, Span)>;

impl Reader<'_> {
    fn span<T>(&self, part: &Spanned<T>) -> Span {
        self.whole.part(part.span())
    }

    fn mistake(&mut self, id: &'static str, span: Span, message: impl Into<String>, help: impl Into<String>) {
        let mut finding = Finding::new(id, Level::Error, span, message);
        finding.help(help);
        self.mistakes.push(finding);
    }

    fn list(&mut self, table: &DeTable<'_>) -> Vec<Entry> {
        let mut entries = Vec::new();
        for (key, value) in table {
            let (kind, span) = (key.get_ref().as_ref(), self.span(key));
            if !["known", "flaky"].contains(&kind) {
                let help = "start each entry with `[[known]]` or `[[flaky]]`";
                self.mistake("baseline-key", span, format!("unknown key `{kind}`"), help);
                continue;
            }
            // Only an entry with a separate header line can be removed without other changes.
            let tables = value.get_ref().as_array().and_then(|array| {
                let has_header = |item| self.sources.slice(self.span(item)).starts_with("[[");
                let tables = array.iter().map(|item| {
                    item.get_ref()
                        .as_table()
                        .filter(|_| has_header(item))
                        .map(|table| (self.span(item), table))
                });
                tables.collect::<Option<Vec<_>>>()
            });
            let Some(tables) = tables else {
                let message = format!("`{kind}`: expected an array of tables");
                let help = format!("start each entry with `[[{kind}]]`");
                self.mistake("baseline-type", span, message, help);
                continue;
            };
            let is_flaky = kind == "flaky";
            entries.extend(tables.iter().filter_map(|(header, table)| {
                let before = self.mistakes.len();
                let entry = self.entry(*header, table)?;
                (self.mistakes.len() == before).then_some(Entry { is_flaky, ..entry })
            }));
        }
        entries
    }

    /// The entry in a table. An entry with mistakes lacks some of its values.
    fn entry(&mut self, header: Span, table: &DeTable<'_>) -> Option<Entry> {
        for key in table.keys().filter(|key| !KEYS.contains(&key.get_ref().as_ref())) {
            let message = format!("unknown key `{}` in an entry", key.get_ref());
            self.mistake("baseline-key", self.span(key), message, format!("expected {}", KEYS.join(", ")));
        }
        self.check_keys(header, table);
        let rule = self.rule(table);
        let case = self.pattern(table, "case", Pattern::for_names);
        let subject = self.pattern(table, "subject", Pattern::for_names);
        let file = self.pattern(table, "file", Pattern::for_paths);
        let count = self.count(table);
        let message = self.text(table, "message");
        let reason = self.reason(header, table);
        let link = self.text(table, "link");
        let expires = self.date(table);
        let span_of = |key| table.get(key).map(|value| self.span(value));
        let end = table.values().map(|value| self.span(value).end).max()?;
        let spans = Spans {
            header,
            name: span_of("case").or(span_of("subject")).or(span_of("rule"))?,
            count: span_of("count"),
            message: span_of("message"),
            expires: span_of("expires"),
            whole: Span { start: header.start, end },
        };
        // Replace control characters, because reports print these texts within a line.
        let one_line = |text: &str| text.replace(char::is_control, " ");
        Some(Entry {
            rule: rule.map(str::to_owned),
            is_flaky: false,
            reason: one_line(reason?),
            link: link.map(|(text, _)| one_line(text)),
            expires,
            name: case.or(subject),
            file,
            count,
            is_exceeded: false,
            message: message.map(|(text, _)| text.to_owned()),
            spans,
        })
    }

    /// Checks that the keys of an entry may be combined.
    fn check_keys(&mut self, header: Span, table: &DeTable<'_>) {
        const ID: &str = "baseline-selector";
        let value = |key| table.get(key);
        match (value("rule"), value("case")) {
            (Some(_), Some(case)) => {
                let help = "remove one of them: an entry applies to either a rule or cases";
                self.mistake(ID, self.span(case), "`case` and `rule` in one entry", help);
            }
            (None, None) => {
                let help = "add a `rule`, or a `case` pattern";
                self.mistake(ID, header, "the entry has neither `rule` nor `case`", help);
            }
            _ => {}
        }
        for key in ["subject", "file"] {
            if let (Some(value), None) = (value(key), value("rule")) {
                let help = "add a `rule` to the entry, or remove this key";
                self.mistake(ID, self.span(value), format!("`{key}` without `rule`"), help);
            }
        }
        let has_other_rule = value("rule").and_then(|rule| rule.get_ref().as_str());
        let has_other_rule = has_other_rule.is_some_and(|id| self.rules.contains(&id));
        if let Some(count) = value("count").filter(|_| has_other_rule || value("case").is_some()) {
            let message = "`count` is only for rules of `lint` and `breaking`";
            self.mistake(ID, self.span(count), message, "remove this key");
        }
    }

    fn rule<'t>(&mut self, table: &'t DeTable<'_>) -> Option<&'t str> {
        let (id, span) = self.text(table, "rule")?;
        let ids = || RULES.iter().map(|rule| rule.id).chain(breaking::RULES.iter().map(|rule| rule.id));
        // The ids of other rules are in capitals.
        let is_other = self.rules.is_empty() && id.starts_with(|first: char| first.is_ascii_uppercase());
        if !is_other && !ids().chain(self.rules.iter().copied()).any(|known| known == id) {
            let help = similar(id, ids().chain(self.rules.iter().copied())).map_or_else(
                || "`uavspec rules` and `uavspec lint --rules` list the rules".to_owned(),
                |similar| format!("did you mean `{similar}`?"),
            );
            self.mistake("baseline-rule", span, format!("unknown rule `{id}`"), help);
        }
        Some(id)
    }

    fn text<'t>(&mut self, table: &'t DeTable<'_>, key: &str) -> Located<&'t str> {
        let value = table.get(key)?;
        let (text, span) = (value.get_ref().as_str(), self.span(value));
        if text.is_none() {
            let message = format!("`{key}`: expected a string, found type {}", value.get_ref().type_str());
            self.mistake("baseline-type", span, message, "put the value in quotes");
        }
        text.map(|text| (text, span))
    }

    fn pattern(
        &mut self,
        table: &DeTable<'_>,
        key: &str,
        read: fn(&str) -> Result<Pattern, String>,
    ) -> Option<Pattern> {
        let (text, span) = self.text(table, key)?;
        let pattern = read(text).map_err(|error| {
            let help = format!("to match this text literally, write `{}`", escape(text));
            self.mistake("baseline-pattern", span, format!("invalid pattern `{text}`: {error}"), help);
        });
        pattern.ok()
    }

    fn count(&mut self, table: &DeTable<'_>) -> Option<usize> {
        let value = table.get("count")?;
        let number = value.get_ref().as_integer();
        let count = number.and_then(|number| usize::from_str_radix(number.as_str(), number.radix()).ok());
        if count.is_none() {
            let message = "`count`: expected a number of findings";
            self.mistake("baseline-type", self.span(value), message, "write a number without quotes");
        }
        count
    }

    fn reason<'t>(&mut self, header: Span, table: &'t DeTable<'_>) -> Option<&'t str> {
        let (reason, span) = match table.get("reason") {
            Some(_) => self.text(table, "reason")?,
            None => ("", header),
        };
        if reason.trim().is_empty() {
            let help = "explain the findings, so others know when to remove the entry";
            self.mistake("baseline-reason", span, "the entry has no `reason`", help);
        }
        Some(reason)
    }

    fn date(&mut self, table: &DeTable<'_>) -> Option<Date> {
        let value: &Spanned<DeValue<'_>> = table.get("expires")?;
        let datetime = value.get_ref().as_datetime().filter(|found| found.time.is_none());
        let date = datetime.and_then(|found| found.date);
        if date.is_none() {
            let help = "write it without quotes, e.g. 2027-06-30";
            self.mistake("baseline-date", self.span(value), "`expires`: expected a date", help);
        }
        date.map(|date| Date { year: date.year, month: date.month, day: date.day })
    }
}
