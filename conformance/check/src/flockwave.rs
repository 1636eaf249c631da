//! Checks recorded Flockwave sessions and files of bare messages.
//!
//! A line of a recorded session is `{"t": time since the epoch, "conn": name, "dir": "in" or "out", "msg": {…}}`.
//! The direction is from the client's point of view. Data that is not JSON is stored as a string in `"raw"` instead of
//! `"msg"`. For events, `"dir"` is `"event"`, and `"event"` is `"connect"`, `"closed"` or `"refused"`.
//!
//! Sessions recorded by `probe` have further members. `"trial"` is the id of the rule under test, and `"how"` describes
//! the trial. `"url"` appears at the start of a connection, and `"why"` at the end of a connection. The value of
//! `"why"` is `"client"` if the client closed the connection. Other members are ignored.

mod listeners;
mod pieces;
mod reports;
mod summary;
mod time;
mod types;

use std::collections::HashMap;

use uavspec_flockwave::record::{Connection, Direction, SessionRecord, Trial};
use uavspec_flockwave::session::parts;
use uavspec_model::json::{SyntaxError, TRUNCATED, Tree};
use uavspec_model::text::{thousands, utf8};
use uavspec_model::{Extent, Location};
use uavspec_rules::definitions::Definitions;
use uavspec_rules::rule;
use uavspec_schema::json_type;

pub(super) use self::listeners::Listeners;
use self::pieces::Pieces;
pub(super) use self::reports::Report;
use self::reports::Reports;
pub use self::summary::{FlockwaveSummary, TypeCount, UnreadTimes};
use self::types::{FromServer, Types};
use super::coverage::{PartResult, Parts, Share, Tally, Unit};
use super::{CaptureResult, CheckRun, Summary, microseconds};
use crate::limits::{MAX_CONNECTION_NAME, MAX_CONNECTIONS};

/// The maximum length of `how`, in bytes. Longer values are ignored.
const MAX_HOW: usize = 512;

/// True for a line of a recorded session, and for a bare Flockwave message.
pub(crate) fn is_flockwave(tree: &Tree<'_>) -> bool {
    is_line(tree) || is_message(tree)
}

fn is_line(tree: &Tree<'_>) -> bool {
    let has = |key| tree.get(key).is_some();
    // rosbridge messages have `op`.
    tree.get("dir").and_then(Tree::as_str).is_some()
        && !has("op")
        && (has("msg") || has("raw") || has("event"))
}

fn is_message(tree: &Tree<'_>) -> bool {
    tree.get("$fw.version").is_some()
}

/// Checks the records of a session, from a file or from a live server.
pub struct FlockwaveChecker<'d> {
    pub(super) run: CheckRun<'d>,
    source: FlockwaveSummary,
    reports: Reports<'d>,
    /// The incomplete messages from clients.
    pieces: Pieces,
    /// The connection numbers, by connection name.
    connections: HashMap<String, usize>,
    types: Types,
}

/// A message or an event of a connection.
#[derive(Clone, Copy)]
struct ParsedLine<'h> {
    /// The name of the connection, if it is known.
    name: Option<&'h str>,
    direction: Direction,
    time: Option<f64>,
    content: Content<'h>,
    text: &'h str,
    trial: Option<Trial<'h>>,
    note: Option<&'h str>,
}

/// The content of a record.
#[derive(Clone, Copy)]
enum Content<'c> {
    Message(&'c Tree<'c>),
    /// Data that is not JSON.
    Raw,
    Event,
}

impl<'d> FlockwaveChecker<'d> {
    /// Creates a checker for a new session.
    pub fn new(definitions: &'d Definitions) -> Self {
        Self::with_run(CheckRun::new(definitions))
    }

    pub(super) fn with_run(run: CheckRun<'d>) -> Self {
        // The fast path drops the content of status reports, but an observer needs it.
        let reports = match &run.observer {
            Some(_) => Reports::disabled(),
            None => Reports::new(run.definitions),
        };
        let source = FlockwaveSummary::default();
        Self {
            run,
            source,
            reports,
            pieces: Pieces::default(),
            connections: HashMap::new(),
            types: Types::default(),
        }
    }

    /// Disables the fast path for status reports. The result of a check stays the same, but the check takes several
    /// times as long. Tests compare both paths.
    #[must_use]
    pub fn thorough(self) -> Self {
        Self { reports: Reports::disabled(), ..self }
    }

    /// The number of status reports that took the fast path.
    pub fn num_known_reports(&self) -> u64 {
        self.reports.seen()
    }

