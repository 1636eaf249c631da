//! `FW-ASY-20J`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ASY-20J",
    name: "Unique ids in ASYNC-TIMEOUT",
    level: Level::Should,
    status: Status::Advisory,
    statement: "The `ids` of ASYNC-TIMEOUT are unique.",
    source: source::SCHEMA,
    applies_to: "ASYNC-TIMEOUT",
    why: "The JSON Schema requires unique items. A client may reject the message or handle the same \
          timeout twice.",
    example: r#"{"type":"ASYNC-TIMEOUT","ids":["r2","r2"]}"#,
    fix: "Remove duplicate receipts before you send the list.",
})
.checks(&[Check::Message(check)])
.covers(&[Attribution::new(&["ASYNC-TIMEOUT"], "ids", &[Fault::Value])])
.bug(Bug::message("ASYNC-TIMEOUT lists its receipt twice.", |out| out.repeat_first_id("ASYNC-TIMEOUT")))
.mutants(&[Mutant::session("a duplicate id", |session| {
    session
        .exchange(json!({ "type": "UAV-RTH", "ids": ["kite"] }), json!({ "receipt": { "kite": "rcpt-8" } }));
    session.notify(json!({ "type": "ASYNC-TIMEOUT", "ids": ["rcpt-8", "rcpt-8"] }));
})]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    if message.body_of("ASYNC-TIMEOUT").is_some() {
        body::unique(message, context, "ids");
    }
}
