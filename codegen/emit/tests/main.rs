//! Tests of the public items of the crate, one module per file.

mod bindings;
mod edge;
mod hostile;
mod json_schema;
mod json_types;
mod oracle;
mod origin;
mod properties;
mod type_pages;
mod vectors;
