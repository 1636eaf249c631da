//! TCP: one message per line.

use std::collections::VecDeque;
use std::rc::Rc;

use serde::de::IgnoredAny;
use serde_json::Value;
use uavspec_flockwave::transport::lines::{Line, Lines};
use uavspec_rules::flockwave::{env_25, tcp_01, tcp_02, tcp_03, tcp_04};

use super::Shared;
use super::connection::{Protocol, Step};
use super::limits::{REQUEST_LIMIT, Reason};
use super::outbox::Outbox;
use crate::hub::{ConnectionKind, SessionId, Sink};

/// Sends messages as lines.
struct LineSink {
    outbox: Rc<Outbox>,
    /// True with the FW-TCP-01 bug, which splits notifications into several lines.
    is_spread: bool,
}

impl Sink for LineSink {
    fn send(&self, text: &str) {
        let spread = if self.is_spread { spread(text) } else { None };
        self.outbox.push(spread.unwrap_or_else(|| text.to_owned()) + "\n");
    }

    fn close(&self) {
        self.outbox.close();
    }
}

/// A notification with line breaks.
#[allow(clippy::disallowed_methods, reason = "a client reads it, no terminal")]
fn spread(text: &str) -> Option<String> {
    let message: Value = serde_json::from_str(text).ok()?;
    if message.get("refs").is_some() { None } else { serde_json::to_string_pretty(&message).ok() }
}

/// A client over TCP.
pub(super) struct LineClient {
    session: SessionId,
    lines: Lines,
    /// Reordered lines; used only with bugs.
    reordered: VecDeque<Line>,
}

impl LineClient {
    pub(super) fn new(shared: &mut Shared, outbox: &Rc<Outbox>) -> Self {
        let sink = LineSink { outbox: Rc::clone(outbox), is_spread: shared.has_bug(&tcp_01::RULE) };
        let session = shared.hub.open(ConnectionKind::Persistent, Rc::new(sink));
        Self { session, lines: Lines::new(REQUEST_LIMIT), reordered: VecDeque::new() }
    }

    /// The next line. Some bugs affect all lines that arrived together.
    fn next(&mut self, shared: &Shared) -> Option<Line> {
        let (is_reversing, is_dropping) = (shared.has_bug(&env_25::RULE), shared.has_bug(&tcp_02::RULE));
        if !is_reversing && !is_dropping {
            return self.lines.take();
        }
        if self.reordered.is_empty() {
            let mut taken = self.lines.taken();
            if is_reversing {
                taken.reverse();
            }
            if is_dropping {
                taken.truncate(1);
            }
            self.reordered = taken.into();
        }
        self.reordered.pop_front()
    }
}

impl Protocol for LineClient {
    fn feed(&mut self, bytes: &[u8]) {
        self.lines.feed(bytes);
    }

    fn step(&mut self, shared: &mut Shared, _: &Rc<Outbox>) -> Step {
        let Some(line) = self.next(shared) else {
            if shared.has_bug(&tcp_04::RULE) {
                self.lines.drop_rest();
            }
            return Step::Starved;
        };
        // A line over the length limit is dropped, because its request is unknown.
        let Line::Whole(line) = line else { return Step::Handled { is_request: false } };
        if shared.has_bug(&tcp_03::RULE) && serde_json::from_slice::<IgnoredAny>(&line).is_err() {
            return Step::End;
        }
        Step::Handled { is_request: shared.receive(self.session, &line) }
    }

    fn unfinished(&self) -> usize {
        self.lines.capacity()
    }

    fn end(&mut self, shared: &mut Shared, reason: Reason) {
        shared.hub.end_session(self.session, reason);
    }
}
