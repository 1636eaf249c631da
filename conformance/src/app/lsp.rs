//! `uavspec lsp`.

use clap::Args;
use uavspec_report::explain::History;
use uavspec_rules::definitions::Library;

use super::{Exit, Status};

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
pub(super) fn run(_: &LspArgs) -> Exit {
    let library = Library::built_in();
    let history = History::new(&library);
    let served = uavspec_lsp::run(&|message, item| history.lines(message, item));
    served.map(|()| Status::Conforms).map_err(|failure| Status::Unreadable.failed(&failure))
}
