//! Tests of the parts, each of which may see what is private; those of the program are in `tests/`.

mod browser;
mod catalogue;
mod check;
mod damage;
mod ext;
mod flockwave;
mod hostile;
mod json;
mod live_matrix;
mod mcap;
mod mutants;
mod report;
mod reports;
mod shapes;
#[path = "../tests/support/mod.rs"]
mod support;
mod trials;
mod ulog;
mod watch;
