//! Tests that each example violates its rule.
//!
//! An example is one server message or a transcript. In a transcript, client lines start with `→` and server lines with
//! `←`. A line that starts with two spaces continues the previous line. Lines in parentheses are remarks. A message may
//! consist of a body only, without an envelope.

use std::fmt::Write as _;

use serde_json::{Value, json};
use uavspec_check::check_capture;
use uavspec_model::Rule;
use uavspec_model::json::Tree;
use uavspec_rules::definitions::Definitions;
use uavspec_rules::flockwave::{RULES, env_07, env_24, env_25, env_27};
use uavspec_schema::json_type::Direction;

/// The maximum length of a line, in characters.
const MAX_LINE: usize = 100;

/// The maximum number of lines.
const MAX_LINES: usize = 6;

/// The prefix of a Socket.IO packet that carries a Flockwave message.
const EVENT: &str = r#"42["fw","#;

#[test]
fn each_example_violates_its_rule() {
    let definitions = &Definitions::built_in();
    for flockwave in RULES {
        let rule = &flockwave.rule;
        let capture = Recording::of_example(rule, definitions).text;
        let result = check_capture(capture.as_bytes(), None, definitions).expect("a readable capture");
        let violated: Vec<&str> = result.findings.groups().map(|group| group.rule.id).collect();
        assert!(violated.contains(&rule.id), "{}: {violated:?} in\n{capture}", rule.id);
    }
}

#[test]
fn each_rule_has_a_reason_a_short_example_and_a_fix() {
    for flockwave in RULES {
        let Rule { id, why, example, fix, .. } = flockwave.rule;
        assert!(why.ends_with('.') && fix.ends_with('.'), "{id}");
        assert!((1..=MAX_LINES).contains(&example.lines().count()), "{id}");
        assert!(example.lines().all(|line| (1..=MAX_LINE).contains(&line.chars().count())), "{id}");
    }
}

/// A recording of an example.
struct Recording<'d> {
    rule: &'static Rule,
    definitions: &'d Definitions,
    text: String,
    time: f64,
    /// True if no further request follows in the recording.
    is_last: bool,
    num_messages: usize,
    /// The ids and types of unanswered requests.
    unanswered: Vec<(Value, String)>,
    /// The start of a request that continues on the next line.
    incomplete: String,
}

impl<'d> Recording<'d> {
    fn of_example(rule: &'static Rule, definitions: &'d Definitions) -> Self {
        let mut recording = Self {
            rule,
            definitions,
            text: String::new(),
            time: 1_790_000_000.0,
            is_last: true,
            num_messages: 0,
            unanswered: Vec::new(),
            incomplete: String::new(),
        };
        let url = rule.example.strip_prefix("(connected to ").and_then(|rest| rest.split(')').next());
        recording.event(json!({ "event": "connect", "url": url.unwrap_or("tcp://localhost:5001") }));
        if rule.example.starts_with(['→', '←', '(']) {
            let joined = rule.example.replace("\n  ", "\u{b}");
            let lines: Vec<&str> = joined.lines().collect();
            for (at, line) in lines.iter().enumerate() {
                recording.is_last = !lines[at + 1..].iter().any(|line| line.starts_with('→'));
                recording.line(&line.replace('\u{b}', "\n"));
            }
        } else {
            recording.server(rule.example);
        }
        recording.event(json!({ "event": "closed", "why": "eof" }));
        recording
    }

    fn line(&mut self, line: &str) {
        if let Some(text) = line.strip_prefix("→ ") {
            self.client(text);
        } else if let Some(text) = line.strip_prefix("← ") {
            self.server(text);
        } else if let Some((seconds, _)) = line.trim_start_matches('(').split_once(" s later") {
            self.time += seconds.parse::<f64>().expect("a number of seconds");
        }
    }

