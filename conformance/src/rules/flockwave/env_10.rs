//! `FW-ENV-10`.

use serde_json::json;

use super::{
    Bug, Check, Detail, FlockwaveRule, Level, Message, Mutant, Rule, RuleContext, Status, body, mutant,
    source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-10",
        level: Level::Must,
        status: Status::Normative,
        statement: "A message never has both `body` and `error`.",
        source: source::GENERAL,
        applies_to: "messages of the server",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Message(check)],
    covers: &[],
    bug: Bug::message("Beside its body SYS-VER has an error.", |out| {
        if out.kind() == "SYS-VER" {
            out.message()["error"] = json!({ "message": "all is well" });
        }
    }),
    trial: None,
    mutants: &[Mutant {
        name: "both",
        make: || mutant::reply_message("SYS-VER", |message| message["error"] = json!({ "code": 7 })),
        also: &[],
    }],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    context.covered();
    if ["body", "error"].iter().all(|name| body::is_there(message.value.get(name))) {
        message.violates(context, || Detail::differs("one of `body` and `error`", "both"));
    }
}
