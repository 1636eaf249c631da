//! `FW-WTH-01`.

use serde_json::json;

use super::{
    Attribution, Bug, Check, ExpectedValue, FlockwaveRule, Level, Message, Mutant, Rule, RuleContext, Status,
    Tree, attribution, body, mutant, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-WTH-01",
        name: "Time of weather data",
        level: Level::Must,
        status: Status::Normative,
        statement: "The `timestamp` of weather data is a number of milliseconds.",
        source: source::TYPES,
        applies_to: "WTH-AT, WTH-INF",
        why: "Clients compute the age of the weather data from this timestamp. Without a valid timestamp, \
              old wind data looks current.",
        example: r#"{"type":"WTH-AT","weather":{"position":[475000000,190000000],
  "timestamp":"12:30:00"}}"#,
        fix: "Send the Unix time in milliseconds as a number.",
    },
    checks: &[Check::Message(check)],
    covers: &[
        Attribution::new(&["WTH-AT"], "weather", attribution::MISSING),
        Attribution::new(&["WTH-AT"], "weather.timestamp", attribution::MISSING),
        Attribution::new(&["WTH-INF"], "status.*", attribution::MISSING),
        Attribution::new(&["WTH-INF"], "status.*.timestamp", attribution::MISSING),
    ],
    bug: Bug::message("The `timestamp` of weather data is a string.", |out| {
        out.each_status("WTH-INF", |status| status["timestamp"] = json!("noon"));
        if let Some(body) = out.body_of("WTH-AT") {
            body["weather"]["timestamp"] = json!("noon");
        }
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "a WTH-INF timestamp that is a string",
            make: || {
                mutant::reply("WTH-INF", |body| {
                    body["status"]["ridge"]["timestamp"] = "noon".into();
                })
            },
            also: &[],
        },
        Mutant {
            name: "a missing WTH-AT timestamp",
            make: || mutant::reply("WTH-AT", |body| mutant::remove(&mut body["weather"], "timestamp")),
            also: &[],
        },
    ],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    for (key, weather) in body::states(message, "WTH-INF") {
        body::member(
            message,
            context,
            Some(weather),
            &["body", "status", key],
            ("timestamp", true),
            &ExpectedValue::Number,
        );
    }
    // FW-ENV-26 reports null.
    let weather = message.body_of("WTH-AT").and_then(|body| body.get("weather"));
    if let Some(weather) = weather.filter(|weather| **weather != Tree::Null) {
        body::member(
            message,
            context,
            Some(weather),
            &["body", "weather"],
            ("timestamp", true),
            &ExpectedValue::Number,
        );
    }
}
