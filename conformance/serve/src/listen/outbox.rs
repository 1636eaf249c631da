//! Queues of data for clients.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::io::{ErrorKind, Write as _};
use std::net::Shutdown;
use std::rc::Rc;
use std::time::Instant;

use mio::net::TcpStream;
use tungstenite::protocol::frame::Frame;
use tungstenite::protocol::frame::coding::{Data, OpCode};
use uavspec_model::clock::Clock;

use super::limits::{Budget, DISCONNECTED, QUEUE_LIMIT, Reason, Share, TOO_SLOW};
use crate::hub::Sink;

/// The memory for managing a piece of data.
const OVERHEAD: usize = 32;

/// The data that waits to be sent over a stream, or until it is taken.
pub(super) struct Outbox {
    stream: Option<Rc<TcpStream>>,
    clock: Clock,
    pieces: RefCell<VecDeque<Vec<u8>>>,
    /// The number of bytes of the first piece that have already been sent.
    sent: Cell<usize>,
    share: Share,
    state: Cell<State>,
    /// The time of the last progress while data is waiting to be sent over the stream.
    waiting_since: Cell<Option<Instant>>,
}

/// The state of an outbox.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum State {
    Open,
    /// No more data can be added.
    Closing,
    /// All data has been sent, and the stream is closed in this direction.
    Sent,
    /// Nothing more can be sent.
    Failed(Reason),
}

impl Outbox {
    pub(super) fn new(stream: Option<Rc<TcpStream>>, budget: &Rc<Budget>, clock: Clock) -> Self {
        Self {
            stream,
            clock,
            pieces: RefCell::default(),
            sent: Cell::new(0),
            share: Share::new(budget),
            state: Cell::new(State::Open),
            waiting_since: Cell::new(None),
        }
    }

    /// Adds data, and sends as much as possible. An outbox whose client reads too slowly is emptied and closed.
    pub(super) fn push(&self, bytes: impl Into<Vec<u8>>) {
        if self.is_closed() {
            return;
        }
        let bytes = bytes.into();
        if self.waiting() == 0 {
            self.waiting_since.set(Some(self.clock.now()));
        }
        self.share.set(self.waiting() + bytes.len() + OVERHEAD);
        self.pieces.borrow_mut().push_back(bytes);
        self.flush();
        if self.share.is_exceeded() || self.waiting() > QUEUE_LIMIT {
            self.fail(TOO_SLOW);
        }
    }

    /// Sends a WebSocket frame.
    pub(super) fn push_frame(&self, frame: Frame) {
        let mut bytes = Vec::with_capacity(frame.len());
        // Writing to memory can't fail.
        if frame.format(&mut bytes).is_ok() {
            self.push(bytes);
        }
    }

    /// Sends a text as a WebSocket message.
    pub(super) fn push_text(&self, text: impl Into<Vec<u8>>) {
        self.push_frame(Frame::message(text.into(), OpCode::Data(Data::Text), true));
    }

    /// Sends waiting data, as much as possible. Returns the new state.
    pub(super) fn flush(&self) -> State {
        let Some(stream) = &self.stream else { return self.state.get() };
        let mut pieces = self.pieces.borrow_mut();
        while let Some(piece) = pieces.front() {
            match (&**stream).write(&piece[self.sent.get()..]) {
                Ok(sent) => {
                    let mut freed = sent;
                    self.sent.set(self.sent.get() + sent);
                    if self.sent.get() == piece.len() {
                        pieces.pop_front();
                        self.sent.set(0);
                        freed += OVERHEAD;
                    }
                    self.share.set(self.waiting() - freed);
                    self.waiting_since.set((!pieces.is_empty()).then(|| self.clock.now()));
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                // A new connection might not be ready yet.
                Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::NotConnected) => {
                    return self.state.get();
                }
                Err(_) => {
                    drop(pieces);
                    self.fail(DISCONNECTED);
                    return self.state.get();
                }
            }
        }
        if self.state.get() == State::Closing {
            self.state.set(State::Sent);
            // The client may have disconnected already.
            let _ = stream.shutdown(Shutdown::Write);
        }
        self.state.get()
    }

    /// Takes the oldest piece of data.
    pub(super) fn take(&self) -> Option<Vec<u8>> {
        let piece = self.pieces.borrow_mut().pop_front()?;
        self.share.set(self.waiting() - piece.len() - OVERHEAD);
        Some(piece)
    }

    /// The memory of waiting data, in bytes.
    pub(super) fn waiting(&self) -> usize {
        self.share.used()
    }

    /// True if no more data can be added.
    pub(super) fn is_closed(&self) -> bool {
        self.state.get() != State::Open
    }

    /// True if the waiting data was dropped.
    pub(super) fn has_failed(&self) -> bool {
        matches!(self.state.get(), State::Failed(_))
    }

    /// The time of the last progress while data is waiting to be sent.
    pub(super) fn waiting_since(&self) -> Option<Instant> {
        self.waiting_since.get()
    }

    fn fail(&self, reason: Reason) {
        self.state.set(State::Failed(reason));
        self.pieces.replace(VecDeque::new());
        self.sent.set(0);
        self.share.set(0);
        self.waiting_since.set(None);
    }
}

impl Sink for Outbox {
    fn send(&self, text: &str) {
        self.push(text);
    }

    fn close(&self) {
        if !self.is_closed() {
            self.state.set(State::Closing);
            self.flush();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn returns_queued_texts_after_closing() {
        let queue = Outbox::new(None, &Budget::new(1000), Clock::simulated());
        assert_eq!(queue.take(), None);
        for text in ["a", "b"] {
            queue.push(text);
        }
        queue.close();
        queue.push("c");
        assert_eq!([queue.take(), queue.take(), queue.take()], [Some(b"a".into()), Some(b"b".into()), None]);
        assert_eq!(queue.waiting(), 0);
    }

    #[test]
    fn closes_a_queue_that_nobody_empties() {
        let budget = Budget::new(1000);
        let [abandoned, used] = [0; 2].map(|_| Outbox::new(None, &budget, Clock::simulated()));
        for _ in 0..20 {
            abandoned.push("x".repeat(100));
            used.push("x".repeat(100));
            used.take();
        }
        assert!(abandoned.has_failed() && !used.is_closed());
    }
}
