//! Tests of files whose schemas differ from the definitions.

use std::fs;

use serde_json::{Value, json};
use uavspec_check::{Basis, CaptureResult, CheckStatus, Summary, check_mcap};
use uavspec_px4::comparison::Differences;
use uavspec_rules::definitions::Definitions;
use uavspec_rules::rule;
use uavspec_test_captures::mcap::{channel, file, message, schema};
use uavspec_test_support::{extent, shared};

use super::{GLIDER, Glider, PERIOD, checked, corrupt_count, equal, good, ros, ros2msg, source, violated};

/// The basis on which the only channel of a file is checked.
fn basis(result: &CaptureResult) -> &Basis {
    match &source(result).channels[0].status {
        CheckStatus::Checked(basis) => basis,
        other => panic!("{other:?}"),
    }
}

fn differences(result: &CaptureResult) -> &Differences {
    source(result).channels[0].status.differences().expect("the schema differs")
}

/// Glider messages with an additional field at the start. `change` modifies each message.
fn longer(change: impl Fn(&mut Glider)) -> Vec<u8> {
    let (name, hash) = ros("Glider");
    let text = ros2msg(&GLIDER.replace("uint64 timestamp ", "uint64 number\nuint64 timestamp "));
    let hash = format!("RIHS01_{}", hash.trim_start_matches("RIHS01_").replace(['0', '1', '2', '3'], "4"));
    let mut records = [
        schema(1, &name, "ros2msg", text.as_bytes()),
        channel(3, 1, "/glider", "cdr", &[("topic_type_hash", &hash)]),
    ]
    .concat();
    for number in 1..=60 {
        let mut glider = Glider::at(number * PERIOD);
        change(&mut glider);
        let payload = glider.cdr();
        records.extend(message(3, &[&payload[..4], &[9; 8], &payload[4..]].concat()));
    }
    file(&records)
}

#[test]
fn reads_differing_schemas_and_checks_common_fields() {
    let result = checked(&longer(|_| ()));
    let message = "/glider: additional fields: number (uint64); its hash differs as well".to_owned();
    assert_eq!(violated(&result), [("PX-FMT-01", message.clone())], "the hash is part of the difference");
    assert_eq!((result.checked, result.duration, corrupt_count(&result)), (60, 59 * PERIOD, vec![]));
    let found = differences(&result);
    assert_eq!(found.extra, ["number (uint64)"]);
    assert!(source(&result).channels[0].message.ends_with("; its hash differs as well"));

    let result = checked(&longer(|glider| {
        glider.speed = 61.0;
        glider.is_landed = 7;
        glider.name = [255; 4];
        glider.heights[2] = -501;
    }));
    let ids: Vec<(&str, String)> = violated(&result);
    let expected = [
        ("PX-BOOL-01", "/glider.is_landed: expected 0 or 1, found 7"),
        ("PX-FMT-01", message.as_str()),
        ("PX-RANGE-01", "/glider.marks.height: marks[2].height: -501 is outside the range -500 to 9000"),
        ("PX-RANGE-01", "/glider.speed: 61 is outside the range 0 to 60"),
        ("PX-STR-01", "/glider.name: invalid UTF-8 at byte 0"),
    ];
    assert_eq!(ids, expected.map(|(id, text)| (id, text.to_owned())));
}

/// An array in a file may be longer or shorter than in the definition.
#[test]
fn checks_counts_against_the_array_in_the_schema() {
    let (name, _) = ros("Glider");
    for (marks, num_marks, is_violating) in [(8, 7, false), (8, 9, true), (2, 2, false), (2, 3, true)] {
        let text = format!("uint64 timestamp\nuint8 num_marks\nuint8[{marks}] marks\n");
        let payload = [&[0, 1, 0, 0][..], &PERIOD.to_le_bytes(), &[num_marks], &vec![1; marks]].concat();
        let records = [
            schema(1, &name, "ros2msg", text.as_bytes()),
            channel(3, 1, "/glider", "cdr", &[]),
            message(3, &payload),
        ];
        let found = violated(&checked(&file(&records.concat())));
        let found: Vec<_> = found.into_iter().filter(|(rule, _)| *rule != "PX-FMT-01").collect();
        let message =
            ("PX-LEN-01", format!("/glider.num_marks: {num_marks} exceeds the array length {marks}"));
        assert_eq!(found, if is_violating { vec![message] } else { vec![] }, "{num_marks} of {marks}");
    }
}

