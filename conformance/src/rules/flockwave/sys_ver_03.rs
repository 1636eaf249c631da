//! `FW-SYS-VER-03`.

use serde_json::json;

use super::{
    Attribution, Bug, Check, Exchange, Fault, FlockwaveRule, Level, Mutant, Rule, RuleContext, Shape, Status,
    fw,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-SYS-VER-03",
        level: Level::Must,
        status: Status::Normative,
        statement: "`name` and `revision`, where they are present, are strings.",
        source: fw::MESSAGES,
        applies_to: "SYS-VER",
    },
    check: Check::Exchange(judge),
    covers: &[
        Attribution::new(&["SYS-VER"], "name", &[Fault::Kind]),
        Attribution::new(&["SYS-VER"], "revision", &[Fault::Kind]),
    ],
    bug: Bug::message("The name of the server is a list.", |out| {
        out.set("SYS-VER", "name", json!(["glider"]));
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "a revision that is a number",
            make: || fw::reply("SYS-VER", |body| body["revision"] = 7.into()),
            also: &[],
        },
        Mutant {
            name: "a name that is a list",
            make: || fw::reply("SYS-VER", |body| body["name"] = json!([])),
            also: &[],
        },
    ],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if exchange.body_of("SYS-VER").is_some() {
        fw::field(exchange, context, "name", false, &Shape::Nullable(&Shape::Text));
        fw::field(exchange, context, "revision", false, &Shape::Nullable(&Shape::Text));
    }
}
