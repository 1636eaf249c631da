//! Tests of the Rust code for types and messages on pages. The code for `fixtures/ok/type-tables*` is compiled and run
//! here. To accept intended changes: `UAVSPEC_UPDATE_FIXTURES=1 cargo test -p uavspec-emit json_types::`.

use uavspec_test_definitions as support;

/// The emitted code, arranged as a crate.
#[allow(dead_code, missing_docs, unreachable_pub, unused_imports)]
#[rustfmt::skip]
mod emitted;

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::path::Path;

use emitted::{gliders, odd};
use gliders::json::{
    Callsign, Fix, Glider, GliderWinch, Instant, Mark, Marks, MarksValue, Notification, Phase, Request,
    Response, field_close, glider_inf, tower_ack,
};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value as Json, json};
use uavspec_emit::{GENERATED_BY, rust, vectors};
use uavspec_schema::{Form, SourceMap, read};

/// The packages with their pages.
const PAGES: [(&str, &str); 2] = [
    ("gliders", include_str!("../../schema/tests/fixtures/ok/type-tables/gliders.md")),
    ("odd", include_str!("../../schema/tests/fixtures/ok/type-tables-names/odd.md")),
];

#[test]
fn compiled_code_is_up_to_date() {
    let mut sources = SourceMap::default();
    let packages = PAGES.map(|(name, text)| {
        let mut package = support::package(name, Form::Table);
        package.sources.push(sources.add(format!("{name}.md"), text.into()).expect("a page"));
        package
    });
    let (schema, diagnostics) = read(&sources, &packages);
    assert_eq!(diagnostics, []);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/json_types/emitted");
    let mut failures = Vec::new();
    let files = rust::emit(&schema, &sources, &rust::Options::default());
    for file in &files {
        assert!(file.text.starts_with(&format!("// {GENERATED_BY}")), "{}", file.path);
        failures.extend(support::differs(&folder.join(&file.path), &file.text));
    }
    let known: Vec<_> = files.iter().map(|file| folder.join(&file.path)).collect();
    let found = support::files_below(&folder, &["rs"]);
    failures.extend(
        found
            .iter()
            .filter(|path| !known.contains(path))
            .map(|path| format!("{} is obsolete", path.display())),
    );
    assert!(failures.is_empty(), "{}", failures.concat());
}

/// Checks a round trip.
fn round<T: DeserializeOwned + Serialize + PartialEq + Debug>(value: &T, json: &Json) {
    assert_eq!(&serde_json::to_value(value).expect("JSON"), json);
    let text = json.to_string();
    assert_eq!(&serde_json::from_str::<T>(&text).unwrap_or_else(|error| panic!("{text}: {error}")), value);
    assert_eq!(&T::deserialize(json).unwrap_or_else(|error| panic!("{text}: {error}")), value);
}

fn refused<T: DeserializeOwned + Debug>(json: &Json, expected: &str) {
    refused_text::<T>(&json.to_string(), expected);
}

fn refused_text<T: DeserializeOwned + Debug>(text: &str, expected: &str) {
    let error = serde_json::from_str::<T>(text).expect_err("an error").to_string();
    assert!(error.contains(expected), "{text}: {error}");
}

fn mark(lat: i64, height: Option<i64>, radius: Option<f64>) -> Mark {
    Mark { lat, lon: 2, height, radius }
}

#[test]
fn checks_lengths_of_tuples() {
    round(&mark(1, None, None), &json!([1, 2]));
    round(&mark(1, Some(3), None), &json!([1, 2, 3]));
    round(&mark(1, None, Some(0.5)), &json!([1, 2, null, 0.5]));
    let read: Mark = serde_json::from_value(json!([1, 2, null])).expect("null for an omitted element");
    assert_eq!(read, mark(1, None, None));
    refused::<Mark>(&json!([1]), "invalid length 1");
    refused::<Mark>(&json!([1, 2, 3, 4.0, 5]), "invalid length 5");
    refused::<Mark>(&json!([1, 2, 3, null]), "null");
    refused::<Mark>(&json!([1, null]), "null");
    refused::<Mark>(&json!({ "lat": 1, "lon": 2 }), "an array with the elements of Mark");
}

