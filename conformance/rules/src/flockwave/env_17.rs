//! `FW-ENV-17`.

use uavspec_schema::json_type::Direction;

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-17",
    name: "Type of a notification",
    level: Level::Should,
    status: Status::Disputed(
        "The specification text allows UAV-INF, CONN-INF, DEV-INF, CLK-INF and UAV-PREFLT as \
         notifications; the published JSON Schema for notifications does not. This rule allows these \
         notifications.",
    ),
    statement: "If a message from the server has no `refs`, its type is SYS-PING or a type that is \
                allowed for notifications.",
    source: source::GENERAL,
    applies_to: "messages from the server",
    why: "A message of any other type without `refs` is usually a response whose `refs` is missing by \
          mistake. The client cannot match the response to a request, and the request times out.",
    example: r#"{"$fw.version":"1.0","id":"s1","body":{"type":"UAV-LIST","ids":["uav-1"]}}"#,
    fix: "Add `refs` if the message answers a request. Otherwise, do not send the message: only some \
          types may be notifications.",
})
.checks(&[Check::Message(check)])
.bug(Bug::message("Each SYS-VER response is followed by a CONN-LIST that was not requested.", |out| {
    if out.kind() == "SYS-VER" {
        out.follow(None, json!({ "type": "CONN-LIST", "ids": ["radio-1"] }));
    }
}))
.mutants(&[Mutant::session("a response without `refs`", |session| {
    session.notify(json!({ "type": "UAV-LIST", "ids": [] }));
})]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    let defined_schemas = context.definitions.defined_schemas();
    let Some(name) = message.type_name.filter(|name| defined_schemas.has(name)) else { return };
    // FW-ENV-26 reports a `refs` that is null, and FW-ACK-01 reports acknowledgments. The answer to a message without
    // an id has no id to refer to.
    let has_refs = message.role != Role::Notification || message.value.get("refs").is_some();
    if has_refs || message.may_answer_unknown || matches!(name, "ACK-ACK" | "ACK-NAK") {
        return;
    }
    context.covered();
    // The description of OBJ-CMD says that results are sent in notifications of this type.
    if name != "OBJ-CMD" && !defined_schemas.is_defined(name, Direction::Notification) {
        message.violates(context, || {
            Detail::new(format!("{name} cannot be a notification, so it needs `refs`"))
        });
    }
}