/// The version of a topic must match the type in the file, regardless of the definition.
#[test]
fn compares_the_topic_version_with_the_schema_in_the_file() {
    let (name, _) = ros("Glider");
    let of_version =
        |number: u32| GLIDER.replace("MESSAGE_VERSION = 2", &format!("MESSAGE_VERSION = {number}"));
    let without = GLIDER.replace("uint32 MESSAGE_VERSION = 2", "");
    for (topic, text, problem) in [
        ("/fmu/out/glider_v2", of_version(2), ""),
        ("/fmu/out/glider_v3", of_version(3), ""),
        (
            "/fmu/out/glider_v2",
            of_version(3),
            "/fmu/out/glider_v2: the topic name has version 2, but its schema has version 3",
        ),
        (
            "/fmu/out/glider_v3",
            of_version(2),
            "/fmu/out/glider_v3: the topic name has version 3, but its schema has version 2",
        ),
        ("/fmu/out/glider_v2", without.clone(), ""),
        (
            "/fmu/out/glider_v3",
            without,
            "/fmu/out/glider_v3: the topic name has version 3, but the definition has version 2",
        ),
        (
            "/fmu/out/glider_v3",
            "int8 a[".to_owned(),
            "/fmu/out/glider_v3: the topic name has version 3, but the definition has version 2",
        ),
        ("/fmu/out/glider_v3_1", of_version(3), ""),
        ("/fmu/out/glider_velocity", of_version(2), ""),
    ] {
        let text = if text.starts_with("int8") { text } else { ros2msg(&text) };
        let records = [
            schema(1, &name, "ros2msg", text.as_bytes()),
            channel(3, 1, topic, "cdr", &[]),
            message(3, &good().cdr()),
        ];
        let found = violated(&checked(&file(&records.concat())));
        let expected = if problem.is_empty() { vec![] } else { vec![("PX-VER-01", problem.to_owned())] };
        assert_eq!(found, expected, "{topic} {text}");
    }
}

#[test]
fn compares_field_order_but_not_comments_and_constants() {
    let (name, _) = ros("Glider");
    let with = |text: &str| {
        let records = [schema(1, &name, "ros2msg", text.as_bytes()), channel(3, 1, "/glider", "cdr", &[])];
        checked(&file(&records.concat()))
    };
    let swapped = GLIDER
        .replace("uint8 mode ", "uint8 n ")
        .replace("num_marks ", "mode ")
        .replace("uint8 n ", "uint8 num_marks ");
    assert!(differences(&with(&ros2msg(&swapped))).is_moved);
    let no_comments: String =
        GLIDER.lines().map(|line| line.split('#').next().unwrap_or("").to_owned() + "\r\n").collect();
    let equal = &equal();
    assert_eq!(basis(&with(&ros2msg(&no_comments))), equal);
    assert_eq!(
        basis(&with(&ros2msg(&GLIDER.replace("uint8 MODE_THERMAL = 7", "uint8 MODE_WAVE = 9")))),
        equal
    );
    // ROS 2 treats these types as the same.
    assert_eq!(basis(&with(&ros2msg(&GLIDER.replace("char[4]", "uint8[4]")))), equal);
    let retyped = with(&ros2msg(&GLIDER.replace("char[4]", "char[5]")));
    assert_eq!(differences(&retyped).retyped, ["name (char[5], defined as char[4])"]);
    let nested = with(&ros2msg(GLIDER).replace("int16 height", "int32 height"));
    assert_eq!(differences(&nested).nested, ["marks"]);
}

