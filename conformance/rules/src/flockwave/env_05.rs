//! `FW-ENV-05`.
//!
//! A server may copy an id that is not a string from a malformed request. `FW-ENV-06` checks the value of a string.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-05",
    name: "Type of refs",
    level: Level::Should,
    status: Status::Advisory,
    statement: "The `refs` field of a message, if present, is a string.",
    source: source::GENERAL,
    applies_to: "messages from the server",
    why: "`refs` distinguishes responses from notifications. If `refs` is not a string, a client cannot \
          find the request.",
    example: r#"{"$fw.version":"1.0","id":"s1","refs":7,"body":{"type":"OBJ-DEL","ids":["uav-1"]}}"#,
    fix: "In responses, copy the `id` of the request to `refs`. In notifications, omit `refs`.",
})
.checks(&[Check::Exchange(check)])
.bug(Bug::message("The `refs` of UAV-INF notifications is a number.", |out| {
    if out.notification_of("UAV-INF").is_some() {
        out.message()["refs"] = json!(7);
    }
}))
.mutants(&[Mutant::session("`refs` that is a number", |session| {
    session.notify(json!({ "type": "CONN-INF" }));
    if let Some(line) = session.lines.last_mut() {
        line["msg"]["refs"] = json!(7);
    }
})]);

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let Some(refs) = exchange.message().and_then(|message| message.get("refs")) else { return };
    context.covered();
    // FW-ENV-26 reports null.
    if matches!(refs, Tree::Text(_) | Tree::Null) || exchange.reference == Reference::Unclear {
        return;
    }
    exchange.violates(context, || Detail::differs("a string", refs).at("/refs"));
}
