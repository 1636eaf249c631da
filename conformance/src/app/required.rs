//! Rules that have to be exercised.

use clap::Args;

use super::Status;
use crate::model::{Reason, Rule};
use crate::report::Subject;
use crate::rules::rule;

/// Arguments of commands that judge by rules.
#[derive(Args, Debug)]
pub(super) struct RequireArgs {
    /// Rules that have to be exercised: that nothing was there to judge is a breach, too.
    #[arg(long, value_name = "ID", value_delimiter = ',')]
    require: Vec<String>,
}

impl RequireArgs {
    /// The rules; that there is no such one has been told.
    pub(super) fn rules(&self) -> Result<Vec<&'static Rule>, Status> {
        let find = |id: &String| {
            rule(id).ok_or_else(|| {
                anstream::eprintln!("error: --require {id}: no such rule\n  help: `uavspec rules` lists all");
                Status::Usage
            })
        };
        self.require.iter().map(find).collect()
    }
}

/// Which of these rules were not exercised in any subject; that is told as well.
pub(super) fn idle(required: &[&Rule], subjects: &[Subject]) -> Vec<Reason> {
    let is_idle = |id: &str| {
        let rules = subjects.iter().flat_map(|subject| &subject.rules);
        rules.filter(|rule| rule.id == id).all(|rule| rule.covered == 0)
    };
    let idle = required.iter().filter(|rule| is_idle(rule.id));
    let remarks = idle.map(|rule| {
        let remark = format!("{} was required, and nothing was there that it could have judged", rule.id);
        anstream::eprintln!("error: {remark}");
        Reason::from(remark)
    });
    remarks.collect()
}
