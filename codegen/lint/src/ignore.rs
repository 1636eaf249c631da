//! Comments and configuration entries that ignore findings. Invalid and unused comments and entries are reported.

use std::collections::{BTreeMap, BTreeSet};

use uavspec_schema::Form;
use uavspec_schema::diagnostic::{Level, Problem};
use uavspec_schema::directive::{self, Directive};
use uavspec_schema::finding::Finding;
use uavspec_schema::glider;
use uavspec_schema::msg::ast::{Line, Part};
use uavspec_schema::resolve::PackageSource;
use uavspec_schema::source::{SourceId, SourceMap, Span};
use uavspec_schema::wording::similar;

use super::rule::{Check, Levels, Measured, Rule};
use super::settings::{Ignore, Settings};
use super::subject;
use super::subject::SourceText;

/// `invalid-ignore`: an ignore comment without a known rule or without a reason.
pub(super) const INVALID: Rule = Rule {
    id: "invalid-ignore",
    statement: "An ignore comment without a known rule or without a reason.",
    why: "An ignore comment that names an unknown rule has no effect. Without a reason, nobody can tell when the \
        comment becomes obsolete. Parser errors can't be ignored.",
    fix: "Name a rule and give a reason.",
    levels: Levels::both(Level::Warning),
    bad: glider![
        "float32 sink      # [m/s] Sink rate  # uavspec:ignore unit-mising the source defines no unit"
    ],
    good: glider!["float32 sink      # Sink rate  # uavspec:ignore unit-missing the source defines no unit"],
    measured: Some(Measured { findings: 0, sample: 0, right: 0 }),
    check: Check::Ignores,
};

/// `unused-ignore`: an ignore comment without a finding to ignore.
pub(super) const UNUSED: Rule = Rule {
    id: "unused-ignore",
    statement: "An ignore comment without a finding to ignore.",
    why: "The comment would hide any later finding from this rule. Comments for rules that are switched off are \
        not reported.",
    fix: "Remove the comment.",
    levels: Levels::both(Level::Warning),
    bad: glider!["float32 sink      # [m/s] Sink rate  # uavspec:ignore unit-missing not known yet"],
    good: glider!["float32 sink      # [m/s] Sink rate"],
    measured: Some(Measured { findings: 0, sample: 0, right: 0 }),
    check: Check::Ignores,
};

/// A request to ignore findings.
struct Request<'s> {
    rule: &'s str,
    reason: &'s str,
    span: Span,
    scope: Scope,
    /// The span to delete when the request to ignore findings is removed: its comment, or its whole line.
    removal: Option<Span>,
}

enum Scope {
    /// Findings that start on one of these lines.
    Lines(Vec<Span>),
    /// Findings in this source.
    Source(SourceId),
    /// Findings in these sources, or in all sources for `None`.
    Sources(Option<BTreeSet<SourceId>>),
}

/// Removes the ignored findings, and adds findings about invalid and unused requests.
pub(super) fn apply(
    sources: &SourceMap,
    parsed: &[PackageSource<'_>],
    (rules, settings): (&[&Rule], &Settings),
    selected: &BTreeSet<SourceId>,
    findings: &mut Vec<Finding>,
) {
    let mut requests: Vec<Request<'_>> = settings.ignores.iter().map(configured_request).collect();
    for (_, _, span, definition) in parsed.iter().flat_map(|package| &package.files) {
        let source = sources.source_of(*span);
        definition.parts.iter().for_each(|part| add_requests_of_part(part, source, sources, &mut requests));
    }
    for text in subject::texts(sources, parsed).iter().filter(|text| text.form == Form::Table) {
        add_requests_of_page(text, sources, &mut requests);
    }
    requests.retain(|request| match request.scope {
        Scope::Lines(_) | Scope::Source(_) => selected.contains(&sources.source_of(request.span)),
        Scope::Sources(_) => true,
    });
    let index = Index::new(&requests);
    let mut used = vec![false; requests.len()];
    findings.retain(|finding| {
        let request = find(rules, finding.rule).and_then(|_| index.find(finding, sources, &requests));
        request.inspect(|request| used[*request] = true).is_none()
    });
    for (request, used) in requests.iter().zip(used) {
        findings.extend(request.invalid(rules, settings));
        if !used {
            findings.extend(request.unused(rules, settings));
        }
    }
}

fn configured_request(ignore: &Ignore) -> Request<'_> {
    let scope = Scope::Sources(ignore.sources.clone());
    Request { rule: &ignore.rule, reason: &ignore.reason, span: ignore.span, scope, removal: None }
}

fn add_requests_of_part<'s>(
    part: &Part<'s>,
    source: SourceId,
    sources: &SourceMap,
    requests: &mut Vec<Request<'s>>,
) {
    let is_comment = |line: &&Line<'_>| line.item.is_none() && line.comment.is_some();
    let head = part.lines.iter().take_while(is_comment).count();
    for (at, line) in part.lines.iter().enumerate() {
        let Some(comment) = &line.comment else { continue };
        let Some(directive) = comment.directive else { continue };
        let below = || part.lines[at..].iter().find(|line| line.item.is_some());
        let scope = if line.item.is_some() {
            Scope::Lines(vec![line.span])
        } else if at < head {
            Scope::Source(source)
        } else {
            // The comment itself can have findings, in addition to the declaration below it.
            below().map_or(Scope::Source(source), |below| Scope::Lines(vec![line.span, below.span]))
        };
        let removal = if comment.is_directive() && line.item.is_none() {
            whole_line(line.span, sources)
        } else {
            // The removal starts at the end of the text before the request.
            let text = comment.text.trim_end();
            let start = if text.is_empty() { 0 } else { 1 + text.len() };
            comment.span.part(start..start).to(comment.span)
        };
        requests.push(Request::of(directive, scope, removal));
    }
}

