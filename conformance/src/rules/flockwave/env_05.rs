//! `FW-ENV-05`.

use serde_json::Value;

use super::{
    Bug, Check, ExpectedValue, FlockwaveRule, Level, Message, Mutant, Rule, RuleContext, Session, Status,
    body, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-05",
        level: Level::Should,
        status: Status::Advisory,
        statement: "The `refs` field of a message, if present, is a string of 1 to 36 characters.",
        source: source::SCHEMA,
        applies_to: "messages from the server",
        why: "`refs` distinguishes responses from notifications. If `refs` is null or empty, a client may treat a \
              notification as a response, or reject the notification.",
        example: r#"{"$fw.version":"1.0","id":"s1","refs":null,"body":{"type":"OBJ-DEL","ids":["uav-1"]}}"#,
        fix: "In responses, copy the `id` of the request to `refs`. In notifications, omit `refs`; do not send null.",
    },
    checks: &[Check::Message(check)],
    covers: &[],
    bug: Bug::message("The `refs` of notifications is null.", |out| {
        if out.is_notification() {
            out.message()["refs"] = Value::Null;
        }
    }),
    trial: None,
    mutants: &[Mutant {
        name: "`refs` of 37 characters",
        make: || {
            let session = Session::new();
            let id = || "x".repeat(37);
            let session = session.request("SYS-VER", |message| message["id"] = id().into())?;
            Some(session.reply_message("SYS-VER", |message| message["refs"] = id().into())?.to_bytes())
        },
        also: &[],
    }],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    body::member(message, context, Some(message.value), &[], ("refs", false), &ExpectedValue::Length(1, 36));
}
