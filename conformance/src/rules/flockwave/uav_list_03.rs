//! `FW-UAV-LIST-03`.

use serde_json::{Value, json};

use super::{Bug, Check, FlockwaveRule, Level, Mutant, Rule, Status, listed_uavs, mutant, source};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UAV-LIST-03",
        level: Level::Info,
        status: Status::Advisory,
        statement: "UAV-INF returns the state of each UAV that UAV-LIST contains.",
        source: source::DERIVED,
        applies_to: "UAV-LIST and UAV-INF over time",
        why: "Clients list the UAVs and then query their states. If UAV-INF reports a UAV as unknown, the UAV stays on \
              the display without a position.",
        example: r#"→ {"type":"UAV-LIST"}
← {"type":"UAV-LIST","ids":["uav-1"]}
→ {"type":"UAV-INF","ids":["uav-1"]}
← {"type":"UAV-INF","error":{"uav-1":"Unknown UAV"}}
→ {"type":"UAV-LIST"}
← {"type":"UAV-LIST","ids":["uav-1"]}"#,
        fix: "Use the same registry for UAV-LIST and UAV-INF. Return the last known state of a UAV, even if it is \
              old.",
    },
    checks: &[Check::Session(|| Box::new(listed_uavs::Unknown::default()))],
    covers: &[],
    bug: Bug::message("UAV-LIST and OBJ-LIST contain a UAV that UAV-INF reports as unknown.", |out| {
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
        name: "an unknown UAV in the list",
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
