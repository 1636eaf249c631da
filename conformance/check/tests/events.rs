//! Tests of events and of the metadata that explains them. The results are compared with those of libevents' Python
//! parser.

use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;

use allocation_counter::measure;
use serde_json::{Map, Value, json};
use sha2::{Digest as _, Sha256};
use tempfile::TempDir;
use uavspec_capture::mcap::attachment_body;
use uavspec_capture::ulog::{Event, Log, Reader};
use uavspec_check::convert::Settings;
use uavspec_check::timeline::{Texts, Timeline};
use uavspec_check::{CaptureResult, check_bytes, check_ulog};
use uavspec_dynamic::event::{DecodedEvent, EventValue, Events};
use uavspec_model::{Extent, Verdict};
use uavspec_px4::checks::{Report, Reports, Step};
use uavspec_px4::event::{EventMetadata, EventOrigin, RawEvent};
use uavspec_rules::definitions::{Definitions, Library};
use uavspec_rules::rule;
use uavspec_rules::sample::Flight;
use uavspec_runtime::event::{Argument, Profile};
use uavspec_schema::EventKind;
use uavspec_schema::translation::Translations;
use uavspec_test_captures::mcap as bag;
use uavspec_test_support::{Writer, shared, xz};

use crate::convert::converted;

/// The decoded events of a log, in the form of the reference.
fn events_of(log: &Path) -> Vec<Value> {
    let mut reader = Reader::new(BufReader::new(File::open(log).expect("a log")));
    let (mut formats, mut metadata, mut reports) = (Log::default(), Vec::new(), Reports::default());
    let mut read: Option<EventMetadata> = None;
    let mut found = Vec::new();
    while let Some(item) = reader.next().expect("a readable log") {
        if let Event::MultiInformation { key: "metadata_events", value, .. } = item.event {
            metadata.extend_from_slice(value);
        }
        let Some(record) = formats.take(&item, &mut |_, _| {}) else { continue };
        if record.subscription.topic != "event" {
            continue;
        }
        let events = read.get_or_insert_with(|| {
            let (read, mistake) = EventMetadata::of_capture(&metadata).expect("event metadata");
            assert_eq!(mistake, None);
            read
        });
        let events = events.events();
        let values = record.message_type.view_uorb(record.payload).expect("an event");
        let timestamp = values.get("timestamp").and_then(uavspec_dynamic::Value::number).expect("a time");
        let raw = RawEvent::read(values).expect("an event");
        let mut event = json!({
            "timestamp": timestamp.to_string().parse::<u64>().expect("a time"),
            "sequence": raw.sequence,
            "id": raw.id,
            "log_levels": raw.levels,
        });
        match raw.decode(events) {
            Err(_) => event["unknown"] = true.into(),
            Ok(decoded) => {
                let facts = decoded_event(&decoded);
                event.as_object_mut().expect("an object").extend(facts);
                let before = reports.latest().cloned().unwrap_or_default();
                if reports.follow(&raw, Some(&decoded)) == Step::Complete {
                    event["report"] = report(reports.latest().expect("a report"), &before, events);
                }
            }
        }
        found.push(event);
    }
    found
}

fn decoded_event(event: &DecodedEvent<'_>) -> Map<String, Value> {
    let argument = |index: usize| {
        let value = match event.values[index] {
            EventValue::Integer(value) => json!(i64::try_from(value).expect("a small number")),
            EventValue::Float(value) => json!(f64::from(value)),
        };
        let shown = event.argument(index).expect("an argument");
        let text = match shown {
            // The reference prints the number with the digits of a double.
            Argument::Float(value) => python_float(f64::from(value)),
            _ => shown.to_string(),
        };
        json!({ "value": value, "text": text })
    };
    let facts = json!({
        "namespace": event.component.namespace,
        "name": event.event.name,
        "group": event.event.group,
        "type": event.event.kind.name(),
        "message": event.message(Profile::Dev),
        "description": event.description(Profile::Dev),
        "arguments": (0..event.values.len()).map(argument).collect::<Vec<_>>(),
    });
    facts.as_object().expect("an object").clone()
}

/// A number in the notation of Python.
fn python_float(value: f64) -> String {
    if value.fract() == 0.0 { format!("{value:.1}") } else { value.to_string() }
}

