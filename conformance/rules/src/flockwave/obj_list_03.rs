//! `FW-OBJ-LIST-03`.

use super::prelude::*;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-OBJ-LIST-03",
    name: "Filter with an unknown type",
    level: Level::Should,
    status: Status::Normative,
    statement: "For an unknown object type in `filter`, OBJ-LIST returns an empty list.",
    source: source::MESSAGES,
    applies_to: "OBJ-LIST requests from a probe that tests this rule",
    why: "Extensions add object types, so clients ask for types that this server does not know. To them, \
          a refusal looks like a failure, and a list of all objects looks like a match.",
    example: r#"→ {"type":"OBJ-LIST","filter":["cloud"]}
← {"type":"ACK-NAK","reason":"Unknown object type: cloud"}"#,
    fix: "Do not validate the types in `filter`. Return the matching objects, or an empty list if the \
          type is unknown.",
})
.checks(&[Check::Exchange(check)])
.bug(Bug::behaviour("OBJ-LIST refuses unknown object types."))
.trial(Trial::Requests(|_| vec![Request::new("", json!({ "type": "OBJ-LIST", "filter": ["unknown-type"] }))]))
.mutants(&[
    Mutant::refused("the request is refused", "tcp#9"),
    Mutant::connection("all objects are listed", "tcp#9", |session| {
        let request = json!({ "type": "OBJ-LIST", "filter": ["cloud"] });
        let all = json!({ "type": "OBJ-LIST", "ids": ["kite", "swift"] });
        session.tries_and_receives(&RULE.rule, "", request, all);
    }),
]);

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if !served::served(exchange, context) || exchange.response("OBJ-LIST").is_none() {
        return;
    }
    if let Some(Tree::List(ids)) = exchange.field("ids")
        && !ids.is_empty()
    {
        exchange.violates(context, || {
            Detail::differs("an empty list", format!("{} ids", ids.len())).at("/body/ids")
        });
    }
}
