//! The `inspect` command, which prints the model.

use std::io::Write as _;

use clap::Args;

use super::arguments::DefinitionsArgs;
use super::print::report;
use crate::diagnostic::has_errors;
use crate::emit;
use crate::failure::Failure;
use crate::load::read;

/// Arguments of `inspect`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  cargo xtask inspect        print the definitions that uavspec.toml lists
  cargo xtask inspect --package px4 --dialect px4 --input msg/BatteryStatus.msg")]
pub struct InspectArgs {
    #[command(flatten)]
    definitions: DefinitionsArgs,
}

pub(super) fn run(args: &InspectArgs) -> Result<bool, Failure> {
    let plan = args.definitions.plan()?;
    let (loaded, schema, diagnostics) = read(&plan)?;
    report("inspect", &loaded, &diagnostics, "nothing printed");
    if has_errors(&diagnostics) {
        return Ok(false);
    }
    let mut text = serde_json::to_string_pretty(&emit::inspect::schema(&schema))
        .map_err(|error| Failure::new(error.to_string()))?;
    text.push('\n');
    // It is not an error if the reader closes the pipe early.
    let _ = std::io::stdout().write_all(text.as_bytes());
    Ok(true)
}
