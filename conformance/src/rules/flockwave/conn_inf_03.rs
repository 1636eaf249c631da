//! `FW-CONN-INF-03`.

use serde_json::json;

use super::{
    Attribution, Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Shape, Status,
    attribution, fw,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-CONN-INF-03",
        level: Level::Must,
        status: Status::Normative,
        statement: "`purpose` and `status` of each state are names that the specification has.",
        source: fw::MESSAGES,
        applies_to: "CONN-INF",
    },
    check: Check::Exchange(judge),
    covers: &[
        Attribution::new(&["CONN-INF"], "status.*", attribution::MISSING),
        Attribution::new(&["CONN-INF"], "status.*.purpose", attribution::UNFIT),
        Attribution::new(&["CONN-INF"], "status.*.status", attribution::UNFIT),
    ],
    bug: Bug::message("The purpose of connections is a number.", |out| {
        out.each_status("CONN-INF", |status| status["purpose"] = json!(1));
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "a purpose of its own",
            make: || fw::notice("CONN-INF", |body| body["status"]["winch"]["purpose"] = "tow".into()),
            also: &[],
        },
        Mutant {
            name: "a status that is a number",
            make: || fw::notice("CONN-INF", |body| body["status"]["winch"]["status"] = 2.into()),
            also: &[],
        },
    ],
};

const PURPOSE: Shape =
    Shape::OneOf(&["debug", "dgps", "dock", "gps", "mocap", "time", "uavRadioLink", "other"]);

const STATUS: Shape = Shape::OneOf(&["disconnected", "connecting", "connected", "disconnecting", "unknown"]);

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    for (key, state) in fw::states(exchange, "CONN-INF") {
        let keys = ["body", "status", key];
        fw::member(exchange, context, Some(state), &keys, ("purpose", true), &PURPOSE);
        fw::member(exchange, context, Some(state), &keys, ("status", true), &STATUS);
    }
}
