//! The program `uavspec`.

use std::process::ExitCode;

fn main() -> ExitCode {
    uavspec_conformance::app::main()
}