fn report(report: &Report, before: &Report, events: &Events) -> Value {
    let names = |problems: &[uavspec_px4::checks::Problem], without: &Report| -> Vec<String> {
        let kept = problems.iter().filter(|problem| !without.problems.contains(problem));
        kept.map(|problem| events.get(problem.id).expect("an event").1.name.clone()).collect()
    };
    let modes = report.modes.values();
    let modes: Map<String, Value> = modes
        .map(|mode| (mode.name.clone(), json!({ "can_arm": mode.can_arm, "can_run": mode.can_run })))
        .collect();
    let components = report.components.values();
    let components: Map<String, Value> = components
        .map(|found| {
            let state = json!({
                "present": found.is_present,
                "error": found.has_error,
                "warning": found.has_warning,
            });
            (found.name.clone(), state)
        })
        .collect();
    json!({
        "modes": modes,
        "health": components,
        "checks": names(&report.problems, &Report::default()),
        "added": names(&report.problems, before),
        "removed": names(&before.problems, report),
    })
}

#[test]
fn events_and_reports_are_those_of_the_reference() {
    let (Some(oracle), Some(logs)) = (shared("oracle/events"), shared("corpus/ulog")) else { return };
    let mut compared = 0;
    for entry in fs::read_dir(oracle).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.extension().is_none_or(|extension| extension != "json") {
            continue;
        }
        let text = fs::read_to_string(&path).expect("a file");
        let expected: Value = serde_json::from_str(&text).expect("JSON");
        let expected = expected["events"].as_array().expect("events");
        let log = logs.join(path.file_stem().expect("a name")).with_extension("ulg");
        let found = events_of(&log);
        assert_eq!(found.len(), expected.len(), "{path:?}");
        for (found, expected) in found.iter().zip(expected) {
            assert_eq!(found, expected, "{path:?}");
        }
        compared += found.len();
    }
    assert!(compared > 0, "no events");
}

/// The texts for which the reference parsers in Python and in C++ differ, each with the text that this program prints.
#[test]
fn differences_to_the_references_are_known() {
    const INTEGER: &str = r#""type": "uint8_t""#;
    const FLOAT: &str = r#""type": "float""#;
    const ENUM: &str = r#""type": "side_t""#;
    for (text, ty, bytes, ours, python, cpp) in [
        // The shortest text that denotes the same float.
        ("{1}", FLOAT, 16.423_f32.to_le_bytes(), "16.423", "16.42300033569336", "16.423"),
        ("{1}", FLOAT, 2_f32.to_le_bytes(), "2", "2.0", "2"),
        // Numbers are decimal. C++ reads a number that starts with 0 as octal.
        ("{01}", INTEGER, [7, 0, 0, 0], "7", "7", "7"),
        // An unknown unit is a mistake in the metadata. It is printed.
        ("{1ft}", INTEGER, [7, 0, 0, 0], "{1ft}", "{1ft}", "7 ft"),
        ("{1:.1}", INTEGER, [7, 0, 0, 0], "7.0", "7.0", "7"),
        // Decimal places are meaningless for a label. The Python parser fails.
        ("{1:.1}", ENUM, [1, 0, 0, 0], "Left", "error", "Left"),
        ("{1m}", ENUM, [1, 0, 0, 0], "Left m", "Left m", "Left"),
        ("<profile>a</profile>b", INTEGER, [0; 4], "b", "b", "ab"),
    ] {
        let json = format!(
            r#"{{"version": 2, "components": {{"0": {{"namespace": "common",
            "enums": {{"side_t": {{"type": "uint8_t", "entries": {{"1": {{"name": "left", "description": "Left"}}}}}}}},
            "event_groups": {{"default": {{"events": {{"1": {{"name": "a", "message": {},
            "arguments": [{{"name": "b", {ty}}}]}}}}}}}}}}}}}}"#,
            Value::from(text)
        );
        let (events, _) = Events::read(json.into_bytes());
        let event = events.decode(1, &bytes).expect("an event");
        assert_eq!(event.event.kind, EventKind::Plain);
        let shown = event.message(Profile::Normal);
        assert_eq!(shown, ours, "{text} is {python:?} in Python and {cpp:?} in C++");
    }
}

const METADATA: &str = r#"{"version": 2, "components": {"3": {"namespace": "kite", "event_groups": {"default": {"events": {
    "1": {"name": "loose", "message": "Tether {1} loose", "arguments": [{"name": "tether", "type": "uint8_t"}]},
    "2": {"name": "wet", "message": "Wet"}}}}}}}"#;

/// A log with an event, and with event metadata in pieces of up to 100 bytes.
fn log(metadata: &[u8], digest: Option<&str>) -> Vec<u8> {
    let mut log = Writer::with_flags();
    log.format("event:uint64_t timestamp;uint32_t id;uint16_t event_sequence;uint8_t[25] arguments;uint8_t log_levels;");
    if let Some(digest) = digest {
        log.entry(b'I', &[], "char[64] metadata_events_sha256", digest.as_bytes());
    }
    let longest = if metadata.len() > 10_000 { 60_000 } else { 100 };
    for (number, piece) in metadata.chunks(longest).enumerate() {
        let key = format!("uint8_t[{}] metadata_events", piece.len());
        log.entry(b'M', &[u8::from(number > 0)], &key, piece);
    }
    log.subscribe(0, 0, "event");
    let mut arguments = [0; 25];
    arguments[0] = 7;
    let [time, id, sequence] = [&5_000_u64.to_le_bytes()[..], &0x0300_0001_u32.to_le_bytes(), &[0; 2]];
    log.data(0, &[time, id, sequence, &arguments, &[0x66]].concat());
    log.bytes
}

