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
#[allow(dead_code, reason = "the tests of the program use the rest of it")]
#[path = "../tests/support/mod.rs"]
pub(crate) mod support;
mod trials;
mod ulog;
