//! What came of a subject.

use maud::{Markup, html};

use super::finding;
use super::{badge, class, shown, testee, with_code};
use crate::report::{
    About, ChannelResult, Finding, Flockwave, FlockwaveType, Format, FormatResult, McapChannel, Report,
    RuleVerdict, Subject, Verdict,
};
use crate::text::Grouped;

/// How many findings of a rule, places of damage and formats stand open; more can be opened.
const MAX_OPEN: usize = 4;

/// How many of each are told at all; the JSON report has more.
const MAX_TOLD: usize = 50;

/// All subjects, a row each.
pub(super) fn list(report: &Report) -> Markup {
    html! {
        section aria-labelledby="files" {
            h2 id="files" { "Files" }
            table.files role="table" {
                thead role="rowgroup" {
                    tr role="row" {
                        th scope="col" role="columnheader" { "Conclusion" }
                        th scope="col" role="columnheader" { "File" }
                        th.number scope="col" role="columnheader" { "Messages" }
                    }
                }
                tbody role="rowgroup" {
                    @for unreadable in &report.unreadable {
                        tr role="row" {
                            td role="cell" { span.badge.fail { "unreadable" } }
                            td role="cell" { code.path { (shown(&unreadable.path)) } p { (shown(&unreadable.message)) } }
                            td.number role="cell" {}
                        }
                    }
                    @for subject in &report.subjects {
                        tr role="row" {
                            td role="cell" { (outcome(subject)) }
                            td role="cell" { code.path { (shown(&subject.path)) } p { (shown(&subject.conclusion.text)) } }
                            td.number role="cell" { (Grouped(subject.judged)) }
                        }
                    }
                }
            }
        }
    }
}

fn outcome(subject: &Subject) -> Markup {
    let outcome = subject.conclusion.outcome;
    let word = match class(outcome) {
        "pass" => "conforms",
        "fail" => "fails",
        _ => "nothing",
    };
    html! { span.badge.(class(outcome)) { (word) } }
}

/// Whether there is more to say of a subject than a row holds.
pub(super) fn has_more_to_tell(subject: &Subject) -> bool {
    !subject.findings.is_empty() || !subject.damage.is_empty() || matches!(subject.about, About::Testee(_))
}

/// All that is to be told of a subject. The index tells its anchors from those of others.
pub(super) fn section(subject: &Subject, index: usize) -> Markup {
    let anchor = anchor(index);
    html! {
        section.subject aria-labelledby=(anchor) {
            h2 id=(anchor) { code.path { (shown(&subject.path)) } }
            p.facts { (facts(subject)) }
            @match &subject.about {
                About::Ulog(log) => (formats(&log.formats)),
                About::Json(json) => {
                    (notes("Other ways of writing, let pass", &json.dialects))
                    (notes("Without a definition, and not judged", &json.undefined))
                },
                About::Mcap(mcap) => {
                    (channels(&mcap.channels))
                    (notes("Other ways of writing, let pass", &mcap.dialects))
                },
                About::Flockwave(found) => (message_types(found)),
                About::Testee(testee) => (testee::section(testee)),
            }
            (damage(subject))
            (notes("What happened", &subject.notes))
            (findings(subject, &anchor))
        }
    }
}

fn facts(subject: &Subject) -> Markup {
    let mut facts = vec![subject.conclusion.text.clone()];
    let count = |number: u64, what: &str| {
        let ending = if number == 1 { "" } else { "s" };
        format!("{} {what}{ending}", Grouped(number))
    };
    match &subject.about {
        About::Ulog(log) => {
            facts.extend(log.firmware.clone());
            facts.push(count(log.formats.len() as u64, "topic"));
            facts.push(count(subject.records, "message"));
            facts.push(count(log.dropouts, "dropout"));
        }
        About::Json(json) => {
            facts.push(count(json.lines, "line"));
            facts.push(count(subject.records, "message"));
            facts.push(count(json.types, "type"));
            if json.skipped > 0 {
                facts.push(format!("{} that publish nothing", Grouped(json.skipped)));
            }
        }
        About::Mcap(mcap) => {
            facts.extend([&mcap.profile, &mcap.library].into_iter().filter(|text| !text.is_empty()).cloned());
            facts.push(count(mcap.channels.len() as u64, "channel"));
            facts.push(count(subject.records, "message"));
        }
        About::Flockwave(found) => {
            facts.push(count(found.connections, "connection"));
            facts.push(count(found.requests, "request"));
            facts.push(count(found.responses, "response"));
            facts.push(count(found.notifications, "notification"));
            facts.push(count(found.types.len() as u64, "message type"));
        }
        About::Testee(testee) => {
            if !testee.version.is_empty() {
                facts.push(format!("version {}", testee.version));
            }
            facts.push(count(subject.records, "case"));
            facts.push(count(testee.restarts.into(), "restart"));
        }
    }
    let seconds = subject.duration_us / 1_000_000;
    if seconds > 0 {
        facts.push(format!("{} min {} s", seconds / 60, seconds % 60));
    }
    html! { @for fact in &facts { span { (shown(fact)) } " " } }
}

/// Formats that differ, and how many don't.
fn formats(formats: &[Format]) -> Markup {
    let of = |wanted| formats.iter().filter(move |format| format.result == wanted);
    let differing: Vec<&Format> = of(FormatResult::Differs).collect();
    html! {
        @if !formats.is_empty() {
            h3 { "Formats beside the definitions" }
            p {
                (of(FormatResult::Equal).count()) " equal, " (differing.len()) " differ, "
                (of(FormatResult::Undefined).count()) " have no definition"
            }
            (folded(&differing, "format", |format| html! {
                li { code { (shown(&format.topic)) } ": " (shown(&format.message)) }
            }))
        }
    }
}