#[test]
fn checks_incomparable_schemas_by_name() {
    let (name, _) = ros("Glider");
    for (encoding, text, expected) in [
        (
            "ros2idl",
            &b"module club { struct Glider {}; };"[..],
            "the schema encoding `ros2idl` isn't supported",
        ),
        ("ros2msg", b"\xff\xfe", "invalid schema: invalid UTF-8 at byte 0"),
        ("ros2msg", b"Rope rope\n", "invalid schema: "),
        ("ros2msg", b"uint64[4000000000] timestamp\n", "invalid schema: "),
        ("", b"", "no schema with fields"),
        ("ros2msg", b"", "no schema with fields"),
        ("omgidl", b"module", "the schema encoding `omgidl` isn't supported"),
    ] {
        let records = [
            schema(1, &name, encoding, text),
            channel(3, 1, "/any", "cdr", &[]),
            message(3, &Glider { is_landed: 2, ..good() }.cdr()),
        ];
        let result = checked(&file(&records.concat()));
        let problem = basis(&result).problem().expect("it can't be compared");
        assert!(problem.starts_with(expected), "{problem}");
        assert_eq!(
            violated(&result),
            [("PX-BOOL-01", "/any.is_landed: expected 0 or 1, found 2".to_owned())]
        );
        assert_eq!(result.checked, 1);
    }
}

/// Programs that record DDS traffic use DDS type names.
#[test]
fn reads_schemas_with_dds_names() {
    let (name, hash) = ros("Glider");
    let dds = name.replacen("/msg/", "::msg::dds_::", 1) + "_";
    let records = [
        schema(1, &dds, "ros2msg", ros2msg(GLIDER).as_bytes()),
        channel(3, 1, "/glider", "cdr", &[("topic_type_hash", &hash)]),
        message(3, &good().cdr()),
    ];
    let result = checked(&file(&records.concat()));
    assert_eq!((basis(&result), violated(&result), result.checked), (&equal(), vec![], 1));
}

/// Without a readable schema, only the hash identifies the fields.
#[test]
fn messages_of_another_hash_with_an_invalid_schema_are_not_checked() {
    let (name, _) = ros("Glider");
    let hash = format!("RIHS01_{}", "0".repeat(64));
    let records = [
        schema(1, &name, "ros2msg", b"Rope rope\n"),
        channel(3, 1, "/glider", "cdr", &[("topic_type_hash", &hash)]),
        message(3, &good().cdr()[..40]),
    ];
    let result = checked(&file(&records.concat()));
    let rules: Vec<&str> = violated(&result).into_iter().map(|(rule, _)| rule).collect();
    assert_eq!((basis(&result), rules, result.checked), (&Basis::OtherHash, vec!["PX-HASH-01"], 0));
}

