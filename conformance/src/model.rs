//! The words that all rooms share: rules, the records that they look at, and what they find.

mod date;
mod detail;
mod excuse;
mod finding;
mod reason;
mod record;
mod rule;

pub use self::date::Date;
pub use self::detail::Detail;
pub(crate) use self::detail::hexadecimal;
pub use self::excuse::{Excuse, ExcuseKind};
pub use self::finding::{Findings, Group, Verdict};
pub use self::reason::Reason;
pub(crate) use self::record::{Channel, Message};
pub use self::record::{Extent, Place};
pub use self::rule::{Level, Rule, Status};
