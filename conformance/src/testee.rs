//! Codecs and validators in any language, asked over pipes or a connection.
//!
//! ```text
//!  definitions ──vectors──▶ cases ──run──▶ link ──answers──▶ compare ──▶ verdicts ──▶ report
//!                              └────────dump──▶ file ──▶ … ──▶ file ──replay──┘
//! ```
//!
//! [`protocol`] says what goes over the pipes, [`wire`] how values look there.

pub mod case;
pub mod compare;
pub mod file;
pub mod known;
mod link;
pub mod lint;
pub mod options;
pub mod outcome;
mod process;
pub mod protocol;
pub mod run;
pub mod target;
pub mod wire;
