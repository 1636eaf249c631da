//! The `inspect` command, which prints the model.

use clap::Args;
use uavspec_schema::diagnostic::has_errors;
use uavspec_schema::failure::Failure;
use uavspec_schema::json_text;

use super::arguments::DefinitionsArgs;
use super::print::{print_report, protect_inputs, report};
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
    protect_inputs(loaded.inputs(&plan))?;
    print_report(&json_text::pretty(&uavspec_emit::inspect::schema(&schema)));
    Ok(true)
}
