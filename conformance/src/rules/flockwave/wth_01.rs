//! `FW-WTH-01`.

use serde_json::json;

use super::{
    Attribution, Bug, Check, FlockwaveRule, INTEGER, Level, Message, Mutant, Rule, RuleContext, Status,
    attribution, body, mutant, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-WTH-01",
        level: Level::Must,
        status: Status::Disputed(
            "The specification text requires whole milliseconds, and all its examples are integers; most JSON \
             Schemas allow any number. This rule requires an integer.",
        ),
        statement: "The `timestamp` of weather data is an integer number of milliseconds.",
        source: source::TYPES,
        applies_to: "WTH-AT, WTH-INF",
        why: "Clients compute the age of the weather data from this timestamp. If it is in seconds instead of \
              milliseconds, current wind data looks decades old.",
        example: r#"{"type":"WTH-AT","weather":{"position":[475000000,190000000],
  "timestamp":1790000000.25}}"#,
        fix: "Send the Unix time in milliseconds as an integer.",
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
            name: "a WTH-INF timestamp in fractional seconds",
            make: || {
                mutant::reply("WTH-INF", |body| {
                    body["status"]["ridge"]["timestamp"] = 1_790_000_000.25.into();
                })
            },
            also: &[],
        },
        Mutant {
            name: "a WTH-AT timestamp in fractional seconds",
            make: || mutant::reply("WTH-AT", |body| body["weather"]["timestamp"] = 1_790_000_000.25.into()),
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
            &INTEGER,
        );
    }
    if let Some(weather) = message.body_of("WTH-AT").and_then(|body| body.get("weather")) {
        body::member(message, context, Some(weather), &["body", "weather"], ("timestamp", true), &INTEGER);
    }
}
