//! `FW-UAV-INF-04`.

use super::fw::{self, Exchange, Shape};
use super::{Check, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UAV-INF-04",
        level: Level::Should,
        status: Status::Advisory,
        statement: "`error` maps ids to strings.",
        source: fw::SCHEMA,
        applies_to: "UAV-INF",
    },
    check: Check::Exchange(judge),
    mutants: &[Mutant {
        name: "a number for the reason",
        make: || fw::reply("UAV-INF", |body| body["error"]["owl"] = 7.into()),
        also: &[],
    }],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if exchange.body_of("UAV-INF").is_some() {
        fw::field(exchange, context, "error", false, &Shape::Nullable(&Shape::Map(&Shape::Text)));
    }
}
