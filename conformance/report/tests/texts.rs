//! Expected texts: the changes that each bug of the reference server makes to messages, the findings of each mutant,
//! and the messages of a probe.

use std::fmt::Write as _;

use serde_json::{Value, json};
use uavspec_check::check_capture;
use uavspec_flockwave::transport::endpoint::Endpoint;
use uavspec_rules::definitions::Definitions;
use uavspec_rules::flockwave::sample::Session;
use uavspec_rules::flockwave::trial::{self, Sent, Step};
use uavspec_rules::flockwave::{Outgoing, RULES};
use uavspec_rules::sample::Flight;
use uavspec_rules::{Mutant, mutants};
use uavspec_test_support::extent;

use crate::mutants::tested_mutants;

/// The folder with the expected texts.
const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/texts");

const UPDATE: &str = "`UAVSPEC_UPDATE_FIXTURES=1 cargo test -p uavspec-report texts`";

/// The messages of a server, each with the body of the request that it answers, if any.
fn messages() -> Vec<(Value, Option<Value>)> {
    let session = Session::new();
    let is_sent = |line: &&Value, direction: &str| line["dir"] == direction && line["msg"]["id"].is_string();
    let requests: Vec<&Value> = session.lines.iter().filter(|line| is_sent(line, "out")).collect();
    let answered = |refs: &Value| requests.iter().find(|line| line["msg"]["id"] == *refs);
    let mut messages: Vec<(Value, Option<Value>)> = session
        .lines
        .iter()
        .filter(|line| is_sent(line, "in"))
        .map(|line| {
            (line["msg"].clone(), answered(&line["msg"]["refs"]).map(|line| line["msg"]["body"].clone()))
        })
        .collect();
    // A refusal, with the wording of the reference server.
    let refusal = json!({ "type": "ACK-NAK", "reason": "no handler for UAV-SOAR" });
    let refusal = json!({ "$fw.version": "1.0", "id": "say-no", "refs": "ask-no", "body": refusal });
    messages.push((refusal, Some(json!({ "type": "UAV-SOAR" }))));
    messages
}

/// The members that differ, such as `/body/ids/0: "kite" → 7`.
fn differences(path: &str, before: &Value, after: &Value) -> Vec<String> {
    let keys: Vec<String> = match (before, after) {
        (Value::Object(before), Value::Object(after)) => {
            before.keys().chain(after.keys().filter(|key| !before.contains_key(*key))).cloned().collect()
        }
        (Value::Array(before), Value::Array(after)) => {
            (0..before.len().max(after.len())).map(|at| at.to_string()).collect()
        }
        _ if before == after => return Vec::new(),
        _ => return vec![format!("{path}: {before} → {after}")],
    };
    let member = |value: &Value, key: &str| value.pointer(&format!("/{}", key.replace('/', "~1"))).cloned();
    let differ = |key: &String| match (member(before, key), member(after, key)) {
        (Some(before), Some(after)) => differences(&format!("{path}/{key}"), &before, &after),
        (Some(before), None) => vec![format!("{path}/{key}: {before} → nothing")],
        (_, after) => vec![format!("{path}/{key}: nothing → {}", after.unwrap_or_default())],
    };
    keys.iter().flat_map(differ).collect()
}

/// The effect of a bug on a message. Empty if the message stays the same.
fn effect(before: &Value, texts: &[String]) -> String {
    match texts {
        [] => "dropped".to_owned(),
        [text] => match serde_json::from_str::<Value>(text) {
            Ok(after) => differences("", before, &after).join(", "),
            Err(_) => text.clone(),
        },
        texts => {
            let original = before.to_string();
            let added = texts.iter().filter(|text| **text != original);
            added.map(|text| format!("with {text}")).collect::<Vec<_>>().join(", ")
        }
    }
}

/// The effects of bugs on the messages of a conforming session, for the first bug and every `step`-th bug after it.
/// Each effect is the number of changed messages by type, with the first change.
fn bugs(step: usize) -> Vec<String> {
    let messages = messages();
    let mut tables = Vec::new();
    for rule in RULES.into_iter().step_by(step) {
        let mut table = String::new();
        let mut effects: Vec<(&str, usize, String)> = Vec::new();
        for (number, (message, request)) in (1..).zip(&messages) {
            let mut outgoing = Outgoing::new(message.clone(), request.as_ref(), number);
            rule.bug.apply(&mut outgoing);
            let effect = effect(message, &outgoing.into_texts());
            if effect.is_empty() {
                continue;
            }
            let kind = message["body"]["type"].as_str().unwrap_or("no type");
            match effects.iter_mut().find(|(known, ..)| *known == kind) {
                Some((_, count, _)) => *count += 1,
                None => effects.push((kind, 1, effect)),
            }
        }
        _ = writeln!(table, "{}: {}", rule.rule.id, rule.bug.description);
        for (kind, count, effect) in effects {
            let short: String = effect.chars().take(160).collect();
            _ = writeln!(table, "    {count} {kind}: {short}");
        }
        tables.push(table);
    }
    tables
}

