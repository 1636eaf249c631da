//! `FW-WTH-01`.

use super::prelude::*;
use super::val_01;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-WTH-01",
    name: "Time of weather data",
    level: Level::Must,
    status: Status::Normative,
    statement: "The `timestamp` of weather data is an integer number of milliseconds since 1970. The \
                time is from 2001 to 2099.",
    source: source::TYPES,
    applies_to: "WTH-AT, WTH-INF",
    why: "Clients compute the age of the weather data from this timestamp. Without a valid timestamp, old \
          wind data looks current. With a timestamp in seconds, current data looks decades old.",
    example: r#"{"type":"WTH-AT","weather":{"position":[475000000,190000000],
  "timestamp":1790000000.5}}"#,
    fix: "Send the Unix time in milliseconds as an integer.",
})
.checks(&[Check::Message(check)])
.covers(&[
    Attribution::new(&["WTH-AT"], "weather", attribution::MISSING),
    Attribution::new(&["WTH-AT"], "weather.timestamp", attribution::INVALID),
    Attribution::new(&["WTH-INF"], "status.*", attribution::MISSING),
    Attribution::new(&["WTH-INF"], "status.*.timestamp", attribution::INVALID),
])
.bug(Bug::message("The `timestamp` of weather data is in seconds.", |out| {
    let to_seconds = |weather: &mut Value| {
        let milliseconds = weather["timestamp"].as_f64().unwrap_or_default();
        weather["timestamp"] = json!(milliseconds / 1000.0);
    };
    out.each_status("WTH-INF", to_seconds);
    if let Some(body) = out.body_of("WTH-AT") {
        to_seconds(&mut body["weather"]);
    }
}))
.mutants(&[
    Mutant::reply("a WTH-INF timestamp that is a string", "WTH-INF", |body| {
        body["status"]["ridge"]["timestamp"] = "noon".into();
    }),
    Mutant::reply("a WTH-INF timestamp in seconds", "WTH-INF", |body| {
        body["status"]["ridge"]["timestamp"] = 1_790_000_000.into();
    }),
    Mutant::reply("a WTH-AT timestamp in seconds with a fraction", "WTH-AT", |body| {
        body["weather"]["timestamp"] = json!(1_790_000_000.5);
    }),
    Mutant::reply("a WTH-AT timestamp in milliseconds with a fraction", "WTH-AT", |body| {
        body["weather"]["timestamp"] = json!(1_790_000_000_000.5);
    }),
    Mutant::reply("a missing WTH-AT timestamp", "WTH-AT", |body| {
        mutant::remove(&mut body["weather"], "timestamp");
    }),
]);

/// The subject of all findings. Both message types share it, because the same clock sets their timestamps.
const SUBJECT: &str = "Weather.timestamp";

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    for (key, weather) in body::states(message, "WTH-INF") {
        check_timestamp(message, context, weather, &["body", "status", key, "timestamp"]);
    }
    // FW-ENV-26 reports null.
    let weather = message.body_of("WTH-AT").and_then(|body| body.get("weather"));
    if let Some(weather) = weather.filter(|weather| **weather != Tree::Null) {
        check_timestamp(message, context, weather, &["body", "weather", "timestamp"]);
    }
}

/// Checks the timestamp of weather data at a path.
fn check_timestamp(message: &Message<'_>, context: &mut RuleContext<'_>, weather: &Tree<'_>, path: &[&str]) {
    context.covered();
    let found = weather.get("timestamp");
    let is_valid = |found: &Tree<'_>| found.as_integer().is_some() && val_01::is_within(found, val_01::TIMES);
    if found.is_some_and(is_valid) {
        return;
    }
    message.violates_as(SUBJECT, context, || {
        let found = found.map_or_else(|| "nothing".to_owned(), ToString::to_string);
        Detail::differs("an integer number of milliseconds since 1970, from 2001 to 2099", found)
            .at(pointer(path))
    });
}
