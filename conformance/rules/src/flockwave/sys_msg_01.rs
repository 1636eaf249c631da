//! `FW-SYS-MSG-01`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-SYS-MSG-01",
    name: "Fields of SYS-MSG",
    level: Level::Must,
    status: Status::Normative,
    statement: "`items` is a list, and each item has a string `message`.",
    source: source::MESSAGES,
    applies_to: "SYS-MSG",
    why: "Clients show these messages to the operator. Without text, a warning goes unnoticed.",
    example: r#"{"type":"SYS-MSG","items":[{"severity":"error"}]}"#,
    fix: "Send `items` as a list of objects, even for one message, and give each item a string `message`.",
})
.checks(&[Check::Message(check)])
.covers(&[
    Attribution::new(&["SYS-MSG"], "items", attribution::MISSING),
    Attribution::new(&["SYS-MSG"], "items.*", attribution::MISSING),
    Attribution::new(&["SYS-MSG"], "items.*.message", attribution::MISSING),
])
.bug(Bug::message("Items of SYS-MSG have no `message`.", |out| {
    if let Some(item) = out.item() {
        item.remove("message");
    }
}))
.mutants(&[
    Mutant::notice("an item without a message", "SYS-MSG", |body| {
        body["items"][0] = json!({ "severity": "info" });
    }),
    Mutant::notice("`items` is not a list", "SYS-MSG", |body| body["items"] = "Thermals".into()),
]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    if message.body_of("SYS-MSG").is_none() {
        return;
    }
    body::field(message, context, "items", true, &ExpectedValue::List(&ExpectedValue::Object));
    if let Some(Tree::List(items)) = message.field("items") {
        for (at, item) in items.iter().enumerate().filter(|(_, item)| matches!(item, Tree::Object(_))) {
            let keys = ["body", "items", &at.to_string()];
            body::member(message, context, Some(item), &keys, ("message", true), &ExpectedValue::Text);
        }
    }
}
