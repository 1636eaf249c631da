//! `uavspec man`.

use std::io;
use std::path::{Path, PathBuf};

use clap::Args;
use clap_mangen::{Man, generate_to};

use super::report::print_result;
use super::{Exit, Status, interface, unreadable};

const EXAMPLES: &str = "Examples:
  uavspec man | man -l -
  uavspec man --out ~/.local/share/man/man1";

/// Arguments of `man`.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct ManArgs {
    /// Folder to write the man pages of all commands to. It is created if necessary.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Runs `uavspec man`.
pub(super) fn run(args: &ManArgs) -> Exit {
    if let Some(folder) = &args.out {
        write(folder).map_err(|error| unreadable(folder, error))?;
        return Ok(Status::Conforms);
    }
    let mut page = Vec::new();
    // Writing to memory can't fail.
    let _ = Man::new(interface()).render(&mut page);
    print_result(&String::from_utf8_lossy(&page))
}

fn write(folder: &Path) -> io::Result<()> {
    std::fs::create_dir_all(folder)?;
    generate_to(interface(), folder)
}
