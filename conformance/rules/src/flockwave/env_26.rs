//! `FW-ENV-26`.
//!
//! A value may be valid in one part of the specification and invalid in another. A server that follows either part must
//! not fail. For such values, this rule therefore replaces the rules that report other values of the same field.

use uavspec_flockwave::body_schema::Deviation;

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-26",
    name: "Values allowed in part of the specification",
    level: Level::Should,
    status: Status::Disputed(
        "For optional fields, the published JSON Schemas do not allow null, but the guidelines for \
         specification authors do. For timestamps other than those of weather data, the JSON Schemas \
         allow any number. For coordinates and velocities, the tables in the text allow any number. Only \
         the JSON Schema allows a longitude of 180°. This rule reports all of these values.",
    ),
    statement: "A value is valid in every part of the specification. An optional field is omitted instead \
                of null. Timestamps, coordinates and velocities are integers, and longitudes are less \
                than 180°.",
    source: source::GENERAL,
    applies_to: "messages from the server",
    why: "Clients that follow a different part of the specification reject the whole message.",
    example: concat!(
        r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000,"#,
        r#""attitude":null}}}"#
    ),
    fix: "Omit optional fields that have no value. Round timestamps, coordinates and velocities to \
          integers, and send -180° instead of 180°.",
})
.checks(&[Check::Message(check)])
.bug(Bug::message("The `refs` of notifications is null.", |out| {
    if out.is_notification() {
        out.message()["refs"] = Value::Null;
    }
}))
.mutants(&[
    Mutant::reply("null in an optional field", "ACK-NAK", |body| body["reason"] = json!(null)),
    Mutant::state("null in an optional field of a UAV state", |state| state["attitude"] = json!(null)),
    Mutant::session("a notification whose `refs` is null", |session| {
        session.notify(json!({ "type": "CONN-DEL", "ids": ["winch"] }));
        if let Some(line) = session.lines.last_mut() {
            line["msg"]["refs"] = Value::Null;
        }
    }),
    Mutant::reply_message("a null error next to a body", "UAV-LIST", |message| {
        message["error"] = json!(null);
    }),
    Mutant::session("an error whose code is null", |session| {
        let id = session.sends(json!({ "type": "LCN-INF" }));
        session.answers(&id, json!({ "error": { "code": null, "message": "No" } }));
    }),
    Mutant::state("a timestamp with a fraction", |state| state["timestamp"] = json!(1_790_000_000_000.5)),
    Mutant::state("a position in degrees", |state| state["position"] = json!([46.541, 11.552])),
    Mutant::state("a longitude of 180°", |state| state["position"] = json!([0, 1_800_000_000])),
]);

/// The longitude that the specification text excludes, as written in a body.
const LONGITUDE_180: &str = "1800000000";

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    context.covered();
    // A server may copy an id that is null.
    let is_copied = |keys: &[&str]| message.may_answer_unknown && *keys == ["refs"];
    for keys in null_members(message.value).filter(|keys| !is_copied(keys)) {
        message.violates(context, || {
            Detail::new("null in place of an absent member")
                .at(pointer(keys))
                .expected("nothing")
                .actual("null")
        });
    }
    let Some(type_name) = message.type_name else { return };
    for deviation in message.deviations.into_iter().flatten() {
        if is_disputed(type_name, deviation) {
            message.deviates(context, &deviation.field, deviation);
        }
    }
}

/// The optional members of an envelope that are null. `FW-ENV-11` and `FW-ENV-12` report null if the other members are
/// missing as well.
fn null_members(message: &Tree<'_>) -> impl Iterator<Item = &'static [&'static str]> {
    let is_null = |value: Option<&Tree<'_>>| value == Some(&Tree::Null);
    let member = |holder: Option<&Tree<'_>>, name: &str, other: &str| {
        let get = |key| holder.and_then(|holder| holder.get(key));
        is_null(get(name)) && body::is_present(get(other))
    };
    let error = message.get("error");
    let found: [(bool, &'static [&'static str]); 5] = [
        (is_null(message.get("refs")), &["refs"]),
        (member(Some(message), "body", "error"), &["body"]),
        (member(Some(message), "error", "body"), &["error"]),
        (member(error, "code", "message"), &["error", "code"]),
        (member(error, "message", "code"), &["error", "message"]),
    ];
    found.into_iter().filter(|(is_null, _)| *is_null).map(|(_, keys)| keys)
}

/// True if a part of the specification allows the value.
pub(super) fn is_disputed(type_name: &str, deviation: &Deviation) -> bool {
    match deviation.fault {
        Some(Fault::Null) => deviation.is_optional,
        // A number is only of the wrong kind if it has a fraction.
        Some(Fault::Kind) => {
            may_be_fraction(type_name, &deviation.field) && deviation.mismatch.actual.parse::<f64>().is_ok()
        }
        Some(Fault::Value) => {
            deviation.field.split('.').any(|name| name == "position")
                && deviation.mismatch.path.ends_with("/1")
                && deviation.mismatch.actual == LONGITUDE_180
        }
        _ => false,
    }
}

/// True if a part of the specification allows fractions in this field of a UAV state.
fn is_fraction(name: &str) -> bool {
    ["timestamp", "position", "positionXYZ", "velocity", "velocityXYZ"].contains(&name)
}

/// True if a part of the specification allows fractions in this field.
fn may_be_fraction(type_name: &str, field: &str) -> bool {
    match type_name {
        "UAV-INF" => {
            field.strip_prefix("status.").and_then(|field| field.split('.').next()).is_some_and(is_fraction)
        }
        "BCN-INF" | "CONN-INF" | "DOCK-INF" => field == "status.timestamp",
        "CLK-INF" => field == "status.retrievedAt",
        "SYS-MSG" => field == "items.timestamp",
        "SYS-TIME" => field == "timestamp",
        _ => false,
    }
}
