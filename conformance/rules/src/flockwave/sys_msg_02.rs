//! `FW-SYS-MSG-02`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-SYS-MSG-02",
    name: "Severity of a log message",
    level: Level::Must,
    status: Status::Normative,
    statement: "The `severity` of an item is `debug`, `info`, `warning`, `error` or `critical`.",
    source: source::MESSAGES,
    applies_to: "SYS-MSG",
    why: "Clients use the severity to choose a colour and a sound, and to filter messages. An unknown \
          severity may hide a critical message.",
    example: r#"{"type":"SYS-MSG","items":[{"message":"Battery low","severity":"fatal"}]}"#,
    fix: "Map internal log levels to the five severities, or omit `severity` if it is `info`.",
})
.checks(&[Check::Message(check)])
.covers(&[Attribution::new(&["SYS-MSG"], "items.*.severity", attribution::WRONG)])
.bug(Bug::message("The severity of SYS-MSG items is `loud`.", |out| {
    if let Some(item) = out.item() {
        item.insert("severity".to_owned(), json!("loud"));
    }
}))
.mutants(&[Mutant::notice("an unknown severity", "SYS-MSG", |body| {
    body["items"][0]["severity"] = "loud".into();
})]);

const SEVERITY: ExpectedValue =
    ExpectedValue::Nullable(&ExpectedValue::OneOf(&["debug", "info", "warning", "error", "critical"]));

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    let Some(Tree::List(items)) = message.body_of("SYS-MSG").and_then(|body| body.get("items")) else {
        return;
    };
    for (at, item) in items.iter().enumerate() {
        let keys = ["body", "items", &at.to_string()];
        body::member(message, context, Some(item), &keys, ("severity", false), &SEVERITY);
    }
}
