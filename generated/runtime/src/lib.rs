//! The runtime of code that uavspec-codegen generates: message traits with codecs and checks, and field types that Rust
//! lacks. The generator itself also uses the scalar, layout and severity types.
//!
//! The crate is `no_std`, has no unsafe code, and doesn't allocate for fixed-size messages.
//!
//! | feature | adds |
//! |---|---|
//! | `std` (default) | `std::error::Error` for the error types; enables `alloc` |
//! | `alloc` | strings, sequences, and functions that return a `Vec` |
//! | `defmt` | messages in logs of embedded devices: module `log` |
//! | `proptest` | strategies for property tests: module `strategy` |
//! | `schemars` | JSON Schemas, with the crate schemars: module `schema` |
//! | `json` | types of JSON messages, which specification pages define: module `json_type`; enables `serde` and `std` |
//! | `serde` | JSON and other serde formats: module `json` |
//! | `views` | access to single fields of a uORB payload without decoding the others: module `view` |
//!
//! # Performance
//!
//! These are medians on a machine with two cores. `cargo xtask bench codec` compares each codec with an alternative on
//! the same bytes:
//!
//! | | this crate | alternative |
//! |---|---|---|
//! | `FailsafeFlags`, 88 bytes of uORB | decode 5.6 ns, encode 3.3 ns | copying 88 bytes 3.1 ns |
//! | `BatteryStatus`, 168 bytes | decode 7.7 ns, encode 5.0 ns | copying 168 bytes 5.4 ns |
//! | `ArmingCheckReply`, 232 bytes, five nested messages | decode 17.8 ns, encode 13.1 ns | copying 232 bytes 5.2 ns |
//! | three fields of `FailsafeFlags` through its view | 2.7 ns | copying 88 bytes 2.8 ns |
//! | CDR of `FailsafeFlags` | decode 4.6 ns, encode 20.9 ns (to a buffer 7.3) | crate cdr 125 and 155 ns, cdr-encoding 126 and 120 ns |
//! | CDR of `ArmingCheckReply` | decode 14 ns (big endian 105), encode 31.5 ns (to a buffer 16.1) | cdr 357 and 481 ns, cdr-encoding 293 and 197 ns |
//! | JSON of `FailsafeFlags`, with `serde_json` | read 995 ns, write 726 ns | serde's derive 900 and 711 ns |
//! | JSON of `ArmingCheckReply` | read 2.71 µs, write 1.35 µs | serde's derive 2.43 and 1.34 µs |
//!
//! For a fixed-size message, the compiler turns the codec into loads and stores of several values each. Nested messages
//! are decoded one after the other. Reading JSON takes a tenth longer than with serde's derive, mostly because keys are
//! compared, but the code compiles much faster.
//!
//! `cargo xtask bench compile` measures how long `cargo check` takes, in seconds. "Generated" is the crate generated
//! from PX4's 261 messages. "Derives" is a crate of plain structs with the same fields, which uses only the derives of
//! the enabled features:
//!
//! | features | generated | derives |
//! |---|---|---|
//! | none | 2.8 | 0.5 |
//! | `defmt` | 3.4 | 1.3 |
//! | `proptest` | 3.0 | 1.1 |
//! | `schemars` | 3.0 | 1.2 |
//! | `serde` | 4.2 | 8.9 |
//! | all four | 5.2 | 10.8 |
//!
//! Codecs, views and descriptors, which need no feature, account for 2.3 s of each generated crate. That is about ten
//! milliseconds per message.

#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]

#[cfg(feature = "std")]
extern crate std;

/// Re-export for generated code with strings or sequences.
#[cfg(any(feature = "alloc", test))]
pub extern crate alloc;

pub mod cdr;
mod constraint;
pub mod descriptor;
mod error;
mod fixed;
mod flag;
#[cfg(feature = "serde")]
pub mod json;
#[cfg(feature = "json")]
pub mod json_type;
pub mod layout;
#[cfg(feature = "defmt")]
pub mod log;
mod message;
mod open;
mod path;
pub mod record;
mod scalar;
#[cfg(feature = "schemars")]
pub mod schema;
mod severity;
#[cfg(feature = "proptest")]
pub mod strategy;
mod text;
pub mod uorb;
mod validate;
mod value;
#[cfg(feature = "views")]
pub mod view;
mod without;

/// Re-export of the `defmt` crate, for generated code.
#[cfg(feature = "defmt")]
pub use defmt;
/// Re-export of the `proptest` crate, for generated code.
#[cfg(feature = "proptest")]
pub use proptest;
/// Re-export of the `schemars` crate, for generated code.
#[cfg(feature = "schemars")]
pub use schemars;
/// Re-export of the `serde` crate, for generated code.
#[cfg(feature = "serde")]
pub use serde;

pub use constraint::{Constraint, Number, Rule};
pub use error::{DecodeError, EncodeError, Fault};
pub use flag::Flag;
pub use message::{Definition, Message, UorbMessage};
pub use open::Open;
pub use path::Path;
pub use scalar::Scalar;
pub use severity::{ErrorClass, ErrorList, Severity};
pub use text::{Text, TextError};
pub use validate::Violation;

/// Functions that only the macros of this crate may call.
#[doc(hidden)]
pub mod __private {
    pub use crate::open::{flag_names, fmt_enum, fmt_flags};
}

/// A field value with a JSON form. Without the `serde` feature, every type implements this trait.
#[cfg(feature = "serde")]
#[doc(hidden)]
pub use json::Field as JsonField;

/// A field value with a JSON form. Without the `serde` feature, every type implements this trait.
#[cfg(not(feature = "serde"))]
#[doc(hidden)]
pub use without::JsonField;

/// Expands to the given code if the `json` feature is enabled, and to nothing otherwise.
#[cfg(feature = "json")]
#[macro_export]
macro_rules! with_json {
    ($($code:tt)*) => { $($code)* };
}

/// A message with a JSON Schema. Without the `schemars` feature, every type implements this trait.
#[cfg(feature = "schemars")]
#[doc(hidden)]
pub use schema::SchemaRecord;

/// A message with a JSON Schema. Without the `schemars` feature, every type implements this trait.
#[cfg(not(feature = "schemars"))]
#[doc(hidden)]
pub use without::SchemaRecord;
