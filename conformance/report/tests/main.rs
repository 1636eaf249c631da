//! Tests of the public items of the crate, one module per file.

mod browser;
mod growth;
mod hostile;
mod mutants;
mod report;
mod rule_list;
mod texts;
mod untrusted;
