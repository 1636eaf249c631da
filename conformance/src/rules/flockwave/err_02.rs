//! `FW-ERR-02`.

use serde_json::json;

use super::{Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, fw};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ERR-02",
        level: Level::Should,
        status: Status::Normative,
        statement: "0 isn't listed: an empty list says that there is no error.",
        source: fw::ERRORS,
        applies_to: "`errors` of UAV-INF",
    },
    check: Check::Exchange(judge),
    covers: &[],
    bug: Bug::message("The absence of errors is listed.", |out| out.set_in_state("errors", json!([0]))),
    trial: None,
    mutants: &[
        Mutant { name: "0", make: || fw::errors(&[0]), also: &[] },
        Mutant { name: "0 beside another", make: || fw::errors(&[0, 1]), also: &[] },
    ],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    fw::codes(exchange, context, |codes| codes.contains(&0).then(|| "0 is listed".to_owned()));
}
