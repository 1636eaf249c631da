//! The findings by rule, and the rules without listed findings.

use maud::{Markup, html};
use uavspec_model::text::{plural, thousands};

use super::{badge, finding, with_code};
use crate::by_rule::{ByRule, Listed};
use crate::{RuleReport, Verdict};

/// The number of groups of a rule that are initially visible. The user can expand the rest.
const MAX_OPEN: usize = 4;

/// The maximum number of groups in the expanded part. The JSON report contains more.
const MAX_LISTED_ITEMS: usize = 50;

/// The number of rules above which the findings start with links to the rules.
const MAX_WITHOUT_LINKS: usize = 3;

/// The findings of all files, by rule.
pub(super) fn findings(rules: &[Listed<'_>], is_single: bool) -> Markup {
    html! {
        @if !rules.is_empty() {
            section aria-labelledby="findings" {
                h2 id="findings" { "Findings" }
                @if rules.len() > MAX_WITHOUT_LINKS {
                    nav aria-label="Rules with findings" {
                        ul.chips { @for Listed { rule, .. } in rules { li {
                            a href={ "#" (rule.id) } { (rule.id) } " "
                            span.aside { (thousands(rule.findings)) }
                        } } }
                    }
                }
                @for listed in rules { (rule_section(listed, is_single)) }
            }
        }
    }
}

fn rule_section(listed: &Listed<'_>, is_single: bool) -> Markup {
    let Listed { rule, groups, .. } = listed;
    // Findings that don't affect the outcome are collapsed.
    let is_open = rule.verdict > Verdict::Shown;
    let (open, rest) = groups.split_at(if is_open { groups.len().min(MAX_OPEN) } else { 0 });
    let shown = &rest[..rest.len().min(MAX_LISTED_ITEMS)];
    let num_rest = listed.num_groups - open.len();
    let more = listed.more_than(open.len() + shown.len());
    html! {
        section.group aria-labelledby=(rule.id) {
            h3 id=(rule.id) { (badge(rule.verdict)) " " (id(rule)) " " (level(rule)) }
            (requirement(rule))
            p.aside { (plural(rule.findings, "finding")) " in " (plural(rule.covered, "check")) }
            @for group in open { (finding::article(rule, group, is_single)) }
            @if num_rest > 0 {
                details.rest {
                    summary {
                        (num_rest) @if is_open { " more" } " group" @if num_rest > 1 { "s" } " of findings"
                    }
                    @for group in shown { (finding::article(rule, group, is_single)) }
                }
            }
            @if more > 0 { p.more { "… and " (plural(more, "more finding")) } }
        }
    }
}

fn level(rule: &RuleReport) -> Markup {
    html! { span.level { (rule.level) @if rule.status != "normative" { ", " (rule.status) } } }
}

fn requirement(rule: &RuleReport) -> Markup {
    html! {
        p { (with_code(rule.statement)) }
        @if let Some(dispute) = rule.dispute { p.aside { "Disputed: " (with_code(dispute)) } }
    }
}

/// The rules without listed findings. The rules that passed or weren't covered are folded.
pub(super) fn others(by_rule: &ByRule<'_>) -> Markup {
    let with = |verdict: Verdict| -> Vec<&RuleReport> {
        by_rule.others.iter().copied().filter(|rule| rule.verdict == verdict).collect()
    };
    let is_folded = |rule: &&&RuleReport| {
        matches!(rule.verdict, Verdict::Pass | Verdict::Unsupported | Verdict::NotCovered)
    };
    let open: Vec<&RuleReport> = by_rule.others.iter().filter(|rule| !is_folded(rule)).copied().collect();
    html! {
        @if !by_rule.others.is_empty() {
            section aria-labelledby="rules" {
                h2 id="rules" { @if by_rule.listed.is_empty() { "Rules" } @else { "Other rules" } }
                @if !open.is_empty() { (table("Findings", &open)) }
                @for (verdict, label) in [
                    (Verdict::Pass, "passed"),
                    (Verdict::Unsupported, "unsupported"),
                    (Verdict::NotCovered, "not covered"),
                ] {
                    @let rules = with(verdict);
                    @if !rules.is_empty() {
                        details.rest {
                            summary { (plural(rules.len(), "rule")) " " (label) }
                            (table("Checks", &rules))
                        }
                    }
                }
            }
        }
    }
}

/// The id of a rule, with a link to its page if the page is published.
fn id(rule: &RuleReport) -> Markup {
    html! {
        @if rule.url.is_empty() { span.id { (rule.id) } }
        @else { a.id href=(rule.url) { (rule.id) } }
    }
}

/// A table of rules. The heading of the last column is `Findings` or `Checks`.
fn table(heading: &str, rules: &[&RuleReport]) -> Markup {
    html! {
        table.rules {
            thead { tr { th scope="col" { "Rule" } th.number scope="col" { (heading) } } }
            tbody {
                @for rule in rules {
                    tr {
                        td {
                            @if heading == "Findings" { (badge(rule.verdict)) " " }
                            (id(rule)) " " (level(rule))
                            (requirement(rule))
                        }
                        td.number {
                            @if heading == "Findings" { (thousands(rule.findings)) } @else { (thousands(rule.covered)) }
                        }
                    }
                }
            }
        }
    }
}
