//! Tests of JSON captures: each rule finds its violations, and reading continues after errors.

mod forms;
mod hostile;
mod logs;

use std::fs;
use std::sync::LazyLock;

use serde_json::{Value, json};
use uavspec_check::{CaptureResult, JsonSummary, Summary, check_capture};
use uavspec_model::{Location, Verdict};
use uavspec_rules::definitions::Definitions;
use uavspec_rules::{RULES, rule};

const GLIDER: &str = "\
uint32 MESSAGE_VERSION = 2
uint8 ORB_QUEUE_LENGTH = 2

uint64 timestamp          # [us] Time since system start
float32 speed             # [m/s] [@range 0, 60] [@invalid -1] Speed
float32[2] flaps          # [rad] [@range -1, 1] [@invalid NaN] Left and right
uint8 MODE_CRUISE = 0     # Straight on
uint8 MODE_THERMAL = 7    # Circling in lift
uint8 mode                # [@enum MODE] What it does
uint8 num_marks           # [-] [@invalid 255] [@count marks] Entries of marks in use
Mark[3] marks             # Places to fly to
char[4] name              # Call sign
bool is_landed            # Whether it stands on the ground
uint8[5] raw              # Anything
int64 serial              # Any number
float64 ratio             # Any ratio
";
const MARK: &str =
    "# A place\n\nuint64 timestamp  # [us] Time of entry\nint16 height  # [m] [@range -500, 9000] Height\n";

const PERIOD: u64 = 20_000;

static DEFINITIONS: LazyLock<Definitions> = LazyLock::new(|| {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("Glider.msg"), GLIDER).expect("a file");
    fs::write(folder.path().join("Mark.msg"), MARK).expect("a file");
    Definitions::load(folder.path()).expect("definitions")
});

fn glider(timestamp: u64) -> Value {
    json!({
        "timestamp": timestamp, "speed": 20.0, "flaps": [0.5, null], "mode": 7, "num_marks": 3,
        "marks": vec![json!({"timestamp": 0, "height": 9000}); 3],
        "name": "D-1", "is_landed": true, "raw": [1, 2, 3, 4, 255], "serial": i64::MIN, "ratio": 1e300,
    })
}

fn typed(message: &Value) -> String {
    json!({"type": type_name(), "message": message}).to_string()
}

fn published(topic: &str, message: &Value) -> String {
    json!({"op": "publish", "topic": topic, "msg": message}).to_string()
}

/// The full type name. Its package depends on the name of the temporary folder.
fn type_name() -> String {
    format!("{}/Glider", DEFINITIONS.schema.packages[0].name)
}

fn check_bytes(bytes: &[u8]) -> CaptureResult {
    check_capture(bytes, None, &DEFINITIONS).expect("bytes can be read")
}

fn check_bare(text: &str) -> CaptureResult {
    let message = DEFINITIONS.message_of_topic("glider");
    assert!(message.is_some());
    check_capture(text.as_bytes(), message, &DEFINITIONS).expect("bytes can be read")
}

fn source(result: &CaptureResult) -> &JsonSummary {
    match &result.summary {
        Summary::Json(source) => source,
        other => panic!("expected JSON, found {other:?}"),
    }
}

fn violated(result: &CaptureResult) -> Vec<(&'static str, String)> {
    let message =
        |group: &uavspec_model::Group| (group.rule.id, format!("{}: {}", group.subject, group.examples[0].1));
    result.findings.groups().map(message).collect()
}

fn corruption(result: &CaptureResult) -> Vec<String> {
    result.corruption.iter().map(|(location, what)| format!("{location}: {what}")).collect()
}

/// Conforming lines, followed by the line `last`.
fn lines_with(last: &str) -> String {
    let lines = (1..60).map(|number| typed(&glider(number * PERIOD)));
    lines.chain([last.to_owned()]).map(|line| line + "\n").collect()
}