/// The problems with the metadata, the text of the event in the timeline, and the origin of the metadata.
fn explained(log: &[u8]) -> (Vec<String>, String, String) {
    let definitions = Definitions::built_in();
    let result = check_ulog(log, &definitions);
    assert_eq!((result.checked, result.extent), (1, Extent::Whole));
    let problems = result.findings.groups().inspect(|group| assert_eq!(group.rule.id, "PX-EVT-01"));
    let problems = problems.map(|group| group.examples[0].1.to_string()).collect();
    let timeline = Timeline::of_bytes(log, &definitions, &Texts::of(Translations::default()));
    let timeline = timeline.expect("a timeline");
    let lane = timeline.lanes.iter().find(|lane| lane.name == "event").expect("the lane of events");
    let event = &lane.values[0].parts[0];
    let text = event.label.as_ref().map_or(&event.name, |label| &label.text);
    (problems, text.clone(), timeline.event_metadata.expect("an origin"))
}

fn digest(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02X}")).collect()
}

#[test]
fn a_log_is_explained_with_its_own_event_metadata() {
    let packed = xz(METADATA.as_bytes());
    for log in [log(&packed, Some(&digest(&packed))), log(&packed, None), log(METADATA.as_bytes(), None)] {
        let own = "its own event metadata";
        assert_eq!(explained(&log), (Vec::new(), "Tether 7 loose".to_owned(), own.to_owned()));
    }
}

#[test]
fn event_metadata_with_a_mistake_explains_other_events() {
    let metadata = METADATA.replace("\"message\": \"Wet\"", "\"message\": 7");
    let (problems, text, _) = explained(&log(&xz(metadata.as_bytes()), None));
    assert_eq!(problems, ["the event metadata has mistakes: `message` is not a string"]);
    assert_eq!(text, "Tether 7 loose");
}

#[test]
fn a_huge_file_with_event_metadata_is_refused_early() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("all_events.json");
    File::create(&path).and_then(|file| file.set_len(100 << 20)).expect("a file of zeros");
    let mut error = String::new();
    let memory = measure(|| error = EventMetadata::load(&path).expect_err("refused").to_string());
    assert!(error.ends_with("all_events.json: longer than 1048576 bytes"), "{error}");
    assert!(memory.bytes_max < 4 << 20, "{} bytes", memory.bytes_max);
}

#[test]
fn a_log_with_corrupt_event_metadata_is_checked() {
    let packed = xz(METADATA.as_bytes());
    let stated = digest(&packed);
    let mut flipped = packed.clone();
    flipped[100] ^= 1;
    let truncated = &packed[..150];
    let too_long = vec![b' '; (1 << 20) + 1];
    for (log, expected) in [
        (
            log(truncated, Some(&stated)),
            format!("its SHA-256 hash is {}, but", digest(truncated).to_lowercase()),
        ),
        (log(&packed, Some("\u{1b}[31m")), format!("its SHA-256 hash is {}, but", stated.to_lowercase())),
        (log(truncated, None), "truncated xz data".to_owned()),
        (log(&flipped, None), "corrupt xz data: ".to_owned()),
        (log(b"\xff\xfe", None), "byte 0xff is not valid UTF-8".to_owned()),
        (log(b"kite", None), "invalid JSON: unexpected word".to_owned()),
        (log(&xz(b"{\"version\": 2"), None), "invalid JSON: unterminated object".to_owned()),
        (log(&xz(&too_long), None), "more than 1048576 bytes after decompression".to_owned()),
        (log(&too_long, None), "it is longer than 1,048,576 bytes".to_owned()),
    ] {
        let (problems, text, origin) = explained(&log);
        let [problem] = &problems[..] else { panic!("{expected}: {problems:?}") };
        let (place, reason) = problem.split_once(" can't be used: ").expect("a reason");
        assert!(place == "the event metadata" && reason.starts_with(&expected), "{problem}");
        assert!(!problem.contains('\u{1b}'), "{problem:?}");
        assert_eq!(text, "event 50331649 (component 3, number 1), log levels 6 and 6, arguments 07");
        assert_eq!(origin, "uavspec's built-in events (PX4 1.15)");
    }
}

