//! `FW-SYS-VER-01`.

use serde_json::json;

use super::{
    Attribution, Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Shape, Status,
    attribution, fw,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-SYS-VER-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "`software` is a string.",
        source: fw::MESSAGES,
        applies_to: "SYS-VER",
    },
    check: Check::Exchange(judge),
    covers: &[Attribution::new(&["SYS-VER"], "software", attribution::MISSING)],
    bug: Bug::message("The name of the software is a number.", |out| {
        out.set("SYS-VER", "software", json!(7));
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "a number",
            make: || fw::reply("SYS-VER", |body| body["software"] = 7.into()),
            also: &[],
        },
        Mutant {
            name: "no software",
            make: || fw::reply("SYS-VER", |body| fw::remove(body, "software")),
            also: &[],
        },
    ],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if exchange.body_of("SYS-VER").is_some() {
        fw::field(exchange, context, "software", true, &Shape::Text);
    }
}
