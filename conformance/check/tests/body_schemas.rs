//! Tests of body schemas: each deviation from the definitions is reported by exactly one rule.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

use serde_json::{Value, json};
use uavspec_check::check_capture;
use uavspec_emit::vectors;
use uavspec_flockwave::body_schema::Deviation;
use uavspec_model::json::Tree;
use uavspec_rules::definitions::Definitions;
use uavspec_rules::flockwave::attributed;
use uavspec_schema::json_type::Direction;
use uavspec_test_support::extent;

static DEFINITIONS: LazyLock<Definitions> = LazyLock::new(Definitions::built_in);

/// A message body for one direction, with its expected validity.
struct Vector {
    type_name: String,
    direction: Direction,
    description: String,
    body: Value,
    is_valid: bool,
}

/// The vectors of all messages.
static VECTORS: LazyLock<Vec<Vector>> = LazyLock::new(vectors);

fn vectors() -> Vec<Vector> {
    let files = vectors::emit(&DEFINITIONS.schema, &vectors::Options::default());
    let mut found = Vec::new();
    for message in &DEFINITIONS.schema.json_messages {
        for part in &message.parts {
            let name = format!("flockwave/{}.json", part.name);
            let is_its = |path: &str| path.contains("json-schema-test-suite") && path.ends_with(&name);
            let file = files.iter().find(|file| is_its(&file.path)).expect("a file of vectors");
            let groups: Vec<Value> = serde_json::from_str(&file.text).expect("JSON");
            for test in groups.iter().flat_map(|group| group["tests"].as_array().expect("tests")) {
                found.push(Vector {
                    type_name: message.name.clone(),
                    direction: part.direction,
                    description: test["description"].as_str().expect("a text").to_owned(),
                    body: test["data"].clone(),
                    is_valid: test["valid"].as_bool().expect("a verdict"),
                });
            }
        }
    }
    found
}

fn deviations(type_name: &str, direction: Direction, body: &Value) -> Vec<Deviation> {
    let text = body.to_string();
    let tree = Tree::read(&text).expect("JSON");
    DEFINITIONS.body_schemas().deviations(type_name, direction, &tree).expect("a shape")
}

/// The vectors and the body check must agree: the generated schemas and test vectors are independent of the body check.
#[test]
fn agrees_with_the_vectors_on_valid_bodies() {
    assert!(VECTORS.len() > 2_000, "{}", VECTORS.len());
    let mut wrong = Vec::new();
    for Vector { type_name, direction, description, body, is_valid } in &*VECTORS {
        let found = deviations(type_name, *direction, body);
        if found.is_empty() != *is_valid {
            wrong.push(format!("{type_name} {direction}, {description}: {found:?}"));
        }
    }
    assert_eq!(wrong, Vec::<String>::new());
}

/// The locations of all values, as JSON pointers.
fn places(value: &Value, at: &str, places: &mut Vec<String>) {
    let mut inner = |key: &str, value: &Value| {
        let at = format!("{at}/{}", key.replace('~', "~0").replace('/', "~1"));
        self::places(value, &at, places);
        places.push(at);
    };
    match value {
        Value::Array(values) => {
            values.iter().enumerate().for_each(|(key, value)| inner(&key.to_string(), value));
        }
        Value::Object(members) => members.iter().for_each(|(key, value)| inner(key, value)),
        _ => {}
    }
}

/// Copies of a body, each with one small change.
fn changed(body: &Value) -> Vec<Value> {
    let mut found = Vec::new();
    let mut all = Vec::new();
    places(body, "", &mut all);
    for location in all.iter().filter(|location| *location != "/type") {
        for other in
            [json!(null), json!(7.25), json!(-7), json!("x/"), json!(""), json!([]), json!({}), json!(true)]
        {
            let mut body = body.clone();
            *body.pointer_mut(location).expect("a place") = other;
            found.push(body);
        }
        let (holder, key) = location.rsplit_once('/').expect("a key");
        let mut body = body.clone();
        if let Some(Value::Object(members)) = body.pointer_mut(holder) {
            members.remove(key);
            members.insert("flaps".to_owned(), 7.into());
            found.push(body);
        }
    }
    found
}

/// The locations of findings in a body, by rule.
fn found(direction: Direction, body: &Value) -> BTreeMap<&'static str, BTreeSet<String>> {
    let mut message = json!({ "$fw.version": "1.0", "id": "say-1", "body": body });
    if direction == Direction::Response {
        message["refs"] = "ask-1".into();
    }
    let line = json!({ "dir": "in", "msg": message }).to_string();
    let result = check_capture(line.as_bytes(), None, &DEFINITIONS).expect("a line");
    let mut found: BTreeMap<_, BTreeSet<String>> = BTreeMap::new();
    for group in result.findings.groups() {
        let places = group.examples.iter().map(|(_, detail)| detail.path.clone());
        found.entry(group.rule.id).or_default().extend(places);
    }
    found
}

