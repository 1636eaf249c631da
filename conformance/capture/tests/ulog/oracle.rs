//! Tests that uavspec reads the same contents from real logs as another tool.

use std::collections::BTreeMap;
use std::fs::{self, File};

use serde_json::{Map, Value as Json, json};
use uavspec_capture::ulog::{Event, Log, Problem, Reader};
use uavspec_dynamic::{DynamicView, MessageType, ULOG_PACKAGE, Value};
use uavspec_test_support::{extent, shared};

/// Logs of the corpus and their problems.
const LOGS: [(&str, &[Problem]); 3] = [
    ("sample", &[Problem::NoFlagBits { version: 0 }]),
    ("sample_log_small", &[]),
    ("sample_logging_tagged_and_default_params", &[]),
];

#[test]
fn reads_the_same_contents_as_another_tool() {
    let (Some(logs), Some(oracles)) = (shared("corpus/ulog"), shared("oracle/ulog")) else { return };
    for (name, problems) in LOGS {
        let oracle = fs::read_to_string(oracles.join(format!("{name}.json"))).expect("an oracle");
        let oracle: Json = serde_json::from_str(&oracle).expect("JSON");
        let content = Content::read(File::open(logs.join(format!("{name}.ulg"))).expect("a log"));
        assert_eq!(content.problems, problems, "{name}");
        content.check(&oracle);
        content.check_topics(&oracle);
    }
}

/// The contents of a log.
#[derive(Default)]
struct Content {
    log: Log,
    problems: Vec<Problem>,
    counts: BTreeMap<&'static str, u64>,
    start: (u8, u64),
    flags: Option<([u8; 8], [u8; 8])>,
    dropout_ms: u64,
    information: Map<String, Json>,
    /// For each key of multi-information messages, the number of parts that each value has.
    multi: BTreeMap<String, Vec<u64>>,
    initial: Map<String, Json>,
    changed: u64,
    /// Default parameters, by the bit that denotes the kind of default.
    defaults: BTreeMap<String, Map<String, Json>>,
    lines: Vec<Json>,
    tagged: BTreeMap<String, u64>,
    records: BTreeMap<(String, u64), Vec<Vec<u8>>>,
}

impl Content {
    fn read(input: File) -> Self {
        let mut content = Self::default();
        let mut reader = Reader::new(input);
        while let Some(item) = reader.next().expect("a file") {
            if let Some(record) = content.log.take(&item, &mut |_, problem| panic!("{problem}")) {
                let key = (record.subscription.topic.clone(), record.subscription.multi_id.into());
                content.records.entry(key).or_default().push(record.payload.to_vec());
            }
            content.take(item.event);
        }
        content.log.finish(&mut |_, problem| panic!("{problem}"));
        content
    }

    fn take(&mut self, event: Event<'_>) {
        match event {
            Event::Start { version, timestamp } => self.start = (version, timestamp),
            Event::FlagBits { compatible, incompatible, .. } => self.flags = Some((compatible, incompatible)),
            Event::Information { key, ty, value } => {
                self.information.insert(key.to_owned(), typed(ty, value));
            }
            Event::MultiInformation { is_continued, key, .. } => {
                let counts = self.multi.entry(key.to_owned()).or_default();
                match counts.last_mut().filter(|_| is_continued) {
                    Some(last) => *last += 1,
                    None => counts.push(1),
                }
            }
            // Parameters that follow the first data message are changes.
            Event::Parameter { .. } if !self.records.is_empty() => self.changed += 1,
            Event::Parameter { key, ty, value } => {
                self.initial.insert(key.to_owned(), typed(ty, value));
            }
            Event::DefaultParameter { defaults, key, ty, value } => {
                for bit in (0..8).filter(|bit| defaults >> bit & 1 != 0) {
                    let values = self.defaults.entry(bit.to_string()).or_default();
                    values.insert(key.to_owned(), typed(ty, value));
                }
            }
            Event::Logging { level, tag, timestamp, text } => match tag {
                None => self.lines.push(json!([level, timestamp, text])),
                Some(tag) => *self.tagged.entry(tag.to_string()).or_default() += 1,
            },
            Event::Synchronisation => *self.counts.entry("sync").or_default() += 1,
            Event::Dropout { milliseconds } => {
                *self.counts.entry("dropouts").or_default() += 1;
                self.dropout_ms += u64::from(milliseconds);
            }
            Event::Problem(problem) => self.problems.push(problem),
            Event::Format { .. } | Event::Subscription { .. } | Event::Data { .. } => {}
            other => panic!("{other:?}"),
        }
    }

