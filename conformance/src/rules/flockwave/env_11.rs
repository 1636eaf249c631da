//! `FW-ENV-11`.

use super::{
    Bug, Check, Detail, FlockwaveRule, Level, Message, Mutant, Rule, RuleContext, Status, Tree, body, mutant,
    source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-11",
        level: Level::Should,
        status: Status::Disputed(
            "The text has `body` as an object; the published schema also lets it be null.",
        ),
        statement: "A message has `body`, an object, or `error`.",
        source: source::SCHEMA,
        applies_to: "messages of the server",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Message(check)],
    covers: &[],
    bug: Bug::message("Notifications of UAV-INF have neither body nor error.", |out| {
        if out.notification_of("UAV-INF").is_some()
            && let Some(message) = out.message().as_object_mut()
        {
            message.remove("body");
        }
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "neither",
            make: || mutant::reply_message("ACK-ACK", |message| mutant::remove(message, "body")),
            also: &[],
        },
        Mutant {
            name: "a body that is a string",
            make: || mutant::reply_message("ACK-ACK", |message| message["body"] = "fine".into()),
            also: &[],
        },
    ],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    context.covered();
    match message.value.get("body") {
        Some(Tree::Object(_)) => {}
        None | Some(Tree::Null) if body::is_there(message.value.get("error")) => {}
        None => message.violates(context, || Detail::differs("`body` or `error`", "neither")),
        Some(other) => message.violates(context, || Detail::differs("an object", other).at("/body")),
    }
}