/// Channels of which there is something to say, and how many are as they should be.
fn channels(channels: &[McapChannel]) -> Markup {
    let others: Vec<&McapChannel> =
        channels.iter().filter(|channel| channel.result != ChannelResult::Equal).collect();
    html! {
        @if !channels.is_empty() {
            h3 { "Channels beside the definitions" }
            p { (channels.len() - others.len()) " of " (channels.len()) " have a schema that is equal" }
            (folded(&others, "channel", |channel| html! {
                li { code { (shown(&channel.topic)) } ": " (told(channel)) }
            }))
        }
    }
}

/// What there is to say of a channel.
fn told(channel: &McapChannel) -> String {
    match channel.result {
        ChannelResult::Equal | ChannelResult::Differs | ChannelResult::ByName => shown(&channel.message),
        ChannelResult::Undefined => "no definition".to_owned(),
        ChannelResult::Unsupported => format!("messages as {}, which isn't read", shown(&channel.encoding)),
    }
}

/// The types of messages, and those that aren't judged.
fn message_types(found: &Flockwave) -> Markup {
    let told = |types: &[FlockwaveType]| -> Vec<String> {
        let of = |one: &FlockwaveType| {
            let (from_server, from_client) = (Grouped(one.from_server), Grouped(one.from_client));
            format!("{}: {from_server} from the server, {from_client} from clients", one.name)
        };
        types.iter().map(of).collect()
    };
    html! {
        (notes("Message types", &told(&found.types)))
        (notes("Types that the definitions don't have, and not judged", &told(&found.unsupported)))
        @if found.uncounted > 0 { p.more { "… and " (Grouped(found.uncounted)) " messages of other types" } }
    }
}

fn notes(title: &str, notes: &[String]) -> Markup {
    let notes: Vec<&String> = notes.iter().collect();
    html! {
        @if !notes.is_empty() {
            h3 { (title) }
            (folded(&notes, "other", |note| html! { li { (shown(note)) } }))
        }
    }
}

fn damage(subject: &Subject) -> Markup {
    let damage: Vec<_> = subject.damage.iter().collect();
    html! {
        @if !damage.is_empty() {
            h3 { "Damage" }
            (folded(&damage, "place", |damage| html! {
                li { span.place { (damage.place) } ": " (shown(&damage.message)) }
            }))
            @if subject.more_damage > 0 { p.more { "… and " (Grouped(subject.more_damage)) " more places" } }
        }
    }
}

/// A list of which the first are seen and the others can be opened.
fn folded<T>(items: &[T], noun: &str, item: impl Fn(&T) -> Markup) -> Markup {
    let (open, rest) = items.split_at(items.len().min(MAX_OPEN));
    let told = &rest[..rest.len().min(MAX_TOLD)];
    html! {
        ul { @for found in open { (item(found)) } }
        @if !rest.is_empty() {
            details {
                summary { (rest.len()) " more " (noun) @if rest.len() > 1 { "s" } }
                ul { @for found in told { (item(found)) } }
                @if told.len() < rest.len() { p.more { "… and " (rest.len() - told.len()) " more" } }
            }
        }
    }
}

/// Findings rule by rule, the gravest first.
fn findings(subject: &Subject, anchor: &str) -> Markup {
    let mut rules: Vec<&RuleVerdict> = subject.rules.iter().filter(|rule| is_told(rule)).collect();
    rules.sort_by_key(|rule| std::cmp::Reverse(rule.verdict));
    html! {
        @if let Some(first) = subject.findings.first().filter(|_| !rules.is_empty()) {
            h3 { "Findings" }
            @for rule in rules { (of_rule(subject, rule, anchor)) }
            (finding::again(&first.reproduce))
        }
    }
}

/// Whether findings of a rule are told. Formats that differ stand elsewhere already, unless they count.
fn is_told(rule: &RuleVerdict) -> bool {
    rule.findings > 0 && (rule.id != "PX-FMT-01" || rule.verdict == Verdict::Fail)
}

/// Where the findings of a rule stand that a subject has.
pub(super) fn rule_anchor(subject: &Subject, index: usize, rule: &str) -> Option<String> {
    // Failures of a testee stand case by case.
    let is_source = !matches!(subject.about, About::Testee(_));
    let is_there = is_source && subject.rules.iter().any(|found| found.id == rule && is_told(found));
    is_there.then(|| format!("{}-{rule}", anchor(index)))
}

fn anchor(index: usize) -> String {
    format!("subject-{}", index + 1)
}

fn of_rule(subject: &Subject, rule: &RuleVerdict, anchor: &str) -> Markup {
    let found: Vec<&Finding> = subject.findings.iter().filter(|finding| finding.rule == rule.id).collect();
    // What was only shown is of interest to few.
    let is_open = rule.verdict > Verdict::Shown;
    let (open, rest) = found.split_at(if is_open { found.len().min(MAX_OPEN) } else { 0 });
    let told = &rest[..rest.len().min(MAX_TOLD)];
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
                    summary { (rest.len()) @if is_open { " more" } @if rest.len() == 1 { " place" } @else { " places" } }
                    @for finding in told { (finding::article(finding)) }
                    @if told.len() < rest.len() { p.more { "… and " (rest.len() - told.len()) " more" } }
                }
            }
        }
    }
}

fn times(count: u64) -> String {
    if count == 1 { "once".to_owned() } else { format!("{} times", Grouped(count)) }
}
