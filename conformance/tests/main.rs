//! The tests of the program `uavspec` and of what its library offers, in one program; each file is a module. Tests of
//! the parts are in `src/tests/`.

mod cli;
mod imports;
mod known;
mod probe;
mod schema;
mod serve;
#[allow(dead_code, reason = "the tests of the parts use the rest of it")]
mod support;
mod testee;
mod watch;
