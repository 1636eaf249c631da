//! The limits of the server, the reasons to disconnect clients, and the memory that all clients share.

use std::cell::Cell;
use std::rc::Rc;
use std::time::Duration;

use uavspec_model::net::open_files;

/// The maximum length of a received message, in bytes. A list of 10,000 ids is much shorter.
pub(crate) const REQUEST_LIMIT: usize = 1 << 20;

/// The maximum number of bytes that wait to be sent to one client.
pub(super) const QUEUE_LIMIT: usize = 4 << 20;

/// The maximum number of bytes that wait to be sent to all clients, unless each client uses less than its share.
pub(super) const TOTAL_QUEUED: usize = 32 << 20;

/// The maximum number of bytes of incomplete messages from all clients, unless each client uses less than its share.
pub(super) const TOTAL_RECEIVED: usize = 16 << 20;

/// The number of bytes that wait to be sent to a client, above which the server reads no further requests from it.
pub(super) const PAUSE_LIMIT: usize = 64 << 10;

/// The maximum number of connections, of Socket.IO sessions, and of clients over UDP. The maximum number of connections is
/// lower if the process may open fewer files.
pub(super) const CLIENT_LIMIT: usize = 256;

/// The maximum number of bytes of notifications over UDP for each received datagram. The address of a datagram may be
/// forged, so the server must not send large amounts of data to it.
pub(super) const DATAGRAM_BUDGET: usize = 4 << 20;

/// The maximum number of steps of one socket before others have their turn.
pub(super) const STEPS_AT_ONCE: usize = 16;

/// The time without a request after which a client counts as idle. If the server is full, newcomers replace idle
/// clients.
pub(super) const IDLE_TIME: Duration = Duration::from_secs(10);

/// The maximum time from the first to the last byte of a message.
pub(super) const MESSAGE_TIME: Duration = Duration::from_secs(30);

/// The maximum time without progress while messages wait to be sent, after which the client is disconnected.
pub(super) const SEND_LIMIT: Duration = Duration::from_secs(10);

/// The number of files that the process needs in addition to connections.
const OTHER_FILES: u64 = 32;

/// The maximum number of connections of this process.
pub(super) fn connections() -> usize {
    let files = open_files().map(|files| files.saturating_sub(OTHER_FILES).max(1));
    let files = files.and_then(|files| usize::try_from(files).ok());
    files.map_or(CLIENT_LIMIT, |files| files.min(CLIENT_LIMIT))
}

/// The reason why the server disconnects a client, as sent to it. `None` if the client disconnected, or if the connection
/// failed.
pub(super) type Reason = Option<&'static str>;

/// The client closed the connection, or the connection failed.
pub(super) const DISCONNECTED: Reason = None;

/// Too many messages wait to be sent, or they wait for too long.
pub(super) const TOO_SLOW: Reason = Some("the client reads too slowly");

/// A message was still incomplete after [`MESSAGE_TIME`].
pub(super) const UNFINISHED: Reason = Some("a message wasn't finished in time");

/// The incomplete messages of this client use more than its share of [`TOTAL_RECEIVED`].
pub(super) const TOO_MUCH: Reason = Some("unfinished messages use too much memory");

/// The server can't serve another client.
pub(super) const REFUSED: Reason = Some("refused: the server was full");

/// The system can't create another socket.
pub(super) const NOT_ACCEPTED: Reason = Some("not accepted: the system reported an error");

/// A newcomer replaces the client.
pub(super) const REPLACED: Reason = Some("the server is full, and this client was idle");

/// Memory that several clients share.
pub(super) struct Budget {
    limit: usize,
    used: Cell<usize>,
}

impl Budget {
    /// Creates a budget of this many bytes.
    pub(super) fn new(limit: usize) -> Rc<Self> {
        Rc::new(Self { limit, used: Cell::new(0) })
    }
}

/// The memory of one client within a [`Budget`].
pub(super) struct Share {
    budget: Rc<Budget>,
    used: Cell<usize>,
}

impl Share {
    /// Creates an empty share.
    pub(super) fn new(budget: &Rc<Budget>) -> Self {
        Self { budget: Rc::clone(budget), used: Cell::new(0) }
    }

    /// The memory of this client, in bytes.
    pub(super) fn used(&self) -> usize {
        self.used.get()
    }

    /// Sets the memory of this client.
    pub(super) fn set(&self, bytes: usize) {
        let others = self.budget.used.get() - self.used.replace(bytes);
        self.budget.used.set(others + bytes);
    }

    /// True if the budget is exceeded, and this client uses more than an equal part of it. If no client does so, all
    /// clients together use at most twice the budget.
    pub(super) fn is_exceeded(&self) -> bool {
        let Budget { limit, used } = &*self.budget;
        used.get() > *limit && self.used() > limit / Rc::strong_count(&self.budget)
    }
}

impl Drop for Share {
    fn drop(&mut self) {
        self.set(0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_largest_shares_exceed_a_budget() {
        let budget = Budget::new(100);
        let [large, small, third] = [90, 10, 0].map(|bytes| {
            let share = Share::new(&budget);
            share.set(bytes);
            share
        });
        assert!(!large.is_exceeded());
        third.set(25);
        assert!(!third.is_exceeded(), "an equal part of the budget");
        assert!(large.is_exceeded());
        drop(large);
        small.set(60);
        assert!(!small.is_exceeded(), "the memory of the dropped share is free again");
        assert_eq!(budget.used.get(), 85);
    }
}