    /// Checks a line of a recorded session, or a bare message.
    pub fn line(&mut self, bytes: &[u8], line: u64, is_last: bool) {
        let location = Location::Line(line);
        let done = match self.reports.read(bytes) {
            Some(report) => self.report(&report, location, is_last),
            None => self.read(bytes, location, is_last),
        };
        if let Err(problem) = done {
            let extent = if is_last { Extent::EndsEarly } else { Extent::WithGaps };
            self.run.corruption(location, problem, extent);
        }
    }

    /// Handles a status report. Its findings are only counted if they are known.
    fn report(&mut self, report: &Report<'_>, location: Location, is_last: bool) -> Result<(), String> {
        let index = self.connection(report.name)?;
        let time = time::of_number(report.time);
        if time.is_none() || !self.reports.count(report, &self.run.findings) {
            return self.read(report.text.as_bytes(), location, is_last);
        }
        let record = SessionRecord {
            connection: connection(index, report.name),
            direction: Direction::In,
            time,
            text: report.text,
            value: None,
            trial: None,
            note: None,
            location,
        };
        self.run.include_time(record.time);
        self.run.records += 1;
        self.source.notifications += 1;
        let direction = json_type::Direction::Notification;
        self.count_type(&record, Report::TYPE, direction, Report::NUM_VALUES);
        self.run.checked_report(&record, report);
        Ok(())
    }

    fn read(&mut self, bytes: &[u8], location: Location, is_last: bool) -> Result<(), String> {
        let text = utf8(bytes)?;
        let tree = Tree::read(text).map_err(|error| match error {
            SyntaxError { problem: TRUNCATED, at } if is_last => {
                format!("the last value is truncated after {at} bytes")
            }
            error => error.to_string(),
        })?;
        if is_line(&tree) {
            return self.recorded(&tree, text, location);
        }
        if is_message(&tree) {
            let direction =
                if is_request(&tree, self.run.definitions) { Direction::Out } else { Direction::In };
            let content = Content::Message(&tree);
            let bare =
                ParsedLine { name: None, direction, time: None, content, text, trial: None, note: None };
            return self.record(&bare, location);
        }
        Err("expected a line of a recorded session (with `dir`, and one of `msg`, `raw` and `event`) or a Flockwave \
             message (with `$fw.version`)"
            .to_owned())
    }

    /// Handles a record of a recorded session, parsed from a line.
    fn recorded(&mut self, tree: &Tree<'_>, text: &str, location: Location) -> Result<(), String> {
        let name = match tree.get("conn") {
            None | Some(Tree::Null) => None,
            Some(Tree::Text(name)) => Some(name.to_string()),
            Some(other) => Some(other.to_string()),
        };
        let time = tree.get("t").filter(|time| **time != Tree::Null).and_then(|time| {
            let read = time::seconds(time);
            if read.is_none() {
                self.source.unread_times.add(time, location);
            }
            read
        });
        let direction = match tree.get("dir").and_then(Tree::as_str) {
            Some("in") => Direction::In,
            Some("out") => Direction::Out,
            Some("event") => Direction::Event,
            _ => return Err("`dir`: expected `in`, `out` or `event`".to_owned()),
        };
        let string = |key| tree.get(key).and_then(Tree::as_str);
        let trial = string("trial").and_then(rule);
        let how = string("how").filter(|how| how.len() <= MAX_HOW).unwrap_or_default();
        let line = ParsedLine {
            name: name.as_deref(),
            direction,
            time,
            content: Content::Raw,
            text,
            trial: trial.map(|rule| Trial { rule, how }),
            note: string("url").or_else(|| string("why")),
        };
        match (direction, tree.get("msg"), string("raw")) {
            (Direction::Event, ..) => {
                let event = string("event").ok_or("`event`: expected a string")?;
                self.record(&ParsedLine { content: Content::Event, text: event, ..line }, location)
            }
            (_, Some(message), _) => {
                if direction == Direction::Out {
                    self.end_pieces(line.name)?;
                }
                self.record(&ParsedLine { content: Content::Message(message), ..line }, location)
            }
            (Direction::Out, None, Some(raw)) if name.as_deref().is_some_and(is_ordered) => {
                self.piece(&line, raw, location)
            }
            (_, None, Some(raw)) => self.raw(&ParsedLine { text: raw, ..line }, location),
            (_, None, None) => Err("expected `msg`, or `raw` with a string".to_owned()),
        }
    }

