//! Terminal displays of the fleet of a live Flockwave server, and of the [state of a PX4 vehicle](vehicle).
//!
//! ```text
//!  client ──bytes──▶ message ──▶ poller           chooses the next request
//!     ▲                 │          │
//!     └────requests─────│──────────┘  session: a thread
//!                       ▼
//!                     fleet ──▶ view, list        known states, and their display
//! ```
//!
//! Servers aren't trusted. A [`message`] contains only the data that the display needs, and a fleet has at most
//! `MAX_UAVS` UAVs. All text from a server is escaped before it is shown.

pub mod codes;
pub mod fleet;
pub mod list;
pub mod message;
pub mod screen;
pub mod session;
pub(crate) mod state;
#[cfg(test)]
mod tests;
pub mod vehicle;
pub mod view;

mod format;
mod order;
mod poller;
mod rate;
mod roster;
mod words;
