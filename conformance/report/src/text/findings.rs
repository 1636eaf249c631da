//! The findings of a capture, as text. Findings of a rule that have the same message and location are merged, because
//! they usually have the same cause.

use std::fmt::{self, Write as _};

use anstyle::Style;
use uavspec_check::names;
use uavspec_model::text::{shown, thousands, wrapped};
use uavspec_model::{DISPUTED, Level};
use uavspec_rules::px4;

use super::{FAIL, PLAIN, WARN};
use crate::{Example, Finding, Subject, Verdict, by_rule};

/// The width of the column with the verdict.
const WORD: usize = 7;

/// The minimum width of the rule column.
const MIN_WIDTH: usize = 12;

/// The indentation of the details of a finding.
const DETAIL: usize = 6;

/// The maximum length of an excerpt, in characters.
const MAX_EXCERPT: usize = 300;

/// Findings of a rule that have the same message and location.
pub(super) struct Merged<'s> {
    first: &'s Finding,
    example: &'s Example,
    subjects: Vec<&'s str>,
}

/// The findings of a subject in the order of the report, starting with the most severe.
pub(super) fn merged(subject: &Subject) -> Vec<Merged<'_>> {
    let mut all: Vec<Merged<'_>> = Vec::new();
    for level in [Level::Must, Level::Should, Level::Info] {
        // The summary lists format differences instead.
        let is_of_level = |found: &&Finding| found.level == level && found.rule != px4::FMT_01.rule.id;
        for found in subject.findings.iter().filter(is_of_level) {
            let Some(example) = found.examples.first() else { continue };
            match all.last_mut().filter(|last| last.is_like(found, example)) {
                Some(last) => last.subjects.push(&found.subject),
                None => all.push(Merged { first: found, example, subjects: vec![&found.subject] }),
            }
        }
    }
    all
}

impl Merged<'_> {
    fn is_like(&self, other: &Finding, example: &Example) -> bool {
        let Self { first, example: mine, .. } = self;
        (first.rule, first.verdict, first.count) == (other.rule, other.verdict, other.count)
            && (&mine.message, mine.location) == (&example.message, example.location)
            && first.known == other.known
    }
}

const fn style(verdict: Verdict) -> Style {
    match verdict {
        Verdict::Fail => FAIL,
        Verdict::Warn => WARN,
        _ => PLAIN,
    }
}

/// Writes a group of merged findings.
pub(super) fn write(merged: &Merged<'_>, subject: &Subject, text: &mut String) -> fmt::Result {
    let Merged { first: finding, example, subjects } = merged;
    let width =
        subject.findings.iter().map(|found| found.rule.len()).max().unwrap_or_default().max(MIN_WIDTH);
    let known = finding.known.as_ref();
    let word = known.map_or(finding.verdict.name(), |known| known.kind.name());
    let style = style(finding.verdict);
    let indent = width + WORD + 9;
    let content = match &subjects[..] {
        [only] => format!("{}: {}", shown(only), shown(&example.text())),
        many => format!("{}: {}", names(many.iter().copied()), shown(&example.message)),
    };
    let content = wrapped(&content, indent, indent);
    writeln!(text, "{style}{word:<WORD$}{style:#} {:<width$} {:<6} {content}", finding.rule, finding.level)?;
    let mut details = vec![place(finding, example, subject)];
    if !example.connection.is_empty() {
        let exchange = [("request: ", &example.request), ("message: ", &example.excerpt)];
        let exchange = exchange.into_iter().filter(|(_, content)| !content.is_empty());
        details.extend(exchange.map(|(name, content)| format!("{name}{}", excerpt(content))));
    }
    details.extend(finding.specification.iter().map(|page| format!("specification: {page}")));
    details.extend(known.map(ToString::to_string));
    for detail in details {
        writeln!(text, "{:DETAIL$}{}", "", wrapped(&detail, DETAIL, DETAIL + 2))?;
    }
    Ok(())
}

/// The number of findings, and details about the first one: its location in the file, its time and connection, and the
/// line of the definition.
fn place(finding: &Finding, example: &Example, subject: &Subject) -> String {
    let times = match finding.count {
        1 => "once".to_owned(),
        count => format!("{} times, first", thousands(count)),
    };
    let mut place = format!("{times} {}", by_rule::place(subject.is_readable_again, example));
    if let Some(line) = &finding.definition {
        let _ = write!(place, "   {line}");
    }
    if finding.status == DISPUTED {
        place.push_str("   disputed");
    }
    place
}

/// The start of a text from the capture.
fn excerpt(text: &str) -> String {
    let text = shown(text);
    match text.char_indices().nth(MAX_EXCERPT) {
        None => text,
        Some((end, _)) => format!("{}…", &text[..end]),
    }
}
