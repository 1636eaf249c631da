//! What generated code calls. (placeholder doc, replaced below)
#![cfg_attr(not(feature = "std"), no_std)]
pub mod layout;
mod scalar;
mod severity;
pub use scalar::Scalar;
pub use severity::{ErrorClass, Severity};
