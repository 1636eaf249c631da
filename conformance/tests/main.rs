//! The tests of the program `uavspec` and of what its library offers, in one program; each file is a module. Tests of
//! the parts are in `src/tests/`.

mod cli;
mod imports;
mod known;
mod probe;
mod schema;
mod serve;
mod support;
mod testee;
mod watch;
