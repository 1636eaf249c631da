//! Queues of data for clients.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::io::{ErrorKind, Write as _};
use std::net::Shutdown;
use std::rc::Rc;
use std::time::{Duration, Instant};

use mio::net::TcpStream;
use tungstenite::protocol::frame::Frame;
use tungstenite::protocol::frame::coding::{Data, OpCode};
use uavspec_model::clock::Clock;

use super::limits::{Budget, QUEUE_LIMIT, Share};
use super::statistics::Reason;

/// The bytes that wait to be sent over a connection.
#[derive(Debug)]
pub(super) struct Outbox {
    stream: Rc<TcpStream>,
    clock: Clock,
    bytes: RefCell<VecDeque<u8>>,
    share: Share,
    state: Cell<State>,
    /// The time of the last progress while bytes are waiting.
    waiting_since: Cell<Option<Instant>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Open,
    /// The connection ends after the waiting bytes have been sent.
    Closing,
    /// All bytes have been sent.
    Sent,
    /// Nothing more can be sent.
    Failed(Reason),
}

impl Outbox {
    pub(super) fn new(stream: Rc<TcpStream>, budget: &Rc<Budget>, clock: Clock) -> Self {
        Self {
            stream,
            clock,
            bytes: RefCell::default(),
            share: Share::new(budget),
            state: Cell::new(State::Open),
            waiting_since: Cell::new(None),
        }
    }

    /// Sends as many of these bytes as possible, and queues the rest. A client that reads too slowly is disconnected.
    pub(super) fn push(&self, bytes: &[u8]) {
        if self.state.get() != State::Open {
            return;
        }
        let sent = if self.waiting() == 0 { self.send(bytes) } else { 0 };
        let rest = &bytes[sent..];
        if rest.is_empty() || self.has_failed() {
            return;
        }
        self.bytes.borrow_mut().extend(rest);
        if self.waiting_since.get().is_none() {
            self.waiting_since.set(Some(self.clock.now()));
        }
        let waiting = self.waiting();
        if self.share.set(waiting).is_err() || waiting > QUEUE_LIMIT {
            self.fail(Reason::TooSlow);
        }
    }

    /// Sends a WebSocket frame.
    pub(super) fn push_frame(&self, frame: Frame) {
        let mut bytes = Vec::with_capacity(frame.len());
        // Writing to memory can't fail.
        if frame.format(&mut bytes).is_ok() {
            self.push(&bytes);
        }
    }

    /// Sends a text as a WebSocket message.
    pub(super) fn push_text(&self, text: &str) {
        self.push_frame(Frame::message(text.to_owned(), OpCode::Data(Data::Text), true));
    }

    /// Sends waiting bytes, as many as possible.
    pub(super) fn flush(&self) {
        while self.waiting() > 0 && !self.has_failed() {
            let mut bytes = self.bytes.borrow_mut();
            let sent = self.send(bytes.as_slices().0);
            if sent == 0 {
                break;
            }
            bytes.drain(..sent);
            if bytes.is_empty() {
                *bytes = VecDeque::new();
            }
            self.waiting_since.set((!bytes.is_empty()).then(|| self.clock.now()));
            // A shrinking share can't exceed the budget.
            let _ = self.share.set(bytes.len());
        }
        if self.state.get() == State::Closing && self.waiting() == 0 {
            self.state.set(State::Sent);
            // The client may have disconnected already.
            let _ = self.stream.shutdown(Shutdown::Write);
        }
    }

    /// Ends the connection after the waiting bytes have been sent.
    pub(super) fn close(&self) {
        if self.state.get() == State::Open {
            self.state.set(State::Closing);
        }
        self.flush();
    }

    /// Drops the waiting bytes, and ends the connection.
    pub(super) fn fail(&self, reason: Reason) {
        self.state.set(State::Failed(reason));
        *self.bytes.borrow_mut() = VecDeque::new();
        self.waiting_since.set(None);
        let _ = self.share.set(0);
    }

    /// The number of waiting bytes.
    pub(super) fn waiting(&self) -> usize {
        self.bytes.borrow().len()
    }

    /// True if no more data can be added.
    pub(super) fn is_closed(&self) -> bool {
        self.state.get() != State::Open
    }

    /// True if all bytes have been sent and the connection is closed in this direction.
    pub(super) fn is_sent(&self) -> bool {
        self.state.get() == State::Sent
    }

    /// The reason why nothing more can be sent.
    pub(super) fn failure(&self) -> Option<Reason> {
        match self.state.get() {
            State::Failed(reason) => Some(reason),
            _ => None,
        }
    }

