//! The limits of the server, and the memory that all clients share.

use std::cell::Cell;
use std::rc::Rc;
use std::time::Duration;

use uavspec_model::net::open_files;

/// The maximum length of a received message, in bytes. A list of 10,000 ids is much shorter.
pub(super) const REQUEST_LIMIT: usize = 1 << 20;

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

/// The time since its last request after which a connection is idle. If the server is full, newcomers replace idle
/// clients.
pub(super) const IDLE_TIME: Duration = Duration::from_secs(10);

/// The maximum time between HTTP requests.
pub(super) const HTTP_IDLE_LIMIT: Duration = Duration::from_secs(60);

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

/// Memory that several clients share.
#[derive(Debug)]
pub(super) struct Budget {
    limit: usize,
    used: Cell<usize>,
    users: Cell<usize>,
}

impl Budget {
    /// Creates a budget of this many bytes.
    pub(super) fn new(limit: usize) -> Rc<Self> {
        Rc::new(Self { limit, used: Cell::new(0), users: Cell::new(0) })
    }
}

/// The memory of one client within a [`Budget`].
#[derive(Debug)]
pub(super) struct Share {
    budget: Rc<Budget>,
    used: Cell<usize>,
}

/// The error for memory that exceeds a budget.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Exceeded;

impl Share {
    /// Creates an empty share.
    pub(super) fn new(budget: &Rc<Budget>) -> Self {
        budget.users.set(budget.users.get() + 1);
        Self { budget: Rc::clone(budget), used: Cell::new(0) }
    }

    /// Sets the memory of this client. Fails if the budget is exceeded, and this client uses more than an equal part of
    /// it. Clients that use less never fail, so all clients together use at most twice the budget.
    pub(super) fn set(&self, bytes: usize) -> Result<(), Exceeded> {
        let Budget { limit, used, users } = &*self.budget;
        let is_growing = bytes > self.used.get();
        used.set(used.get() - self.used.replace(bytes) + bytes);
        let is_exceeded = used.get() > *limit && bytes > limit / users.get().max(1);
        if is_growing && is_exceeded { Err(Exceeded) } else { Ok(()) }
    }
}

impl Drop for Share {
    fn drop(&mut self) {
        let Budget { used, users, .. } = &*self.budget;
        used.set(used.get() - self.used.get());
        users.set(users.get() - 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_largest_shares_exceed_a_budget() {
        let budget = Budget::new(100);
        let [large, small, third] = [0; 3].map(|_| Share::new(&budget));
        assert_eq!((large.set(90), small.set(10)), (Ok(()), Ok(())));
        assert_eq!(third.set(30), Ok(()), "less than a third of the budget");
        assert_eq!(large.set(91), Err(Exceeded));
        assert_eq!(large.set(80), Ok(()), "the share shrinks");
        drop(large);
        assert_eq!(small.set(60), Ok(()), "the memory of the dropped share is free again");
        assert_eq!(budget.used.get(), 90);
    }
}
