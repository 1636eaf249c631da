//! `FW-CONN-INF-03`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-CONN-INF-03",
    name: "Values in connection states",
    level: Level::Must,
    status: Status::Normative,
    statement: "In each state, `purpose` and `status` have values that the specification defines.",
    source: source::MESSAGES,
    applies_to: "CONN-INF",
    why: "Clients use these values to choose the icon and the warning for a connection. With an unknown \
          value, a working link may look broken, or a broken link may look fine.",
    example: r#"{"type":"CONN-INF","status":{"radio-1":{"id":"radio-1","purpose":"dgps","status":"up"}}}"#,
    fix: "Map internal values to those in the specification. Use the purpose `other` or the status \
          `unknown` if none fits.",
})
.checks(&[Check::Message(check)])
.covers(&[
    Attribution::new(&["CONN-INF"], "status.*", attribution::MISSING),
    Attribution::new(&["CONN-INF"], "status.*.purpose", attribution::INVALID),
    Attribution::new(&["CONN-INF"], "status.*.status", attribution::INVALID),
])
.bug(Bug::message("The `purpose` of connections is a number.", |out| {
    out.each_status("CONN-INF", |status| status["purpose"] = json!(1));
}))
.mutants(&[
    Mutant::notice("an unknown purpose", "CONN-INF", |body| {
        body["status"]["winch"]["purpose"] = "tow".into();
    }),
    Mutant::notice("a status that is a number", "CONN-INF", |body| {
        body["status"]["winch"]["status"] = 2.into();
    }),
]);

const PURPOSE: ExpectedValue =
    ExpectedValue::OneOf(&["debug", "dgps", "dock", "gps", "mocap", "time", "uavRadioLink", "other"]);

const STATUS: ExpectedValue =
    ExpectedValue::OneOf(&["disconnected", "connecting", "connected", "disconnecting", "unknown"]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    for (key, state) in body::states(message, "CONN-INF") {
        let keys = ["body", "status", key];
        body::member(message, context, Some(state), &keys, ("purpose", true), &PURPOSE);
        body::member(message, context, Some(state), &keys, ("status", true), &STATUS);
    }
}
