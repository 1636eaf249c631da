//! Checks values of PX4 messages in memory, in CDR and in JSON. Each record is checked by the plan of its type. A plan
//! is compiled once for each type. The crate also compares the definitions in a capture with expected ones.
//!
//! ```
//! use uavspec_px4::comparison::compare_texts;
//!
//! let differences = compare_texts("uint8 mode\n", "uint16 mode\n");
//! assert!(differences.to_string().contains("mode"));
//! ```

#![cfg_attr(not(test), warn(clippy::disallowed_macros, clippy::disallowed_methods))]

pub mod checks;
pub mod comparison;
pub mod event;
pub mod format;
pub mod json;
mod limits;
pub mod memory;
pub(crate) mod values;

pub use self::values::ValueRules;
