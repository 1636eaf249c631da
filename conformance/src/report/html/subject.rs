//! The section of a subject.

use maud::{Markup, html};
use uavspec_codegen::emit::docs::markdown::plural;

use super::finding;
use super::{badge, class, shown, testee, with_code};
use crate::check::Line;
use crate::report::{About, Finding, OutcomeKind, Report, RuleVerdict, Subject, Verdict};
use crate::rules::px4;
use crate::text::Grouped;

/// The number of list items that are initially visible. The user can expand the rest.
const MAX_OPEN: usize = 4;

/// The maximum number of items in the expanded part. The JSON report has more.
const MAX_LISTED_ITEMS: usize = 50;

/// The table of subjects.
pub(super) fn list(report: &Report) -> Markup {
    html! {
        section aria-labelledby="files" {
            h2 id="files" { "Files" }
            table.files role="table" {
                thead role="rowgroup" {
                    tr role="row" {
                        th scope="col" role="columnheader" { "Outcome" }
                        th scope="col" role="columnheader" { "File" }
                        th.number scope="col" role="columnheader" { "Messages" }
                    }
                }
                tbody role="rowgroup" {
                    @for unreadable in &report.unreadable {
                        tr role="row" {
                            td role="cell" { span.badge.fail { (OutcomeKind::Failed.name()) } }
                            td role="cell" {
                                code.path { (shown(&unreadable.path)) }
                                p { (shown(&unreadable.message)) }
                            }
                            td.number role="cell" {}
                        }
                    }
                    @for subject in &report.subjects {
                        tr role="row" {
                            td role="cell" { (outcome(subject)) }
                            td role="cell" { code.path { (shown(&subject.path)) } p { (shown(&subject.outcome.text)) } }
                            td.number role="cell" { (Grouped(subject.coverage.records.checked)) }
                        }
                    }
                    @for file in report.not_checked.iter().take(MAX_LISTED_ITEMS) {
                        tr role="row" {
                            td role="cell" { span.badge.none { "not checked" } }
                            td role="cell" { code.path { (shown(&file.path)) } p { (shown(&file.message)) } }
                            td.number role="cell" {}
                        }
                    }
                }
            }
            @let more = report.not_checked.len().saturating_sub(MAX_LISTED_ITEMS);
            @if more > 0 { p.more { "… and " (more) " more files that were not checked" } }
        }
    }
}

fn outcome(subject: &Subject) -> Markup {
    let outcome = subject.outcome.kind;
    html! { span.badge.(class(outcome)) { (outcome.name()) } }
}

/// True if the subject needs a section in addition to its row.
pub(super) fn has_details(subject: &Subject) -> bool {
    !subject.findings.is_empty()
        || !subject.corruption.is_empty()
        || subject.is_testee()
        || subject.outcome.kind != OutcomeKind::Conforms
}

/// The section of a subject. The index makes the section's anchors unique.
pub(super) fn section(subject: &Subject, index: usize) -> Markup {
    let anchor = anchor(index);
    html! {
        section.subject aria-labelledby=(anchor) {
            h2 id=(anchor) { code.path { (shown(&subject.path)) } }
            p.facts { (facts(subject)) }
            @if !subject.outcome.remarks.is_empty() {
                ul.remarks { @for remark in &subject.outcome.remarks { li { (shown(remark)) } } }
            }
            @for line in subject.coverage_lines() { (summary_line(&line)) }
            @match &subject.about {
                About::Capture(summary) => { @for line in summary.describe().lines() { (summary_line(&line)) } },
                About::Testee(testee) => (testee::section(testee)),
            }
            (corruption(subject))
            (notes(&subject.notes))
            (findings(subject, &anchor))
        }
    }
}

fn facts(subject: &Subject) -> Markup {
    let facts = match &subject.about {
        About::Capture(summary) => summary.describe().facts(subject.totals()),
        About::Testee(testee) => {
            let version = (!testee.version.is_empty()).then(|| format!("version {}", shown(&testee.version)));
            let counts = [plural(subject.records, "case"), plural(testee.restarts.into(), "restart")];
            version.into_iter().chain(counts).collect()
        }
    };
    html! {
        span { (shown(&subject.outcome.text)) } " "
        @for fact in &facts { span { (fact) } " " }
    }
}

/// A line of a summary, followed by its complete lists.
fn summary_line(line: &Line) -> Markup {
    let details: Vec<&String> = line.details.iter().collect();
    html! {
        h3 { (line.label[..1].to_uppercase()) (line.label[1..]) }
        p { (line.text) }
        @for list in line.lists.iter().filter(|list| !list.items.is_empty()) {
            (folded(&list.items, "line", |item| html! { li { span.place { (list.label) } ": " (item) } }))
        }
        @if !details.is_empty() { (folded(&details, "line", |detail| html! { li { (detail) } })) }
    }
}

