//! `FW-ENV-05I`.

use uavspec_flockwave::record::Direction;

use super::prelude::*;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-05I",
    name: "Invalid ids are not copied",
    level: Level::Info,
    status: Status::Advisory,
    statement: "If the `id` of a request is not a string, the server does not copy it to `refs`.",
    source: source::DERIVED,
    applies_to: "responses to requests whose `id` is not a string",
    why: "`refs` must be a string. A client with generated types can't decode the refusal, so its \
          developer doesn't learn what is wrong with the request.",
    example: r#"→ {"$fw.version":"1.0","id":17,"body":{"type":"SYS-PING"}}
← {"$fw.version":"1.0","id":"s1","refs":17,"body":{"type":"ACK-NAK","reason":"Invalid id"}}"#,
    fix: "Check the `id` of a request before using it. Send the refusal without `refs`.",
})
.checks(&[Check::Exchange(check)])
.bug(Bug::behaviour("An id that is not a string is copied to `refs`."))
.mutants(&[
    Mutant::connection("`refs` that copies a number", "tcp#9", |session| copies(session, &json!(17))),
    Mutant::connection("`refs` that copies null", "tcp#9", |session| copies(session, &json!(null))),
]);

/// Adds a request that has an invalid id, and its refusal with the same id in `refs`.
fn copies(session: &mut Session, id: &Value) {
    let request = json!({ "$fw.version": "1.0", "id": id, "body": { "type": "SYS-PING" } });
    session.line("out", request);
    let refusal = json!({ "type": "ACK-NAK", "reason": "Invalid id" });
    let answer = json!({ "$fw.version": "1.0", "id": "odd-1", "refs": id, "body": refusal });
    session.line("in", answer);
}

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let is_request = exchange.role == Role::Request && exchange.record.direction == Direction::Out;
    let id = exchange.record.value.and_then(|message| message.get("id"));
    if is_request && id.is_some_and(|id| id.as_str().is_none()) {
        context.covered();
    }
    let copy = exchange.message().and_then(|message| message.get("refs")).filter(|_| exchange.copies_id);
    if let Some(refs) = copy {
        exchange.violates(context, || Detail::differs("no copy of an invalid id", refs).at("/refs"));
    }
}
