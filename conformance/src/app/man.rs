//! `uavspec man`.

use std::io;
use std::path::{Path, PathBuf};

use clap::Args;
use clap_mangen::{Man, generate_to};

use super::report::print;
use super::{Status, interface};
use crate::text::terminal;

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
pub(super) fn run(args: &ManArgs) -> Status {
    let (place, result) = match &args.out {
        Some(folder) => (terminal::path(folder), write(folder)),
        None => ("standard output".to_owned(), print_page()),
    };
    match result {
        Ok(()) => Status::Conforms,
        Err(error) => {
            terminal::error(format_args!("{place}: {error}"), None);
            Status::Unreadable
        }
    }
}

fn write(folder: &Path) -> io::Result<()> {
    std::fs::create_dir_all(folder)?;
    generate_to(interface(), folder)
}

fn print_page() -> io::Result<()> {
    let mut page = Vec::new();
    Man::new(interface()).render(&mut page)?;
    print(&String::from_utf8_lossy(&page))
}
