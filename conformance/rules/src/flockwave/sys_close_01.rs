//! `FW-SYS-CLOSE-01`.

use super::prelude::*;
use super::sys_close_02;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-SYS-CLOSE-01",
    name: "Fields of SYS-CLOSE",
    level: Level::Must,
    status: Status::Normative,
    statement: "SYS-CLOSE is a notification with an optional string `reason`.",
    source: source::MESSAGES,
    applies_to: "SYS-CLOSE",
    why: "Clients show `reason` to the operator before the connection ends. If the message cannot be \
          decoded, the connection seems to fail for no reason.",
    example: r#"{"type":"SYS-CLOSE","reason":7}"#,
    fix: "Send SYS-CLOSE without `refs`. Send `reason` as a human-readable string, or omit it.",
})
.checks(&[Check::Message(check)])
.covers(&[Attribution::new(&["SYS-CLOSE"], "reason", &[Fault::Kind])])
.bug(
    Bug::message("The `reason` of SYS-CLOSE is a number.", |out| {
        out.set("SYS-CLOSE", "reason", json!(7));
    })
    .needs(Needs::Farewell),
)
.mutants(&[
    Mutant::notice("a reason that is a number", "SYS-CLOSE", |body| body["reason"] = 7.into()),
    Mutant::session("SYS-CLOSE as a response", |session| {
        let id = session.sends(json!({ "type": "UAV-SOAR" }));
        session.answers(&id, json!({ "body": { "type": "SYS-CLOSE" } }));
    })
    .also(&[&sys_close_02::RULE.rule]),
]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    if message.body_of("SYS-CLOSE").is_none() {
        return;
    }
    context.covered();
    if message.role != Role::Notification {
        message.violates(context, || Detail::new("a notification must not have `refs`"));
    }
    body::field(message, context, "reason", false, &ExpectedValue::Nullable(&ExpectedValue::Text));
}