#[test]
fn compares_the_declared_parts_of_json_schemas() {
    let (name, _) = ros("Glider");
    let with = |schema_text: &str| {
        let records =
            [schema(1, &name, "jsonschema", schema_text.as_bytes()), channel(3, 1, "/x", "json", &[])];
        checked(&file(&records.concat()))
    };
    let mark = json!({"type": "object", "properties": {"timestamp": {"type": "integer"}, "height": {"type": "number"}}});
    let text = json!({"$ref": "#/$defs/glider", "$defs": {"mark": mark, "glider": {"properties": {
        "timestamp": {"type": "integer"}, "speed": {"type": ["number", "null"]},
        "flaps": {"type": "array", "items": {"type": ["null", "number"]}},
        "mode": {"type": "integer"}, "num_marks": {"anyOf": [{"const": 1}]},
        "marks": {"type": "array", "items": {"$ref": "#/$defs/mark"}},
        "name": {"type": "string"}, "is_landed": {"type": "boolean"},
    }}}});
    let equal = &equal();
    assert_eq!(basis(&with(&text.to_string())), equal);
    let changed = |path: &str, to: Value| {
        let mut text = text.clone();
        *text.pointer_mut(path).expect("a place") = to;
        differences(&with(&text.to_string())).clone()
    };
    let fields = "/$defs/glider/properties";
    let found = changed(&format!("{fields}/is_landed/type"), json!("integer"));
    assert_eq!(found.retyped, ["is_landed (integer, defined as boolean)"]);
    let found = changed(&format!("{fields}/flaps/items/type"), json!("string"));
    assert_eq!(found.retyped, ["flaps (array of string, defined as array of number)"]);
    for (flaps, expected) in [
        (json!({"type": "array", "minItems": 2, "maxItems": 2}), None),
        (json!({"type": "array", "minItems": 3, "maxItems": 3}), Some("array of 3")),
        (json!({"type": "array", "minItems": 1, "maxItems": 2}), Some("array of 1 to 2")),
        (json!({"type": "array", "minItems": 3}), Some("array of at least 3")),
        (json!({"type": "array", "minItems": 0, "maxItems": 9}), Some("array of at most 9")),
    ] {
        let mut text = text.clone();
        text["$defs"]["glider"]["properties"]["flaps"] = flaps;
        let result = with(&text.to_string());
        let found = source(&result).channels[0].status.differences().map(|found| found.retyped.clone());
        let expected = expected.map(|stated| vec![format!("flaps ({stated}, defined as array of 2)")]);
        assert_eq!(found, expected);
    }
    let found = changed(&format!("{fields}/mode"), json!({"type": "integer", "maximum": 65_535}));
    assert_eq!(found.retyped, ["mode (integer from 0 to 65535, defined as integer from 0 to 255)"]);
    let found = changed("/$defs/mark/properties/height/type", json!("boolean"));
    assert_eq!(found.nested, ["marks"]);
    let found = changed(fields, json!({"timestamp": {}, "depth": {"type": "number"}}));
    assert_eq!((found.missing.len(), found.extra.as_slice()), (7, &["depth (number)".to_owned()][..]));
    let mut partly = text.clone();
    partly["$defs"]["glider"]["required"] =
        json!(["timestamp", "speed", "flaps", "mode", "num_marks", "marks", "name"]);
    let result = with(&partly.to_string());
    assert_eq!(differences(&result).optional, ["is_landed"]);
    assert_eq!(violated(&result), [("PX-FMT-01", "/x: fields that aren't required: is_landed".to_owned())]);

    for nothing in ["{}", r#"{"type": "object"}"#, "true", "[]", "7", r##"{"$ref": "#"}"##] {
        assert_eq!(basis(&with(nothing)), &Basis::NoSchema, "{nothing}");
    }
    assert!(matches!(basis(&with("{")), Basis::Unreadable(_)));
    assert!(matches!(basis(&with(&"[".repeat(100_000))), Basis::Unreadable(_)));
}

