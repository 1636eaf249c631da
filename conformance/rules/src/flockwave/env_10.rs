//! `FW-ENV-10`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-10",
    name: "Body and error exclude each other",
    level: Level::Must,
    status: Status::Normative,
    statement: "A message never has both `body` and `error`.",
    source: source::GENERAL,
    applies_to: "messages from the server",
    why: "The client does not know whether the request succeeded. Different clients may reach different \
          conclusions.",
    example: r#"{"$fw.version":"1.0","id":"s1","refs":"c1","body":{"type":"ACK-ACK"},"error":{"code":7}}"#,
    fix: "Send `body` in normal responses and `error` in failures, never both.",
})
.checks(&[Check::Message(check)])
.bug(Bug::message("SYS-VER has an `error` in addition to its `body`.", |out| {
    if out.kind() == "SYS-VER" {
        out.message()["error"] = json!({ "message": "all is well" });
    }
}))
.mutants(&[Mutant::reply_message("both `body` and `error`", "SYS-VER", |message| {
    message["error"] = json!({ "code": 7 });
})]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    context.covered();
    if ["body", "error"].iter().all(|name| body::is_present(message.value.get(name))) {
        message.violates(context, || Detail::differs("one of `body` and `error`", "both"));
    }
}
