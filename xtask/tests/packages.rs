//! Tests of the packages for npm and `PyPI`: the content of archives, the types of modules generated from arbitrary
//! definitions, and the examples in the READMEs of installed packages.
//!
//! Tests that require Node or Python are ignored by default. They install type checkers below `target/`. The files in
//! `packages/` specify the versions of the type checkers.

mod archives;
mod declarations;
mod labels;
mod readme;
mod shadowing;
pub(crate) mod tools;