fn notes(notes: &[String]) -> Markup {
    let notes: Vec<&String> = notes.iter().collect();
    html! {
        @if !notes.is_empty() {
            h3 { "Notes" }
            (folded(&notes, "note", |note| html! { li { (shown(note)) } }))
        }
    }
}

fn corruption(subject: &Subject) -> Markup {
    let corruption: Vec<_> = subject.corruption.iter().collect();
    html! {
        @if !corruption.is_empty() {
            h3 { "Corrupt or unreadable parts" }
            (folded(&corruption, "part", |corruption| html! {
                li { span.place { (corruption.location) } ": " (shown(&corruption.message)) }
            }))
            @if subject.more_corruption > 0 { p.more { "… and " (Grouped(subject.more_corruption)) " more parts" } }
        }
    }
}

/// A list with only the first items visible. The user can expand the rest.
fn folded<T>(items: &[T], noun: &str, item: impl Fn(&T) -> Markup) -> Markup {
    let (open, rest) = items.split_at(items.len().min(MAX_OPEN));
    let listed = &rest[..rest.len().min(MAX_LISTED_ITEMS)];
    html! {
        ul { @for found in open { (item(found)) } }
        @if !rest.is_empty() {
            details {
                summary { (rest.len()) " more " (noun) @if rest.len() > 1 { "s" } }
                ul { @for found in listed { (item(found)) } }
                @if listed.len() < rest.len() { p.more { "… and " (rest.len() - listed.len()) " more" } }
            }
        }
    }
}

/// The findings by rule, most severe first.
fn findings(subject: &Subject, anchor: &str) -> Markup {
    let mut rules: Vec<&RuleVerdict> = subject.rules.iter().filter(|rule| has_own_section(rule)).collect();
    rules.sort_by_key(|rule| std::cmp::Reverse(rule.verdict));
    html! {
        @if let Some(first) = subject.findings.first().filter(|_| !rules.is_empty()) {
            h3 { "Findings" }
            @for rule in rules { (rule_section(subject, rule, anchor)) }
            (finding::reproduce(&first.reproduce))
        }
    }
}

/// True if the findings of a rule are listed. Format differences appear in the summary instead, unless they are
/// failures.
fn has_own_section(rule: &RuleVerdict) -> bool {
    rule.findings > 0 && (rule.id != px4::FMT_01.rule.id || rule.verdict == Verdict::Fail)
}

/// The anchor for the findings of a rule in a subject.
pub(super) fn rule_anchor(subject: &Subject, index: usize, rule: &str) -> Option<String> {
    // Failures of a testee are listed by case.
    let has_anchor =
        !subject.is_testee() && subject.rules.iter().any(|found| found.id == rule && has_own_section(found));
    has_anchor.then(|| format!("{}-{rule}", anchor(index)))
}

fn anchor(index: usize) -> String {
    format!("subject-{}", index + 1)
}

fn rule_section(subject: &Subject, rule: &RuleVerdict, anchor: &str) -> Markup {
    let found: Vec<&Finding> = subject.findings.iter().filter(|finding| finding.rule == rule.id).collect();
    // Findings that don't affect the outcome are collapsed.
    let is_open = rule.verdict > Verdict::Shown;
    let (open, rest) = found.split_at(if is_open { found.len().min(MAX_OPEN) } else { 0 });
    let listed = &rest[..rest.len().min(MAX_LISTED_ITEMS)];
    html! {
        div.group id={ (anchor) "-" (rule.id) } {
            @if let Some(first) = found.first() {
                p.tags {
                    (badge(rule.verdict)) " " a.id href=(first.url) { (rule.id) } " "
                    span.level {
                        (rule.level) @if first.status != "normative" { ", " (first.status) }
                        ", found " (times(rule.findings))
                    }
                }
                p.aside { (with_code(first.statement)) }
            }
            @for finding in open { (finding::article(finding)) }
            @if !rest.is_empty() {
                details.rest {
                    summary {
                        (rest.len()) @if is_open { " more" } " finding" @if rest.len() > 1 { "s" }
                    }
                    @for finding in listed { (finding::article(finding)) }
                    @if listed.len() < rest.len() { p.more { "… and " (rest.len() - listed.len()) " more" } }
                }
            }
        }
    }
}

fn times(count: u64) -> String {
    if count == 1 { "once".to_owned() } else { format!("{} times", Grouped(count)) }
}