    /// Handles text that was sent over a stream. The text may be a part of a message, or contain several messages.
    fn piece(&mut self, line: &ParsedLine<'_>, piece: &str, location: Location) -> Result<(), String> {
        let index = self.connection(line.name.unwrap_or_default())?;
        for text in self.pieces.add(index, piece) {
            self.raw(&ParsedLine { text: &text, ..*line }, location)?;
        }
        self.run.sessions.sending(index, self.pieces.is_incomplete(index));
        Ok(())
    }

    /// Handles the end of an incomplete text: a whole message follows on the same connection, so no piece can complete
    /// the text.
    fn end_pieces(&mut self, name: Option<&str>) -> Result<(), String> {
        let index = self.connection(name.unwrap_or_default())?;
        if self.pieces.end(index).is_some() {
            self.run.sessions.sent_unreadable(index);
        }
        Ok(())
    }

    /// Handles text that may be a message. The program that recorded the session may have a stricter JSON parser. In
    /// text from a client, U+FFFD replaces bytes that aren't valid UTF-8, so the server can't read the message.
    fn raw(&mut self, line: &ParsedLine<'_>, location: Location) -> Result<(), String> {
        let is_replaced = line.direction == Direction::Out && line.text.contains(char::REPLACEMENT_CHARACTER);
        match Tree::read(line.text) {
            Ok(message) if !is_replaced => {
                self.record(&ParsedLine { content: Content::Message(&message), ..*line }, location)
            }
            _ => self.record(line, location),
        }
    }

    /// Passes a record to the rules and counts it.
    fn record(&mut self, line: &ParsedLine<'_>, location: Location) -> Result<(), String> {
        let ParsedLine { name, direction, time, content, text, trial, note } = *line;
        let content = match content {
            // If a key is repeated, the server may use a different value than these rules.
            Content::Message(value) if direction == Direction::Out && value.repeats_a_key() => Content::Raw,
            other => other,
        };
        let name = name.unwrap_or_default();
        let connection = connection(self.connection(name)?, name);
        let value = if let Content::Message(value) = content { Some(value) } else { None };
        let record = SessionRecord { connection, direction, time, text, value, trial, note, location };
        self.follow_event(&record);
        self.count(&record);
        self.run.session_record(&record);
        Ok(())
    }

    /// The number of a connection. A new name gets the next number.
    fn connection(&mut self, name: &str) -> Result<usize, String> {
        if let Some(index) = self.connections.get(name) {
            return Ok(*index);
        }
        if name.len() > MAX_CONNECTION_NAME {
            return Err(format!("the connection name is longer than {MAX_CONNECTION_NAME} bytes"));
        }
        let index = self.connections.len();
        if index >= MAX_CONNECTIONS {
            return Err(format!("more than {} connections", thousands(MAX_CONNECTIONS)));
        }
        self.connections.insert(name.to_owned(), index);
        self.source.connections += 1;
        Ok(index)
    }

    /// Handles the start and the end of connections.
    fn follow_event(&mut self, record: &SessionRecord<'_>) {
        if record.direction != Direction::Event {
            return;
        }
        if matches!(record.text, "connect" | "closed") {
            self.pieces.end(record.connection.index);
        }
        match record.text {
            "connect" => {
                self.run.disconnected(record.connection, None);
                self.run.sessions.opened(record.connection.index);
            }
            "closed" => self.run.disconnected(record.connection, record.note),
            "failed" => self.run.sessions.failed(record.connection.index, record.note),
            _ => {}
        }
    }

    fn count(&mut self, record: &SessionRecord<'_>) {
        self.run.include_time(record.time);
        if record.direction == Direction::Event {
            return;
        }
        let is_from_server = record.direction == Direction::In;
        self.run.records += u64::from(is_from_server);
        let Some(message) = record.value else { return };
        let name = message.get("body").and_then(|body| body.get("type")).and_then(Tree::as_str);
        let is_answer = message.get("refs").is_some_and(|refs| *refs != Tree::Null)
            || self.run.sessions.is_answer_to_unknown(record, self.run.definitions.body_schemas());
        let direction = match (is_answer, is_from_server) {
            (true, _) => json_type::Direction::Response,
            (false, true) if name != Some("SYS-PING") => json_type::Direction::Notification,
            (false, _) => json_type::Direction::Request,
        };
        *match direction {
            json_type::Direction::Request => &mut self.source.requests,
            json_type::Direction::Response => &mut self.source.responses,
            json_type::Direction::Notification => &mut self.source.notifications,
        } += 1;
        let Some(name) = name else {
            // Envelope rules also check messages that have no type.
            return self.run.checked += u64::from(is_from_server);
        };
        let num_values = match message.get("body") {
            Some(Tree::Object(members)) => members.len() as u64,
            _ => 0,
        };
        self.count_type(record, name, direction, num_values);
    }

