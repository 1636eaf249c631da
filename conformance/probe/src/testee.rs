//! Tests codecs and validators written in any language, over pipes or a TCP connection.
//!
//! ```text
//!  definitions ──vectors──▶ cases ──run──▶ link ──responses──▶ compare ──▶ verdicts ──▶ report
//!                              └────────dump──▶ file ──▶ … ──▶ file ──replay──┘
//! ```
//!
//! `protocol.rs` defines the lines of the protocol, and `wire.rs` defines the encoding of values in these lines.
//!
//! ```
//! use uavspec_rules::definitions::Definitions;
//! use uavspec_probe::testee::{Op, Options, Target, cases, run};
//!
//! let definitions = Definitions::built_in();
//! let types = definitions.types();
//! let cases = cases(&definitions, types);
//! let hashes: Vec<usize> = (0..cases.len()).filter(|id| cases[*id].op == Op::Hash).collect();
//! assert!(!hashes.is_empty());
//!
//! // A testee that can't be started is an error, not a verdict.
//! let options = Options::new(Target::Command(vec!["./no-such-codec".into()]));
//! assert!(run(&cases, &hashes, types, &options, &|_, _| {}).is_err());
//! ```

pub mod case;
pub mod compare;
pub mod file;
pub mod known;
mod link;
pub mod lint;
#[cfg(test)]
mod memory;
pub mod options;
pub mod outcome;
mod process;
pub(crate) mod protocol;
pub mod run;
pub mod target;
#[cfg(test)]
mod tests;
mod timeouts;
pub(crate) mod wire;

pub use self::case::{Case, Expected, ExpectedResponse, Input, cases};
pub use self::compare::Difference;
pub use self::lint::{CHECKS, Check, CheckOutcome, LintResult, check, lint};
pub use self::options::Options;
pub use self::outcome::{Counts, Outcome, ProtocolRemarks, Verdict};
pub use self::protocol::{Format, Hello, Op, PROTOCOL};
pub use self::run::run;
pub use self::target::Target;
pub use self::wire::{from_base64, from_wire, to_base64, to_wire};
