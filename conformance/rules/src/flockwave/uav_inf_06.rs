//! `FW-UAV-INF-06`.

use super::prelude::*;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UAV-INF-06",
    name: "Unknown UAVs",
    level: Level::Info,
    status: Status::Advisory,
    statement: "UAV-INF lists an unknown UAV in `error` instead of refusing the request.",
    source: source::DERIVED,
    applies_to: "UAV-INF requests from a probe that tests this rule",
    why: "If one unknown id fails the whole request, the client does not get the state of any requested UAV.",
    example: r#"→ {"type":"UAV-INF","ids":["uav-9"]}
← {"type":"ACK-NAK","reason":"Unknown UAV: uav-9"}"#,
    fix: "Look up each id separately, and add unknown ids to `error`.",
})
.checks(&[Check::Exchange(|exchange, context| served::in_error(exchange, context, &["UAV-INF"]))])
.bug(Bug::behaviour("An unknown UAV fails the whole request."))
.trial(Trial::Requests(|_| vec![Request::new("", json!({ "type": "UAV-INF", "ids": [trial::UNKNOWN_ID] }))]))
.mutants(&[
    Mutant::refused("the request is refused", "tcp#9"),
    Mutant::connection("the response has a state for an unknown UAV", "tcp#9", |session| {
        let request = json!({ "type": "UAV-INF", "ids": ["nobody"] });
        let status = json!({ "nobody": { "id": "nobody", "timestamp": 1_790_000_000_000_u64 } });
        let reported = json!({ "type": "UAV-INF", "status": status });
        session.tries_and_receives(&RULE.rule, "", request, reported);
    }),
]);
