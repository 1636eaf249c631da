//! Compares values in real logs with the values that another tool found. The formats in the logs define the types.

use std::collections::BTreeMap;
use std::fs;

use serde_json::Value as Json;
use uavspec_dynamic::{Defect, DynamicView, FormatProblem, MessageType, Types, ULOG_PACKAGE, Value};
use uavspec_runtime::Number;
use uavspec_schema::{Message, Restriction, Schema};
use uavspec_test_definitions::{extent, files_below, px4, shared};

#[test]
fn reads_the_same_values_from_real_logs_as_another_tool() {
    let (Some(logs), Some(oracles)) = (shared("corpus/ulog"), shared("oracle/ulog")) else { return };
    let mut checked = 0;
    for path in files_below(&logs, &["ulg"]) {
        let oracle = oracles.join(path.file_name().expect("a name")).with_extension("json");
        // Skip logs that the other tool did not read.
        let Ok(oracle) = fs::read_to_string(oracle) else { continue };
        let oracle: Json = serde_json::from_str(&oracle).expect("JSON");
        checked += check_log(&fs::read(&path).expect("a log"), &oracle);
    }
    assert!(checked >= 15 + 70 + 96, "only {checked} topics were compared");
}

/// In a healthy log, each field satisfies the definitions of all releases that contain the field. The only violations
/// are known anomalies: since 1.17, PX4's range for `max_error` excludes 0, the value for an unknown error.
#[test]
fn finds_only_known_violations_in_real_logs() {
    let (Some(logs), Some(corpus)) = (shared("corpus/ulog"), shared("corpus/px4")) else { return };
    let releases = extent::<&[&str]>(&["main", "1.16", "1.15"], &["main", "1.15"]);
    let schemas = releases.iter().map(|release| px4(&corpus.join(release).join("msg")).1);
    let schemas: Vec<Schema> = schemas.collect();
    let (mut checked, mut zeros) = (0, 0);
    let mut found: BTreeMap<String, usize> = BTreeMap::new();
    // A quick run skips the first log, which is large, but contains few restricted values.
    for path in files_below(&logs, &["ulg"]).iter().skip(extent(0, 1)) {
        let bytes = fs::read(path).expect("a log");
        let log = Log::read(&bytes);
        let (types, _) = Types::from_ulog_formats(log.formats.iter().copied());
        for ((topic, _), records) in &log.records {
            let Some(ty) = types.find(ULOG_PACKAGE, topic) else { continue };
            let restricted = restricted(&schemas, topic);
            for record in records.iter().step_by(extent(1, 20)) {
                let view = ty.view_uorb(record).expect("a message");
                if restricted.is_empty() {
                    continue;
                }
                let numbers =
                    flat(view).into_iter().filter_map(|(path, value)| Some((path, value.number()?)));
                for (path, number) in numbers {
                    let name = path.split(['[', '.']).next().unwrap_or_default();
                    for (_, restriction) in restricted.iter().filter(|(field, _)| *field == name) {
                        checked += 1;
                        let is_known = (topic.as_str(), name) == ("battery_status", "max_error");
                        zeros += usize::from(is_known && number == Number::Int(0));
                        if let Some(rule) = restriction.constraint().violated_by(number) {
                            *found.entry(format!("{topic}.{name} {rule}")).or_default() += 1;
                        }
                    }
                }
            }
        }
    }
    assert!(checked > extent(1_000, 50), "only {checked} values are restricted in a release");
    let known = BTreeMap::from([("battery_status.max_error PX-RANGE-01".to_owned(), zeros)]);
    assert_eq!(found, known);
}

/// The restricted fields of a topic in all releases, each with its restriction.
fn restricted<'s>(schemas: &'s [Schema], topic: &str) -> Vec<(&'s str, Restriction)> {
    let mut restricted = Vec::new();
    for schema in schemas {
        let is_of_topic = |message: &&Message| message.topics.iter().any(|known| known == topic);
        let Some(message) = schema.messages.iter().find(is_of_topic) else { continue };
        for field in &message.fields {
            restricted.extend(schema.restriction(message, field).map(|found| (field.name.as_str(), found)));
        }
    }
    restricted
}

/// Checks all topics of a log, and counts them.
fn check_log(bytes: &[u8], oracle: &Json) -> usize {
    let log = Log::read(bytes);
    let (types, errors) = Types::from_ulog_formats(log.formats.iter().copied());
    assert_eq!(errors, []);
    let topics = oracle["topics"].as_array().expect("topics");
    for topic in topics {
        let name = topic["name"].as_str().expect("a name");
        let records = &log.records[&(name.to_owned(), topic["multi_id"].as_u64().expect("a number"))];
        let ty = types.find(ULOG_PACKAGE, name).expect("a format");
        check_topic(ty, records, topic);
    }
    topics.len()
}

