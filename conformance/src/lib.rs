//! Judges outputs of implementations by the definitions that `uavspec-codegen` reads: logs of PX4 (`ULog`), MCAP,
//! messages as JSON, recorded conversations of Flockwave, codecs ([`testee`]) and live servers ([`probe`]). For these there
//! is a reference ([`serve`]), and `uavspec watch` shows their fleets.
//!
//! ```text
//!  bytes ──capture──▶ records ──check (with the rules)──▶ findings ──▶ verdicts ──report──▶ terminal, JSON, HTML, SARIF, JUnit
//! ```
//!
//! Captures lend their records one by one, so memory doesn't grow with the length of the input. Values are
//! checked by a plan that is made once for each format; what happens over time is checked by rules that keep a
//! small state for each channel.
//!
//! Each of these rooms uses only those below it.

#[cfg(test)]
extern crate self as uavspec_conformance;

pub mod app;
pub mod capture;
pub mod check;
pub mod definitions;
mod flockwave;
pub mod json;
mod matrix;
pub mod model;
mod net;
pub mod probe;
mod px4;
pub mod report;
pub mod rules;
pub mod serve;
pub mod testee;
#[cfg(test)]
mod tests;
mod text;
mod watch;

pub use flockwave::{body_schema, transport};
