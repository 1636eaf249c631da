//! `FW-INF-01`.

use serde_json::json;

use super::{
    Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, mutant, reply, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-INF-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "Each id or path that was asked for stands in exactly one map of the reply.",
        source: source::MESSAGES,
        applies_to: "BCN-INF, CLK-INF, DEV-INF, EXT-INF, RTK-INF, UAV-PREFLT, WTH-INF",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(check)],
    covers: &[],
    bug: Bug::message("The last thing that was asked for is missing, in BCN-INF and the like.", |out| {
        out.lose_last(&["BCN-INF", "CLK-INF", "WTH-INF", "RTK-INF", "EXT-INF", "UAV-PREFLT"]);
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "nothing of what was asked for, BCN-INF",
            make: || mutant::reply("BCN-INF", |body| body["status"] = json!({})),
            also: &[],
        },
        Mutant {
            name: "nothing of what was asked for, CLK-INF",
            make: || mutant::reply("CLK-INF", |body| body["status"] = json!({})),
            also: &[],
        },
        Mutant {
            name: "nothing of what was asked for, DEV-INF",
            make: || mutant::reply("DEV-INF", |body| body["values"] = json!({})),
            also: &[],
        },
        Mutant {
            name: "nothing of what was asked for, EXT-INF",
            make: || mutant::reply("EXT-INF", |body| body["status"] = json!({})),
            also: &[],
        },
        Mutant {
            name: "nothing of what was asked for, RTK-INF",
            make: || mutant::reply("RTK-INF", |body| body["preset"] = json!({})),
            also: &[],
        },
        Mutant {
            name: "nothing of what was asked for, UAV-PREFLT",
            make: || mutant::reply("UAV-PREFLT", |body| body["status"] = json!({})),
            also: &[],
        },
        Mutant {
            name: "nothing of what was asked for, WTH-INF",
            make: || mutant::reply("WTH-INF", |body| body["status"] = json!({})),
            also: &[],
        },
    ],
};

const TYPES: [&str; 7] = ["BCN-INF", "CLK-INF", "DEV-INF", "EXT-INF", "RTK-INF", "UAV-PREFLT", "WTH-INF"];

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    reply::partition(exchange, context, &TYPES);
}
