//! `FW-UAV-LIST-01`.

use super::{
    Attribution, Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Shape, Status,
    attribution, fw,
};

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
    covers: &[
        Attribution::new(&["UAV-LIST"], "ids", attribution::MISSING),
        Attribution::new(&["UAV-LIST"], "ids.*", attribution::MISSING),
    ],
    bug: Bug::message("The last id in UAV-LIST is a number.", |out| out.make_last_id_a_number("UAV-LIST")),
    trial: None,
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