    fn client(&mut self, text: &str) {
        if text.starts_with("GET") {
            return self.event(json!({ "event": "refused", "why": "400", "trial": self.rule.id, "how": "" }));
        }
        let message = text.strip_prefix(EVENT).and_then(|text| text.strip_suffix(']')).unwrap_or(text);
        if message.starts_with('{') || !self.incomplete.is_empty() {
            self.incomplete += message;
        } else if self.rule.id == env_27::RULE.rule.id {
            self.record(&json!({ "dir": "out", "raw": message }).to_string());
        }
        let Ok(value) = serde_json::from_str::<Value>(&self.incomplete) else { return };
        self.incomplete.clear();
        self.request(value);
    }

    fn request(&mut self, value: Value) {
        let message = self.with_envelope(value, None);
        let name = message["body"]["type"].as_str().unwrap_or_default().to_owned();
        self.unanswered.push((message["id"].clone(), name.clone()));
        let mut record = json!({ "dir": "out", "msg": message });
        let trial = if self.rule.id == env_24::RULE.rule.id && name == "UAV-SOAR" {
            Some(env_07::RULE.rule.id)
        } else {
            let is_trial = self.rule.applies_to.contains("probe");
            (is_trial && (self.is_last || self.rule.id == env_25::RULE.rule.id)).then_some(self.rule.id)
        };
        if let Some(trial) = trial {
            record["trial"] = trial.into();
            record["how"] = "".into();
        }
        self.record(&record.to_string());
    }

    fn server(&mut self, text: &str) {
        let text = text.strip_prefix(EVENT).and_then(|text| text.strip_suffix(']')).unwrap_or(text);
        if text.starts_with("42[") || text.starts_with("HTTP") {
            return;
        }
        match serde_json::from_str::<Value>(text) {
            Ok(value) => {
                let refs = self.refs(&value);
                let message = self.with_envelope(value, refs);
                self.record(&json!({ "dir": "in", "msg": message }).to_string());
            }
            // Some JSON parsers accept `NaN`.
            Err(_) if Tree::read(text).is_ok() => self.record(&format!(r#"{{"dir":"in","msg":{text}}}"#)),
            Err(_) => self.record(&json!({ "dir": "in", "raw": text }).to_string()),
        }
    }

    /// The id of the request that a body answers, if the body is a response.
    fn refs(&mut self, body: &Value) -> Option<Value> {
        let name = body["type"].as_str()?;
        let same_type = self.unanswered.iter().position(|(_, request)| request == name);
        let can_be_notification =
            self.definitions.defined_schemas().is_defined(name, Direction::Notification);
        if same_type.is_none() && can_be_notification {
            return None;
        }
        if self.unanswered.is_empty() {
            self.request(json!({ "type": name }));
        }
        let (id, _) = self.unanswered.remove(same_type.unwrap_or_default());
        Some(id)
    }

    /// Returns a message with this body, or the value itself if it already has an envelope.
    fn with_envelope(&mut self, value: Value, refs: Option<Value>) -> Value {
        if value.get("type").is_none() {
            return value;
        }
        self.num_messages += 1;
        let id = format!("message-{}", self.num_messages);
        let mut message = json!({ "$fw.version": "1.0", "id": id, "body": value });
        if let Some(refs) = refs {
            message["refs"] = refs;
        }
        message
    }

    fn event(&mut self, event: Value) {
        let mut record = event;
        record["dir"] = "event".into();
        self.record(&record.to_string());
    }

    /// Adds a record from its JSON object.
    fn record(&mut self, object: &str) {
        self.time += 0.05;
        let connection = match self.rule.id {
            id if id.starts_with("FW-UDP") => "udp#1",
            id if id.starts_with("FW-SIO") => "socketio#1",
            _ => "tcp#1",
        };
        let members = object.strip_prefix('{').expect("an object");
        // Writing to a string cannot fail.
        let _ = writeln!(self.text, "{{\"t\":{},\"conn\":\"{connection}\",{members}", self.time);
    }
}
