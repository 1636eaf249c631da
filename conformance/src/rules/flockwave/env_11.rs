//! `FW-ENV-11`.

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, Tree, fw,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-11",
        level: Level::Should,
        status: Status::Disputed(
            "The text has `body` as an object; the published schema also lets it be null.",
        ),
        statement: "A message has `body`, an object, or `error`.",
        source: fw::SCHEMA,
        applies_to: "messages of the server",
    },
    check: Check::Exchange(judge),
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
            make: || fw::reply_message("ACK-ACK", |message| fw::remove(message, "body")),
            also: &[],
        },
        Mutant {
            name: "a body that is a string",
            make: || fw::reply_message("ACK-ACK", |message| message["body"] = "fine".into()),
            also: &[],
        },
    ],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let Some(message) = exchange.message() else { return };
    context.covered();
    match message.get("body") {
        Some(Tree::Object(_)) => {}
        None | Some(Tree::Null) if fw::is_there(message.get("error")) => {}
        None => exchange.breaks(context, || Detail::differs("`body` or `error`", "neither")),
        Some(other) => exchange.breaks(context, || Detail::differs("an object", other).at("/body")),
    }
}
