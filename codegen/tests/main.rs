//! The tests of the generator in one program; each file is a module.

mod attributes;
mod bindings;
mod breaking;
mod constraints;
mod conversion;
mod dynamic;
mod edge;
mod emitters;
mod fixtures;
mod format;
mod format_properties;
mod growth;
mod hostile;
mod imports;
mod json_schema;
mod json_types;
mod lint;
#[cfg(feature = "lsp")]
mod lsp;
mod names;
mod oracle;
mod origin;
mod properties;
mod releases;
mod ros_packages;
mod support;
mod type_pages;
mod vectors;