#[test]
fn distinguishes_absent_from_null() {
    let glider = Glider { id: Callsign::from("D1".to_owned()), time: Instant(5), ..Glider::default() };
    round(&glider, &json!({ "id": "D1", "time": 5 }));
    round(&Glider { fix: Some(None), ..glider.clone() }, &json!({ "id": "D1", "time": 5, "fix": null }));
    let full = Glider {
        position: Some(mark(1, None, None)),
        phase: Some(Phase::from("sleeping")),
        fix: Some(Some(Fix::Value3)),
        marks: Some(Marks(vec![
            MarksValue::Mark(mark(1, None, None)),
            MarksValue::Callsign(glider.id.clone()),
        ])),
        climb: Some(vec![-0.5]),
        crew: Some(vec!["a".to_owned()]),
        winch: Some(GliderWinch::TheMiddle),
        log: Some(String::new()),
        towed_by: Some(Box::new(glider.clone())),
        note: Some(json!({ "any": [null] })),
        ..glider.clone()
    };
    let json = json!({
        "id": "D1", "time": 5, "position": [1, 2], "phase": "sleeping", "fix": 3, "marks": [[1, 2], "D1"],
        "climb": [-0.5], "crew": ["a"], "winch": "the middle", "log": "", "towed_by": { "id": "D1", "time": 5 },
        "note": { "any": [null] }
    });
    round(&full, &json);
    let with = |name: &str, value: Json| {
        let mut json = json.clone();
        json[name] = value;
        json
    };
    refused::<Glider>(&with("phase", Json::Null), "null");
    refused::<Glider>(&with("towed_by", Json::Null), "null");
    refused::<Glider>(&with("fix", json!(1)), "a value of Fix");
    refused::<Glider>(&with("winch", json!("middle")), "a value of GliderWinch");
    refused::<Glider>(&with("marks", json!([1])), "matches no alternative of MarksValue");
    refused::<Glider>(&with("else", json!(1)), "unknown field `else`");
    refused::<Glider>(&with("towed_by", json!({ "id": 7 })), "towed_by: id: invalid type: integer `7`");
    refused::<Glider>(&json!({ "id": "D1" }), "missing field `time`");
    refused::<Glider>(&json!(["D1", 5]), "an object with the fields of Glider");
}

