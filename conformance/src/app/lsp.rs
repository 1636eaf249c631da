//! `uavspec lsp`.

use clap::Args;
use uavspec_codegen::lsp;

use super::Status;
use crate::definitions::Library;
use crate::explain::History;
use crate::text::terminal;

const EXAMPLES: &str = "Examples:
  uavspec lsp    # started by an editor

Neovim:
  vim.lsp.start({ cmd = { \"uavspec\", \"lsp\" }, root_dir = vim.fn.getcwd() })";

/// Arguments of `lsp`.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct LspArgs {
    /// Use standard input and output. This is the default; editors pass the option.
    #[arg(long)]
    stdio: bool,
}

/// Runs `uavspec lsp`.
pub(super) fn run(_: &LspArgs) -> Status {
    let library = Library::built_in();
    match lsp::run(&History::new(&library)) {
        Ok(()) => Status::Conforms,
        Err(failure) => {
            terminal::eprintln!("{failure}");
            Status::Unreadable
        }
    }
}
