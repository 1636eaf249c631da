//! The fleet of a live Flockwave server, as people watch it in a terminal.
//!
//! ```text
//!  client ──bytes──▶ message ──▶ poller           what is to be asked next
//!     ▲                 │          │
//!     └────requests─────│──────────┘  session: a thread
//!                       ▼
//!                     fleet ──▶ view, list        what is known, and how it is shown
//! ```
//!
//! Nothing here trusts a server: of each message no more is kept than a fleet may need ([`message`]), of fleets no
//! more than [`UAV_LIMIT`](roster::UAV_LIMIT), and no text of a server reaches the terminal as it came.

pub(crate) mod codes;
pub(crate) mod fleet;
pub(crate) mod list;
pub(crate) mod message;
pub(crate) mod screen;
pub(crate) mod session;
pub(crate) mod state;
#[cfg(test)]
mod tests;
pub(crate) mod view;

mod format;
mod order;
mod poller;
mod rate;
mod roster;
mod words;
