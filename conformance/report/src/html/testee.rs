//! The results of a testee as HTML.

use maud::{Markup, html};
use uavspec_model::text::thousands;

use super::{fact, finding, number, shown};
use crate::{Case, Counts, Testee};

/// The number of failures that are initially visible. The user can expand the rest.
const MAX_OPEN: usize = 8;

/// The maximum number of failures in the expanded part. The JSON report has more.
const MAX_LISTED_ITEMS: usize = 200;

pub(super) fn section(testee: &Testee) -> Markup {
    let failures: Vec<&Case> = testee.cases.iter().filter(|case| case.verdict.is_failure()).collect();
    let (open, rest) = failures.split_at(failures.len().min(MAX_OPEN));
    let listed = &rest[..rest.len().min(MAX_LISTED_ITEMS)];
    html! {
        @if let Some(reason) = &testee.gave_up { p.what { "The run ended early: " (shown(reason)) } }
        (protocol_remarks(testee))
        @if !failures.is_empty() {
            h3 { "Failures" }
            @for case in open { (article(case)) }
            @if !rest.is_empty() {
                details.rest {
                    summary { (rest.len()) " more failure" @if rest.len() > 1 { "s" } }
                    @for case in listed { (article(case)) }
                    @if listed.len() < rest.len() { p.more { "… and " (rest.len() - listed.len()) " more" } }
                }
            }
        }
        (table(testee))
    }
}

fn protocol_remarks(testee: &Testee) -> Markup {
    html! {
        @if !testee.protocol_remarks.is_empty() {
            h3 { "Protocol violations" }
            ul {
                @for remark in &testee.protocol_remarks {
                    li { (shown(&remark.message)) @if remark.count > 1 { ", " (thousands(remark.count)) " times" } }
                }
                @if testee.more_protocol_remarks > 0 { li { "… and " (thousands(testee.more_protocol_remarks)) " more" } }
            }
        }
    }
}

/// The counts of each type and operation.
fn table(testee: &Testee) -> Markup {
    html! {
        h3 { "Cases" }
        table.counts role="table" {
            thead role="rowgroup" {
                tr role="row" {
                    th scope="col" role="columnheader" { "Type" }
                    th.number scope="col" role="columnheader" { "Pass" }
                    th.number scope="col" role="columnheader" { "Fail" }
                    th.number scope="col" role="columnheader" { "Known" }
                    th.number scope="col" role="columnheader" { abbr title="unsupported" { "Uns." } }
                    th.number scope="col" role="columnheader" { abbr title="not run" { "Not" } }
                }
            }
            tbody role="rowgroup" {
                @for row in testee.supported() {
                    @let Counts { passed, failed, known, unsupported, not_run } = row.counts;
                    tr role="row" {
                        td role="cell" { code { (shown(&row.type_name)) } " " span.level { (shown(&row.op)) } }
                        td.number role="cell" { (number(passed)) }
                        td.number role="cell" { @if failed > 0 { strong.fail { (thousands(failed)) } } @else { (number(0)) } }
                        td.number role="cell" { (number(known)) }
                        td.number role="cell" { (number(unsupported)) }
                        td.number role="cell" { (number(not_run)) }
                    }
                }
            }
        }
        @for line in testee.unsupported_lines() { p { "Unsupported: " (line) } }
    }
}

fn article(case: &Case) -> Markup {
    html! {
        article.finding {
            p.tags {
                span.badge.fail { (case.verdict.name()) } " "
                @if let Some(rule) = &case.rule { span.id { (shown(rule)) } " " }
                span.level { (shown(&case.op)) }
            }
            h4 { code { (shown(&case.name)) } }
            p.what { (shown(&case.description)) }
            dl.evidence {
                (fact("At", &case.path))
                (fact("Expected", &case.expected))
                (fact("Got", &case.actual))
                (fact("Result", &case.message))
                (finding::definition(case.definition.as_ref()))
                (finding::known(case.known.as_ref()))
            }
            @if !case.stderr.is_empty() {
                details {
                    summary { "Standard error" }
                    pre { code { @for line in case.stderr.lines() { (shown(line)) "\n" } } }
                }
            }
            (finding::reproduce(&case.reproduce))
        }
    }
}
