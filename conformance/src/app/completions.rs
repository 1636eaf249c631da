//! `uavspec completions`.

use clap::Args;
use clap_complete::{Shell, generate};

use super::report::print_result;
use super::{Exit, PROGRAM, interface};

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
pub(super) fn run(args: &CompletionsArgs) -> Exit {
    let mut script = Vec::new();
    generate(args.shell, &mut interface(), PROGRAM, &mut script);
    print_result(&String::from_utf8_lossy(&script))
}
