//! The terms of all other crates: rules, records, locations in a capture, findings and verdicts. The crate also has their
//! common tools: JSON, text for people, the time, and network streams.
//!
//! ```
//! use uavspec_model::{Level, Location};
//!
//! assert_eq!(Location::Line(3).to_string(), "line 3");
//! assert!(Level::Must > Level::Should);
//! ```

#![cfg_attr(not(test), warn(clippy::disallowed_macros, clippy::disallowed_methods))]

pub mod clock;
pub mod json;
pub mod limits;
pub mod net;
pub mod text;

mod application;
mod detail;
mod endpoint;
mod excuse;
mod finding;
mod reason;
mod recent;
mod record;
mod rule;
mod subject;

pub use self::application::ApplicationType;
pub use self::detail::{Detail, hexadecimal};
pub use self::endpoint::{Durability, Endpoint, EndpointKind, History, Liveliness, Qos, Reliability};
pub use self::excuse::{Excuse, ExcuseKind};
pub use self::finding::{Findings, Group, MAX_EXAMPLES, Verdict};
pub use self::reason::Reason;
pub use self::recent::Recent;
pub use self::record::{Channel, Extent, Location, Message};
pub use self::rule::{DISPUTED, Level, Rule, Status};
pub use self::subject::SubjectName;
