//! Messages that don't go as they should over transports that carry one message each in a line or a datagram.

use std::collections::BTreeMap;

use super::{Exchange, Role, Tree};
use crate::flockwave::record::{Connection, Direction};
use crate::json::Frame;
use crate::model::Location;

/// How long a message over several lines may be, in bytes: what is longer is taken for no message.
const MAX_TEXT: usize = 1 << 20;

/// How many lines it may have.
const MAX_LINES: usize = 10_000;

/// On how many connections lines are followed at the same time.
const MAX_CONNECTIONS: usize = 16;

/// A line that is no message.
#[derive(Debug)]
pub(super) struct Line {
    /// Where it stands.
    pub(super) location: Location,
    /// What it is instead of an object, where it is JSON.
    pub(super) actual: Option<String>,
    /// How it begins.
    pub(super) excerpt: String,
}

/// Lines of servers that are no messages. Those that make up one together are told from others, which may take until the
/// next message comes.
#[derive(Debug, Default)]
pub(super) struct Lines {
    /// By the index of the connection.
    open: BTreeMap<usize, Open>,
    /// The first lines of what is a message together, and how many lines it has.
    pub(super) whole: Vec<(Line, usize)>,
    /// Lines that aren't part of a message.
    pub(super) other: Vec<Line>,
}

/// Lines that may be the beginning of a message.
#[derive(Debug, Default)]
struct Open {
    lines: Vec<Line>,
    text: String,
    frame: Frame,
}

impl Lines {
    /// Follows what goes over a connection.
    pub(super) fn follow(&mut self, exchange: &Exchange<'_>) {
        let index = exchange.record.connection.index;
        match exchange.role {
            Role::Unanswered => {}
            Role::Unreadable if exchange.record.direction == Direction::In => self.line(index, exchange),
            // What clients send doesn't part what servers do.
            _ if exchange.record.direction == Direction::Out => {}
            // The client didn't wait for the rest.
            Role::Event if exchange.record.note == Some("client") => _ = self.open.remove(&index),
            _ => self.end_of(index),
        }
    }

    /// What may be lost, or is at its end, isn't going to be a message any more.
    pub(super) fn part_all(&mut self) {
        while let Some((_, open)) = self.open.pop_first() {
            self.other.extend(open.lines);
        }
    }

    /// Another message goes over the connection: open lines are no message.
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
        // A number between others is JSON as well, and it doesn't matter which it is.
        let text = if record.value.is_some() { "0" } else { record.text };
        let is_first = !self.open.contains_key(&index);
        if is_first && (!is_of_lines(exchange) || !text.trim_start().starts_with('{')) {
            return self.other.push(line);
        }
        if is_first && self.open.len() >= MAX_CONNECTIONS {
            self.part_all();
        }
        let open = self.open.entry(index).or_default();
        open.lines.push(line);
        open.text.push_str(text);
        open.text.push('\n');
        let depth = open.frame.follow(text);
        if open.text.len() > MAX_TEXT || open.lines.len() > MAX_LINES {
            return self.end_of(index);
        }
        if depth > 0 {
            return;
        }
        let is_message = open.lines.len() > 1 && matches!(Tree::read(&open.text), Ok(Tree::Object(_)));
        if !is_message {
            return self.end_of(index);
        }
        let open = self.open.remove(&index).unwrap_or_default();
        let count = open.lines.len();
        self.whole.extend(open.lines.into_iter().next().map(|first| (first, count)));
    }
}

/// Whether messages are lines on this connection: those of TCP are called `tcp` or begin so.
fn is_of_lines(exchange: &Exchange<'_>) -> bool {
    is_called(exchange.record.connection, "tcp")
}

/// Whether the name of the connection begins so.
pub(super) fn is_called(connection: Connection<'_>, start: &str) -> bool {
    let name = connection.name.get(..start.len());
    name.is_some_and(|name| name.eq_ignore_ascii_case(start))
}

/// Whether a server sends several messages in the place of one: in one line, or in one datagram.
pub(super) fn are_several(exchange: &Exchange<'_>, transport: &str) -> bool {
    let record = exchange.record;
    if exchange.role != Role::Unreadable || record.direction != Direction::In || record.value.is_some() {
        return false;
    }
    let is_object = |text: &str| matches!(Tree::read(text), Ok(Tree::Object(_)));
    is_called(exchange.record.connection, transport)
        && Tree::read(record.text).err().is_some_and(|error| {
            let (first, rest) = record.text.split_at_checked(error.at).unwrap_or_default();
            // Of more than two, the first is enough to see it.
            is_object(first)
                && (is_object(rest) || Tree::read(rest).is_err_and(|error| starts_object(rest, error.at)))
        })
}

/// Whether an object stands before this byte.
fn starts_object(text: &str, at: usize) -> bool {
    text.get(..at).is_some_and(|text| matches!(Tree::read(text), Ok(Tree::Object(_))))
}
