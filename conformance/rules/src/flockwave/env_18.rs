//! `FW-ENV-18`.
//!
//! A violation covered by another rule is reported only by that rule.

use super::prelude::*;
use super::{attributed, inf_01};

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-18",
    name: "Body matches its definition",
    level: Level::Should,
    status: Status::Advisory,
    statement: "A body matches the definition of its type and direction. Additional fields are allowed \
                unless the definition forbids them.",
    source: source::SCHEMA,
    applies_to: "message bodies from the server",
    why: "Clients generated from the definitions fail to decode the body. Hand-written clients read \
          missing or wrong values.",
    example: r#"{"type":"UAV-PREFLT","status":{"uav-1":{"result":"fine","items":[]}}}"#,
    fix: "Compare the body with the definition of its type, and correct the reported field.",
})
.checks(&[Check::Message(check)])
.bug(Bug::message("RTK-LIST has a field that its definition does not allow.", |out| {
    out.set("RTK-LIST", "count", json!(2));
}))
.mutants(&[
    Mutant::reply("a missing required field", "RTK-INF", |body| {
        mutant::remove(&mut body["preset"]["field"], "title");
    }),
    Mutant::notice("a number in place of a string", "ASYNC-ST", |body| {
        body["progress"]["message"] = 7.into();
    }),
    Mutant::reply("a value outside an enumeration", "UAV-PREFLT", |body| {
        body["status"]["kite"]["result"] = "fine".into();
    }),
    Mutant::reply("a number out of range", "WTH-AT", |body| body["weather"]["windSpeed"] = (-1).into()),
    Mutant::reply("a latitude in degrees", "WTH-INF", |body| {
        body["status"]["ridge"]["position"][0] = 46.541.into();
    }),
    Mutant::reply("a position without a longitude", "WTH-INF", |body| {
        body["status"]["ridge"]["position"] = json!([465_410_000]);
    }),
    Mutant::reply("a path without a slash", "DEV-SUB", |body| {
        body["success"] = json!(["/kite/vario", "kite"]);
    }),
    Mutant::reply("a request field in the response", "CLK-INF", |body| body["ids"] = json!(["day"])),
    Mutant::reply("an unknown field in a nested object that allows no unknown fields", "DEV-LIST", |body| {
        body["devices"]["kite"]["colour"] = "red".into();
    }),
    Mutant::reply("a list in place of a map", "EXT-INF", |body| body["error"] = json!([]))
        .also(&[&inf_01::RULE.rule]),
]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    let Some(deviations) = message.deviations else { return };
    context.covered();
    let Some(type_name) = message.type_name else { return };
    for deviation in deviations.iter().filter(|deviation| attributed(type_name, deviation).is_none()) {
        message.deviates(context, &deviation.field, deviation);
    }
}
