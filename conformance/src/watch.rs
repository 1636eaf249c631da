//! The fleet of a live Flockwave server, as people watch it in a terminal.
//!
//! ```text
//!  client ──bytes──▶ message ──▶ asker            what is to be asked next
//!     ▲                 │          │
//!     └────requests─────│──────────┘  session: a thread
//!                       ▼
//!                     fleet ──▶ view, list        what is known, and how it is shown
//! ```
//!
//! Nothing here trusts a server: of each message no more is kept than a fleet may need ([`message`]), of fleets no
//! more than [`UAV_LIMIT`], and no text of a server reaches the terminal as it came.

pub mod codes;
pub mod fleet;
pub mod list;
pub mod message;
pub mod screen;
pub mod session;
pub mod state;
pub mod view;

mod asker;
mod format;
mod order;
mod rate;
mod roster;
mod words;

pub use self::order::Order;
pub use self::roster::{ID_LIMIT, UAV_LIMIT};
