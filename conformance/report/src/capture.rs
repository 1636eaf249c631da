//! The result of checking a capture, as a subject of a report.

use std::time::Duration;

use uavspec_check::{CaptureResult, Clock, Coverage, Describe, ReleaseMatch, Summary};
use uavspec_model::text::plural;
use uavspec_model::{DISPUTED, Extent, Findings, Group, Rule};
use uavspec_probe::RequestType;
use uavspec_rules::definitions::Definitions;
use uavspec_rules::{RULES, flockwave, px4};

use super::outcome::{NO_VIOLATIONS, capitalized};
use super::totals::{is_violated, kinds_of_violations};
use super::{
    About, Corruption, Definition, Example, Finding, Outcome, OutcomeKind, RuleVerdict, Subject, Verdict,
};

/// A capture that was checked.
#[derive(Debug)]
pub struct CheckedCapture {
    /// The path as the user gave it.
    pub path: String,
    /// The result.
    pub result: CaptureResult,
    /// Notable events during a probe, in order. They are not findings.
    pub notes: Vec<String>,
    /// The request types of the definitions, if the subject is a probed server.
    pub requests: Vec<RequestType>,
    /// The reasons why the capture is incomplete although it can be read: for example, the probe was cut short.
    pub cut_short: Vec<String>,
    /// The duration of the check, in milliseconds.
    pub elapsed: u128,
}

impl CheckedCapture {
    /// A capture from a file, an object or memory.
    pub fn new(path: String, result: CaptureResult, elapsed: Duration) -> Self {
        let (notes, requests, cut_short) = (Vec::new(), Vec::new(), Vec::new());
        Self { path, result, notes, requests, cut_short, elapsed: elapsed.as_millis() }
    }
}

/// The run settings that affect reports.
#[allow(clippy::struct_excessive_bools)] // independent options of the command line
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// True if formats that differ from the definitions count as violations.
    pub are_formats_strict: bool,
    /// True if violations of rules of level SHOULD count as failures.
    pub are_warnings_denied: bool,
    /// The minimum percentage of topics or types that must be fully checked. With a lower percentage, the outcome is
    /// incomplete.
    pub min_coverage: Option<f64>,
    /// True if the exit status of an incomplete outcome is 0.
    pub allows_incomplete: bool,
    /// True if the session of a probe isn't recorded in a file.
    pub is_unrecorded: bool,
    /// The arguments of `check` that reproduce the findings, without the file names.
    pub arguments: Vec<String>,
    /// The command that reproduces the findings, if it isn't `check`.
    pub command: Option<String>,
    /// The words of the command that repeats the probe of a server, without the URL and the selected parts.
    pub probe: Option<Vec<String>>,
}

impl Settings {
    /// The command that repeats the probe of a server, but sends only the requests of a rule or a message type.
    fn showing(&self, only: &str, url: &str) -> Option<String> {
        let selection = if only.is_empty() { vec![] } else { vec!["--only", only] };
        let words = self.probe.as_ref()?.iter().map(String::as_str).chain(selection);
        Some(uavspec_model::text::command_line(words.chain([url])))
    }

    /// The command that checks a capture again.
    pub fn command(&self, path: &str) -> String {
        if let Some(command) = &self.command {
            return command.clone();
        }
        let words = ["uavspec", "check"].into_iter().chain(self.arguments.iter().map(String::as_str));
        // A path that starts with a dash would be read as an option. `-` alone denotes standard input.
        let is_like_option = path.starts_with('-') && path != "-";
        let path = if is_like_option { format!("./{path}") } else { path.to_owned() };
        uavspec_model::text::command_line(words.chain([path.as_str()]))
    }

    /// The verdict of a rule.
    fn verdict(&self, findings: &Findings, rule: &'static Rule) -> Verdict {
        match findings.verdict(rule) {
            Verdict::Shown if self.are_formats_strict && rule.id == px4::FMT_01.rule.id => Verdict::Fail,
            Verdict::Warn if self.are_warnings_denied => Verdict::Fail,
            other => other,
        }
    }
}

