//! Detects messages that violate the framing of a transport, which is one message per line or datagram.

use std::collections::BTreeMap;

use uavspec_flockwave::record::{Connection, Direction};
use uavspec_flockwave::session::{Exchange, Role};
use uavspec_model::Location;
use uavspec_model::json::{Frame, Tree};

use crate::limits::{MAX_CONNECTIONS, MAX_INCOMPLETE, MAX_LINES};

/// A line that is not a message.
#[derive(Debug)]
pub(super) struct Line {
    /// The location of the line.
    pub(super) location: Location,
    /// The JSON value, if the line is JSON but not an object.
    pub(super) actual: Option<String>,
    /// The start of the line.
    pub(super) excerpt: String,
}

/// Server lines that are not complete messages. A line is either part of a message that spans several lines, or an
/// unrelated line. Sometimes, only the next message shows which case applies.
#[derive(Debug, Default)]
pub(super) struct Lines {
    /// Undecided lines, by connection index.
    open: BTreeMap<usize, Open>,
    /// For each message that spans several lines, its first line and its number of lines.
    pub(super) split: Vec<(Line, usize)>,
    /// Lines that are not part of a message.
    pub(super) other: Vec<Line>,
}

/// Lines that may be the start of a message.
#[derive(Debug, Default)]
struct Open {
    lines: Vec<Line>,
    text: String,
    frame: Frame,
}

impl Lines {
    /// Processes a record.
    pub(super) fn follow(&mut self, exchange: &Exchange<'_>) {
        let index = exchange.record.connection.index;
        match exchange.role {
            Role::Unanswered => {}
            Role::Unreadable if exchange.record.direction == Direction::In => self.line(index, exchange),
            // Client messages do not interrupt a server message.
            _ if exchange.record.direction == Direction::Out => {}
            // The client closed the connection without waiting for the rest.
            Role::Event if exchange.record.note == Some("client") => _ = self.open.remove(&index),
            _ => self.end_of(index),
        }
    }

    /// Moves all undecided lines to `other`, because the rest may be missing or the session has ended.
    pub(super) fn discard_open(&mut self) {
        while let Some((_, open)) = self.open.pop_first() {
            self.other.extend(open.lines);
        }
    }

    /// Moves the undecided lines of a connection to `other`, because they are not part of a message.
    pub(super) fn end_of(&mut self, index: usize) {
        if let Some(open) = self.open.remove(&index) {
            self.other.extend(open.lines);
        }
    }

    fn line(&mut self, index: usize, exchange: &Exchange<'_>) {
        let record = exchange.record;
        let line = Line {
            location: record.location,
            actual: record.value.map(ToString::to_string),
            excerpt: exchange.excerpt(),
        };
        // A line that is a complete JSON value may be part of a larger message. Any JSON value works as its
        // placeholder.
        let text = if record.value.is_some() { "0" } else { record.text };
        let is_first = !self.open.contains_key(&index);
        if is_first && (!is_tcp(exchange) || !text.trim_start().starts_with('{')) {
            return self.other.push(line);
        }
        if is_first && self.open.len() >= MAX_CONNECTIONS {
            self.discard_open();
        }
        let open = self.open.entry(index).or_default();
        open.lines.push(line);
        open.text.push_str(text);
        open.text.push('\n');
        let depth = open.frame.follow(text);
        if open.text.len() > MAX_INCOMPLETE || open.lines.len() > MAX_LINES {
            return self.end_of(index);
        }
        if depth > 0 {
            return;
        }
        let is_message = matches!(Tree::read(&open.text), Ok(Tree::Object(_)));
        if !is_message {
            return self.end_of(index);
        }
        let open = self.open.remove(&index).unwrap_or_default();
        let count = open.lines.len();
        self.split.extend(open.lines.into_iter().next().map(|first| (first, count)));
    }
}

/// True if the connection uses TCP, where each message is a line. The names of TCP connections start with `tcp`.
fn is_tcp(exchange: &Exchange<'_>) -> bool {
    name_starts_with(exchange.record.connection, "tcp")
}

/// True if the name of the connection starts with `start`, ignoring case.
pub(super) fn name_starts_with(connection: Connection<'_>, start: &str) -> bool {
    let name = connection.name.get(..start.len());
    name.is_some_and(|name| name.eq_ignore_ascii_case(start))
}

/// True if the record is a server line or datagram that contains several messages.
pub(super) fn has_several_messages(exchange: &Exchange<'_>, transport: &str) -> bool {
    let record = exchange.record;
    if exchange.role != Role::Unreadable || record.direction != Direction::In {
        return false;
    }
    let is_object = |text: &str| matches!(Tree::read(text), Ok(Tree::Object(_)));
    name_starts_with(exchange.record.connection, transport)
        && Tree::read(record.text).err().is_some_and(|error| {
            let (first, rest) = record.text.split_at_checked(error.at).unwrap_or_default();
            // The first two messages are sufficient.
            is_object(first)
                && (is_object(rest) || Tree::read(rest).is_err_and(|error| is_object_up_to(rest, error.at)))
        })
}

/// True if the text before this byte is a JSON object.
fn is_object_up_to(text: &str, at: usize) -> bool {
    text.get(..at).is_some_and(|text| matches!(Tree::read(text), Ok(Tree::Object(_))))
}
