//! For people: one page that needs no network and no script, with what it comes to at its top.
//!
//! Texts are escaped by the macro that makes the page, and what can't be seen is shown as an escape. A policy in
//! the page itself lets a browser load nothing and run nothing, should anything slip through.

mod finding;
mod subject;
mod testee;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::{About, Action, Counts, Outcome, OutcomeKind, Report, RuleReport, Subject, Verdict};
use crate::text::Grouped;
use crate::text::shown;

/// The style of the page; all of it, as the page loads nothing.
const STYLE: &str = include_str!("html/style.css");

/// What a browser may do with the page: apply its style.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'";

/// How many subjects are told of one by one: a page with all findings of ten thousand logs opens nowhere.
const MAX_SUBJECTS: usize = 100;

pub(super) fn write(report: &Report) -> String {
    let Report { outcome, subjects, .. } = report;
    // Those that need no more words stand in the list above only.
    let has_own_section = |subject: &&Subject| subjects.len() == 1 || subject::has_details(subject);
    let listed: Vec<&Subject> = subjects.iter().filter(has_own_section).collect();
    let shown_first = &listed[..listed.len().min(MAX_SUBJECTS)];
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="generator" content={ "uavspec " (report.uavspec) };
                title { (shown(&outcome.text)) " – uavspec" }
                style { (PreEscaped(STYLE)) }
            }
            body {
                main {
                    (head(report))
                    @if subjects.len() + report.unreadable.len() > 1 { (subject::list(report)) }
                    @if !report.rules.is_empty() { (rules(&report.rules, shown_first)) }
                    @for (index, subject) in shown_first.iter().enumerate() { (subject::section(subject, index)) }
                    @let more = listed.len() - shown_first.len();
                    @if more > 0 { p.more { "… and " (more) " more; the JSON report tells of all." } }
                }
                footer {
                    p { "To get this report again:" }
                    pre { code { (shown(&report.command)) } }
                    p { "Made by " a href="https://uavspec.dev/" { "uavspec" } " " (report.uavspec) "." }
                }
            }
        }
    };
    page.into_string() + "\n"
}

/// What it comes to, and the figures that say how much that is worth.
fn head(report: &Report) -> Markup {
    let Outcome { kind: outcome, text, remarks, .. } = &report.outcome;
    let what = match report.action {
        Action::Check => "Conformance of recorded data",
        Action::Test => "Conformance of a codec",
        Action::Probe => "Conformance of a live server",
    };
    html! {
        header.head.(class(*outcome)) {
            p.kicker { (what) }
            h1 { (shown(text)) }
            p.lede {
                @match report.subjects.as_slice() {
                    [only] => code.path { (shown(&only.path)) },
                    several => { (several.len()) " files" },
                }
                ", judged by " span.path { (shown(&report.definitions)) }
            }
            @if !remarks.is_empty() {
                ul.remarks { @for remark in remarks { li { (shown(remark)) } } }
            }
            (figures(report))
        }
    }
}

fn figures(report: &Report) -> Markup {
    let of = |verdict| report.count(verdict) as u64;
    let parts = match counts(report) {
        Some(counts) => vec![
            Part { class: "fail", label: "cases failed", count: counts.fail },
            Part { class: "info", label: "known failures", count: counts.known },
            Part { class: "pass", label: "cases passed", count: counts.pass },
            Part { class: "none", label: "unsupported", count: counts.unsupported },
            Part { class: "none", label: "not asked", count: counts.not_run },
        ],
        None => vec![
            Part { class: "fail", label: "rules broken", count: of(Verdict::Fail) },
            Part { class: "warn", label: "rules to look at", count: of(Verdict::Warn) },
            Part { class: "info", label: "shown, not judged", count: of(Verdict::Shown) },
            Part { class: "info", label: "known breaches", count: of(Verdict::Known) },
            Part { class: "pass", label: "rules hold", count: of(Verdict::Pass) },
            Part { class: "none", label: "not exercised", count: of(Verdict::NotCovered) },
        ],
    };
    // What nobody listed needs no figure.
    let parts: Vec<Part> =
        parts.into_iter().filter(|part| part.count > 0 || !part.label.starts_with("known")).collect();
    let checked: u64 = report.subjects.iter().map(|subject| subject.checked).sum();
    let records: u64 = report.subjects.iter().map(|subject| subject.records).sum();
    html! {
        div.bar aria-hidden="true" {
            @for part in parts.iter().filter(|part| part.count > 0) {
                span.(part.class) style={ "flex-grow:" (part.count) } {}
            }
        }
        dl.figures {
            @for part in &parts {
                div.(if part.count > 0 { part.class } else { "zero" }) {
                    dt { (part.label) }
                    dd { (Grouped(part.count)) }
                }
            }
            @if counts(report).is_none() {
                div {
                    dt { "messages judged" @if records > checked { ", of " (Grouped(records)) } }
                    dd { (Grouped(checked)) }
                }
            }
        }
    }
}