/// A deviation is reported by its specific rule, or by `FW-ENV-18` if it has no specific rule.
#[test]
fn reports_each_deviation_once() {
    let (mut own, mut rest, mut number) = (0, 0, 0_usize);
    // Even the larger step of quick mode includes each kind of change.
    let step = extent(1, 37);
    let typical = VECTORS.iter().filter(|vector| vector.description.starts_with("typical"));
    for Vector { type_name, direction, body, .. } in typical {
        let direction = *direction;
        if direction == Direction::Request {
            continue;
        }
        // A body with all fields violates the rules on mutually exclusive fields.
        let before = found(direction, body);
        for body in changed(body) {
            number += 1;
            if !number.is_multiple_of(step) {
                continue;
            }
            let (deviations, found) = (deviations(type_name, direction, &body), found(direction, &body));
            let reported = found.get("FW-ENV-18").cloned().unwrap_or_default();
            let expected = deviations.iter().filter(|deviation| attributed(type_name, deviation).is_none());
            let expected: BTreeSet<String> = expected.map(|one| one.mismatch.path.clone()).collect();
            assert!(
                reported.is_subset(&expected) && reported.is_empty() == expected.is_empty(),
                "{body}: {found:?}"
            );
            for deviation in &deviations {
                let Some(rule) = attributed(type_name, deviation).map(|rule| rule.id) else { continue };
                assert!(found.contains_key(rule), "{rule} must report {deviation:?} in {body}: {found:?}");
                own += 1;
            }
            let is_new = |rule: &&str| *rule != "FW-ENV-18" && !before.contains_key(rule);
            for (rule, places) in found.iter().filter(|(rule, _)| is_new(rule)) {
                let both: Vec<_> = places.intersection(&reported).collect();
                assert!(both.is_empty(), "{rule} also reports {both:?} in {body}");
            }
            rest += reported.len();
        }
    }
    assert!(own > extent(500, 2) && rest > extent(1_000, 10), "{own} and {rest}");
}

#[test]
fn distinguishes_directions() {
    let states = json!({ "type": "UAV-INF", "status": {}, "ids": ["kite"] });
    assert_eq!(deviations("UAV-INF", Direction::Request, &states), []);
    let response = deviations("UAV-INF", Direction::Response, &states);
    assert_eq!(response.len(), 1, "{response:?}");
    assert_eq!(response[0].mismatch.path, "/body/ids");
    assert_eq!(deviations("UAV-INF", Direction::Notification, &states), []);
    let tree = Tree::read("{}").expect("JSON");
    assert_eq!(DEFINITIONS.body_schemas().deviations("SYS-CLOSE", Direction::Response, &tree), None);
    assert_eq!(DEFINITIONS.body_schemas().deviations("SOAR-INF", Direction::Response, &tree), None);
}

#[test]
fn reports_deviations_with_location_and_expected_value() {
    let reported = |type_name: &str, body: Value| -> Vec<String> {
        let found = deviations(type_name, Direction::Response, &body);
        let words = found.into_iter().map(|Deviation { mismatch, .. }| mismatch);
        words.map(|one| format!("{}: {}, found {}", one.path, one.expected, one.actual)).collect()
    };
    let body = json!({ "type": "RTK-INF", "preset": { "a/b": {
        "title": 7, "format": "paper", "sources": ["x", ""], "type": null } }, "error": { "c": 1, "d": 2 } });
    assert_eq!(
        reported("RTK-INF", body),
        [
            "/body/preset/a~1b/title: a string, found 7",
            "/body/preset/a~1b/format: one of `auto`, `rtcm2`, `rtcm3`, `ubx`, found \"paper\"",
            "/body/preset/a~1b/sources/1: a string of at least 1 characters, found \"\"",
            "/body/preset/a~1b/type: one of `builtin`, `dynamic`, `user`, found null",
            "/body/error/c: a string, found 1",
        ]
    );
    let body = json!({ "type": "SHOW-CRTH-START", "schedule": [
        { "type": "rth", "startMs": 1.5, "endMs": "soon" }, { "type": "rth", "startMs": 1, "endMs": "inf" }, 7 ] });
    assert_eq!(
        reported("SHOW-CRTH-START", body),
        [
            "/body/schedule/0/startMs: an integer, found 1.5",
            "/body/schedule/0/endMs: one of `auto`, `inf`, found \"soon\"",
            "/body/schedule/2: an object of type TimeAxisScheduleSegment, found 7",
        ]
    );
    let body = json!({ "type": "WTH-AT", "weather": {
        "position": [91.5, 0], "timestamp": 1, "humidity": 101, "magneticVector": [1, 2] } });
    assert_eq!(
        reported("WTH-AT", body),
        [
            "/body/weather/position/0: an integer from -900000000 to 900000000 (latitude), found 91.5",
            "/body/weather/humidity: an integer from 0 to 100, found 101",
            "/body/weather/magneticVector: a list of 3 elements, found 2 elements",
        ]
    );
    let body = json!({ "type": "OBJ-CMD", "result": { "kite": { "type": "plain" } }, "wind": 3 });
    assert_eq!(
        reported("OBJ-CMD", body),
        [
            "/body/result/kite/data: anything, found nothing",
            "/body/wind: only the fields `type`, `result`, `error`, `receipt`, found 3",
        ]
    );
}

