//! Tests of the public items of the crate, one module per file.

mod attributes;
mod baseline;
mod breaking;
mod constraints;
mod format;
mod format_properties;
mod layout;
mod lint;
