//! `FW-ASY-04`.

use uavspec_flockwave::session::OPERATIONS;

use super::env_18;
use super::prelude::*;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ASY-04",
    name: "Form of a receipt",
    level: Level::Should,
    status: Status::Advisory,
    statement: "A receipt is a string of 1 to 64 characters.",
    source: source::SCHEMA,
    applies_to: "responses with `receipt`",
    why: "Clients send receipts back in ASYNC-CANCEL and ASYNC-RESUME, which accept only strings of 1 to \
          64 characters. With any other value, the operation cannot be cancelled.",
    example: r#"{"type":"UAV-RTH","receipt":{"uav-1":7}}"#,
    fix: "Create a short unique string for each operation, such as a UUID.",
})
.checks(&[Check::Message(check)])
.covers(&[
    Attribution::new(&OPERATIONS, "receipt", &[Fault::Kind]),
    Attribution::new(&OPERATIONS, "receipt.*", attribution::INVALID),
    Attribution::new(&["LOG-DATA"], "receipt", attribution::WRONG),
])
.bug(Bug::behaviour("Receipts are 70 characters long.").also(&[&env_18::RULE.rule]))
.mutants(&[
    Mutant::session("a receipt that is a number", |session| {
        session.exchange(json!({ "type": "UAV-RTH", "ids": ["kite"] }), json!({ "receipt": { "kite": 7 } }));
    }),
    Mutant::session("an empty receipt", |session| {
        session.exchange(json!({ "type": "UAV-RTH", "ids": ["kite"] }), json!({ "receipt": { "kite": "" } }));
    }),
]);

const RECEIPT: ExpectedValue = ExpectedValue::Length(1, 64);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    if message.role != Role::Response || !message.type_name.is_some_and(reply::may_have_receipts) {
        return;
    }
    let receipts = ExpectedValue::Map(&RECEIPT);
    let schema = if message.type_name == Some("LOG-DATA") { &RECEIPT } else { &receipts };
    match message.field("receipt") {
        None | Some(Tree::Null) => {}
        Some(_) => body::field(message, context, "receipt", true, schema),
    }
}
