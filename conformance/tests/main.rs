//! The tests of `uavspec`, in one program; each file is a module.

mod browser;
mod catalogue;
mod check;
mod cli;
mod damage;
mod ext;
mod flockwave;
mod json;
mod known;
mod live_matrix;
mod mcap;
mod mutants;
mod probe;
mod report;
mod reports;
mod schema;
mod serve;
mod shapes;
mod support;
mod testee;
mod trials;
mod ulog;
mod watch;
