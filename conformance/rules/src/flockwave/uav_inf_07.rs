//! `FW-UAV-INF-07`.

use super::prelude::*;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UAV-INF-07",
    name: "Request without ids",
    level: Level::Info,
    status: Status::Advisory,
    statement: "UAV-INF accepts a request with no ids.",
    source: source::DERIVED,
    applies_to: "UAV-INF requests from a probe that tests this rule",
    why: "Clients build the list from a selection, which may be empty. If the request is refused, the \
          operator sees an error for no reason.",
    example: r#"→ {"type":"UAV-INF","ids":[]}
← {"type":"ACK-NAK","reason":"No ids"}"#,
    fix: "Answer an empty list with an empty `status`.",
})
.checks(&[Check::Exchange(served::check)])
.bug(Bug::behaviour("Requests with no ids fail."))
.trial(Trial::Requests(requests))
.mutants(&[Mutant::refused("the request is refused", "tcp#9")]);

/// A repeated id is not tested: the definition requires unique ids, so a server may refuse them.
fn requests(_: &[String]) -> Vec<Request> {
    vec![Request::new("no ids", json!({ "type": "UAV-INF", "ids": [] }))]
}