impl Subject {
    /// Creates the subject of a capture.
    pub fn from_capture(checked: CheckedCapture, definitions: &Definitions, settings: &Settings) -> Self {
        let CheckedCapture { path, mut result, notes, requests, cut_short, elapsed } = checked;
        let notes = [std::mem::take(&mut result.notes), notes].concat();
        let cut_short = [std::mem::take(&mut result.cut_short), cut_short].concat();
        let findings = &result.findings;
        // Rules that apply to other kinds of captures aren't listed.
        let is_session = result.summary.describe().is_session();
        let is_known = !matches!(result.summary, Summary::Unknown(_));
        let rules: Vec<RuleVerdict> = RULES
            .iter()
            .filter(|rule| is_known && rule.is_on_flockwave() == is_session)
            .map(|rule| rule_verdict(rule, findings, settings.verdict(findings, rule)))
            .collect();
        let command = settings.command(&path);
        let url = path.clone();
        let finding = |group: &Group| {
            let only = group.examples.first().map_or("", |(_, detail)| detail.only.as_str());
            let command = settings.showing(only, &url).unwrap_or_else(|| command.clone());
            finding(group, settings.verdict(findings, group.rule), &command, definitions, result.clock)
        };
        let corruption = result.corruption.iter();
        let mut subject = Self {
            path,
            about: About::Capture(result.summary),
            records: result.records,
            checked: result.checked,
            duration_us: result.duration,
            outcome: Outcome::new(OutcomeKind::Nothing, String::new()),
            findings: findings.groups().map(finding).collect(),
            more_findings: RULES.iter().map(|rule| findings.dropped(rule)).sum(),
            rules,
            corruption: corruption
                .map(|(location, text)| Corruption { location: *location, message: text.clone() })
                .collect(),
            more_corruption: result.more_corruption,
            extent: result.extent,
            coverage: result.coverage,
            event_metadata: result.event_metadata,
            incomplete: Vec::new(),
            cut_short,
            notes,
            requests,
            is_readable_again: !settings.is_unrecorded,
            start_utc: result.clock.start_utc(),
            elapsed,
        };
        subject.set_outcome(settings);
        subject
    }

    /// Sets the outcome of a capture from its verdicts, its extent and its coverage.
    pub(crate) fn set_outcome(&mut self, settings: &Settings) {
        self.incomplete = self.reasons(settings);
        let kind = if self.count(Verdict::Fail) > 0 {
            OutcomeKind::DoesNotConform
        } else if !self.incomplete.is_empty() {
            OutcomeKind::Incomplete
        } else if !self.coverage.is_full() {
            OutcomeKind::Partial
        } else {
            OutcomeKind::Conforms
        };
        let outcome = Outcome::new(kind, capitalized(&self.outcome_text(kind)));
        let is_allowed = kind == OutcomeKind::Incomplete && settings.allows_incomplete;
        let status = if is_allowed { 0 } else { outcome.status };
        self.outcome = Outcome { status, remarks: self.remarks(kind), ..outcome };
    }

    fn summary(&self) -> Option<&dyn Describe> {
        match &self.about {
            About::Capture(summary) => Some(summary.describe()),
            About::Testee(_) => None,
        }
    }

