//! `FW-ENV-18`.
//!
//! What has a rule of its own is told by that alone.

use serde_json::json;

use super::{
    Bug, Check, FlockwaveRule, Level, Message, Mutant, Rule, RuleContext, Status, attributed, inf_01, mutant,
    source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-18",
        level: Level::Should,
        status: Status::Disputed(
            "The published schemas don't let a field be null that isn't required; the advice to the authors of the specification \
         does. Here null is a deviation wherever the definition doesn't name it.",
        ),
        statement: "A body has the shape that the definitions give its type for its direction, so far as no other rule is about that; fields that they don't have are allowed where they don't close the object.",
        source: source::SCHEMA,
        applies_to: "bodies of the server",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Message(check)],
    covers: &[],
    bug: Bug::message("RTK-LIST has a field that its definition doesn't allow.", |out| {
        if let Some(body) = out.body_of("RTK-LIST") {
            body["count"] = json!(2);
        }
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "a required field is absent",
            make: || mutant::reply("RTK-INF", |body| mutant::remove(&mut body["preset"]["field"], "title")),
            also: &[],
        },
        Mutant {
            name: "null for what is left out",
            make: || mutant::reply("ACK-NAK", |body| body["reason"] = json!(null)),
            also: &[],
        },
        Mutant {
            name: "a number for a word",
            make: || mutant::notice("ASYNC-ST", |body| body["progress"]["message"] = 7.into()),
            also: &[],
        },
        Mutant {
            name: "a value that a closed set doesn't have",
            make: || mutant::reply("UAV-PREFLT", |body| body["status"]["kite"]["result"] = "fine".into()),
            also: &[],
        },
        Mutant {
            name: "a number out of bounds",
            make: || mutant::reply("WTH-AT", |body| body["weather"]["windSpeed"] = (-1).into()),
            also: &[],
        },
        Mutant {
            name: "a latitude in degrees",
            make: || mutant::reply("WTH-INF", |body| body["status"]["ridge"]["position"][0] = 46.541.into()),
            also: &[],
        },
        Mutant {
            name: "a position without a longitude",
            make: || {
                mutant::reply("WTH-INF", |body| body["status"]["ridge"]["position"] = json!([465_410_000]))
            },
            also: &[],
        },
        Mutant {
            name: "a path without a slash",
            make: || mutant::reply("DEV-SUB", |body| body["success"] = json!(["/kite/vario", "kite"])),
            also: &[],
        },
        Mutant {
            name: "a field that the request has",
            make: || mutant::reply("CLK-INF", |body| body["ids"] = json!(["day"])),
            also: &[],
        },
        Mutant {
            name: "a field that a closed object doesn't have, deep inside",
            make: || mutant::reply("DEV-LIST", |body| body["devices"]["kite"]["colour"] = "red".into()),
            also: &[],
        },
        Mutant {
            name: "a map that is a list",
            make: || mutant::reply("EXT-INF", |body| body["error"] = json!([])),
            also: &[&inf_01::RULE.rule],
        },
    ],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    let Some(deviations) = message.deviations else { return };
    context.covered();
    let Some(type_name) = message.type_name else { return };
    for deviation in deviations.iter().filter(|deviation| attributed(type_name, deviation).is_none()) {
        message.deviates(context, &deviation.field, deviation);
    }
}
