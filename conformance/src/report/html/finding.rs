//! A finding as HTML.

use maud::{Markup, html};

use super::{fact, shown};
use crate::report::{Definition, Example, Finding, Known};
use crate::text::Grouped;

pub(super) fn article(finding: &Finding) -> Markup {
    let (first, others) = match finding.examples.split_first() {
        Some((first, others)) => (Some(first), others),
        None => (None, &[][..]),
    };
    html! {
        article.finding {
            h4 { code { (shown(&finding.subject)) } }
            @if let Some(first) = first {
                p.what { (shown(&first.text())) }
                p.aside {
                    @if finding.count == 1 { "Once, at " } @else { (Grouped(finding.count)) " times, first at " }
                    (first.location)
                }
                dl.evidence {
                    (evidence(first))
                    (definition(finding.definition.as_ref()))
                    (known(finding.known.as_ref()))
                }
            }
            @if !others.is_empty() {
                details {
                    summary { "Other locations" }
                    ul {
                        @for other in others {
                            li {
                                (other.location) ": " (shown(&other.text()))
                                dl.evidence { (evidence(other)) }
                            }
                        }
                        @let more = finding.count.saturating_sub(finding.examples.len() as u64);
                        @if more > 0 { li { "… and " (Grouped(more)) " more times" } }
                    }
                }
            }
        }
    }
}

fn evidence(example: &Example) -> Markup {
    html! {
        (fact("At", example.at()))
        (fact("Expected", &example.expected))
        (fact("Found", &example.actual))
        (fact("Excerpt", &example.excerpt))
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

/// An entry in a list of known failures. Only HTTP and HTTPS links can be clicked.
pub(super) fn known(known: Option<&Known>) -> Markup {
    html! {
        @if let Some(known) = known {
            dt { "Known" }
            dd {
                (shown(&known.reason))
                @if let Some(expires) = &known.expires { ", until " (shown(expires)) }
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