fn check_topic(ty: MessageType<'_>, records: &[&[u8]], topic: &Json) {
    let name = ty.name();
    assert_eq!(topic["count"], records.len(), "{name}");
    let views: Vec<DynamicView<'_>> =
        records.iter().map(|record| ty.view_uorb(record).expect("a message")).collect();
    for (key, view) in [("first", views.first()), ("last", views.last())] {
        let found = flat(*view.expect("a record"));
        let expected = topic[key].as_object().expect("an object");
        let expected: Vec<_> = expected.iter().filter(|(name, _)| !name.contains("_padding")).collect();
        assert_eq!(found.len(), expected.len(), "{name} {key}");
        for ((path, value), (expected_path, expected)) in found.iter().zip(expected) {
            assert_eq!(path, expected_path, "{name} {key}");
            assert_eq!(json(*value), *expected, "{name} {key} {path}");
            let again = views[if key == "first" { 0 } else { views.len() - 1 }].get(path);
            assert_eq!(again.map(json).as_ref(), Some(expected), "{name} {key} {path} by its path");
        }
    }
    // A quick run doesn't read all records of long topics.
    let is_read = records.len() <= extent(usize::MAX, 300);
    if is_read && !topic["fields"].to_string().contains("_padding") {
        assert_eq!(topic["columns_crc32"], columns_crc32(&views, &topic["fields"]), "{name}");
    }
}

/// The values of a message with their paths: dots for nested fields, brackets for array elements.
fn flat(view: DynamicView<'_>) -> Vec<(String, Value<'_>)> {
    fn add<'v>(values: &mut Vec<(String, Value<'v>)>, path: String, value: Value<'v>) {
        match value {
            Value::Message(view) => {
                view.fields().for_each(|(name, value)| add(values, format!("{path}.{name}"), value));
            }
            Value::Array(elements) => elements
                .iter()
                .enumerate()
                .for_each(|(index, value)| add(values, format!("{path}[{index}]"), value)),
            value => values.push((path, value)),
        }
    }
    let mut values = Vec::new();
    view.fields().for_each(|(name, value)| add(&mut values, name.to_owned(), value));
    values
}

/// The value in the JSON form of the oracle.
fn json(value: Value<'_>) -> Json {
    match value {
        Value::Bool(value) => Json::from(u8::from(value)),
        Value::Int(value) => Json::from(value),
        Value::UInt(value) => Json::from(value),
        Value::Float32(value) => float(value.into()),
        Value::Float64(value) => float(value),
        Value::Text(_) | Value::String(_) | Value::Message(_) | Value::Array(_) => Json::Null,
    }
}

fn float(value: f64) -> Json {
    if value.is_infinite() { Json::from(value.to_string()) } else { Json::from(value) }
}

