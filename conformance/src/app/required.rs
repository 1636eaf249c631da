//! The option `--require`.

use clap::Args;
use uavspec_model::text::terminal;
use uavspec_model::{Reason, Rule};
use uavspec_report::Totals;
use uavspec_rules::rule;

use super::{Status, unknown_rule};

/// Arguments of commands that check rules.
#[derive(Args, Debug)]
pub(super) struct RequireArgs {
    /// Fail if this rule was not checked, because the input contains nothing that it applies to (repeatable).
    ///
    /// Separate multiple ids with commas.
    #[arg(long, value_name = "ID", value_delimiter = ',')]
    require: Vec<String>,
}

impl RequireArgs {
    /// The required rules. Prints an error if an id is unknown.
    pub(super) fn rules(&self) -> Result<Vec<&'static Rule>, Status> {
        let unknown = |id: &str| unknown_rule(&format!("--require {id}: no such rule"), id);
        self.require.iter().map(|id| rule(id).ok_or_else(|| unknown(id))).collect()
    }
}

/// Prints an error for each required rule that no subject covers, and returns these errors.
pub(super) fn uncovered(required: &[&Rule], totals: &Totals) -> Vec<Reason> {
    let uncovered = required.iter().filter(|rule| !totals.covers(rule.id));
    let reasons = uncovered.map(|rule| {
        let reason = format!("{} is required, but not covered by the input", rule.id);
        terminal::error(&reason, None);
        Reason::from(reason)
    });
    reasons.collect()
}
