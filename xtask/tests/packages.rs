//! The packages for npm and `PyPI`, and what they are made of: what is in the archives; that type checkers find no fault
//! with modules of any definitions; that values are of the declared types just where they are valid; and that packages,
//! once installed, do what their READMEs say.
//!
//! Whatever needs Node or Python is ignored unless it is asked for. It installs type checkers, at the versions that
//! stand in `packages/`, below `target/`.

mod archives;
mod declarations;
mod labels;
mod readme;
mod tools;