fn check(bytes: &[u8], library: &Library) -> CaptureResult {
    check_bytes(bytes, library).expect("bytes can be read").result
}

#[test]
fn a_result_names_the_event_metadata_that_explains_the_events() {
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("kite.json");
    fs::write(&path, METADATA).expect("a file");
    let (library, with_file) =
        (Library::built_in(), Library::built_in().with_events(EventMetadata::load(&path).expect("metadata")));
    let (metadata, hash) = (METADATA.as_bytes(), digest(METADATA.as_bytes()));
    let [capture, built_in] = [EventOrigin::Capture, EventOrigin::BuiltIn].map(|origin| origin.to_string());
    let file = path.to_string_lossy();
    for (log, library, expected, has_wrong_hash) in [
        (log(metadata, Some(&hash)), &library, &*capture, false),
        (log(metadata, Some(&hash)), &with_file, &*capture, false),
        (log(metadata, Some(&hash.replace('0', "1"))), &library, &*built_in, true),
        (log(b"", None), &library, &*built_in, false),
        (log(b"", None), &with_file, &*file, false),
    ] {
        let result = check(&log, library);
        assert_eq!(result.event_metadata.as_deref(), Some(expected));
        let is_wrong = result.findings.verdict(rule("PX-EVT-01").expect("a rule")) == Verdict::Fail;
        assert_eq!(is_wrong, has_wrong_hash);
    }
}

#[test]
fn a_reply_contains_events_if_it_counts_them() {
    let definitions = Definitions::built_in();
    let lines = String::from_utf8(Flight::new(&definitions).lines().to_bytes()).expect("text");
    let reply = lines.lines().find(|line| line.contains("\"num_events\":2")).expect("a reply with events");
    let without = reply.replace("\"num_events\":2", "\"num_events\":0");
    let metadata = |line: &str| check(line.as_bytes(), &Library::built_in()).event_metadata;
    assert_eq!(metadata(reply), Some(EventOrigin::BuiltIn.to_string()));
    assert_eq!(metadata(&without), None);
}

/// A bag with an attachment and an event.
fn bag_with(name: &str, data: &[u8], is_first: bool) -> Vec<u8> {
    let attachment = bag::record(9, &[&attachment_body(name, "application/json", data)]);
    let event = json!({
        "timestamp": 9, "id": 7, "event_sequence": 1, "arguments": vec![0; 25], "log_levels": 0
    });
    let channel = bag::channel(1, 0, "/fmu/out/event", "json", &[]);
    let event = [channel, bag::message(1, event.to_string().as_bytes())].concat();
    bag::file(&if is_first { [attachment, event] } else { [event, attachment] }.concat())
}

#[test]
fn an_attachment_of_a_bag_explains_the_events_that_follow() {
    let library = Library::built_in();
    let [capture, built_in] = [EventOrigin::Capture, EventOrigin::BuiltIn].map(|origin| origin.to_string());
    let long = [METADATA.as_bytes(), &vec![b' '; 1 << 20]].concat();
    for (name, data, is_first, expected, note) in [
        ("all_events.json", METADATA.as_bytes(), true, &capture, None),
        // The compression is detected from the content.
        ("all_events.json.xz", METADATA.as_bytes(), true, &capture, None),
        ("events.json", METADATA.as_bytes(), true, &built_in, None),
        ("all_events.json", METADATA.as_bytes(), false, &built_in, Some("it follows the first message")),
        ("all_events.json", b"{}", true, &built_in, Some("`version`")),
        ("all_events.json.xz", b"\xfd7zXZ\0\0", true, &built_in, Some("")),
        ("all_events.json", &long, true, &built_in, Some("longer than 1,048,576 bytes: 1,048,9")),
        ("all_events.json", b"", true, &built_in, Some("")),
    ] {
        let result = check(&bag_with(name, data, is_first), &library);
        assert_eq!(result.event_metadata.as_ref(), Some(expected), "{name}");
        assert_eq!(result.corruption, []);
        let notes: Vec<&str> = result.notes.iter().map(String::as_str).collect();
        let is_noted = note.map(|note| matches!(notes[..], [found] if found.contains(note)));
        assert!(is_noted.unwrap_or(notes.is_empty()), "{notes:?}");
    }
}

#[test]
fn conversions_keep_the_event_metadata() {
    let metadata = METADATA.as_bytes();
    for capture in [log(metadata, Some(&digest(metadata))), bag_with("all_events.json", metadata, true)] {
        let (report, output) = converted(&capture, "px4@1.17", Settings::default());
        assert!(report.is_complete(), "{:?}", report.problems);
        let result = check(&output, &Library::built_in());
        assert_eq!(result.event_metadata, Some(EventOrigin::Capture.to_string()));
        assert_eq!(result.notes, [""; 0]);
    }
}
