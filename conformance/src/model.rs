//! The shared types: rules, records and findings.
//!
//! ```
//! use uavspec_conformance::check::check_capture;
//! use uavspec_conformance::definitions::Definitions;
//! use uavspec_conformance::model::{Extent, Level, Verdict};
//! use uavspec_conformance::rules::rule;
//!
//! let definitions = Definitions::built_in();
//! let definition = definitions.message_of_type("px4/ArmingCheckRequest");
//! let record = r#"{"timestamp": 7, "request_id": 300, "valid_registrations_mask": 1}"#;
//! let result = check_capture(record.as_bytes(), definition, &definitions)?;
//! assert_eq!(result.extent, Extent::Whole);
//! let rule = rule("PX-JSON-02").unwrap();
//! assert_eq!(rule.level, Level::Must);
//! assert_eq!(result.findings.verdict(rule), Verdict::Fail);
//! # Ok::<(), std::io::Error>(())
//! ```

mod application;
mod date;
mod detail;
mod endpoint;
mod excuse;
mod finding;
mod reason;
mod record;
mod rule;
mod subject;

pub(crate) use self::application::ApplicationType;
pub use self::date::Date;
pub use self::detail::Detail;
pub(crate) use self::detail::hexadecimal;
#[cfg(any(feature = "dds", feature = "zenoh"))]
pub(crate) use self::endpoint::History;
pub(crate) use self::endpoint::{Durability, Endpoint, EndpointKind, Liveliness, Qos, Reliability};
pub use self::excuse::{Excuse, ExcuseKind};
pub(crate) use self::finding::{Counted, MAX_EXAMPLES};
pub use self::finding::{Findings, Group, Verdict};
pub use self::reason::Reason;
pub(crate) use self::record::{Channel, Message};
pub use self::record::{Extent, Location};
pub(crate) use self::rule::DISPUTED;
pub use self::rule::{Level, Rule, Status};
pub(crate) use self::subject::SubjectName;
