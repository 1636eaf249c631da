//! The tests of the generated types, in one program; each file is a module.

mod readme;
mod schemas;
mod specification;
mod strategies;
mod support;
mod vectors;