    /// The time during which the client has read nothing although bytes are waiting.
    pub(super) fn waiting_time(&self, now: Instant) -> Duration {
        self.waiting_since.get().map_or(Duration::ZERO, |since| now.saturating_duration_since(since))
    }

    fn has_failed(&self) -> bool {
        self.failure().is_some()
    }

    /// Sends bytes, and returns their number.
    fn send(&self, bytes: &[u8]) -> usize {
        loop {
            match (&*self.stream).write(bytes) {
                Ok(sent) => return sent,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                // A new connection may not be ready yet.
                Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::NotConnected) => {
                    return 0;
                }
                Err(_) => {
                    self.state.set(State::Failed(Reason::Disconnected));
                    return 0;
                }
            }
        }
    }
}

/// Texts that wait until they are taken.
#[derive(Debug)]
pub(super) struct TextQueue {
    texts: RefCell<VecDeque<String>>,
    bytes: Cell<usize>,
    share: Share,
    is_closed: Cell<bool>,
    has_overflowed: Cell<bool>,
}

/// The memory for managing a text.
const TEXT_OVERHEAD: usize = 32;

/// The result of [`TextQueue::take`].
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Taken {
    /// At least one text.
    Texts(Vec<String>),
    /// The queue is empty.
    Nothing,
    /// The queue is empty and closed.
    End,
}

impl TextQueue {
    pub(super) fn new(budget: &Rc<Budget>) -> Self {
        Self {
            texts: RefCell::default(),
            bytes: Cell::new(0),
            share: Share::new(budget),
            is_closed: Cell::new(false),
            has_overflowed: Cell::new(false),
        }
    }

    /// Adds a text, unless the queue is closed. A queue that becomes too long is emptied and closed.
    pub(super) fn push(&self, text: String) {
        if self.is_closed.get() {
            return;
        }
        let bytes = self.bytes.get() + text.len() + TEXT_OVERHEAD;
        self.texts.borrow_mut().push_back(text);
        self.bytes.set(bytes);
        if self.share.set(bytes).is_err() || bytes > QUEUE_LIMIT {
            self.texts.replace(VecDeque::new());
            self.bytes.set(0);
            let _ = self.share.set(0);
            self.is_closed.set(true);
            self.has_overflowed.set(true);
        }
    }

    /// Closes the queue. Queued texts can still be taken.
    pub(super) fn close(&self) {
        self.is_closed.set(true);
    }

    /// True if no more texts can be added.
    pub(super) fn is_closed(&self) -> bool {
        self.is_closed.get()
    }

    /// True if [`take`](Self::take) returns something other than [`Taken::Nothing`].
    pub(super) fn is_ready(&self) -> bool {
        self.is_closed.get() || !self.texts.borrow().is_empty()
    }

    /// True if the queue was emptied because it became too long.
    pub(super) fn has_overflowed(&self) -> bool {
        self.has_overflowed.get()
    }

    /// Takes up to `most` texts.
    pub(super) fn take(&self, max: usize) -> Taken {
        let mut texts = self.texts.borrow_mut();
        let count = texts.len().min(max);
        if count == 0 {
            return if self.is_closed.get() { Taken::End } else { Taken::Nothing };
        }
        let taken: Vec<String> = texts.drain(..count).collect();
        let freed: usize = taken.iter().map(|text| text.len() + TEXT_OVERHEAD).sum();
        self.bytes.set(self.bytes.get() - freed);
        let _ = self.share.set(self.bytes.get());
        Taken::Texts(taken)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn returns_queued_texts_after_closing() {
        let queue = TextQueue::new(&Budget::new(1000));
        assert_eq!(queue.take(1), Taken::Nothing);
        for text in ["a", "b", "c"] {
            queue.push(text.to_owned());
        }
        queue.close();
        queue.push("d".to_owned());
        assert_eq!(queue.take(2), Taken::Texts(vec!["a".to_owned(), "b".to_owned()]));
        assert_eq!(queue.take(2), Taken::Texts(vec!["c".to_owned()]));
        assert_eq!(queue.take(2), Taken::End);
    }

    #[test]
    fn closes_a_queue_that_nobody_empties() {
        let budget = Budget::new(1000);
        let (abandoned, used) = (TextQueue::new(&budget), TextQueue::new(&budget));
        for _ in 0..20 {
            abandoned.push("x".repeat(100));
            used.push("x".repeat(100));
            used.take(1);
        }
        assert_eq!((abandoned.take(1), used.take(1)), (Taken::End, Taken::Nothing));
    }
}