    /// The reasons why the capture wasn't read or checked completely.
    fn reasons(&self, settings: &Settings) -> Vec<String> {
        if let About::Capture(Summary::Unknown(summary)) = &self.about {
            return vec![summary.reason.clone()];
        }
        let noun = self.summary().map_or("file", Describe::noun);
        let is_session = self.summary().is_some_and(Describe::is_session);
        let Coverage { unit, units, .. } = self.coverage;
        let unit = unit.noun();
        let mut reasons = self.cut_short.clone();
        match self.extent {
            Extent::Whole if self.corrupt_count() > 0 => {
                let count = usize::try_from(self.corrupt_count()).unwrap_or(usize::MAX);
                reasons.push(format!("{} in the {noun}", plural(count, "problem")));
            }
            Extent::Whole => {}
            Extent::WithGaps if self.records == 0 => {
                reasons.push(format!("the {noun} contains no readable messages"));
            }
            Extent::EndsEarly => reasons.push(format!("the {noun} is truncated")),
            Extent::WithGaps => reasons.push(format!("parts of the {noun} are corrupt")),
            Extent::Unreadable => reasons.push(format!("the {noun} can't be read completely")),
        }
        if self.coverage.undecodable() > 0 && self.extent == Extent::Whole {
            let count = plural(self.coverage.undecodable(), unit);
            reasons.push(format!("{count} can't be decoded completely"));
        }
        if let About::Capture(summary) = &self.about {
            reasons.extend(summary.releases().iter().filter_map(ReleaseMatch::problem));
        }
        let min = settings.min_coverage.unwrap_or_default();
        if self.records == 0 && reasons.is_empty() {
            let sender =
                if is_session { "the server sent".to_owned() } else { format!("the {noun} contains") };
            reasons.push(format!("{sender} no messages"));
        } else if self.coverage.is_empty() && self.records > 0 {
            let details = self.coverage.unchecked().map(|text| format!(": {text}")).unwrap_or_default();
            reasons.push(format!("no {unit} was checked{details}"));
        } else if !self.coverage.is_empty() && !units.reaches(min) {
            let percent = units.percent();
            reasons.push(format!("{} fully checked ({percent} %), less than {min} %", units.text(unit)));
        }
        reasons
    }

    /// The outcome as a predicate, such as `conforms, with 1 warning`.
    fn outcome_text(&self, kind: OutcomeKind) -> String {
        let units = || self.coverage.units.text(self.coverage.unit.noun());
        let reason = self.incomplete.first().map(String::as_str).unwrap_or_default();
        match (kind, self.warnings()) {
            (OutcomeKind::DoesNotConform, _) => self.violations(),
            (OutcomeKind::Incomplete, _) => format!("incomplete: {reason}"),
            (OutcomeKind::Partial, warnings) => {
                let found = warnings.as_deref().unwrap_or(NO_VIOLATIONS);
                format!("{found}, partial coverage: {} fully checked", units())
            }
            (_, warnings) => {
                let warnings = warnings.map(|warnings| format!(", with {warnings}")).unwrap_or_default();
                let own = self.coverage.own_schema();
                let own = own.map(|topics| format!(", {topics} only to the schema in the file"));
                format!("conforms{warnings}{}", own.unwrap_or_default())
            }
        }
    }

    fn remarks(&self, kind: OutcomeKind) -> Vec<String> {
        let mut remarks = match kind {
            OutcomeKind::DoesNotConform => self.incomplete.clone(),
            _ => self.incomplete.iter().skip(1).cloned().collect(),
        };
        if kind == OutcomeKind::Incomplete && !self.coverage.is_empty() {
            let found = self.warnings().unwrap_or_else(|| NO_VIOLATIONS.to_owned());
            remarks.push(format!("{found} in the part that was checked"));
        }
        remarks
    }

    fn known_count(&self) -> usize {
        self.findings.iter().filter(|finding| finding.known.is_some()).count()
    }

    /// The numbers of warnings and known failures, such as `1 warning and 2 known failures`.
    fn warnings(&self) -> Option<String> {
        let numbers = [(self.count(Verdict::Warn), "warning"), (self.known_count(), "known failure")];
        let listed = numbers.iter().filter(|(count, _)| *count > 0).map(|(count, noun)| plural(*count, noun));
        let listed: Vec<String> = listed.collect();
        (!listed.is_empty()).then(|| listed.join(" and "))
    }

    fn violations(&self) -> String {
        let violated = self.rules.iter().filter(|rule| is_violated(rule));
        let (must, should) =
            kinds_of_violations(violated.map(|rule| rule.level == uavspec_model::Level::Should));
        let known = match self.known_count() {
            0 => String::new(),
            known => format!(", {known} known"),
        };
        format!("does not conform: {must} MUST, {should} SHOULD{known}")
    }
}

fn rule_verdict(rule: &'static Rule, findings: &Findings, verdict: Verdict) -> RuleVerdict {
    let grouped: u64 = findings.groups_of(rule).map(|group| group.count).sum();
    RuleVerdict {
        id: rule.id,
        level: rule.level,
        verdict,
        covered: findings.covered(rule),
        findings: grouped + findings.dropped(rule),
    }
}

