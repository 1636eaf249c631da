//! The section of a subject.

use maud::{Markup, PreEscaped, html};
use uavspec_check::Line;
use uavspec_model::text::{plural, thousands};
use uavspec_probe::RequestType;

use super::{class, finding, number, shown, testee};
use crate::outcome::capitalized;
use crate::{About, OutcomeKind, Report, Subject, Unreadable};

/// The number of list items that are initially visible. The user can expand the rest.
const MAX_OPEN: usize = 4;

/// The maximum number of items in the expanded part. The JSON report has more.
const MAX_LISTED_ITEMS: usize = 50;

/// The maximum number of unreadable files in the table, and the maximum number of other files. Browsers can't open much
/// larger tables.
pub(super) const MAX_ROWS: usize = 10_000;

/// The table of files or testees. `rows` are the rows of the first subjects.
pub(crate) fn list(report: &Report, rows: &str) -> Markup {
    let noun = super::noun(report.action);
    let (failed, not_checked) = (&report.unreadable, &report.not_checked);
    let row = |class: &str, outcome: &str, file: &Unreadable| -> Markup {
        html! {
            tr role="row" {
                td role="cell" { span.badge.(class) { (outcome) } }
                td role="cell" { code.path { (shown(&file.path)) } p { (shown(&file.message)) } }
                td.number role="cell" {}
            }
        }
    };
    let more = |count: usize, max: usize, rest: &str| -> Markup {
        let more = count.saturating_sub(max);
        html! { @if more > 0 { p.more { "… and " (more) " more " (rest) } } }
    };
    html! {
        section aria-labelledby="files" {
            h2 id="files" { (capitalized(noun)) "s" }
            table.files role="table" {
                thead role="rowgroup" {
                    tr role="row" {
                        th scope="col" role="columnheader" { "Outcome" }
                        th scope="col" role="columnheader" { (capitalized(noun)) }
                        th.number scope="col" role="columnheader" { "Messages" }
                    }
                }
                tbody role="rowgroup" {
                    @for file in failed.iter().take(MAX_ROWS) { (row("fail", OutcomeKind::Failed.name(), file)) }
                    (PreEscaped(rows))
                    @for file in not_checked.iter().take(MAX_LISTED_ITEMS) { (row("none", "not checked", file)) }
                }
            }
            (more(failed.len(), MAX_ROWS, "files that failed; the JSON report lists all of them"))
            (more(report.totals.subjects, MAX_ROWS, "files that were checked; the JSON report lists all of them"))
            (more(not_checked.len(), MAX_LISTED_ITEMS, "files that were not checked"))
        }
    }
}

/// The row of a subject in the table.
pub(super) fn row(subject: &Subject) -> Markup {
    html! {
        tr role="row" {
            td role="cell" { span.badge.(class(subject.outcome.kind)) { (subject.outcome.kind.name()) } }
            td role="cell" { code.path { (shown(&subject.path)) } p { (shown(&subject.outcome.text)) } }
            td.number role="cell" { (thousands(subject.coverage.records.checked)) }
        }
    }
}

/// True if the subject needs a section in addition to its row.
pub(super) fn has_details(subject: &Subject) -> bool {
    !subject.findings.is_empty()
        || !subject.corruption.is_empty()
        || subject.is_testee()
        || subject.outcome.kind != OutcomeKind::Conforms
}

/// The section of a subject. `index` makes the section's anchor unique. In a report with a single subject, the coverage
/// is in the head, and the command of the whole run is in the footer.
pub(super) fn section(noun: &str, subject: &Subject, index: usize, is_single: bool, command: &str) -> Markup {
    let anchor = format!("subject-{}", index + 1);
    let is_shown = |line: &Line| !is_single || !line.lists.is_empty() || !line.details.is_empty();
    html! {
        section.subject aria-labelledby=(anchor) {
            h2 id=(anchor) { (noun) " " code.path { (shown(&subject.path)) } }
            p.facts { (facts(subject)) }
            @if !is_single && !subject.outcome.remarks.is_empty() {
                ul.remarks { @for remark in &subject.outcome.remarks { li { (shown(remark)) } } }
            }
            @for line in subject.coverage_lines().iter().filter(|line| is_shown(line)) { (summary_line(line)) }
            @match &subject.about {
                About::Capture(summary) => {
                    @for line in subject.summary_lines(summary.describe()) { (summary_line(&line)) }
                },
                About::Testee(testee) => (testee::section(testee)),
            }
            (corruption(subject))
            (notes(&subject.notes))
            (requests(&subject.requests))
            @if let Some(first) = subject.findings.first().filter(|first| first.reproduce != command) {
                (finding::reproduce(&first.reproduce))
            }
        }
    }
}

fn facts(subject: &Subject) -> Markup {
    let facts = match &subject.about {
        About::Capture(summary) => summary.describe().facts(subject.totals()),
        About::Testee(testee) => {
            let version = (!testee.version.is_empty()).then(|| format!("version {}", shown(&testee.version)));
            let counts = [plural(subject.records, "case"), plural(testee.restarts, "restart")];
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
    html! {
        h3 { (capitalized(line.label)) }
        p { (line.text) }
        @for list in line.lists.iter().filter(|list| !list.items.is_empty()) {
            (folded(&list.items, "line", |item| html! { li { span.place { (list.label) } ": " (item) } }))
        }
        @if !line.details.is_empty() { (folded(&line.details, "line", |detail| html! { li { (detail) } })) }
    }
}

fn notes(notes: &[String]) -> Markup {
    html! {
        @if !notes.is_empty() {
            h3 { "Notes" }
            (folded(notes, "note", |note| html! { li { (shown(note)) } }))
        }
    }
}

fn corruption(subject: &Subject) -> Markup {
    html! {
        @if !subject.corruption.is_empty() {
            h3 { "Corrupt or unreadable parts" }
            (folded(&subject.corruption, "part", |corruption| html! {
                li { span.place { (corruption.location) } ": " (shown(&corruption.message)) }
            }))
            @if subject.more_corruption > 0 { p.more { "… and " (thousands(subject.more_corruption)) " more parts" } }
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

/// The request types, in a folded table. Types that were not sent come first.
fn requests(requests: &[RequestType]) -> Markup {
    let (unsent, sent): (Vec<_>, Vec<_>) = requests.iter().partition(|request| request.not_sent.is_some());
    html! {
        @if !requests.is_empty() {
            details.rest {
                summary { "Request types: " (sent.len()) " sent, " (unsent.len()) " not sent" }
                table.counts {
                    thead {
                        tr {
                            th scope="col" { "Type" }
                            th.number scope="col" { "Sent" }
                            th.number scope="col" { "Answered" }
                            th.number scope="col" { "Refused" }
                        }
                    }
                    tbody {
                        @for request in unsent.iter().chain(&sent) {
                            tr {
                                th scope="row" {
                                    code { (shown(&request.name)) }
                                    @if let Some(reason) = &request.not_sent { p.aside { "not sent: " (shown(reason)) } }
                                }
                                @for count in [request.sent, request.answered, request.refused] {
                                    td.number { (number(count)) }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}
