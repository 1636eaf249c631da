//! Tests of the packages for npm and `PyPI`: the content of archives, the types of modules for any definitions, and the
//! examples in READMEs of installed packages.
//!
//! Tests that require Node or Python are ignored by default. They install type checkers below `target/`, at the
//! versions in `packages/`.

mod archives;
mod declarations;
mod labels;
mod readme;
mod tools;
