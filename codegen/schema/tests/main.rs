//! Tests of the public items of the crate, one module per file.

mod events;
mod fixtures;
