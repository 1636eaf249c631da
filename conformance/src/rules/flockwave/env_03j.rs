//! `FW-ENV-03J`.

use serde_json::json;

use super::{
    Bug, Check, ExpectedValue, FlockwaveRule, Level, Message, Mutant, Rule, RuleContext, Status, body,
    mutant, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-03J",
        level: Level::Should,
        status: Status::Advisory,
        statement: "`id` of a message has 1 to 36 characters.",
        source: source::SCHEMA,
        applies_to: "messages of the server",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Message(check)],
    covers: &[],
    bug: Bug::message("Ids have 40 characters.", |out| {
        let id = format!("{:0>40}", out.number);
        out.message()["id"] = json!(id);
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "an id of 37 characters",
            make: || mutant::reply_message("SYS-VER", |message| message["id"] = "x".repeat(37).into()),
            also: &[],
        },
        Mutant {
            name: "an empty id",
            make: || mutant::reply_message("SYS-VER", |message| message["id"] = "".into()),
            also: &[],
        },
    ],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    if message.id.is_none() {
        return;
    }
    body::member(message, context, Some(message.value), &[], ("id", true), &ExpectedValue::Length(1, 36));
}