fn add_requests_of_page<'s>(page: &SourceText<'s>, sources: &SourceMap, requests: &mut Vec<Request<'s>>) {
    for (line, span) in page.lines() {
        let Some((directive, start)) = directive::find(line, span) else { continue };
        let (scope, removal) = if start == 0 {
            (Scope::Source(sources.source_of(span)), whole_line(span, sources))
        } else {
            let end = if line.ends_with("-->") { line.len() } else { start };
            (Scope::Lines(vec![span]), span.part(start..end))
        };
        requests.push(Request::of(directive, scope, removal));
    }
}

/// The span of a line with its line end, if any.
fn whole_line(line: Span, sources: &SourceMap) -> Span {
    let source = sources.span(sources.source_of(line));
    let rest = sources.slice(Span { start: line.end, end: source.end });
    let end = if rest.starts_with("\r\n") { 2 } else { u32::from(rest.starts_with('\n')) };
    Span { start: line.start, end: line.end + end }
}

impl<'s> Request<'s> {
    fn of(directive: Directive<'s>, scope: Scope, removal: Span) -> Self {
        let Directive { rule, reason, span } = directive;
        Self { rule, reason, span, scope, removal: Some(removal) }
    }

    fn invalid(&self, rules: &[&Rule], settings: &Settings) -> Option<Finding> {
        let level = settings.level(&INVALID)?;
        let report = |message: String, help: String| {
            let mut finding = Finding::new(INVALID.id, level, self.span, message);
            finding.help(help);
            Some(finding)
        };
        if self.rule.is_empty() {
            return report(
                "an ignore comment without a rule".to_owned(),
                "write `uavspec:ignore RULE reason`".to_owned(),
            );
        }
        if find(rules, self.rule).is_none() {
            let is_error = Problem::KINDS.iter().any(|kind| kind.code == self.rule);
            let help = match similar(self.rule, rules.iter().map(|rule| rule.id)) {
                _ if is_error => "correct the error".to_owned(),
                Some(similar) => format!("did you mean `{similar}`?"),
                None => "`lint --rules` lists all rules".to_owned(),
            };
            let what = if is_error { "an error and can't be ignored" } else { "not a rule" };
            return report(format!("`{}` is {what}", self.rule), help);
        }
        if self.reason.is_empty() {
            let help = "give a reason, so that others can tell when the comment becomes obsolete".to_owned();
            return report(format!("no reason for ignoring `{}`", self.rule), help);
        }
        None
    }

    fn unused(&self, rules: &[&Rule], settings: &Settings) -> Option<Finding> {
        let level = settings.level(&UNUSED)?;
        settings.level(find(rules, self.rule)?)?;
        let message = format!("`{}` has no finding here", self.rule);
        let mut finding = Finding::new(UNUSED.id, level, self.span, message);
        finding.help("remove the comment");
        if let Some(removal) = self.removal {
            finding.edit(removal, "");
        }
        Some(finding)
    }
}

/// Finds a rule by its id.
fn find<'r>(rules: &[&'r Rule], id: &str) -> Option<&'r Rule> {
    rules.binary_search_by_key(&id, |rule| rule.id).ok().map(|at| rules[at])
}

/// Requests, indexed by scope.
struct Index<'s> {
    /// By rule and start of the line: the end of the line, and the index of the request that ignores
    /// findings on the line.
    lines: BTreeMap<(&'s str, u32), (u32, usize)>,
    sources: BTreeMap<(&'s str, SourceId), usize>,
    /// The few requests in the configuration.
    others: Vec<usize>,
}

impl<'s> Index<'s> {
    fn new(requests: &[Request<'s>]) -> Self {
        let mut index = Self { lines: BTreeMap::new(), sources: BTreeMap::new(), others: Vec::new() };
        for (at, request) in requests.iter().enumerate() {
            match &request.scope {
                Scope::Lines(lines) => {
                    for line in lines {
                        index.lines.entry((request.rule, line.start)).or_insert((line.end, at));
                    }
                }
                Scope::Source(source) => {
                    index.sources.entry((request.rule, *source)).or_insert(at);
                }
                Scope::Sources(_) => index.others.push(at),
            }
        }
        index
    }

    /// Finds a request that ignores `finding`.
    fn find(&self, finding: &Finding, sources: &SourceMap, requests: &[Request<'_>]) -> Option<usize> {
        let source = sources.source_of(finding.span);
        let in_line = || {
            let before = self.lines.range((finding.rule, 0)..=(finding.rule, finding.span.start));
            let (_, (end, request)) = before.last()?;
            (finding.span.start <= *end).then_some(*request)
        };
        let in_source = || self.sources.get(&(finding.rule, source)).copied();
        let in_others = || {
            let covers = |request: &&usize| match &requests[**request].scope {
                Scope::Sources(Some(only)) => only.contains(&source),
                _ => true,
            };
            let has_rule = |request: &&usize| requests[**request].rule == finding.rule;
            self.others.iter().filter(has_rule).find(covers).copied()
        };
        in_line().or_else(in_source).or_else(in_others)
    }
}
