//! `FW-UAV-INF-05`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UAV-INF-05",
    name: "Fields of a status report",
    level: Level::Should,
    status: Status::Normative,
    statement: "A UAV-INF notification has no fields other than `type` and `status`.",
    source: source::MESSAGES,
    applies_to: "UAV-INF",
    why: "Clients do not expect errors in a notification, and drop them. The operator never learns about \
          the problem.",
    example: r#"{"type":"UAV-INF","status":{},"error":{"uav-9":"Connection lost"}}"#,
    fix: "Send only `status`. Report problems in the `errors` of a UAV. Report lost UAVs with OBJ-DEL.",
})
.checks(&[Check::Message(check)])
.bug(Bug::message("UAV-INF notifications have an `error`.", |out| {
    if let Some(body) = out.notification_of("UAV-INF") {
        body["error"] = json!({ "ghost-1": "there is no such UAV" });
    }
}))
.mutants(&[Mutant::notice("a notification with `error`", "UAV-INF", |body| {
    body["error"] = json!({ "owl": "Lost" });
})]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    let Some(Tree::Object(members)) = message.notification("UAV-INF") else { return };
    context.covered();
    if let Some((key, _)) = members.iter().find(|(key, _)| key != "type" && key != "status") {
        message.violates(context, || {
            Detail::new(format!("unexpected field {}", body::quoted(key))).at(pointer(&["body", key]))
        });
    }
}