#[test]
fn rejects_repeated_fields_of_all_objects() {
    refused_text::<Glider>(r#"{"id":"D1","time":1,"time":2}"#, "duplicate field `time`");
    // A value of any type, and a field that the page doesn't define.
    refused_text::<Glider>(r#"{"id":"D1","time":1,"note":{"a":1,"a":2}}"#, "duplicate field `a`");
    refused_text::<odd::json::A>(r#"{"type":"x","else":[{"b":1,"b":1}]}"#, "duplicate field `b`");
    refused_text::<Request>(r#"{"type":"GLIDER-INF","ids":[],"ids":["D1"]}"#, "duplicate field `ids`");
    refused_text::<Request>(r#"{"type":"A","type":"GLIDER-INF","ids":[]}"#, "duplicate field `type`");
    let status = r#"{"id":"D1","time":1}"#;
    let text = format!(r#"{{"type":"GLIDER-INF","status":{{"D1":{status},"D1":{status}}}}}"#);
    refused_text::<Notification>(&text, "duplicate field `D1`");
    refused_text::<Response>(r#"{"type":"WINCH-INF","load":{"c":1,"c":2}}"#, "duplicate field `c`");
}

#[test]
fn refuses_to_write_nan_and_infinity() {
    let glider = Glider { climb: Some(vec![0.5, f64::NAN]), ..Glider::default() };
    let status = BTreeMap::from([("D1".to_owned(), glider.clone())]);
    let message = Notification::from(glider_inf::Notification { status });
    let number = odd::json::Option(f64::NEG_INFINITY);
    let named = odd::json::A { a_b_2: Some(number), ..odd::json::A::default() };
    for (result, expected) in [
        (serde_json::to_string(&glider), "climb is NaN"),
        (serde_json::to_string(&message), "climb is NaN"),
        (serde_json::to_string(&mark(1, None, Some(f64::INFINITY))), "radius is inf"),
        (serde_json::to_string(&named), "a_b is -inf"),
        (serde_json::to_string(&number), "Option is -inf"),
    ] {
        let error = result.expect_err("an error").to_string();
        assert_eq!(error, format!("{expected}, which JSON can't represent"));
    }
}

/// Each type contains the next type twice, so the number of paths doubles with each level.
#[test]
fn derives_defaults_of_deeply_nested_types() {
    let levels = (0..40).map(|level| {
        let next = level + 1;
        format!(
            "\n## T{level}\n\n| Field | Required | Type | Description |\n|---|---|---|---|\n| a | yes | T{next} | One \
             |\n| b | yes | T{next} | Another |\n"
        )
    });
    let text = format!("# Nested types\n{}\n## T40\n\nstring\n", levels.collect::<String>());
    let (sources, schema, diagnostics) = support::texts(Form::Table, &[("nested.md", text.as_str())]);
    assert_eq!(diagnostics, []);
    let files = rust::emit(&schema, &sources, &rust::Options::default());
    let types = files.iter().find(|file| file.path == "demo/json/types.rs").expect("a file of types");
    assert_eq!(types.text.matches("Default, PartialEq").count(), 41);
}

#[test]
fn provides_ranges_and_known_values() {
    assert_eq!(Instant::RANGE, 0..=4_102_444_800_000);
    assert!(Instant(0).is_in_range() && !Instant(-1).is_in_range());
    assert!(odd::json::Option(-0.5).is_in_range() && !odd::json::Option(-0.6).is_in_range());
    assert_eq!(Phase::from("final glide"), Phase::FinalGlide);
    assert!(Phase::Towed.is_known() && !Phase::from("sleeping").is_known());
    assert_eq!(Phase::from("sleeping").to_string(), "sleeping");
    assert_eq!(Phase::from("sleeping"), Phase::Unnamed("sleeping".to_owned()));
    assert_eq!(String::from(Callsign::from("D1")), "D1");
    assert_eq!(Fix::ALL.iter().map(|fix| fix.value()).collect::<Vec<_>>(), [0, 2, 3]);
}

#[test]
fn distinguishes_messages_by_type() {
    let request = Request::from(glider_inf::Request { ids: vec![Callsign::from("D1")] });
    let text = serde_json::to_string(&request).expect("JSON");
    assert_eq!(text, r#"{"type":"GLIDER-INF","ids":["D1"]}"#, "the type comes first");
    round(&request, &json!({ "type": "GLIDER-INF", "ids": ["D1"] }));
    assert_eq!(request.message_type(), "GLIDER-INF");
    round(&Request::FieldClose(field_close::Request {}), &json!({ "type": "FIELD-CLOSE" }));
    round(&Response::TowerAck(tower_ack::Response {}), &json!({ "type": "TOWER-ACK" }));
    let glider = Glider { id: Callsign::from("D1".to_owned()), time: Instant(5), ..Glider::default() };
    let status = BTreeMap::from([("D1".to_owned(), glider)]);
    let json = json!({ "type": "GLIDER-INF", "status": { "D1": { "id": "D1", "time": 5 } } });
    round(&Notification::GliderInf(glider_inf::Notification { status: status.clone() }), &json);
    round(&Response::GliderInf(glider_inf::Response { status: Some(status), error: None }), &json);
    let other = json!({ "type": "WINCH-INF", "load": { "D1": 1 }, "a": null });
    round(&Response::Other(other.clone()), &other);
    assert_eq!(Response::Other(other).message_type(), "WINCH-INF");

    refused::<Request>(&json!({ "ids": [] }), "missing field `type`");
    refused::<Request>(&json!({ "type": 1 }), "a string");
    refused::<Request>(&json!([]), "a message object");
    refused::<Request>(&json!({ "type": "GLIDER-INF" }), "GLIDER-INF: missing field `ids`");
    refused::<Response>(&json!({ "type": "TOWER-ACK", "else": 1 }), "unknown field `else`");
}

/// Checks a type against its vectors: valid values survive a round trip, and values with a wrong type or structure are
/// rejected. Ranges, lengths and patterns are not checked.
fn check_vectors<T: DeserializeOwned + Serialize + PartialEq + Debug>(
    vectors: &[(String, Json)],
    name: &str,
) {
    let path = format!("{name}.vectors.json");
    let (_, file) = vectors.iter().find(|(found, _)| *found == path).unwrap_or_else(|| panic!("{path}"));
    for case in file["cases"].as_array().expect("cases") {
        let read = serde_json::from_value::<T>(case["json"].clone());
        match (case["rule"].as_str(), read) {
            (Some("SHAPE-RANGE" | "SHAPE-PATTERN" | "SHAPE-UNIQUE") | None, read) => {
                let read = read.unwrap_or_else(|error| panic!("{name}: {case}: {error}"));
                let written = serde_json::to_value(&read).expect("JSON");
                let again: T = serde_json::from_value(written).expect("the written value is valid");
                assert_eq!(again, read, "{name}: {case}");
            }
            // Lengths are checked for tuples only.
            (Some("SHAPE-LENGTH"), read) if !name.ends_with("/Mark") => drop(read),
            // A message of another type is preserved.
            (Some("SHAPE-VALUE"), read) if name.contains('.') => assert!(read.is_ok(), "{case}"),
            (Some(_), read) => assert!(read.is_err(), "{name}: {case}: {read:?}"),
        }
    }
}

#[test]
fn accepts_and_rejects_vectors_as_stated() {
    let mut sources = SourceMap::default();
    let packages = PAGES.map(|(name, text)| {
        let mut package = support::package(name, Form::Table);
        package.sources.push(sources.add(format!("{name}.md"), text.into()).expect("a page"));
        package
    });
    let (schema, _) = read(&sources, &packages);
    let files = vectors::emit(&schema, &vectors::Options::default());
    let files = files.iter().filter(|file| file.path.ends_with(".vectors.json"));
    let vectors: Vec<(String, Json)> =
        files.map(|file| (file.path.clone(), serde_json::from_str(&file.text).expect("JSON"))).collect();
    macro_rules! check {
        ($($package:ident: $($type:ident)*;)*) => {
            $($(check_vectors::<$package::json::$type>(
                &vectors,
                concat!(stringify!($package), "/", stringify!($type)),
            );)*)*
        };
    }
    check! {
        gliders: Callsign Fix Glider Instant Mark Marks Phase;
        odd: A B D Option Result S Vec Visitor;
    }
    check_vectors::<Request>(&vectors, "gliders/GLIDER-INF.request");
    check_vectors::<Response>(&vectors, "gliders/TOWER-ACK.response");
    check_vectors::<Notification>(&vectors, "gliders/GLIDER-INF.notification");
}

#[test]
fn escapes_keywords_in_names() {
    use odd::json::{A, AMany, AMap, B, D, S, Visitor};
    assert_eq!(serde_json::to_value(AMany::Other).expect("JSON"), "Other");
    let inner = A { r#type: S("x".to_owned()), ..A::default() };
    let value = A {
        self_: Some(Some(D::from(9_007_199_254_740_993))),
        r#ref: Some("r".to_owned()),
        a_b: Some(Visitor::from("Other")),
        a_b_2: Some(odd::json::Option(1.5)),
        map: Some(BTreeMap::from([
            ("b".to_owned(), Some(AMap::Boolean(true))),
            ("i".to_owned(), Some(AMap::Integer(1))),
            ("l".to_owned(), Some(AMap::List(vec![inner.clone()]))),
            ("n".to_owned(), None),
        ])),
        key: Some(Box::new(B { a: Some(Box::new(inner.clone())), b: None })),
        ..inner
    };
    let json = json!({
        "type": "x", "self": 9_007_199_254_740_993_i64, "$ref": "r", "a-b": "Other", "a_b": 1.5,
        "map": { "b": true, "i": 1, "l": [{ "type": "x" }], "n": null }, "key": [{ "type": "x" }]
    });
    round(&value, &json);
    assert!(matches!(value.a_b, Some(Visitor::Other)), "{:?}", value.a_b);
}