    fn check(&self, oracle: &Json) {
        assert_eq!(json!(self.start.0), oracle["file_version"]);
        assert_eq!(json!(self.start.1), oracle["start_us"]);
        let (compatible, incompatible) = self.flags.unwrap_or_default();
        assert_eq!(json!(compatible), oracle["compat_flags"]);
        assert_eq!(json!(incompatible), oracle["incompat_flags"]);
        assert_eq!(json!(self.counts.get("sync").unwrap_or(&0)), oracle["sync_count"]);
        assert_eq!(json!(self.counts.get("dropouts").unwrap_or(&0)), oracle["dropouts"]);
        assert_eq!(json!(self.dropout_ms), oracle["dropout_ms_total"]);
        let mut information = oracle["info"].as_object().expect("an object").clone();
        information.extend(oracle["info_other"].as_object().expect("an object").clone());
        assert_eq!(sorted(&self.information), sorted(&information));
        assert_eq!(json!(self.multi), oracle["info_multiple"]);
        assert_eq!(sorted(&self.initial), sorted(oracle["initial_params"].as_object().expect("an object")));
        assert_eq!(json!(self.changed), oracle["params_changed"]);
        assert_eq!(json!(self.defaults), oracle["default_params"]);
        assert_eq!(json!(self.lines.len()), oracle["logged_messages"]);
        assert_eq!(self.lines.first().unwrap_or(&Json::Null), &oracle["first_logged"]);
        assert_eq!(json!(self.tagged), oracle["logged_messages_tagged"]);
        let formats: BTreeMap<&str, Vec<Vec<&str>>> = self
            .log
            .formats()
            .map(|(name, fields)| {
                (name, fields.split_terminator(';').map(|field| field.split(' ').collect()).collect())
            })
            .collect();
        assert_eq!(json!(formats), oracle["formats"]);
    }

    fn check_topics(&self, oracle: &Json) {
        let topics = oracle["topics"].as_array().expect("topics");
        assert_eq!(self.records.len(), topics.len());
        for topic in topics.iter().step_by(extent(1, 5)) {
            let name = topic["name"].as_str().expect("a name");
            let key = (name.to_owned(), topic["multi_id"].as_u64().expect("a number"));
            let message_type = self.log.types().find(ULOG_PACKAGE, name).expect("a type");
            check_topic(message_type, &self.records[&key], topic);
        }
    }
}

fn check_topic(message_type: MessageType<'_>, records: &[Vec<u8>], topic: &Json) {
    let name = message_type.name();
    assert_eq!(topic["count"], records.len(), "{name}");
    let rows: Vec<_> =
        records.iter().map(|record| flatten(message_type.view_uorb(record).expect("a message"))).collect();
    for (key, row) in [("first", rows.first()), ("last", rows.last())] {
        let found = row.expect("a record").iter().map(|(path, value)| (path.clone(), number(*value)));
        let expected = topic[key].as_object().expect("an object").clone().into_iter();
        let expected = expected.filter(|(path, _)| !path.contains("_padding"));
        assert_eq!(found.collect::<Vec<_>>(), expected.collect::<Vec<_>>(), "{name} {key}");
    }
    if !topic["fields"].to_string().contains("_padding") {
        assert_eq!(topic["columns_crc32"], columns_crc32(&rows, &topic["fields"]), "{name}");
    }
}

/// The values of a message with their paths.
fn flatten(view: DynamicView<'_>) -> Vec<(String, Value<'_>)> {
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

/// A number as the oracle writes it.
fn number(value: Value<'_>) -> Json {
    let float = |value: f64| {
        if value.is_infinite() { Json::from(value.to_string()) } else { Json::from(value) }
    };
    match value {
        Value::Bool(value) => Json::from(u8::from(value)),
        Value::Int(value) => Json::from(value),
        Value::UInt(value) => Json::from(value),
        Value::Float32(value) => float(value.into()),
        Value::Float64(value) => float(value),
        Value::Text(_) | Value::String(_) | Value::Message(_) | Value::Array(_) => Json::Null,
    }
}

/// The checksum of all values, column by column.
fn columns_crc32(rows: &[Vec<(String, Value<'_>)>], fields: &Json) -> u32 {
    let mut crc = crc32fast::Hasher::new();
    let mut add = |bytes: &[u8]| crc.update(bytes);
    for column in 0..rows[0].len() {
        let ty = fields[column][0].as_str().expect("a type");
        let bits = ty.trim_start_matches('u').trim_start_matches("int").trim_end_matches("_t");
        let size = bits.parse::<usize>().map_or(8, |bits| bits / 8);
        for row in rows {
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
    crc.finalize()
}

/// The value of an information message or a parameter.
fn typed(ty: &str, value: &[u8]) -> Json {
    let mut bytes = [0; 8];
    bytes[..value.len().min(8)].copy_from_slice(&value[..value.len().min(8)]);
    let number = u64::from_le_bytes(bytes);
    let low = u32::try_from(number & u64::from(u32::MAX)).expect("32 bits");
    match ty {
        "int32_t" => json!(low.cast_signed()),
        "uint32_t" | "uint64_t" => json!(number),
        "float" => json!(f64::from(f32::from_bits(low))),
        text if text.starts_with("char[") => json!(str::from_utf8(value).expect("UTF-8")),
        other => panic!("{other} in a log"),
    }
}

fn sorted(map: &Map<String, Json>) -> BTreeMap<&String, &Json> {
    map.iter().collect()
}
