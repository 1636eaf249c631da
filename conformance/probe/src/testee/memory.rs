//! Testees in memory, for tests. They answer immediately, and waiting for them takes only simulated time.

use std::collections::VecDeque;
use std::fmt;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError};
use std::time::Instant;

use uavspec_model::clock::Clock;

use super::link::Received;

/// A running testee: a function that takes a line, and returns the lines that the testee writes. `None` if the testee
/// ends instead.
type Answer = Box<dyn FnMut(&[u8]) -> Option<Vec<String>> + Send>;

/// A program: a function that starts a testee.
#[derive(Clone)]
pub struct Program(Arc<dyn Fn() -> Answer + Send + Sync>);

impl Program {
    pub(super) fn new(start: impl Fn() -> Answer + Send + Sync + 'static) -> Self {
        Self(Arc::new(start))
    }

    /// Starts the program, which receives the requests from a channel.
    pub(super) fn start(&self, requests: Receiver<Vec<u8>>, line_limit: usize) -> Memory {
        Memory { answer: Some((self.0)()), requests, lines: VecDeque::new(), line_limit }
    }
}

impl fmt::Debug for Program {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Program")
    }
}

impl PartialEq for Program {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Eq for Program {}

/// A connection to a testee in memory.
pub(super) struct Memory {
    /// The running testee. `None` if it has ended.
    answer: Option<Answer>,
    requests: Receiver<Vec<u8>>,
    lines: VecDeque<String>,
    line_limit: usize,
}

impl Memory {
    pub(super) fn receive(&mut self, until: Instant, clock: &Clock) -> Received {
        loop {
            match self.lines.pop_front() {
                Some(line) if line.len() > self.line_limit => return Received::TooLong,
                Some(line) => return Received::Line(line.into_bytes()),
                None => {}
            }
            match (&mut self.answer, self.requests.try_recv()) {
                (None, _) | (_, Err(TryRecvError::Disconnected)) => return Received::Closed,
                (Some(answer), Ok(line)) => match answer(&line) {
                    Some(lines) => self.lines.extend(lines),
                    None => self.answer = None,
                },
                (_, Err(TryRecvError::Empty)) => {
                    clock.sleep_until(until);
                    return Received::Nothing;
                }
            }
        }
    }
}
