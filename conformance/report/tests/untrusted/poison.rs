//! Reports in which all untrusted texts are the same.
//!
//! The patterns name every field, so that a new field causes a compile error until someone decides whether its text is
//! untrusted.

use std::collections::BTreeSet;
use std::sync::OnceLock;

use uavspec_check::convert::{
    Action as Treated, ConversionReport, Format as ConversionFormat, Loss, TopicReport,
};
use uavspec_check::timeline::{Texts, Timeline};
use uavspec_check::{
    BagChannel, BusEndpoint, BusTopic, ChannelResult, CheckStatus, Coverage, FlockwaveSummary, Format,
    FormatResult, JsonSummary, LogSummary, McapSummary, OtherRelease, Part, ReleaseMatch, Summary, TypeCount,
    UnknownSummary, UnreadTimes, check_capture,
};
use uavspec_model::{Excuse, ExcuseKind, Location, Reason};
use uavspec_probe::RequestType;
use uavspec_px4::json::Dialects;
use uavspec_report::{
    About, Action, Case, CheckedCapture, Corruption, Definition, Example, Finding, Outcome, Remark, Report,
    Row, Settings, Subject, Testee, Unreadable,
};
use uavspec_rules::definitions::Definitions;
use uavspec_rules::sample::Flight;
use uavspec_schema::translation::Translations;

use crate::hostile::tested;

/// Reports of each command, with captures of each kind. Their structure doesn't depend on the text.
pub(super) fn reports(text: &str) -> Vec<Report> {
    static REPORTS: OnceLock<Vec<Report>> = OnceLock::new();
    let mut reports = REPORTS.get_or_init(without_text).clone();
    for report in &mut reports {
        poison(report, text);
        for (subject, summary) in report.subjects.iter_mut().zip(summaries(text).into_iter().cycle()) {
            if let About::Capture(_) = subject.about {
                subject.about = About::Capture(summary);
            }
        }
    }
    reports
}

fn without_text() -> Vec<Report> {
    let definitions = Definitions::built_in();
    let create = |action, subjects: usize| {
        let file = || vec![Unreadable { path: String::new(), message: String::new() }];
        let reasons =
            vec![Reason { line: Some(1), ..Reason::from(String::new()) }, Reason::from(String::new())];
        let subjects = (0..subjects).map(|_| subject(&definitions)).collect();
        let report = Report::new(action, String::new(), &definitions.name, subjects, file(), reasons);
        report.with_not_checked(file())
    };
    let mut tested = tested(&definitions);
    for subject in &mut tested.subjects {
        if let About::Testee(testee) = &mut subject.about {
            testee.cases.truncate(24);
            testee.table.truncate(4);
        }
    }
    vec![
        create(Action::Check, summaries("").len()),
        create(Action::Check, 1),
        create(Action::Probe, 1),
        tested,
    ]
}

/// A capture with two findings of one rule, each with several examples.
fn subject(definitions: &Definitions) -> Subject {
    let message = r#"{"timestamp": 1, "arming_check_id": 1000, "mode_id": 1000, "mode_executor_id": -1}"#;
    let line = format!("{{\"type\": \"px4/UnregisterExtComponent\", \"message\": {message}}}\n");
    let checked = CheckedCapture {
        path: String::new(),
        result: check_capture(line.repeat(3).as_bytes(), None, definitions).expect("bytes can be read"),
        notes: vec![String::new(); 2],
        requests: vec![RequestType { not_sent: Some(String::new()), ..request() }, request()],
        cut_short: Vec::new(),
        elapsed: 7,
    };
    let mut subject = Subject::from_capture(checked, definitions, &Settings::default());
    // The texts of most rules are not needed.
    subject.rules.retain(|rule| rule.findings > 0 || rule.id.starts_with("PX-RANGE"));
    subject.incomplete = vec![String::new(); 2];
    subject.event_metadata = Some(String::new());
    let location = Location::Byte(7);
    subject.corruption = vec![Corruption { location, message: String::new() }; 2];
    assert!(subject.findings.len() > 1 && subject.findings[0].examples.len() > 1, "{:?}", subject.findings);
    subject
}

fn request() -> RequestType {
    RequestType { name: String::new(), sent: 1, answered: 1, refused: 1, not_sent: None }
}