/// A part of a whole: a figure, and a stretch of the bar.
struct Part {
    class: &'static str,
    label: &'static str,
    count: u64,
}

/// The counts of all testees; none where none was asked.
fn counts(report: &Report) -> Option<Counts> {
    let mut all = None;
    for subject in &report.subjects {
        if let About::Testee(testee) = &subject.about {
            let all: &mut Counts = all.get_or_insert_default();
            all.pass += testee.counts.pass;
            all.fail += testee.counts.fail;
            all.known += testee.counts.known;
            all.unsupported += testee.counts.unsupported;
            all.not_run += testee.counts.not_run;
        }
    }
    all
}

fn rules(rules: &[RuleReport], subjects: &[&Subject]) -> Markup {
    let mut rules: Vec<&RuleReport> = rules.iter().collect();
    rules.sort_by_key(|rule| std::cmp::Reverse(rule.verdict));
    html! {
        section aria-labelledby="rules" {
            h2 id="rules" { "Rules" }
            // The roles stay where a narrow screen shows the rows as blocks.
            table.rules role="table" {
                thead role="rowgroup" {
                    tr role="row" {
                        th scope="col" role="columnheader" { "Verdict" }
                        th scope="col" role="columnheader" { "Rule" }
                        th.number scope="col" role="columnheader" { "Findings" }
                    }
                }
                tbody role="rowgroup" { @for rule in rules { (rule_row(rule, subjects)) } }
            }
        }
    }
}

fn rule_row(rule: &RuleReport, subjects: &[&Subject]) -> Markup {
    let mut anchors = subjects
        .iter()
        .enumerate()
        .filter_map(|(index, subject)| subject::rule_anchor(subject, index, rule.id));
    let first = anchors.next();
    html! {
        tr role="row" {
            td role="cell" { (badge(rule.verdict)) }
            td role="cell" {
                a.id href=(rule.url) { (rule.id) } " "
                span.level { (rule.level) @if rule.status != "normative" { ", " (rule.status) } }
                p { (with_code(rule.statement)) }
                @if let Some(dispute) = rule.dispute { p.aside { "Disputed: " (with_code(dispute)) } }
            }
            td.number role="cell" {
                @match first {
                    Some(anchor) => a href={ "#" (anchor) } { (Grouped(rule.findings)) },
                    None if rule.covered == 0 => span.aside title="nothing was there to judge" { "–" },
                    None => (Grouped(rule.findings)),
                }
                @if rule.covered > 0 { span.aside { " in " (Grouped(rule.covered)) " judged" } }
            }
        }
    }
}

/// A verdict as a word on its colour.
fn badge(verdict: Verdict) -> Markup {
    let class = match verdict {
        Verdict::Fail => "fail",
        Verdict::Warn | Verdict::Inconclusive => "warn",
        Verdict::Pass => "pass",
        Verdict::Shown | Verdict::Known => "info",
        Verdict::Unsupported | Verdict::NotCovered => "none",
    };
    html! { span.badge.(class) { (verdict.name()) } }
}

fn class(outcome: OutcomeKind) -> &'static str {
    match outcome {
        OutcomeKind::Conforms => "pass",
        OutcomeKind::Nothing | OutcomeKind::Stale => "warn",
        OutcomeKind::DoesNotConform | OutcomeKind::Incomplete => "fail",
    }
}

/// A text of ours, in which code stands between backticks.
fn with_code(text: &str) -> Markup {
    html! {
        @for (index, part) in text.split('`').enumerate() {
            @if index % 2 == 1 { code { (part) } } @else { (part) }
        }
    }
}

/// A row of a list of facts; nothing where there is nothing to say.
fn fact(label: &str, value: &str) -> Markup {
    html! {
        @if !value.is_empty() {
            dt { (label) }
            dd { code { (shown(value)) } }
        }
    }
}
