//! `FW-ERR-08`.

use serde_json::json;

use super::{Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, fw};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ERR-08",
        level: Level::Should,
        status: Status::Normative,
        statement: "201, outside the fence in the air, doesn't stand beside 1, on the ground; 71 does.",
        source: fw::ERRORS,
        applies_to: "`errors` of UAV-INF",
    },
    check: Check::Exchange(judge),
    covers: &[],
    bug: Bug::message("On the ground a UAV has left the fence in the air.", |out| {
        out.set_in_state("errors", json!([1, 201]));
    }),
    trial: None,
    mutants: &[Mutant {
        name: "outside the fence, on the ground",
        make: || fw::errors(&[1, 201]),
        also: &[],
    }],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    fw::codes(exchange, context, |codes| {
        [201, 1]
            .iter()
            .all(|code| codes.contains(code))
            .then(|| "201 is for the air, and 1 says that the UAV is on the ground".to_owned())
    });
}
