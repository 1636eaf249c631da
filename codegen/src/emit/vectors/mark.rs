//! Marks of all files.

use crate::emit::file::GENERATED_BY;

/// The version of the form of the files. It rises when a reader of the form before would misread them.
pub(super) const FORM: u32 = 1;

/// What a file says of its origin.
pub(super) fn mark() -> String {
    format!("{GENERATED_BY}. Do not edit: run `cargo xtask codegen`.")
}