#[test]
fn conforming_json_has_no_violations_and_covers_its_rules() {
    let result = check_bytes(lines_with(&typed(&glider(60 * PERIOD))).as_bytes());
    assert_eq!((violated(&result), corruption(&result)), (vec![], vec![]));
    assert_eq!((result.records, result.checked, result.duration), (60, 60, 59 * PERIOD));
    let found = source(&result);
    assert_eq!((found.lines, found.types, found.skipped), (60, 1, 0));
    assert_eq!(found.dialects.iter().count(), 0);
    let idle: Vec<&str> = RULES
        .iter()
        .filter(|rule| !rule.is_on_flockwave())
        .filter(|rule| result.findings.verdict(rule) == Verdict::NotCovered)
        .map(|rule| rule.id)
        .collect();
    let data = ["PX-BOOL-01", "PX-CDR-01", "PX-CDR-02", "PX-DATA-01", "PX-DATA-02", "PX-DATA-03"];
    let ids = RULES.iter().map(|rule| rule.id);
    let talk: Vec<&str> = ids.filter(|id| id.starts_with("PX-EVT-") || id.starts_with("PX-EXT-")).collect();
    let formats = ["PX-FMT-01", "PX-FMT-02", "PX-FMT-03"];
    // There are no events, publishers or subscribers; no external component communicates; and no type has a version
    // suffix. The messages of a type may belong to several instances.
    let others =
        ["PX-FSF-03", "PX-HASH-01", "PX-HASH-02", "PX-QOS-01", "PX-TIME-01", "PX-TYPE-01", "PX-VER-01"];
    assert_eq!(idle, [&data[..], &talk, &formats, &others].concat());
    assert_eq!(result.findings.covered(rule("PX-JSON-01").expect("a rule")), 60 * 4);
}

/// The mutants: the violated rule, the text after conforming messages, and the expected message.
fn mutants() -> Vec<(&'static str, String, &'static str)> {
    let good = glider(60 * PERIOD);
    let value = |pointer: &str, value: Value| {
        let mut changed = good.clone();
        *changed.pointer_mut(pointer).expect("a member") = value;
        typed(&changed)
    };
    let with = |change: fn(&mut serde_json::Map<String, Value>)| {
        let mut changed = good.clone();
        change(changed.as_object_mut().expect("an object"));
        typed(&changed)
    };
    let text = typed(&good);
    let replaced = |from: &str, to: &str| {
        assert!(text.contains(from), "{text}");
        text.replacen(from, to, 1)
    };
    vec![
        ("PX-ARR-01", value("/raw", json!([1, 2])), "px4/Glider.raw: expected 5 elements, found 2"),
        ("PX-ARR-01", value("/flaps", json!([0, 0, 0])), "px4/Glider.flaps: expected 2 elements, found 3"),
        (
            "PX-ARR-01",
            value("/name", json!("too long")),
            "px4/Glider.name: expected at most 4 bytes, found 8",
        ),
        ("PX-ENUM-01", value("/mode", json!(8)), "px4/Glider.mode: 8 is not a documented value"),
        (
            "PX-JSON-01",
            with(|fields| _ = fields.remove("ratio")),
            "px4/Glider.ratio: the field is missing; expected a number, or null for NaN",
        ),
        (
            "PX-JSON-01",
            with(|fields| _ = fields.insert("tow".into(), 1.into())),
            "px4/Glider.tow: Glider has no such field, but the message contains 1",
        ),
        (
            "PX-JSON-01",
            replaced("\"mode\":7", "\"mode\":7,\"mode\":7"),
            "px4/Glider.mode: the field appears 2 times",
        ),
        (
            "PX-JSON-02",
            value("/is_landed", json!(1)),
            "px4/Glider.is_landed: expected true or false, found 1",
        ),
        (
            "PX-JSON-02",
            value("/raw/4", json!(256)),
            "px4/Glider.raw: raw[4]: expected an integer from 0 to 255, found 256",
        ),
        (
            "PX-JSON-02",
            value("/mode", json!(7.5)),
            "px4/Glider.mode: expected an integer from 0 to 255, found 7.5",
        ),
        (
            "PX-JSON-02",
            value("/serial", json!(1_u64 << 63)),
            "px4/Glider.serial: expected an integer from -9223372036854775808 to 9223372036854775807, found 9223372036854775808",
        ),
        (
            "PX-JSON-02",
            value("/speed", json!(1e39)),
            "px4/Glider.speed: expected a number, or null for NaN, found 1e+39, which is too large for float32",
        ),
        (
            "PX-JSON-02",
            value("/marks/1", json!(null)),
            "px4/Glider.marks: marks[1]: expected an object, found null",
        ),
        (
            "PX-JSON-02",
            value("/name", json!([68, 0, 0, 0])),
            "px4/Glider.name: expected a string, found an array of 4",
        ),
        (
            "PX-JSON-02",
            value("/raw", json!("AQIDBAU=")),
            "px4/Glider.raw: expected an array of 5, found \"AQIDBAU=\"",
        ),
        (
            "PX-JSON-02",
            replaced("[0.5,null]", "[0.5,NaN]"),
            "px4/Glider.flaps: flaps[1]: expected a number, or null for NaN, found a bare NaN, which isn't JSON",
        ),
        (
            "PX-JSON-02",
            replaced("[0.5,null]", "[-Infinity,null]"),
            "px4/Glider.flaps: flaps[0]: expected a number, or null for NaN, found a bare -Infinity",
        ),
        (
            "PX-JSON-02",
            replaced("\"ratio\":1e+300", "\"ratio\":1e400"),
            "px4/Glider.ratio: expected a number, or null for NaN, found 1e400, which is too large for float64",
        ),
        ("PX-LEN-01", value("/num_marks", json!(4)), "px4/Glider.num_marks: 4 exceeds the array length 3"),
        ("PX-NAN-01", value("/speed", json!(null)), "px4/Glider.speed: NaN is not allowed here"),
        (
            "PX-QUEUE-01",
            format!("{0}\n{0}\n{0}", typed(&good)),
            "px4/Glider: more than 2 messages with timestamp 1200000 µs",
        ),
        (
            "PX-RANGE-01",
            value("/marks/1/height", json!(9001)),
            "px4/Glider.marks.height: marks[1].height: 9001 is outside the range -500 to 9000",
        ),
        ("PX-STR-01", value("/name", json!("D\0")), "px4/Glider.name: NUL at byte 1"),
        (
            "PX-STR-01",
            {
                let mut changed = good.clone();
                changed["name"] = json!([68, 255, 0, 0]);
                published("/glider", &changed)
            },
            "/glider.name: invalid UTF-8 at byte 1",
        ),
        (
            "PX-TIME-01",
            [60, 61, 62, 61, 64].map(|time| published("/fmu/out/glider", &glider(time * PERIOD))).join("\n"),
            "/fmu/out/glider.timestamp: timestamp 1220000 is earlier than the previous timestamp, 1240000",
        ),
        ("PX-TIME-02", value("/timestamp", json!(80 * PERIOD)), "px4/Glider: no message for 420 ms"),
        (
            "PX-VER-01",
            published("/fmu/out/glider_v1", &good),
            "/fmu/out/glider_v1: the topic name has version 1, but the definition has version 2",
        ),
    ]
}

