//! A queue of messages to a client.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Instant;

/// The maximum number of queued bytes. A client that reads too slowly is disconnected, so it can't exhaust the memory.
const MAX_BYTES: usize = 64 << 20;

/// A queue between the server and a connection.
#[derive(Debug, Default)]
pub(super) struct Outbox {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    texts: VecDeque<String>,
    bytes: usize,
    is_closed: bool,
}

/// The result of [`Outbox::take`].
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Taken {
    /// At least one message.
    Texts(Vec<String>),
    /// No message arrived before the time limit.
    Nothing,
    /// Nothing: the queue is closed and empty.
    End,
}

impl Outbox {
    /// Adds a message, unless the queue is closed.
    pub(super) fn push(&self, text: String) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if state.is_closed {
            return;
        }
        state.bytes += text.len();
        state.texts.push_back(text);
        if state.bytes > MAX_BYTES {
            *state = State { is_closed: true, ..State::default() };
        }
        self.changed.notify_all();
    }

    /// Closes the queue. Queued messages can still be taken.
    pub(super) fn close(&self) {
        self.state.lock().unwrap_or_else(PoisonError::into_inner).is_closed = true;
        self.changed.notify_all();
    }

    /// Waits for messages, and takes up to `most` of them.
    pub(super) fn take(&self, most: usize, until: Instant) -> Taken {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let left = until.saturating_duration_since(Instant::now());
        let is_idle = |state: &mut State| state.texts.is_empty() && !state.is_closed;
        let waited = self.changed.wait_timeout_while(state, left, is_idle);
        let (mut state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        let count = state.texts.len().min(most);
        if count == 0 {
            return if state.is_closed { Taken::End } else { Taken::Nothing };
        }
        let texts: Vec<String> = state.texts.drain(..count).collect();
        state.bytes -= texts.iter().map(String::len).sum::<usize>();
        Taken::Texts(texts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn returns_queued_texts_after_closing() {
        let outbox = Outbox::default();
        assert_eq!(outbox.take(1, Instant::now()), Taken::Nothing);
        for text in ["a", "b", "c"] {
            outbox.push(text.to_owned());
        }
        outbox.close();
        outbox.push("d".to_owned());
        assert_eq!(outbox.take(2, Instant::now()), Taken::Texts(vec!["a".to_owned(), "b".to_owned()]));
        assert_eq!(outbox.take(2, Instant::now()), Taken::Texts(vec!["c".to_owned()]));
        assert_eq!(outbox.take(2, Instant::now()), Taken::End);
    }

    #[test]
    fn disconnects_a_client_that_does_not_read() {
        let outbox = Outbox::default();
        for _ in 0..70 {
            outbox.push("x".repeat(1 << 20));
        }
        assert_eq!(outbox.take(1, Instant::now()), Taken::End);
    }
}
