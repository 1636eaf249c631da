//! `uavspec rules`.

use clap::Args;
use uavspec_probe::self_test::matrix;
use uavspec_report::rule_list;
use uavspec_rules::definitions::Definitions;
use uavspec_rules::rule;

use super::report::print_result;
use super::{Exit, Format, unknown_rule};

/// Arguments of `rules`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  uavspec rules
  uavspec rules PX-RANGE-01
  uavspec rules --matrix
  uavspec rules --format json")]
pub(super) struct RulesArgs {
    /// Id of the rule to explain.
    #[arg(value_name = "ID", conflicts_with = "matrix")]
    id: Option<String>,
    /// Show which rules find which mutants.
    ///
    /// A mutant is a capture changed so that it violates one rule.
    #[arg(long)]
    matrix: bool,
    /// Output format: text or json.
    #[arg(long, value_name = "FORMAT", default_value = "text", hide_possible_values = true)]
    format: Format,
}

/// Runs `uavspec rules`.
pub(super) fn rules(args: &RulesArgs) -> Exit {
    let text = match (&args.id, args.format) {
        (Some(id), format) => {
            let rule = rule(id).ok_or_else(|| unknown_rule(&format!("{id}: no such rule"), id))?;
            if format == Format::Json { rule_list::to_json(&[rule]) } else { rule_list::rule_text(rule) }
        }
        (None, format) if args.matrix => {
            let rows = matrix(&Definitions::built_in());
            if format == Format::Json { rule_list::matrix_json(&rows) } else { rule_list::matrix_text(&rows) }
        }
        (None, Format::Text) => rule_list::to_text(),
        (None, Format::Json) => rule_list::to_json(&uavspec_rules::RULES),
    };
    print_result(&text)
}
