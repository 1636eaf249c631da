//! Judges outputs of implementations by the definitions that `uavspec-codegen` reads: logs of PX4 (`ULog`), MCAP,
//! messages as JSON, recorded conversations of Flockwave, codecs ([`testee`]) and live servers ([`probe`]). For these there
//! are both ends of the connections ([`live`]) and a reference ([`server`]), and their fleets can be watched ([`watch`]).
//!
//! ```text
//!  bytes ──source──▶ records ──plan, rule──▶ findings ──▶ verdicts ──report──▶ terminal, JSON, HTML, SARIF, JUnit
//! ```
//!
//! Sources lend their records one by one, so memory doesn't grow with the length of the input. Values are
//! judged by a plan that is made once for each format; what happens over time is judged by rules that keep a
//! small state for each channel.

pub mod base64;
pub mod catalogue;
pub mod cli;
pub mod comparison;
pub mod conversation;
pub mod definitions;
pub mod detail;
pub mod finding;
pub mod input;
pub mod json;
pub mod judge;
pub mod known;
pub mod live;
pub mod matrix;
pub mod parallel;
pub mod plan;
pub mod probe;
pub mod record;
pub mod report;
pub mod rule;
pub mod sample;
pub mod server;
pub mod shape;
pub mod source;
pub mod testee;
pub mod watch;
