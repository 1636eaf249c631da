//! `FW-ENV-02`.

use serde_json::json;

use super::{
    Bug, Check, ExpectedValue, FlockwaveRule, Level, Message, Mutant, Rule, RuleContext, Status, body,
    mutant, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-02",
        level: Level::Must,
        status: Status::Normative,
        statement: "`$fw.version` of a message is a string.",
        source: source::GENERAL,
        applies_to: "messages of the server",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Message(check)],
    covers: &[],
    bug: Bug::message("The version of the protocol is a number.", |out| {
        out.message()["$fw.version"] = json!(1);
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "no version",
            make: || mutant::reply_message("SYS-VER", |message| mutant::remove(message, "$fw.version")),
            also: &[],
        },
        Mutant {
            name: "a number",
            make: || mutant::reply_message("SYS-VER", |message| message["$fw.version"] = 1.into()),
            also: &[],
        },
    ],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    body::member(message, context, Some(message.value), &[], ("$fw.version", true), &ExpectedValue::Text);
}