/// A summary of each kind.
fn summaries(text: &str) -> Vec<Summary> {
    let name = || text.to_owned();
    let channel = |result| BagChannel {
        topic: name(),
        encoding: name(),
        schema: Some(name()),
        schema_encoding: Some(name()),
        messages: 1,
        other_cdr: 1,
        result,
        message: name(),
        status: CheckStatus::Undefined,
        release: Some(name()),
        rate: Some(1.0),
    };
    let endpoint = || BusEndpoint { node: Some(name()), qos: Some(name()) };
    let bus = || BusTopic {
        topic: name(),
        type_name: name(),
        type_hash: Some(name()),
        release: Some(name()),
        rate: Some(1.0),
        publishers: vec![endpoint()],
        subscribers: vec![endpoint()],
    };
    let releases = || {
        let others = vec![OtherRelease { topic: name(), release: name() }];
        vec![ReleaseMatch { release: name(), title: name(), matching: 1, topics: 2, others }]
    };
    let types = || vec![TypeCount { name: name(), from_client: 1, from_server: 1 }];
    vec![
        Summary::Log(LogSummary {
            firmware: Some(name()),
            dropouts: 0,
            releases: releases(),
            formats: vec![Format { topic: name(), result: FormatResult::Differs, message: name() }],
        }),
        Summary::Json(JsonSummary {
            lines: 1,
            types: 1,
            skipped: 1,
            releases: releases(),
            undefined: BTreeSet::from([name()]),
            dialects: Dialects::default(),
            has_objects: true,
        }),
        Summary::Mcap(McapSummary {
            profile: name(),
            library: name(),
            channels: vec![channel(ChannelResult::Undefined), channel(ChannelResult::Unsupported)],
            dialects: Dialects::default(),
            releases: releases(),
            bus: vec![bus()],
        }),
        Summary::Flockwave(FlockwaveSummary {
            connections: 1,
            requests: 1,
            responses: 1,
            notifications: 1,
            types: types(),
            unknown: types(),
            uncounted: 1,
            unread_times: UnreadTimes { count: 1, first: name() },
        }),
        Summary::Unknown(UnknownSummary { reason: name() }),
    ]
}

fn poison(report: &mut Report, text: &str) {
    let set = |field: &mut String| text.clone_into(field);
    // The texts of rules are part of uavspec.
    let Report {
        version: _,
        uavspec: _,
        action: _,
        command,
        definitions,
        outcome: whole,
        reasons,
        rules: _,
        subjects,
        unreadable,
        not_checked,
        ..
    } = report;
    [command, definitions].into_iter().for_each(set);
    outcome(whole, text);
    for Reason { message, path, line: _ } in reasons {
        [message, path].into_iter().for_each(set);
    }
    for Unreadable { path, message } in unreadable.iter_mut().chain(not_checked) {
        [path, message].into_iter().for_each(set);
    }
    for subject in subjects {
        poison_subject(subject, text);
    }
}

fn outcome(outcome: &mut Outcome, text: &str) {
    let Outcome { kind: _, status: _, text: sentence, remarks } = outcome;
    text.clone_into(sentence);
    *remarks = vec![text.to_owned(); 2];
}

fn poison_subject(subject: &mut Subject, text: &str) {
    let set = |field: &mut String| text.clone_into(field);
    let Subject {
        path,
        about,
        records: _,
        checked: _,
        duration_us: _,
        outcome: of_subject,
        rules: _,
        findings,
        more_findings: _,
        corruption,
        more_corruption: _,
        extent: _,
        coverage,
        event_metadata,
        incomplete,
        cut_short,
        notes,
        requests,
        is_readable_again: _,
        start_utc: _,
        elapsed: _,
    } = subject;
    set(path);
    outcome(of_subject, text);
    [incomplete, cut_short, notes].into_iter().flatten().chain(event_metadata).for_each(set);
    for Corruption { location: _, message } in corruption {
        set(message);
    }
    for one in findings {
        finding(one, text);
    }
    let Coverage { unit: _, units: _, records: _, values: _, parts, more_parts: _, empty: _ } = coverage;
    for Part { name, .. } in parts {
        set(name);
    }
    for RequestType { name, sent: _, answered: _, refused: _, not_sent } in requests {
        set(name);
        not_sent.iter_mut().for_each(set);
    }
    match about {
        About::Capture(_) => {}
        About::Testee(found) => testee(found, text),
    }
}

