//! Checks drone software against its interface specifications.
//!
//! The crate checks PX4 logs (`ULog`), MCAP, JSON messages, recorded Flockwave sessions, codecs ([`testee`]) and live
//! servers ([`probe`]). [`serve`] is a reference server, and `uavspec watch` shows a server's fleet. `uavspec-codegen`
//! reads the definitions.
//!
//! ```text
//!  bytes ──capture──▶ records ──check──▶ findings ──▶ verdicts ──report──▶ text, JSON, HTML, SARIF, …
//! ```
//!
//! Captures are read record by record, so memory use doesn't depend on the size of the input. For each format, the plan
//! that checks message values is compiled only once. Rules that span several messages keep a small amount of state per
//! channel.

#![cfg_attr(not(test), warn(clippy::disallowed_macros, clippy::disallowed_methods))]

#[cfg(test)]
extern crate self as uavspec_conformance;

pub mod app;
mod bus;
pub mod capture;
pub mod check;
pub mod clock;
mod convert;
pub mod definitions;
mod explain;
mod flockwave;
#[cfg(any(fuzzing, test))]
#[doc(hidden)]
pub mod fuzzing;
pub mod json;
pub mod model;
mod net;
pub mod probe;
mod px4;
pub mod report;
pub mod rules;
mod self_test;
pub mod serve;
mod story;
pub mod tables;
pub mod testee;
#[cfg(test)]
mod tests;
mod text;
mod vehicle;
mod watch;

pub use flockwave::{body_schema, transport};
