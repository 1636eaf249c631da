//! `FW-ENV-17`.

use serde_json::json;

use uavspec_codegen::schema::json_type::Direction;

use super::{
    Bug, Check, Detail, FlockwaveRule, Level, Message, Mutant, Role, Rule, RuleContext, Status, mutant,
    source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-17",
        level: Level::Must,
        status: Status::Disputed(
            "The published schema of notifications lacks UAV-INF, CONN-INF and DEV-INF, which the text allows; CLK-INF and UAV-PREFLT stand as the text has them.",
        ),
        statement: "A message of the server without `refs` is of a type that may be a notification, or a SYS-PING.",
        source: source::GENERAL,
        applies_to: "messages of the server",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Message(check)],
    covers: &[],
    bug: Bug::message("A CONN-LIST that nobody asked for follows each SYS-VER.", |out| {
        if out.kind() == "SYS-VER" {
            out.follow(None, json!({ "type": "CONN-LIST", "ids": ["radio-1"] }));
        }
    }),
    trial: None,
    mutants: &[Mutant {
        name: "an answer without `refs`",
        make: || mutant::then(|session| session.notify(json!({ "type": "UAV-LIST", "ids": [] }))),
        also: &[],
    }],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    let defined_schemas = context.definitions.defined_schemas();
    let Some(name) = message.type_name.filter(|name| defined_schemas.has(name)) else { return };
    if message.role != Role::Notification {
        return;
    }
    context.covered();
    if !defined_schemas.is_defined(name, Direction::Notification) {
        message.violates(context, || Detail::new(format!("{name} has no `refs`, and it is no notification")));
    }
}
