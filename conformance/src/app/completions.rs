//! `uavspec completions`.

use clap::Args;
use clap_complete::{Shell, generate};

use super::report::print;
use super::{PROGRAM, Status, interface};
use crate::text::terminal;

const EXAMPLES: &str = "Examples:
  uavspec completions bash > ~/.local/share/bash-completion/completions/uavspec
  uavspec completions zsh > ~/.zfunc/_uavspec
  uavspec completions fish > ~/.config/fish/completions/uavspec.fish";

/// Arguments of `completions`.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct CompletionsArgs {
    /// Shell to write the script for.
    shell: Shell,
}

/// Runs `uavspec completions`.
pub(super) fn run(args: &CompletionsArgs) -> Status {
    let mut script = Vec::new();
    generate(args.shell, &mut interface(), PROGRAM, &mut script);
    match print(&String::from_utf8_lossy(&script)) {
        Ok(()) => Status::Conforms,
        Err(error) => {
            terminal::error(format_args!("standard output: {error}"), None);
            Status::Unreadable
        }
    }
}
