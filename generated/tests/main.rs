//! Integration tests of the generated types. Each file is a module of this program, so the tests link once.

mod schemas;
mod specification;
mod strategies;
mod support;
mod vectors;