#[test]
fn a_violation_has_a_message_and_a_location() {
    let mutants = mutants();
    for (id, last, message) in mutants {
        let result = check_bytes(lines_with(&last).as_bytes());
        let found = violated(&result);
        assert!(found.len() == 1 && found[0].0 == id && found[0].1.starts_with(message), "{id}: {found:?}");
        assert_eq!(corruption(&result), Vec::<String>::new(), "{id}");
        let group = result.findings.groups().next().expect("a finding");
        assert!(group.examples[0].0 >= Location::Line(60), "{id}: {group:?}");
        assert!(group.definition.is_some(), "{id}");
    }
}

#[test]
fn reports_every_problem_of_a_message() {
    let mut message = glider(PERIOD);
    message["speed"] = json!(61);
    message["marks"][2] = json!({"timestamp": -1, "height": "high", "depth": 0});
    message["raw"] = json!([1, 2, 3, 4, 5, 600]);
    message.as_object_mut().expect("an object").remove("serial");
    let result = check_bytes(typed(&message).as_bytes());
    let ids: Vec<(&str, String)> = violated(&result)
        .into_iter()
        .map(|(id, text)| (id, text[..text.find(':').unwrap_or(0)].to_owned()))
        .collect();
    let expected = [
        ("PX-ARR-01", "px4/Glider.raw"),
        ("PX-JSON-01", "px4/Glider.marks.depth"),
        ("PX-JSON-01", "px4/Glider.serial"),
        ("PX-JSON-02", "px4/Glider.marks.height"),
        ("PX-JSON-02", "px4/Glider.marks.timestamp"),
        ("PX-JSON-02", "px4/Glider.raw"),
        ("PX-RANGE-01", "px4/Glider.speed"),
    ];
    assert_eq!(ids, expected.map(|(id, subject)| (id, subject.to_owned())));
}

