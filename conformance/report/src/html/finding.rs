//! A finding as HTML.

use maud::{Markup, html};
use uavspec_model::Excuse;
use uavspec_model::text::thousands;

use super::{badge, fact, shown};
use crate::by_rule::{Group, place};
use crate::{Definition, Example, RuleReport};

/// The findings of a rule in one topic or field.
pub(super) fn article(rule: &RuleReport, group: &Group, is_single: bool) -> Markup {
    let finding = &group.first;
    html! {
        article.finding {
            h4 {
                @if group.verdict != rule.verdict { (badge(group.verdict)) " " }
                code { (shown(&group.name)) }
            }
            @if let Some((first, others)) = finding.examples.split_first() {
                p.what { (shown(&first.text())) }
                @if let Some(places) = group.places(is_single) { p.aside { (shown(&places)) } }
                dl.evidence {
                    (values(first))
                    (definition(finding.definition.as_ref()))
                    (known(finding.known.as_ref()))
                }
                @if let Some(page) = &finding.specification {
                    p.aside { a href=(page) { "Specification" } }
                }
                (exchange(first))
                (other_examples(group, others))
            }
            (other_files(group))
        }
    }
}

fn other_examples(group: &Group, examples: &[Example]) -> Markup {
    let finding = &group.first;
    let more = finding.count.saturating_sub(finding.examples.len() as u64);
    html! {
        @if !examples.is_empty() {
            details {
                summary { "Other examples" }
                ul {
                    @for example in examples {
                        li {
                            (shown(&place(group.is_readable_again, example))) ": " (shown(&example.text()))
                            dl.evidence { (values(example)) }
                            (exchange(example))
                        }
                    }
                    @if more > 0 { li { "… and " (thousands(more)) " more times" } }
                }
            }
        }
    }
}

/// The other files, each with its first example.
fn other_files(group: &Group) -> Markup {
    let more = group.num_others - group.others.len();
    html! {
        @if group.num_others > 0 {
            details {
                summary { (group.num_others) " other file" @if group.num_others > 1 { "s" } }
                ul {
                    @for file in &group.others {
                        li {
                            code.path { (shown(&file.path)) } ": "
                            @if file.count > 1 { (thousands(file.count)) " times, first " }
                            @if let Some((place, text)) = &file.first { (shown(place)) ": " (shown(text)) }
                            dl.evidence { (known(file.known.as_ref())) }
                        }
                    }
                    @if more > 0 { li { "… and " (thousands(more)) " more" } }
                }
            }
        }
    }
}

fn values(example: &Example) -> Markup {
    html! {
        (fact("At", example.at()))
        (fact("Expected", &example.expected))
        (fact("Found", &example.actual))
    }
}

/// The request next to its answer. If the record belongs to no request, only the record.
fn exchange(example: &Example) -> Markup {
    let Example { request, excerpt, .. } = example;
    let of_record = if request.is_empty() { "Excerpt" } else { "Answer" };
    html! {
        @if !request.is_empty() || !excerpt.is_empty() {
            div.exchange { (quote("Request", request)) (quote(of_record, excerpt)) }
        }
    }
}

fn quote(label: &str, text: &str) -> Markup {
    html! {
        @if !text.is_empty() {
            figure { figcaption { (label) } pre { code { (shown(text)) } } }
        }
    }
}

/// The line of the definition.
pub(super) fn definition(definition: Option<&Definition>) -> Markup {
    html! {
        @if let Some(definition) = definition {
            dt { "Defined" }
            dd {
                code { (shown(definition.text.trim())) }
                span.aside { " " (shown(&definition.to_string())) }
            }
        }
    }
}

/// An entry of a baseline. Only HTTP and HTTPS links can be clicked.
pub(super) fn known(known: Option<&Excuse>) -> Markup {
    html! {
        @if let Some(known) = known {
            dt { "Known" }
            dd {
                (shown(&known.reason))
                @if let Some(expires) = &known.expires { ", until " (expires.to_string()) }
                @if let Some(link) = &known.link {
                    @if link.starts_with("https://") || link.starts_with("http://") {
                        " " a href=(link) { (shown(link)) }
                    } @else {
                        " " (shown(link))
                    }
                }
            }
        }
    }
}

/// The command that reproduces a finding.
pub(super) fn reproduce(command: &str) -> Markup {
    html! {
        details {
            summary { "Reproduce" }
            pre { code { (shown(command)) } }
        }
    }
}
