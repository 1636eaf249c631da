//! `FW-UAV-INF-07`.

use serde_json::json;

use super::{
    Bug, Check, FlockwaveRule, Level, Mutant, Request, Rule, Status, Trial, listed_uavs, mutant, source,
};

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UAV-INF-07",
        level: Level::Info,
        status: Status::Advisory,
        statement: "UAV-INF accepts a request with no ids, or with the same id twice.",
        source: source::DERIVED,
        applies_to: "UAV-INF requests from a probe that tests this rule",
        why: "Clients build the list from a selection, which may be empty or contain duplicates. If the request is \
              refused, the operator sees an error for no reason.",
        example: r#"→ {"type":"UAV-INF","ids":[]}
← {"type":"ACK-NAK","reason":"No ids"}"#,
        fix: "Answer an empty list with an empty `status`, and handle a repeated id only once.",
    },
    checks: &[Check::Session(|| Box::new(listed_uavs::Unknown::to_repeated_ids()))],
    covers: &[],
    bug: Bug::behaviour("Requests with no ids or with a repeated id fail."),
    trial: Some(Trial::Requests(requests)),
    mutants: &[
        Mutant { name: "the request is refused", make: || mutant::refused("tcp#9", &RULE.rule), also: &[] },
        Mutant {
            name: "a repeated id is reported as unknown",
            make: || {
                let request = json!({ "type": "UAV-INF", "ids": ["kite", "kite"] });
                let error = json!({ "type": "UAV-INF", "error": { "kite": "Again" } });
                mutant::over("tcp#9", |session| {
                    listed_uavs::listed_twice(session, |session| {
                        session.tries_and_receives(&RULE.rule, "", request, error);
                    });
                })
            },
            also: &[],
        },
    ],
};

fn requests(uavs: &[String]) -> Vec<Request> {
    let mut requests = vec![Request::new("no ids", json!({ "type": "UAV-INF", "ids": [] }))];
    if let Some(first) = uavs.first() {
        requests.push(Request::new("an id twice", json!({ "type": "UAV-INF", "ids": [first, first] })));
    }
    requests
}