fn finding(finding: &mut Finding, text: &str) {
    let set = |field: &mut String| text.clone_into(field);
    let Finding {
        rule: _,
        level: _,
        status: _,
        statement: _,
        url: _,
        specification: _,
        verdict: _,
        subject,
        count: _,
        examples,
        definition,
        reproduce,
        known,
    } = finding;
    [subject, reproduce].into_iter().for_each(set);
    *definition = Some(definition_of(text));
    *known = Some(known_as(text));
    for example in examples {
        let Example {
            location: _,
            path,
            part,
            message,
            expected,
            actual,
            excerpt,
            time_s: _,
            utc: _,
            utc_us: _,
            log_time_ns: _,
            sequence: _,
            connection,
            request,
        } = example;
        [path, part, message, expected, actual, excerpt, connection, request].into_iter().for_each(set);
    }
}

fn definition_of(text: &str) -> Definition {
    Definition { file: text.to_owned(), line: 1, text: text.to_owned() }
}

fn known_as(text: &str) -> Excuse {
    // Links to web pages are clickable, because the author of the baseline added them.
    let link = Some(format!("javascript:{text}"));
    Excuse { kind: ExcuseKind::Known, reason: text.to_owned(), link, expires: None }
}

fn testee(testee: &mut Testee, text: &str) {
    let set = |field: &mut String| text.clone_into(field);
    let Testee {
        kind: _,
        version,
        counts: _,
        table,
        cases,
        protocol_remarks,
        more_protocol_remarks: _,
        restarts: _,
        gave_up,
    } = testee;
    set(version);
    gave_up.iter_mut().for_each(set);
    for Remark { message, count: _ } in protocol_remarks {
        set(message);
    }
    for Row { op, type_name, counts: _ } in table {
        [op, type_name].into_iter().for_each(set);
    }
    for (index, case) in cases.iter_mut().enumerate() {
        let Case {
            name,
            op,
            type_name,
            description,
            rule,
            verdict: _,
            path,
            expected,
            actual,
            message,
            stderr,
            definition,
            reproduce,
            known,
        } = case;
        [name, op, type_name, description, path, expected, actual, message].into_iter().for_each(set);
        // Each line of standard error is a line of the report.
        *stderr = text.replace('\n', " ");
        set(reproduce);
        *rule = Some(text.to_owned());
        *definition = Some(definition_of(text));
        *known = index.is_multiple_of(2).then(|| known_as(text));
    }
}

fn timeline_without_text() -> Timeline {
    let definitions = Definitions::built_in();
    let bytes = Flight::new(&definitions).log().to_bytes();
    let timeline = Timeline::of_bytes(&bytes, &definitions, &Texts::of(Translations::default()));
    timeline.expect("a readable capture")
}

/// A timeline with the text in every field.
pub(super) fn timeline(text: &str) -> Timeline {
    static TIMELINE: OnceLock<Timeline> = OnceLock::new();
    let mut timeline = TIMELINE.get_or_init(timeline_without_text).clone();
    text.clone_into(&mut timeline.capture);
    text.clone_into(&mut timeline.definitions);
    timeline.corruption = vec![text.to_owned()];
    timeline.topics.iter_mut().for_each(|topic| text.clone_into(&mut topic.name));
    for lane in &mut timeline.lanes {
        text.clone_into(&mut lane.topic);
        text.clone_into(&mut lane.name);
        lane.subject = Some(text.to_owned());
        lane.values
            .iter_mut()
            .flat_map(|value| &mut value.parts)
            .for_each(|part| text.clone_into(&mut part.name));
    }
    timeline
}

/// The report of a conversion with the text in every field.
pub(super) fn conversion(text: &str) -> ConversionReport {
    let name = || text.to_owned();
    let topic = |action| TopicReport {
        topic: name(),
        renamed: Some(name()),
        action,
        from: Some(name()),
        reason: Some(name()),
        messages: 1,
        unreadable: 1,
        error: Some(name()),
        losses: vec![Loss { text: name(), messages: None }, Loss { text: name(), messages: Some(1) }],
        unchecked: vec![name()],
    };
    ConversionReport {
        version: 1,
        uavspec: name(),
        capture: name(),
        from: vec![name()],
        to: Some(name()),
        from_format: ConversionFormat::Log,
        to_format: ConversionFormat::Mcap,
        topics: [Treated::Converted, Treated::Copied, Treated::LeftOut].map(topic).to_vec(),
        problems: vec![name()],
        more_problems: 1,
        notes: vec![name()],
    }
}