/// The findings of each mutant of a Flockwave rule, with their paths and messages.
fn findings(mutants: impl Iterator<Item = Mutant>) -> Vec<String> {
    let definitions = Definitions::built_in();
    let flight = Flight::new(&definitions);
    let mut tables = Vec::new();
    for mutant in mutants.filter(|mutant| mutant.rule.is_on_flockwave()) {
        let mut table = String::new();
        _ = writeln!(table, "{}: {}", mutant.rule.id, mutant.name);
        for (_, bytes) in mutant.captures(&flight) {
            let result = check_capture(&bytes[..], None, &definitions).expect("bytes");
            for group in result.findings.groups() {
                let (location, detail) = &group.examples[0];
                let [path, expected, actual] = [&detail.path, &detail.expected, &detail.actual];
                _ = writeln!(table, "    {} {}, {location}, {path}: {detail}", group.rule.id, group.subject);
                if !expected.is_empty() || !actual.is_empty() {
                    _ = writeln!(table, "        expected {expected}, found {actual}");
                }
            }
        }
        tables.push(table);
    }
    tables
}

/// A message of a probe, shortened.
fn sent(sent: &Sent) -> String {
    let text: String = String::from_utf8_lossy(&sent.text).chars().take(120).collect();
    format!("{} bytes {text:?}, id {:?}", sent.text.len(), sent.id())
}

fn step(step: &Step) -> String {
    let what = match step {
        Step::Send(message) => sent(message),
        Step::Together(all) => format!("together {}", all.iter().map(sent).collect::<Vec<_>>().join(" and ")),
        Step::Pieces(message, count, pause) => format!("in {count} parts, each {pause:?}: {}", sent(message)),
        Step::Packet(text) => format!("packet {text}"),
    };
    format!("{what}, answer to {:?}", step.id())
}

/// The messages with which a probe tests the rules, by transport.
fn trials() -> String {
    let mut table = String::new();
    for (rule, request) in trial::requests(&["kite".to_owned(), "swift".to_owned()]) {
        let trial::Request { how, body, member, is_repeated } = request;
        let again = if is_repeated { ", repeated" } else { "" };
        _ = writeln!(table, "{} {how}{again}: {body} {member:?}", rule.id);
    }
    for url in ["tcp://hill:1", "udp://hill:1", "http://hill:1", "socketio://hill:1"] {
        let endpoint: Endpoint = url.parse().expect("a URL");
        for (rule, attempt) in trial::attempts(&endpoint) {
            let other = attempt.endpoint.map_or_else(String::new, |endpoint| format!(" at {endpoint}"));
            _ = writeln!(table, "{url}, {} {}{other}", rule.id, attempt.how);
            table.extend(attempt.steps.iter().map(|part| format!("    {}\n", step(part))));
        }
    }
    table
}

/// True if the whole text of the expected files is compared.
fn is_whole() -> bool {
    is_updated() || extent(true, false)
}

fn is_updated() -> bool {
    std::env::var_os("UAVSPEC_UPDATE_FIXTURES").is_some()
}

/// Asserts that a file in this folder contains these tables.
fn assert_contained(name: &str, tables: &[String]) {
    let known = std::fs::read_to_string(format!("{FOLDER}/{name}")).expect("the file exists");
    assert!(!tables.is_empty());
    for table in tables {
        let mut found = known.match_indices(table.as_str());
        // Each table begins at the start of a line. Another table follows it.
        let is_table = |at: usize| {
            let (before, after) = (&known[..at], &known[at + table.len()..]);
            (before.is_empty() || before.ends_with('\n')) && !after.starts_with(' ')
        };
        assert!(found.any(|(at, _)| is_table(at)), "{name}: {UPDATE}\n{table}");
    }
}

/// Asserts that a text is the content of a file in this folder.
fn assert_known(name: &str, text: &str) {
    let path = format!("{FOLDER}/{name}");
    if is_updated() {
        std::fs::write(&path, text).expect("the file can be written");
    }
    let known = std::fs::read_to_string(&path).expect("the file exists");
    let changed: Vec<(&str, &str)> =
        text.lines().zip(known.lines()).filter(|(now, then)| now != then).collect();
    assert_eq!((changed, text.lines().count()), (vec![], known.lines().count()), "{name}: {UPDATE}");
}

#[test]
fn bugs_change_the_messages_that_they_describe() {
    if is_whole() {
        assert_known("bugs.txt", &bugs(1).concat());
    } else {
        assert_contained("bugs.txt", &bugs(8));
    }
}

#[test]
fn findings_name_the_path_and_the_difference() {
    if is_whole() {
        assert_known("findings.txt", &findings(mutants()).concat());
    } else {
        assert_contained("findings.txt", &findings(tested_mutants(&[])));
    }
}

#[test]
fn probes_send_the_messages_of_their_trials() {
    assert_known("trials.txt", &trials());
}