/// The checksum of all values, column by column.
fn columns_crc32(views: &[DynamicView<'_>], fields: &Json) -> u32 {
    let rows: Vec<_> = views.iter().map(|view| flat(*view)).collect();
    let mut crc = u32::MAX;
    let mut add = |bytes: &[u8]| {
        for byte in bytes {
            crc ^= u32::from(*byte);
            for _ in 0..8 {
                crc = crc >> 1 ^ (0xedb8_8320 & (crc & 1).wrapping_neg());
            }
        }
    };
    for column in 0..rows[0].len() {
        let size = size(fields[column][0].as_str().expect("a type"));
        for row in &rows {
            match row[column].1 {
                Value::Bool(value) => add(&[u8::from(value)]),
                Value::Int(value) => add(&value.to_le_bytes()[..size]),
                Value::UInt(value) => add(&value.to_le_bytes()[..size]),
                Value::Float32(value) => add(&value.to_le_bytes()),
                Value::Float64(value) => add(&value.to_le_bytes()),
                ref other => panic!("{other:?} in a log"),
            }
        }
    }
    !crc
}

/// The size of an integer type, in bytes.
fn size(ty: &str) -> usize {
    let bits = ty.trim_start_matches('u').trim_start_matches("int").trim_end_matches("_t");
    bits.parse::<usize>().map_or(8, |bits| bits / 8)
}

#[test]
fn reports_unusable_formats_and_keeps_the_others() {
    let long = format!("uint8_t[65000] a;uint8_t[{}] b", 65_533 - 65_000);
    let too_long = format!("{long};bool c");
    let deep: Vec<(String, String)> =
        (1..40).map(|level| (format!("deep{level}"), format!("deep{} a;", level - 1))).collect();
    let mut formats = vec![
        ("good", "uint64_t timestamp;inner[2] inner;char[5] text;uint8_t[3] _padding0;"),
        ("inner", "float x;uint8_t y;uint8_t[3] _padding0"),
        ("good", "uint8_t other"),
        ("none", ""),
        ("odd", "uint8_t a;b"),
        ("odder", "uint8_t[3 a"),
        ("zero", "uint8_t[0] a"),
        ("huge", "inner[4294967295] a"),
        ("long", &long),
        ("too_long", &too_long),
        ("twice", "uint8_t a;bool a"),
        ("missing", "uint8_t a;nothing b"),
        ("self", "self a"),
        ("left", "right a"),
        ("right", "left a"),
        ("holds", "none[3] a"),
        ("deep0", "bool a"),
        ("name with\nbreak", "bool a b"),
    ];
    formats.extend(deep.iter().map(|(name, fields)| (&**name, &**fields)));
    let (types, errors) = Types::from_ulog_formats(formats);
    let messages: Vec<String> = errors.iter().take(14).map(ToString::to_string).collect();
    assert_eq!(
        messages,
        [
            "format `good` is repeated; the first definition is used",
            "format `none` has no fields",
            "format `odd` has the field declaration `b`, expected a type and a name",
            "format `odder` has the field declaration `uint8_t[3 a`, expected a type and a name",
            "format `zero` has an array of length `0`, expected 1 to 65533",
            "format `huge` has an array of length `4294967295`, expected 1 to 65533",
            "format `too_long` takes more than 65533 bytes",
            "format `twice` has two `a` fields",
            "format `missing` has the field `b` with the unknown type `nothing`",
            "format `self` contains itself",
            "format `left` contains itself",
            "format `right` contains itself",
            "format `holds` contains the unusable type `none`",
            "format `name with\\nbreak` has the field declaration `bool a b`, expected a type and a name",
        ]
    );
    assert_eq!(errors[14].problem, FormatProblem::Defect(Defect::TooDeep(32)));
    assert_eq!(errors.len(), 14 + 7);

    let good = types.find(ULOG_PACKAGE, "good").expect("a type");
    let size = good.size().expect("a size");
    assert_eq!((size.padded, size.no_padding), (32, 29));
    let payload: Vec<u8> = (0..29).map(|byte| if byte == 27 { 0 } else { byte + 65 }).collect();
    let view = good.view_uorb(&payload).expect("a message");
    assert_eq!(format!("{:?}", view.get("inner[1].y")), format!("{:?}", Some(Value::UInt(65 + 20))));
    assert!(matches!(view.get("text"), Some(Value::Text(b"YZ["))), "{view:?}");
    assert!(view.get("_padding0").is_none());
    assert!(types.find(ULOG_PACKAGE, "long").expect("a type").size().is_some());
    assert!(types.find(ULOG_PACKAGE, "deep32").expect("a type").view_uorb(&[1]).is_ok());
    let error = types.find(ULOG_PACKAGE, "deep33").expect("a type").view_uorb(&[1]).expect_err("refused");
    assert_eq!(error.to_string(), "deep33: nests messages more than 32 levels deep");
    let error = types.find(ULOG_PACKAGE, "self").expect("a type").decode_uorb(&[]).expect_err("refused");
    assert_eq!(error.to_string(), "self: contains itself");
}

/// The parts of a log that the tests need. The format is documented at
/// <https://docs.px4.io/main/en/dev_log/ulog_file_format.html>.
#[derive(Default)]
struct Log<'l> {
    formats: Vec<(&'l str, &'l str)>,
    /// Payloads by topic and instance number.
    records: BTreeMap<(String, u64), Vec<&'l [u8]>>,
}

impl<'l> Log<'l> {
    fn read(bytes: &'l [u8]) -> Self {
        let mut log = Self::default();
        let mut subscriptions = BTreeMap::new();
        let mut rest = &bytes[16..];
        while let Some((head, tail)) = rest.split_first_chunk::<3>() {
            let Some((payload, tail)) = tail.split_at_checked(u16::from_le_bytes([head[0], head[1]]).into())
            else {
                break;
            };
            rest = tail;
            let text = |bytes| std::str::from_utf8(bytes).expect("UTF-8");
            match head[2] {
                b'F' => log.formats.push(text(payload).split_once(':').expect("a name and fields")),
                b'A' => {
                    let key = (text(&payload[3..]).to_owned(), u64::from(payload[0]));
                    subscriptions.insert([payload[1], payload[2]], key);
                }
                b'D' => {
                    let key = subscriptions[&[payload[0], payload[1]]].clone();
                    log.records.entry(key).or_default().push(&payload[2..]);
                }
                _ => {}
            }
        }
        log
    }
}
