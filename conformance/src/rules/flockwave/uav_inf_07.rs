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
        statement: "UAV-INF serves a request without ids, and one that has an id twice.",
        source: source::DERIVED,
        applies_to: "UAV-INF that tries it",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Session(|| Box::new(listed_uavs::Unknown::to_repeated_ids()))],
    covers: &[],
    bug: Bug::behaviour("Requests with no ids, or with an id twice, fail."),
    trial: Some(Trial::Requests(requests)),
    mutants: &[
        Mutant { name: "the request is refused", make: || mutant::refused("tcp#9", &RULE.rule), also: &[] },
        Mutant {
            name: "a UAV that is asked for twice isn't known",
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