    /// Counts a message of a type. `num_values` is the number of values in its body.
    fn count_type(
        &mut self,
        record: &SessionRecord<'_>,
        name: &str,
        direction: json_type::Direction,
        num_values: u64,
    ) {
        let is_from_server = record.direction == Direction::In;
        let Some(counts) = self.types.get(name, self.run.definitions) else {
            return self.source.uncounted += u64::from(is_from_server);
        };
        if !is_from_server {
            return counts.messages.from_client += 1;
        }
        counts.messages.from_server += 1;
        let found = counts.sent_by_server(direction);
        found.tally.records += 1;
        found.tally.count(found.is_checked, record.time.and_then(microseconds));
        found.values += num_values;
        self.run.checked += u64::from(found.is_checked);
    }

    /// Returns the result. `bytes` is the number of bytes read.
    pub fn finish(mut self, bytes: u64) -> CaptureResult {
        let mut connections: Vec<(&String, &usize)> = self.connections.iter().collect();
        connections.sort_by_key(|(_, index)| **index);
        for (name, index) in connections {
            self.run.disconnected(connection(*index, name), None);
        }
        self.reports.report_counted(&mut self.run.findings);
        let parts = self.parts();
        for counts in self.types.iter() {
            let types = if counts.is_known { &mut self.source.types } else { &mut self.source.unknown };
            types.push(counts.messages.clone());
        }
        let mut result = self.run.finish(bytes, Summary::Flockwave(self.source), Unit::Type, parts);
        // Envelope rules also check messages that have no type.
        result.coverage.records.checked = result.checked;
        result
    }

    fn parts(&self) -> Parts {
        let mut parts = Parts::default();
        for counts in self.types.iter() {
            let name = &counts.messages.name;
            for (direction, found) in counts.directions() {
                let FromServer { is_checked, tally, values } = *found;
                let result = if is_checked { PartResult::Checked } else { PartResult::Undefined };
                let values = Share::of(if is_checked { values } else { 0 }, values);
                if counts.is_known && !is_checked {
                    // The type has a definition, but not for this direction.
                    parts.add(&format!("{name} ({direction})"), result, tally, values);
                } else {
                    parts.add(name, result, tally, values);
                }
            }
        }
        if self.source.uncounted > 0 {
            let tally = Tally::of(self.source.uncounted);
            parts.add("types not listed by name", PartResult::Undefined, tally, Share::default());
        }
        parts
    }
}

/// A connection. Messages without a connection have an empty name.
fn connection(index: usize, name: &str) -> Connection<'_> {
    let is_ordered = !name.is_empty() && is_ordered(name);
    let is_lossy = name.is_empty() || begins(name, "udp");
    Connection { index, name, is_ordered, is_lossy }
}

/// True if the connection with this name delivers messages in order. A name that starts with `udp` denotes UDP, which
/// doesn't. A name that starts with `http` denotes many connections, one for each request.
fn is_ordered(name: &str) -> bool {
    !begins(name, "udp") && !begins(name, "http")
}

fn begins(name: &str, with: &str) -> bool {
    name.get(..with.len()).is_some_and(|start| start.eq_ignore_ascii_case(with))
}

/// True if a bare message is a request. If a type has both requests and notifications, the fields of the message
/// decide.
fn is_request(message: &Tree<'_>, definitions: &Definitions) -> bool {
    let Some(body) = message.get("body") else { return false };
    let Some(name) = body.get("type").and_then(Tree::as_str) else { return false };
    if message.get("refs").is_some_and(|refs| *refs != Tree::Null) {
        return false;
    }
    let schemas = definitions.defined_schemas();
    if !schemas.is_defined(name, json_type::Direction::Notification) {
        // An acknowledgment without `refs` answers a request without an id.
        return !schemas.has(name) || schemas.is_defined(name, json_type::Direction::Request);
    }
    let has_result = ["status", "values"].iter().any(|key| body.get(key).is_some());
    let has_request = parts(name).is_some_and(|parts| body.get(parts.request_field).is_some());
    !has_result && (has_request || name == "TIMESYNC-STATUS")
}
