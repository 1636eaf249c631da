//! The results of checks as tables, for SQL and dataframes.
//!
//! ```text
//!  Subject ──row──▶ captures, topics, findings, rules ──batch──▶ Parquet or Arrow files
//! ```
//!
//! Other programs check captures with a [`Checker`], and receive the tables in memory.
//!
//! The declaration of a column is the only place that states its name, type, unit and meaning, and computes its value.
//! The schema in the files, the batches and the documentation are derived from it.

#![cfg(feature = "arrow")]

mod captures;
mod checker;
mod column;
mod dataset;
mod done;
mod events;
mod failures;
mod find;
mod findings;
mod messages;
mod rows;
mod rules;
#[cfg(test)]
mod tests;
mod timeline;
mod topics;

pub use self::checker::{Capture, Checked, Checker, Options, Problem, Tables, Timeline};
pub use self::dataset::Dataset;
pub use self::done::Done;
pub use self::find::find;
pub use self::messages::Messages;