/// Findings are grouped by field, and refer to the definition of that field.
#[test]
fn findings_refer_to_the_definition() {
    let line = |weather: Value| {
        let body = json!({ "type": "WTH-AT", "weather": weather, "wind": 3 });
        json!({ "dir": "in", "msg": { "$fw.version": "1.0", "id": "a", "refs": "b", "body": body } })
            .to_string()
    };
    let lines = [
        line(json!({ "position": [1, 2.5], "timestamp": 1, "humidity": 101 })),
        line(json!({ "position": [1, 2], "timestamp": 1, "humidity": -1 })),
    ];
    let groups = |definitions: &Definitions| -> Vec<(String, u64, Option<String>)> {
        let result = check_capture(lines.join("\n").as_bytes(), None, definitions).expect("lines");
        let group = |group: &uavspec_model::Group| {
            let line =
                group.definition.map(|span| definitions.line(span).text.trim_start_matches("| ").to_owned());
            (group.subject.clone(), group.count, line.map(|line| line.chars().take(11).collect()))
        };
        result.findings.groups().filter(|group| group.rule.id == "FW-ENV-18").map(group).collect()
    };
    let expected = [
        ("WTH-AT", 2, "### Respons"),
        ("WTH-AT.weather.humidity", 2, "`humidity` "),
        ("WTH-AT.weather.position.longitude", 1, "1 | `longit"),
    ];
    assert_eq!(
        groups(&DEFINITIONS),
        expected.map(|(subject, count, line)| (subject.to_owned(), count, Some(line.to_owned())))
    );
    // The definitions don't include the pages of these messages, so the findings have no line.
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("Glider.msg"), "uint64 timestamp # [us] Time\n").expect("a file");
    let other = Definitions::load(folder.path()).expect("definitions");
    assert_eq!(groups(&other), expected.map(|(subject, count, _)| (subject.to_owned(), count, None)));
}

/// Alternatives that contain each other don't cause endless recursion.
#[test]
fn ends_with_recursive_alternatives() {
    let side = |name: &str| {
        format!(
            "## {name}\n\n| Field | Required | Type | Description |\n|---|---|---|---|\n\
             | `in` | no | Left or Right | What it holds. |\n| `{name}` | yes | integer | Its height. |\n\n"
        )
    };
    let page = format!(
        "# Gliders\n\n{}{}## GLIDER-INF\n\n### Notification\n\n| Field | Required | Type | Description |\n\
         |---|---|---|---|\n| `in` | yes | Left or Right | A side. |\n",
        side("Left"),
        side("Right")
    );
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("gliders.md"), page).expect("a file");
    let config = "[[package]]\nname = \"gliders\"\ndialect = \"table\"\ninclude = [\"*.md\"]\n";
    std::fs::write(folder.path().join("uavspec.toml"), config).expect("a file");
    let definitions = Definitions::load(folder.path()).expect("definitions");
    let mut side = json!({ "Left": "low" });
    for _ in 0..extent(60, 16) {
        side = json!({ "in": side });
    }
    let text = json!({ "type": "GLIDER-INF", "in": side }).to_string();
    let tree = Tree::read(&text).expect("JSON");
    assert!(definitions.body_schemas().deviations("GLIDER-INF", Direction::Notification, &tree).is_some());
    let text = json!({ "type": "GLIDER-INF", "in": { "in": { "Right": 7 }, "Left": "low" } }).to_string();
    let tree = Tree::read(&text).expect("JSON");
    let found =
        definitions.body_schemas().deviations("GLIDER-INF", Direction::Notification, &tree).expect("a shape");
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].mismatch.expected, "an object of type Left, or an object of type Right");
}

/// Bodies of any size and depth are checked, and their findings are bounded.
#[test]
fn checks_hostile_bodies() {
    let mut node = json!({ "type": "device" });
    for _ in 0..55 {
        node = json!({ "type": "device", "children": { "in": node } });
    }
    let body = json!({ "type": "DEV-LIST", "devices": { "kite": node } });
    assert_eq!(deviations("DEV-LIST", Direction::Response, &body), []);
    let weather: BTreeMap<String, Value> = (0..20_000).map(|id| (id.to_string(), json!({}))).collect();
    let body = json!({ "type": "WTH-INF", "status": weather });
    assert_eq!(deviations("WTH-INF", Direction::Response, &body).len(), 10_000);
    let further: BTreeMap<String, Value> = (0..20_000).map(|id| (id.to_string(), json!(id))).collect();
    assert_eq!(deviations("ACK-NAK", Direction::Response, &json!(further)).len(), 10_000);
    let ids: Vec<String> = (0..50_000).map(|id| (id % 49_999).to_string()).collect();
    let found = deviations("WTH-LIST", Direction::Response, &json!({ "type": "WTH-LIST", "ids": ids }));
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].mismatch.actual, "\"0\" twice");
}
