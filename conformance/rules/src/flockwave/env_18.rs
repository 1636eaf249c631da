//! `FW-ENV-18`.
//!
//! A violation covered by another rule is reported only by that rule.

use super::prelude::*;
use super::{attributed, inf_01};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-18",
        name: "Body matches its definition",
        level: Level::Should,
        status: Status::Advisory,
        statement: "A body matches the definition of its type and direction. Additional fields are allowed unless the \
                    definition forbids them.",
        source: source::SCHEMA,
        applies_to: "message bodies from the server",
        why: "Clients generated from the definitions fail to decode the body. Hand-written clients read missing or \
              wrong values.",
        example: r#"{"type":"UAV-PREFLT","status":{"uav-1":{"result":"fine","items":[]}}}"#,
        fix: "Compare the body with the definition of its type, and correct the reported field.",
    },
    checks: &[Check::Message(check)],
    covers: &[],
    bug: Bug::message("RTK-LIST has a field that its definition does not allow.", |out| {
        if let Some(body) = out.body_of("RTK-LIST") {
            body["count"] = json!(2);
        }
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "a missing required field",
            make: || mutant::reply("RTK-INF", |body| mutant::remove(&mut body["preset"]["field"], "title")),
            also: &[],
        },
        Mutant {
            name: "a number in place of a string",
            make: || mutant::notice("ASYNC-ST", |body| body["progress"]["message"] = 7.into()),
            also: &[],
        },
        Mutant {
            name: "a value outside an enumeration",
            make: || mutant::reply("UAV-PREFLT", |body| body["status"]["kite"]["result"] = "fine".into()),
            also: &[],
        },
        Mutant {
            name: "a number out of range",
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
            name: "a request field in the response",
            make: || mutant::reply("CLK-INF", |body| body["ids"] = json!(["day"])),
            also: &[],
        },
        Mutant {
            name: "an unknown field in a nested object that allows no unknown fields",
            make: || mutant::reply("DEV-LIST", |body| body["devices"]["kite"]["colour"] = "red".into()),
            also: &[],
        },
        Mutant {
            name: "a list in place of a map",
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