fn finding(
    group: &Group,
    verdict: Verdict,
    command: &str,
    definitions: &Definitions,
    clock: Clock,
) -> Finding {
    let Group { rule, count, examples, definition, known, .. } = group;
    let example = |(location, detail): &(_, uavspec_model::Detail)| Example {
        location: *location,
        path: detail.path.clone(),
        part: detail.part.clone(),
        message: detail.message.clone(),
        expected: detail.expected.clone(),
        actual: detail.actual.clone(),
        excerpt: detail.excerpt.clone(),
        time_s: detail.time.and_then(|time| clock.seconds(time)),
        utc_us: detail.time.and_then(|time| clock.utc_micros(time)),
        utc: detail.time.and_then(|time| clock.utc(time)),
        log_time_ns: detail.log_time,
        sequence: detail.sequence,
        connection: detail.connection.clone(),
        request: detail.request.clone(),
    };
    let is_disputed = examples.first().is_some_and(|(_, detail)| detail.is_disputed);
    Finding {
        rule: rule.id,
        level: rule.level,
        status: if is_disputed { DISPUTED.to_owned() } else { rule.status.to_string() },
        statement: rule.statement,
        url: uavspec_lint::report::rule_url(rule.id),
        verdict: if known.is_some() { Verdict::Known } else { verdict },
        subject: group.name().to_string(),
        count: *count,
        examples: examples.iter().map(example).collect(),
        definition: definition.map(|span| Definition::new(definitions.line(span))),
        specification: flockwave::page(
            rule,
            &group.subject,
            definition.map(|span| definitions.line(span).file),
        ),
        reproduce: command.to_owned(),
        known: known.clone(),
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use uavspec_check::check_capture;
    use uavspec_model::{Detail, Findings, Location};
    use uavspec_rules::definitions::Definitions;
    use uavspec_rules::rule;

    use super::{CheckedCapture, Settings};
    use crate::{Subject, Verdict};

    #[test]
    fn the_command_reproduces_the_findings() {
        let check = Settings { arguments: vec!["--strict-formats".to_owned()], ..Settings::default() };
        for (path, expected) in [("a.ulg", "a.ulg"), ("-a.ulg", "./-a.ulg"), ("-", "-")] {
            assert_eq!(check.command(path), format!("uavspec check --strict-formats {expected}"));
        }
        let probe = Settings { command: Some("uavspec probe host".to_owned()), ..check };
        assert_eq!(probe.command("-a.ulg"), "uavspec probe host");
    }

    #[test]
    fn strict_formats_make_different_formats_violations() {
        let mut findings = Findings::default();
        let rules = ["PX-FMT-01", "FW-ERR-04"].map(|id| rule(id).expect("a rule"));
        for rule in rules {
            findings.report(rule, "kite", Location::Line(1), None, || Detail::new("differs"));
        }
        for (are_formats_strict, expected) in [(false, Verdict::Shown), (true, Verdict::Fail)] {
            let settings = Settings { are_formats_strict, ..Settings::default() };
            assert_eq!(rules.map(|rule| settings.verdict(&findings, rule)), [expected, Verdict::Shown]);
        }
    }

    #[test]
    fn a_report_lists_the_rules_for_the_kind_of_capture() {
        let definitions = Definitions::built_in();
        let subject = |bytes: &[u8], is_unrecorded| {
            let result = check_capture(bytes, None, &definitions).expect("bytes can be read");
            let checked = CheckedCapture::new("a.jsonl".to_owned(), result, Duration::ZERO);
            Subject::from_capture(checked, &definitions, &Settings { is_unrecorded, ..Settings::default() })
        };
        let flight = subject(b"{\"topic\":\"failsafe_flags\",\"message\":{}}\n", false);
        assert!(!flight.rules.is_empty() && flight.rules.iter().all(|rule| rule.id.starts_with("PX-")));
        assert!(flight.is_readable_again);
        let unknown = subject(b"", true);
        assert!(unknown.rules.is_empty() && !unknown.is_readable_again);
    }
}