/// If the schema of a JSON channel differs from the definition, only the fields that both share are checked, as in CDR.
#[test]
fn checks_the_common_fields_of_json_messages() {
    let (name, _) = ros("Glider");
    let mark = json!({"properties": {"timestamp": {"type": "integer"}, "depth": {"type": "integer"}}});
    let text = json!({
        "properties": {
            "timestamp": {"type": "integer"}, "speed": {"type": "number"}, "kind": {"type": "string"},
            "flaps": {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3},
            "num_marks": {"type": "integer"}, "marks": {"type": "array", "items": mark},
            "name": {"type": "string"}, "is_landed": {"type": "integer"},
        },
        "required": ["timestamp", "speed", "kind"],
    });
    let check = |sent: &Value| {
        let records = [
            schema(1, &name, "jsonschema", text.to_string().as_bytes()),
            channel(3, 1, "/glider", "json", &[]),
            message(3, sent.to_string().as_bytes()),
        ];
        checked(&file(&records.concat()))
    };
    let good = json!({
        "timestamp": PERIOD, "speed": 20.0, "kind": "wood", "flaps": [0.5, 0.5, 7.0], "num_marks": 200,
        "marks": [{"timestamp": 0, "depth": 3}], "name": "D-1", "is_landed": 7, "tow": null,
    });
    let result = check(&good);
    let ids: Vec<&str> = violated(&result).into_iter().map(|(id, _)| id).collect();
    assert_eq!((ids, corrupt_count(&result), result.checked), (vec!["PX-FMT-01"], vec![], 1));
    let found = differences(&result);
    assert_eq!((found.missing.len(), found.extra.len(), found.retyped.len()), (1, 1, 2));
    // The timestamp, the speed and the name.
    let values = result.coverage.values;
    assert_eq!((values.checked, values.total), (3, Some(8)));
    assert_eq!(result.findings.covered(rule("PX-JSON-01").expect("a rule")), 1);
    assert_eq!(result.findings.covered(rule("PX-RANGE-01").expect("a rule")), 1);

    let with = |key: &str, value: Option<Value>| {
        let mut sent = good.clone();
        let members = sent.as_object_mut().expect("an object");
        match value {
            Some(value) => _ = members.insert(key.to_owned(), value),
            None => _ = members.remove(key),
        }
        let found = violated(&check(&sent));
        found.into_iter().filter(|(id, _)| *id != "PX-FMT-01").collect::<Vec<_>>()
    };
    assert_eq!(with("name", None), []);
    assert_eq!(with("mode", Some(json!(8))), []);
    for (value, id, expected) in [
        (Some(json!(61)), "PX-RANGE-01", "61 is outside the range 0 to 60"),
        (Some(json!("fast")), "PX-JSON-02", "expected a number, or null for NaN, found \"fast\""),
        (None, "PX-JSON-01", "the field is missing; expected a number, or null for NaN"),
    ] {
        assert_eq!(with("speed", value), [(id, format!("/glider.speed: {expected}"))]);
    }
}

/// The text that ROS 2 would use for a PX4 message with its nested types can be read, for all messages.
#[test]
fn definitions_of_real_releases_match_themselves() {
    let Some(corpus) = shared("corpus/px4") else { return };
    let mut compared = 0;
    for release in ["1.15", "1.16", "main"].into_iter().step_by(extent(1, 2)) {
        let definitions = Definitions::load(&corpus.join(release)).expect("definitions");
        let texts: Vec<(String, String)> = walkdir::WalkDir::new(corpus.join(release))
            .sort_by_file_name()
            .into_iter()
            .filter_map(|entry| {
                let path = entry.ok()?.into_path();
                let is_message = path.extension().is_some_and(|extension| extension == "msg");
                let name = path.file_stem()?.to_str()?.to_owned();
                is_message.then(|| (name, fs::read_to_string(&path).expect("a text")))
            })
            .collect();
        let line = "=".repeat(80);
        for (name, text) in texts.iter().step_by(extent(1, 4)) {
            // The text contains all other types, so the test doesn't need to find the nested ones.
            let others: String = texts
                .iter()
                .filter(|(other, _)| other != name && text.contains(other.as_str()))
                .flat_map(|(name, text)| {
                    let within = texts.iter().filter(|(other, _)| text.contains(other.as_str()));
                    std::iter::once((name, text)).chain(within.map(|(name, text)| (name, text)))
                })
                .map(|(name, text)| format!("{line}\nMSG: px4_msgs/{name}\n{text}\n"))
                .collect();
            let records = [
                schema(1, &format!("px4_msgs/msg/{name}"), "ros2msg", format!("{text}\n{others}").as_bytes()),
                channel(1, 1, "/any", "cdr", &[]),
            ];
            let result = check_mcap(&file(&records.concat())[..], &definitions);
            let Summary::Mcap(found) = &result.summary else { panic!("MCAP") };
            let status = &found.channels[0].status;
            let is_equal = *status == CheckStatus::Checked(equal());
            assert!(is_equal || *status == CheckStatus::Undefined, "{release} {name}: {status:?}");
            compared += usize::from(is_equal);
        }
    }
    assert!(compared > extent(500, 50), "{compared}");
}
