//! `FW-OBJ-DEL-01`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-OBJ-DEL-01",
    name: "Fields of OBJ-DEL",
    level: Level::Must,
    status: Status::Normative,
    statement: "OBJ-DEL is a notification with `ids`, a list of strings.",
    source: source::MESSAGES,
    applies_to: "OBJ-DEL",
    why: "The client does not know which objects are gone, and keeps showing UAVs that no longer exist.",
    example: r#"{"type":"OBJ-DEL","ids":"uav-1"}"#,
    fix: "Send OBJ-DEL without `refs`. Send `ids` as a list of strings, even if there is only one id.",
})
.checks(&[Check::Message(check)])
.covers(&[
    Attribution::new(&["OBJ-DEL"], "ids", attribution::MISSING),
    Attribution::new(&["OBJ-DEL"], "ids.*", attribution::MISSING),
])
.bug(Bug::message("The `ids` field of OBJ-DEL is a string.", |out| out.replace_ids_by_first("OBJ-DEL")))
.mutants(&[
    Mutant::notice("missing `ids`", "OBJ-DEL", |body| *body = json!({ "type": "OBJ-DEL" })),
    Mutant::session("OBJ-DEL as a response", |session| {
        let id = session.sends(json!({ "type": "UAV-SOAR" }));
        session.answers(&id, json!({ "body": { "type": "OBJ-DEL", "ids": ["vane"] } }));
    }),
]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    if message.body_of("OBJ-DEL").is_none() {
        return;
    }
    context.covered();
    if message.role != Role::Notification {
        message.violates(context, || Detail::new("a notification must not have `refs`"));
    }
    body::id_list(message, context, "OBJ-DEL");
}
