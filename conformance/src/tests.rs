//! Tests of internals; the tests of the program are in `tests/`.

mod application;
mod body_schemas;
mod browser;
mod changing;
mod check;
mod convert;
mod corruption;
mod ext;
mod flockwave;
mod growth;
mod hostile;
mod json;
mod live_matrix;
mod mcap;
#[cfg(feature = "tables")]
mod messages;
pub(crate) mod mutants;
mod outcomes;
mod releases;
mod report;
mod reports;
#[cfg(feature = "db3")]
mod rosbag;
mod rule_list;
#[allow(dead_code, reason = "the tests of the program use the rest")]
#[path = "../tests/support/mod.rs"]
pub(crate) mod support;
#[cfg(feature = "tables")]
mod tables;
mod texts;
mod topics;
mod trials;
mod ulog;
mod unread;
mod untrusted;
mod vehicle_matrix;
