//! What waits to be sent to a client.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Instant;

/// How many bytes may wait. A client that doesn't read so much is cut off: nobody else shall suffer for it.
const MAX_BYTES: usize = 64 << 20;

/// A queue between the server and a connection.
#[derive(Debug, Default)]
pub(super) struct Outbox {
    state: Mutex<State>,
    has_news: Condvar,
}

#[derive(Debug, Default)]
struct State {
    texts: VecDeque<String>,
    bytes: usize,
    is_closed: bool,
}

/// What was taken out.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Taken {
    /// At least one text.
    Texts(Vec<String>),
    /// Nothing, up to the given time.
    Nothing,
    /// Nothing, and nothing will follow.
    End,
}

impl Outbox {
    /// Adds a text, unless the box is closed.
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
        self.has_news.notify_all();
    }

    /// Lets nothing more in. What waits is still taken.
    pub(super) fn close(&self) {
        self.state.lock().unwrap_or_else(PoisonError::into_inner).is_closed = true;
        self.has_news.notify_all();
    }

    /// Waits for texts, and takes up to `most`.
    pub(super) fn take(&self, most: usize, until: Instant) -> Taken {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let left = until.saturating_duration_since(Instant::now());
        let is_idle = |state: &mut State| state.texts.is_empty() && !state.is_closed;
        let waited = self.has_news.wait_timeout_while(state, left, is_idle);
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
    fn what_waits_is_taken_after_the_box_is_closed() {
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
