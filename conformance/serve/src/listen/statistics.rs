//! Counts of served, refused and disconnected clients.

use std::fmt;

/// The reason why the server disconnected a client.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reason {
    /// The client closed the connection, or the connection failed.
    Disconnected,
    /// The client reads too slowly.
    TooSlow,
    /// The client didn't finish a message in time.
    Unfinished,
    /// Too much memory is used by unfinished messages, and this client uses more than its share.
    TooMuch,
    /// A newcomer has replaced the client.
    Replaced,
    /// No requests arrived over HTTP for a minute.
    Idle,
}

impl Reason {
    /// All reasons.
    const ALL: [Self; 6] =
        [Self::Disconnected, Self::TooSlow, Self::Unfinished, Self::TooMuch, Self::Replaced, Self::Idle];

    /// The text of the reason, as sent to the client.
    pub fn text(self) -> &'static str {
        match self {
            Self::Disconnected => "the client disconnected",
            Self::TooSlow => "the client reads too slowly",
            Self::Unfinished => "a message wasn't finished in time",
            Self::TooMuch => "unfinished messages use too much memory",
            Self::Replaced => "the server is full, and this client was idle",
            Self::Idle => "no request arrived for a minute",
        }
    }
}

/// Counts of served, refused and disconnected clients.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// The number of accepted connections.
    pub accepted: u64,
    /// The number of refused connections and Socket.IO sessions.
    pub refused: u64,
    /// The number of errors while accepting connections, such as a lack of file descriptors.
    pub failed: u64,
    /// The number of open connections.
    pub open: usize,
    disconnected: [u64; Reason::ALL.len()],
}

impl Statistics {
    /// The number of clients that were disconnected for a reason.
    pub fn disconnected(&self, reason: Reason) -> u64 {
        self.disconnected[reason as usize]
    }

    /// Counts a disconnected client.
    pub(super) fn count(&mut self, reason: Reason) {
        self.disconnected[reason as usize] += 1;
    }
}

/// The counts that show overload. Empty if no client was refused or disconnected by the server.
impl fmt::Display for Statistics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let disconnected = Reason::ALL.into_iter().filter(|reason| *reason != Reason::Disconnected);
        let disconnected = disconnected.map(|reason| (self.disconnected(reason), reason.text()));
        let others = [
            (self.refused, "refused: the server was full"),
            (self.failed, "not accepted: the system reported an error"),
        ];
        let mut separator = "";
        for (count, text) in others.into_iter().chain(disconnected).filter(|(count, _)| *count > 0) {
            write!(f, "{separator}{count} × {text}")?;
            separator = "\n";
        }
        Ok(())
    }
}
