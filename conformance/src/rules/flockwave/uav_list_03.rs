//! `FW-UAV-LIST-03`.

use serde_json::{Value, json};

use super::{Bug, Check, FlockwaveRule, Level, Mutant, Rule, Status, listed_uavs, mutant, source};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UAV-LIST-03",
        level: Level::Info,
        status: Status::Advisory,
        statement: "UAV-INF knows each UAV that UAV-LIST lists.",
        source: source::DERIVED,
        applies_to: "UAV-LIST and UAV-INF over time",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Session(|| Box::new(listed_uavs::Unknown::default()))],
    covers: &[],
    bug: Bug::message("Lists have a UAV that UAV-INF doesn't know.", |out| {
        let has_uavs = match out.kind() {
            "UAV-LIST" => true,
            "OBJ-LIST" => {
                let filter = out.request.and_then(|body| body.get("filter")).and_then(Value::as_array);
                filter.is_none_or(|kinds| kinds.contains(&json!("uav")))
            }
            _ => false,
        };
        if has_uavs && let Some(ids) = out.message()["body"]["ids"].as_array_mut() {
            ids.push(json!("wraith-1"));
        }
    }),
    trial: None,
    mutants: &[Mutant {
        name: "one that it doesn't know",
        make: || {
            mutant::over("tcp#9", |session| {
                listed_uavs::listed_twice(session, |session| {
                    let error = json!({ "error": { "kite": "No such glider" } });
                    session.exchange(json!({ "type": "UAV-INF", "ids": ["kite"] }), error);
                });
            })
        },
        also: &[],
    }],
};
