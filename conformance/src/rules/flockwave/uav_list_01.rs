//! `FW-UAV-LIST-01`.

use super::fw::{self, Exchange, Shape};
use super::{Check, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UAV-LIST-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "`ids` is a list of strings.",
        source: fw::MESSAGES,
        applies_to: "UAV-LIST",
    },
    check: Check::Exchange(judge),
    mutants: &[
        Mutant { name: "no ids", make: || fw::reply("UAV-LIST", |body| fw::remove(body, "ids")), also: &[] },
        Mutant {
            name: "an id that is a number",
            make: || fw::reply("UAV-LIST", |body| body["ids"][0] = 7.into()),
            also: &[],
        },
    ],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if exchange.body_of("UAV-LIST").is_some() {
        fw::field(exchange, context, "ids", true, &Shape::List(&Shape::Text));
    }
}