/// The JSON pointers of findings lead to the values in the record, whatever its envelope is.
#[test]
fn findings_point_into_the_record() {
    let mut message = glider(PERIOD);
    message["speed"] = json!(61);
    message["marks"][2]["height"] = json!("high");
    message["a/b~c"] = json!(null);
    message["raw"] = json!([1, 2]);
    let typed_record = typed(&message);
    let published_record = published("/glider", &message);
    let bare = message.to_string();
    for (record, around) in [(&typed_record, "/message"), (&published_record, "/msg"), (&bare, "")] {
        let result = if around.is_empty() { check_bare(record) } else { check_bytes(record.as_bytes()) };
        let value: Value = serde_json::from_str(record).expect("JSON");
        let found: Vec<(&str, &str)> = result
            .findings
            .groups()
            .map(|group| (group.rule.id, group.examples[0].1.path.as_str()))
            .collect();
        let expected = [
            ("PX-ARR-01", "/raw"),
            ("PX-JSON-01", "/a~1b~0c"),
            ("PX-JSON-02", "/marks/2/height"),
            ("PX-RANGE-01", "/speed"),
        ];
        let expected = expected.map(|(rule, path)| (rule, format!("{around}{path}")));
        assert_eq!(found, expected.each_ref().map(|(rule, path)| (*rule, path.as_str())));
        for (_, pointer) in found {
            assert!(value.pointer(pointer).is_some(), "{pointer} in {record}");
        }
    }
}

#[test]
fn findings_show_the_original_text_up_to_a_limit() {
    let mut message = glider(PERIOD);
    message.as_object_mut().expect("an object").remove("serial");
    message["raw"] = json!([1, {"a": [true, "\u{1b}"]}]);
    message["name"] = json!("x".repeat(10_000));
    let result = check_bare(&message.to_string());
    let groups: Vec<_> = result.findings.groups().collect();
    for group in &groups {
        let excerpt = &group.examples[0].1.excerpt;
        assert!(!excerpt.is_empty() && excerpt.len() < 300, "{} {excerpt}", group.rule.id);
        assert!(!excerpt.contains('\u{1b}'), "{excerpt}");
    }
    let excerpt = |subject: &str| {
        let group = groups.iter().find(|group| group.subject == subject).expect("a finding");
        group.examples[0].1.excerpt.as_str()
    };
    let whole = excerpt("Glider.serial");
    assert!(
        whole.starts_with(r#"{"timestamp": 20000, "speed": 20.0, "flaps": [0.5, null], "mode": 7, "#),
        "{whole}"
    );
    assert!(whole.ends_with("…}"), "{whole}");
    assert_eq!(excerpt("Glider.raw"), r#""raw": [1, {"a": [true, "\u{1b}"]}]"#);
}

/// Unused array elements may have any value of their type, whether the count precedes or follows the array.
#[test]
fn ignores_unused_array_elements() {
    let with = |num_marks: i64, height: Value| {
        let mut message = glider(PERIOD);
        message["num_marks"] = json!(num_marks);
        message["marks"][2]["height"] = height;
        message
    };
    for (message, id) in [
        (with(2, json!(9001)), None),
        (with(0, json!(9001)), None),
        (with(255, json!(9001)), None),
        (with(3, json!(9001)), Some("PX-RANGE-01")),
        (with(2, json!("high")), Some("PX-JSON-02")),
        (with(2, json!(70_000)), Some("PX-JSON-02")),
    ] {
        let before = message.to_string();
        assert!(before.find("\"num_marks\"") < before.find("\"marks\""));
        let count = format!("\"num_marks\":{},", message["num_marks"]);
        let behind = before.replace(&count, "");
        let behind = format!("{},{}}}", behind.trim_end_matches('}'), count.trim_end_matches(','));
        for text in [before, behind] {
            let result = check_bare(&format!("{text}\n{}", glider(2 * PERIOD)));
            let found: Vec<&str> = violated(&result).iter().map(|(rule, _)| *rule).collect();
            assert_eq!(found, Vec::from_iter(id), "{text}");
            assert_eq!((result.checked, corruption(&result)), (2, vec![]), "{text}");
        }
    }
}
