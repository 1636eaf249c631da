//! `FW-UST-BATTERY`.

use serde_json::json;

use super::{Attribution, Bug, Check, FlockwaveRule, Mutant, Rule, Status, attribution, ust};

/// What the specification says of null, and of negative percentages.
const NULL_AND_NEGATIVE: Status = Status::Disputed(
    "The published schemas don't let a field be null that isn't required; the advice to the authors of the specification \
     does. Here null is a deviation. Any negative percentage says that it is unknown by the text, -1 alone by the \
     schema; here any does.",
);

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UST-BATTERY",
        status: NULL_AND_NEGATIVE,
        statement: "`battery` is the voltage, an integer in tenths of a volt from 0 on; the percentage, 100 at most; and whether it is charged.",
        ..ust::RULE
    },
    checks: &[Check::Message(|message, context| ust::check(message, context, &RULE, "battery"))],
    covers: &[Attribution::new(&["UAV-INF"], "status.*.battery.**", attribution::ALL)],
    bug: Bug::message("A battery is charged to more than all.", |out| {
        out.set_in_state("battery", json!([126, 101]));
    }),
    trial: None,
    mutants: &[
        Mutant { name: "a fraction of a volt", make: || ust::with("battery", json!([11.8, 84])), also: &[] },
        Mutant { name: "101 percent", make: || ust::with("battery", json!([118, 101])), also: &[] },
        Mutant {
            name: "a number where true or false should be",
            make: || ust::with("battery", json!([118, 84, 1])),
            also: &[],
        },
    ],
};
