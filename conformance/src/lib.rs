//! Checks drone software against its interface specifications.
//!
//! The command line of `uavspec`: it checks PX4 logs (`ULog`), MCAP, JSON messages, recorded Flockwave sessions, codecs and
//! live servers, and prints reports. The crates below this one do the work, and other programs can call them.
//!
//! ```text
//!  bytes ──capture──▶ records ──check──▶ findings ──▶ verdicts ──report──▶ text, JSON, HTML, SARIF, …
//! ```
//!
//! Captures are read record by record, so memory use doesn't depend on the size of the input. For each format, the plan
//! for checking message values is compiled only once. Rules that span several messages keep a small amount of state for
//! each channel.

#![cfg_attr(not(test), warn(clippy::disallowed_macros, clippy::disallowed_methods))]

pub mod app;
