//! Tests of the npm package: its content, the examples in its README, and its launcher. Also tests the types in
//! TypeScript and Python modules that are generated from arbitrary definitions.
//!
//! Tests that require Node or Python are ignored by default. They install type checkers below `target/`. The files in
//! `packages/` specify the versions of the type checkers.

mod archives;
mod declarations;
mod labels;
#[cfg(unix)]
mod launcher;
mod readme;
mod shadowing;
pub(crate) mod tools;
