//! Tests of logs: each rule finds its violations, and conforming logs have no findings.

mod counted;
mod time;

use std::fs;

use serde_json::Value;
use tempfile::TempDir;
use uavspec_check::{
    CaptureResult, Format, FormatResult, LogSummary, PartResult, Share, Summary, check_ulog,
};
use uavspec_model::{Extent, Verdict};
use uavspec_rules::definitions::{Definitions, Library};
use uavspec_rules::{RULES, rule};
use uavspec_test_support::{Writer, extent, shared};

const GLIDER: &str = "\
# State of a glider

uint32 MESSAGE_VERSION = 2
uint8 ORB_QUEUE_LENGTH = 2

uint64 timestamp          # [us] Time since system start
float32 speed             # [m/s] [@range 0, 60] [@invalid -1] Speed
float32[2] flaps          # [rad] [@range -1, 1] [@invalid NaN] Left and right
uint8 MODE_CRUISE = 0     # Straight on
uint8 MODE_THERMAL = 7    # Circling in lift
uint8 mode                # [@enum MODE] What it does
uint8 num_marks           # [-] [@count marks] Entries of marks in use
Mark[3] marks             # Places to fly to
char[4] name              # Call sign
bool is_landed            # Whether it stands on the ground
";
const MARK: &str =
    "# A place\n\nuint64 timestamp  # [us] Time of entry\nint16 height  # [m] [@range -500, 9000] Height\n";

const FORMAT: &str = "uint64_t timestamp;float speed;float[2] flaps;uint8_t mode;uint8_t num_marks;char[4] name;\
    bool is_landed;uint8_t[5] _padding0;mark[3] marks;";
const MARK_FORMAT: &str = "mark:uint64_t timestamp;int16_t height;uint8_t[6] _padding0;";

fn definitions() -> (TempDir, Definitions) {
    defined(&[("Glider.msg", GLIDER), ("Mark.msg", MARK)])
}

fn defined(files: &[(&str, &str)]) -> (TempDir, Definitions) {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in files {
        fs::write(folder.path().join(name), text).expect("a file");
    }
    let definitions = Definitions::load(folder.path()).expect("definitions");
    (folder, definitions)
}

/// A glider message that conforms.
#[derive(Clone)]
struct Glider {
    timestamp: u64,
    speed: f32,
    flaps: [f32; 2],
    mode: u8,
    num_marks: u8,
    name: [u8; 4],
    is_landed: u8,
    heights: [i16; 3],
}

impl Glider {
    fn at(timestamp: u64) -> Self {
        let flaps = [0.5, f32::NAN];
        Self {
            timestamp,
            speed: 20.0,
            flaps,
            mode: 7,
            num_marks: 3,
            name: *b"D-1\0",
            is_landed: 1,
            heights: [9000; 3],
        }
    }

    fn bytes(&self) -> Vec<u8> {
        let mut bytes = self.timestamp.to_le_bytes().to_vec();
        bytes.extend(self.speed.to_le_bytes());
        bytes.extend(self.flaps.iter().flat_map(|flap| flap.to_le_bytes()));
        bytes.extend([self.mode, self.num_marks]);
        bytes.extend(self.name);
        bytes.push(self.is_landed);
        bytes.extend([0; 5]);
        for height in self.heights {
            bytes.extend([0; 8]);
            bytes.extend(height.to_le_bytes());
            bytes.extend([0; 6]);
        }
        bytes
    }
}

/// The period of the messages, in µs.
const PERIOD: u64 = 20_000;

/// A conforming log, followed by another message.
fn log_with(last: &Glider) -> Writer {
    let mut log = start();
    for number in 1..60 {
        log.data(5, &Glider::at(number * PERIOD).bytes());
    }
    log.data(5, &last.bytes());
    log
}

fn start() -> Writer {
    let mut log = Writer::with_flags();
    log.entry(b'I', &[], "char[3] sys_name", b"PX4");
    log.format(&format!("glider:{FORMAT}"));
    log.format(MARK_FORMAT);
    log.subscribe(5, 0, "glider");
    log
}

/// The missing part of a log may have contained the missing messages.
#[test]
fn reports_no_violations_that_a_missing_part_may_explain() {
    let whole = log_with(&Glider::at(60 * PERIOD)).bytes;
    let found = |bytes: &[u8]| {
        let (_folder, definitions) = definitions();
        let result = check_ulog(bytes, &definitions);
        let found: Vec<&str> = violated(&result).iter().map(|(rule, _)| *rule).collect();
        assert_ne!(result.extent, Extent::Whole);
        (found, result.corruption.into_iter().map(|(_, text)| text).collect::<Vec<_>>())
    };
    let position = |what: &[u8]| whole.windows(what.len()).position(|part| part == what).expect("a part");
    // The subscription is the last message before the data.
    let subscription = position(b"\x00\x05\x00glider") - 3;
    let mut corrupt = whole.clone();
    corrupt[subscription..subscription + 3].copy_from_slice(&[0xff, 0xff, 0]);
    let (rules, corruption) = found(&corrupt);
    assert_eq!(rules, [""; 0]);
    assert!(
        corruption.iter().any(|text| text.starts_with("data for id 5, which isn't subscribed")),
        "{corruption:?}"
    );
    // Positions after the glider format, and within the mark format.
    let mark = position(b"mark:uint64_t") - 3;
    for cut in [mark, mark + 2, mark + 20] {
        let (rules, corruption) = found(&whole[..cut]);
        assert_eq!(rules, [""; 0], "cut at {cut}");
        assert!(!corruption.is_empty(), "cut at {cut}");
    }
}

fn run_check(log: &Writer) -> CaptureResult {
    let (_folder, definitions) = definitions();
    check_ulog(&log.bytes[..], &definitions)
}

fn as_log(result: &CaptureResult) -> &LogSummary {
    match &result.summary {
        Summary::Log(log) => log,
        other => panic!("expected a log, found {other:?}"),
    }
}

/// The violated rules, each with the subject and message of the first finding.
fn violated(result: &CaptureResult) -> Vec<(&'static str, String)> {
    let message =
        |group: &uavspec_model::Group| (group.rule.id, format!("{}: {}", group.subject, group.examples[0].1));
    result.findings.groups().map(message).collect()
}

fn conforming() -> Writer {
    log_with(&Glider::at(60 * PERIOD))
}

#[test]
fn a_conforming_log_has_no_violations_and_covers_its_rules() {
    let result = run_check(&conforming());
    assert_eq!(violated(&result), []);
    assert_eq!(result.corruption, []);
    assert_eq!((result.records, result.checked), (60, 60));
    assert_eq!(result.duration, 59 * PERIOD);
    let log = as_log(&result);
    let formats: Vec<_> = log.formats.iter().map(|format| (format.topic.as_str(), format.result)).collect();
    assert_eq!(formats, [("glider", FormatResult::Equal)]);
    assert_eq!(log.firmware.as_deref(), Some("PX4"));
    let idle: Vec<&str> = RULES
        .iter()
        .filter(|rule| !rule.is_on_flockwave())
        .filter(|rule| result.findings.verdict(rule) == Verdict::NotCovered)
        .map(|rule| rule.id)
        .collect();
    // There are no events, no external component communicates, the topic has no version suffix, and the log is neither JSON nor MCAP.
    let ids = RULES.iter().map(|rule| rule.id);
    let talk: Vec<&str> = ids.filter(|id| id.starts_with("PX-EVT-") || id.starts_with("PX-EXT-")).collect();
    let others = ["PX-FSF-03", "PX-HASH-01", "PX-HASH-02", "PX-JSON-01", "PX-JSON-02"];
    // A log doesn't contain the publishers and subscribers.
    let live = ["PX-QOS-01", "PX-TYPE-01", "PX-VER-01"];
    assert_eq!(idle, [&["PX-ARR-01", "PX-CDR-01", "PX-CDR-02"], &talk[..], &others, &live].concat());
}

/// Logs that violate one rule each, with the expected message.
fn mutants() -> Vec<(&'static str, Writer, &'static str)> {
    let good = Glider::at(60 * PERIOD);
    let value = |change: fn(&mut Glider)| {
        let mut glider = good.clone();
        change(&mut glider);
        log_with(&glider)
    };
    let with = |change: fn(&mut Writer)| {
        let mut log = conforming();
        change(&mut log);
        log
    };
    let format = |fields: &str| {
        let mut log = Writer::with_flags();
        log.format(&format!("glider:{fields}"));
        log.format(MARK_FORMAT);
        log.subscribe(5, 0, "glider");
        log
    };
    let mut short = conforming();
    short.data(5, &[0; 20]);
    let mut burst = conforming();
    for _ in 0..2 {
        burst.data(5, &good.bytes());
    }
    let mut no_timestamp = format("uint64_t time;");
    no_timestamp.data(5, &[0; 8]);
    vec![
        (
            "PX-BOOL-01",
            value(|glider| glider.is_landed = 153),
            "glider.is_landed: expected 0 or 1, found 153",
        ),
        ("PX-DATA-01", short, "glider: expected 80 bytes of data for id 5, found 20"),
        ("PX-DATA-02", with(|log| _ = log.data(9, &[0; 20])), "id 9: data for id 9, which isn't subscribed"),
        (
            "PX-DATA-03",
            with(|log| _ = log.subscribe(6, 0, "glider")),
            "glider: a second subscription to instance 0",
        ),
        ("PX-ENUM-01", value(|glider| glider.mode = 8), "glider.mode: "),
        (
            "PX-FMT-01",
            format(&FORMAT.replace("uint8_t mode;", "uint8_t kind;")),
            "glider: missing fields: mode (uint8); additional fields: kind (uint8)",
        ),
        (
            "PX-FMT-02",
            with(|log| _ = log.format("tow:uint64_t timestamp;rope[2] ropes;")),
            "tow: format `tow` has the field `ropes`",
        ),
        ("PX-FMT-03", no_timestamp, "glider: the format has no `uint64_t timestamp` field"),
        ("PX-LEN-01", value(|glider| glider.num_marks = 4), "glider.num_marks: 4 exceeds the array length 3"),
        ("PX-NAN-01", value(|glider| glider.speed = f32::NAN), "glider.speed: NaN is not allowed here"),
        ("PX-QUEUE-01", burst, "glider: more than 2 messages with timestamp 1200000 µs"),
        (
            "PX-RANGE-01",
            value(|glider| glider.flaps[1] = 1.5),
            "glider.flaps: flaps[1]: 1.5 is outside the range -1 to 1",
        ),
        ("PX-STR-01", value(|glider| glider.name = *b"D\xff\0\0"), "glider.name: invalid UTF-8 at byte 1"),
        (
            "PX-TIME-01",
            value(|glider| glider.timestamp = 58 * PERIOD),
            "glider.timestamp: timestamp 1160000 is earlier than the previous timestamp, 1180000",
        ),
        (
            "PX-TIME-02",
            value(|glider| glider.timestamp = 80 * PERIOD),
            "glider: no message for 420 ms, but the period is 20 ms",
        ),
    ]
}

/// For some mutants, another rule that is necessarily violated in addition to the intended rule.
const ALSO_VIOLATED: [(&str, &str); 1] = [("PX-FMT-03", "PX-FMT-01")];

#[test]
fn a_violation_has_a_message_and_a_location() {
    let mutants = mutants();
    for (id, log, message) in mutants {
        let result = run_check(&log);
        let found = violated(&result);
        let own: Vec<&String> = found.iter().filter(|(rule, _)| *rule == id).map(|(_, text)| text).collect();
        assert!(own.len() == 1 && own[0].starts_with(message), "{id}: {found:?}");
        let others: Vec<&str> = found.iter().map(|(rule, _)| *rule).filter(|rule| *rule != id).collect();
        let allowed: Vec<&str> =
            ALSO_VIOLATED.iter().filter(|(rule, _)| *rule == id).map(|(_, also)| *also).collect();
        assert_eq!(others, allowed, "{id}: {found:?}");
    }
}

/// A `char` outside of an array is a number.
#[test]
fn checks_a_single_char_as_a_number() {
    let (_folder, definitions) =
        defined(&[("Sign.msg", "uint64 timestamp\nchar letter  # [@range 65, 90] A letter\n")]);
    for (letter, expected) in [(65, vec![]), (33, vec!["PX-RANGE-01"]), (200, vec!["PX-RANGE-01"])] {
        let mut log = Writer::with_flags();
        log.format("sign:uint64_t timestamp;char letter;uint8_t[7] _padding0;");
        log.subscribe(5, 0, "sign");
        log.data(5, &[&[1; 8][..], &[letter], &[0; 7]].concat());
        let result = check_ulog(&log.bytes[..], &definitions);
        let found: Vec<&str> = violated(&result).iter().map(|(rule, _)| *rule).collect();
        assert_eq!(found, expected, "{letter}");
    }
}

/// Older PX4 releases also log topics that were never published. All their bytes are 0.
#[test]
fn values_of_unpublished_topics_are_not_checked() {
    let (_folder, definitions) = defined(&[(
        "Cell.msg",
        "uint64 timestamp\nuint8 error  # [@range 1, 100] Greatest error\nbool is_full\n",
    )]);
    for (time, is_full, expected) in
        [(0, 0, vec![]), (0, 1, vec!["PX-RANGE-01"]), (9, 0, vec!["PX-RANGE-01"])]
    {
        let mut log = Writer::with_flags();
        log.format("cell:uint64_t timestamp;uint8_t error;bool is_full;uint8_t[6] _padding0;");
        log.subscribe(5, 0, "cell");
        log.data(5, &[&[time][..], &[0; 8], &[is_full], &[0; 6]].concat());
        let result = check_ulog(&log.bytes[..], &definitions);
        let found: Vec<&str> = violated(&result).iter().map(|(rule, _)| *rule).collect();
        assert_eq!((found, result.checked), (expected, 1), "{time} {is_full}");
        let covered = result.findings.covered(rule("PX-RANGE-01").expect("a rule"));
        assert_eq!(covered, u64::from(time + is_full > 0), "{time} {is_full}");
    }
}

/// The layout of data is unknown if the log declares its format in two ways.
#[test]
fn data_of_an_ambiguous_format_is_not_checked() {
    let mut log = Writer::with_flags();
    log.format(&format!("glider:{FORMAT}"));
    log.format(&format!("glider:{}", FORMAT.replace("float speed", "uint32_t speed")));
    log.format(MARK_FORMAT);
    log.subscribe(5, 0, "glider");
    log.data(5, &Glider { mode: 8, ..Glider::at(PERIOD) }.bytes());
    let result = run_check(&log);
    assert_eq!((violated(&result), result.records, result.checked), (vec![], 1, 0));
    let part = &result.coverage.parts[0];
    assert_eq!((part.result, part.records), (PartResult::Undecodable, Share::of(0, 1)));
    let texts: Vec<&str> = result.corruption.iter().map(|(_, text)| text.as_str()).collect();
    let expected = [
        "format `glider` is declared again with different fields; data after this can't be decoded",
        "data for id 5, whose format is invalid",
    ];
    assert_eq!(texts, expected);
}

/// A later declaration doesn't affect data that has already been checked.
#[test]
fn checks_data_before_its_format_changes() {
    let other = FORMAT.replace("float speed", "uint32_t speed");
    for (topic, fields, last, expected) in [
        ("glider", FORMAT, format!("glider:{FORMAT}"), PartResult::Checked),
        ("glider", FORMAT, format!("glider:{other}"), PartResult::Checked),
        // The nested message changes.
        ("glider", FORMAT, "mark:uint64_t timestamp;".to_owned(), PartResult::Checked),
        ("glider", other.as_str(), format!("glider:{FORMAT}"), PartResult::Different),
        ("kite", FORMAT, format!("kite:{other}"), PartResult::Undefined),
    ] {
        let first = format!("{topic}:{fields}");
        let mut log = Writer::with_flags();
        log.format(&first);
        log.format(MARK_FORMAT);
        log.subscribe(5, 0, topic);
        log.data(5, &Glider::at(PERIOD).bytes());
        log.format(&last);
        let rules = if expected == PartResult::Different { vec!["PX-FMT-01"] } else { vec![] };
        let check = |log: &Writer, part: PartResult| {
            let result = run_check(log);
            assert_eq!(result.coverage.parts[0].result, part, "{first} {last}");
            let formats = as_log(&result).formats.iter().map(|format| match format.result {
                FormatResult::Equal => PartResult::Checked,
                FormatResult::Differs => PartResult::Different,
                FormatResult::Undefined => PartResult::Undefined,
            });
            assert_eq!(formats.collect::<Vec<_>>(), [expected], "{first} {last}");
            let found: Vec<&str> = violated(&result).iter().map(|(rule, _)| *rule).collect();
            assert_eq!(found, rules, "{first} {last}");
        };
        check(&log, expected);
        log.data(5, &Glider::at(2 * PERIOD).bytes());
        check(&log, if first == last { expected } else { expected.max(PartResult::Undecodable) });
    }
}

/// The id of a topic may be used for another topic after the data.
#[test]
fn compares_the_format_of_a_topic_whose_id_is_reused() {
    let mut log = Writer::with_flags();
    log.format(&format!("glider:{}", FORMAT.replace("float speed", "uint32_t speed")));
    log.format(MARK_FORMAT);
    log.subscribe(5, 0, "glider");
    log.data(5, &Glider::at(PERIOD).bytes());
    log.subscribe(5, 0, "mark");
    let result = run_check(&log);
    let topics: Vec<&str> = as_log(&result).formats.iter().map(|format| format.topic.as_str()).collect();
    assert_eq!(topics, ["glider", "mark"]);
    let found: Vec<&str> = violated(&result).iter().map(|(rule, _)| *rule).collect();
    assert_eq!(found, ["PX-FMT-01"]);
}

/// Nested arrays and long names can't multiply the memory for checks.
#[test]
fn does_not_check_the_values_of_too_many_fields() {
    let topics: Vec<String> = (10..30).map(|number| format!("block_{number}")).collect();
    let block = format!("# TOPICS block {}\nuint64 timestamp\nCell[4000] cells\n", topics.join(" "));
    let (_folder, definitions) = defined(&[("Block.msg", &block), ("Cell.msg", "bool flag\n")]);
    let mut log = Writer::with_flags();
    log.format("cell:bool flag;");
    for topic in &topics {
        log.format(&format!("{topic}:uint64_t timestamp;cell[4000] cells;"));
    }
    for (id, topic) in (0..).zip(&topics) {
        log.subscribe(id, 0, topic);
        log.data(id, &[&[1; 8][..], &[0; 3999], &[2]].concat());
    }
    let result = check_ulog(&log.bytes[..], &definitions);
    let parts = &result.coverage.parts;
    let refused = parts.iter().filter(|part| part.result == PartResult::TooMany).count() as u64;
    assert!((1..10).contains(&refused), "{refused}");
    let found = result.findings.groups().filter(|group| group.rule.id == "PX-BOOL-01");
    assert_eq!(found.map(|group| group.count).sum::<u64>(), 20 - refused);
    assert_eq!(result.coverage.records, Share::of(20 - refused, 20));
}

#[test]
fn shortens_long_names() {
    let mut log = Writer::with_flags();
    log.format("cell:bool flag;");
    log.format(&format!("block:uint64_t timestamp;cell[3] {};", "x".repeat(60_000)));
    log.subscribe(5, 0, "block");
    log.data(5, &[&[1; 8][..], &[2; 3]].concat());
    let result = run_check(&log);
    let subjects: Vec<usize> = result.findings.groups().map(|group| group.subject.len()).collect();
    assert!(subjects.len() == 1 && subjects[0] < 1_000, "{subjects:?}");
}

#[test]
fn accepts_a_new_subscription_after_the_old_one_ended() {
    let checked = |change: &dyn Fn(&mut Writer)| {
        let mut log = conforming();
        change(&mut log);
        let result = run_check(&log);
        violated(&result).iter().map(|(rule, _)| *rule).collect::<Vec<_>>()
    };
    // A topic may be subscribed again: with the same id, or with another id after the old id was unsubscribed or
    // reused.
    let again = |log: &mut Writer, id| _ = log.subscribe(id, 0, "glider");
    assert_eq!(checked(&|log| again(log, 5)), NONE);
    let moved = |log: &mut Writer| {
        log.unsubscribe(5);
        again(log, 6);
    };
    assert_eq!(checked(&moved), NONE);
    let renamed = |log: &mut Writer| {
        log.subscribe(5, 0, "mark");
        again(log, 6);
    };
    assert_eq!(checked(&renamed), NONE);
    // A subscription that has ended doesn't excuse a later duplicate.
    let twice = |log: &mut Writer| {
        moved(log);
        log.subscribe(5, 0, "mark");
        again(log, 7);
    };
    assert_eq!(checked(&twice), ["PX-DATA-03"]);
    assert_eq!(checked(&|log| _ = log.subscribe(6, 1, "glider")), NONE);
}

const NONE: [&str; 0] = [];

#[test]
fn requires_a_timestamp_of_topics_without_data() {
    let checked = |data: bool| {
        let mut log = start();
        log.format("sonde:float x;");
        log.subscribe(6, 0, "sonde");
        log.subscribe(7, 1, "sonde");
        if data {
            log.data(6, &[0; 4]);
            log.data(7, &[0; 4]);
        }
        let result = run_check(&log);
        let rule = rule("PX-FMT-03").expect("a rule");
        assert_eq!(result.findings.covered(rule), 2, "each topic once");
        violated(&result)
    };
    for data in [false, true] {
        let message = "sonde: the format has no `uint64_t timestamp` field";
        assert_eq!(checked(data), [("PX-FMT-03", message.to_owned())]);
    }
    // A format without a subscription may be nested, and an unusable format has no size.
    let mut log = start();
    log.format("sonde:float x;");
    log.format("rope:sail sails;");
    log.subscribe(6, 0, "rope");
    assert_eq!(violated(&run_check(&log)).iter().map(|(rule, _)| *rule).collect::<Vec<_>>(), ["PX-FMT-02"]);
}

/// A finding refers to the definition, if there is one.
#[test]
fn findings_have_a_definition_and_the_expected_value() {
    let (_folder, definitions) = definitions();
    for (id, log, _) in mutants() {
        let result = check_ulog(&log.bytes[..], &definitions);
        let group = result.findings.groups_of(rule(id).expect("a rule")).next().expect("a finding");
        let line = group.definition.map(|span| definitions.line(span));
        let line = line.map(|line| line.text.split('#').next().unwrap_or_default().trim().to_owned());
        let expected = match id {
            // There is no definition of an unknown subscription or format.
            "PX-DATA-02" | "PX-FMT-02" => None,
            "PX-TIME-01" => Some("uint64 timestamp"),
            "PX-DATA-01" | "PX-DATA-03" | "PX-FMT-01" | "PX-FMT-03" | "PX-QUEUE-01" | "PX-TIME-02" => {
                Some("")
            }
            _ => continue,
        };
        assert_eq!(line.as_deref(), expected, "{id}");
        let detail = &group.examples[0].1;
        assert!(!detail.expected.is_empty() && !detail.actual.is_empty(), "{id}: {detail:?}");
    }
}

#[test]
fn allowed_values_outside_the_range_pass() {
    for change in [
        |glider: &mut Glider| glider.speed = -1.0,
        |glider: &mut Glider| glider.speed = 60.0,
        |glider: &mut Glider| glider.flaps = [f32::NAN; 2],
        |glider: &mut Glider| glider.heights[2] = -500,
        |glider: &mut Glider| glider.name = *b"full",
        |glider: &mut Glider| glider.timestamp = 0,
    ] {
        let mut glider = Glider::at(60 * PERIOD);
        change(&mut glider);
        assert_eq!(violated(&run_check(&log_with(&glider))), []);
    }
}

#[test]
fn reports_the_path_of_nested_values() {
    let mut glider = Glider::at(60 * PERIOD);
    glider.heights[1] = 9001;
    let found = violated(&run_check(&log_with(&glider)));
    assert_eq!(
        found,
        [(
            "PX-RANGE-01",
            "glider.marks.height: marks[1].height: 9001 is outside the range -500 to 9000".to_owned()
        )]
    );
}

/// Each finding on a value contains the value's path, even if the message doesn't.
#[test]
fn findings_on_values_contain_the_path_of_the_field() {
    let mut glider = Glider { is_landed: 2, mode: 8, ..Glider::at(60 * PERIOD) };
    glider.flaps[1] = 1.5;
    glider.heights[1] = 9001;
    let result = run_check(&log_with(&glider));
    let paths: Vec<&str> = result.findings.groups().map(|group| group.examples[0].1.path.as_str()).collect();
    assert_eq!(paths, ["is_landed", "mode", "flaps[1]", "marks[1].height"]);
}

#[test]
fn accepts_a_gap_near_a_dropout() {
    let mut log = start();
    for number in 1..60 {
        log.data(5, &Glider::at(number * PERIOD).bytes());
    }
    log.dropout(400);
    log.data(5, &Glider::at(80 * PERIOD).bytes());
    let result = run_check(&log);
    assert_eq!(violated(&result), []);
    assert_eq!(as_log(&result).dropouts, 1);
}

#[test]
fn counts_equal_findings() {
    let mut log = start();
    for number in 1..=5 {
        log.data(5, &Glider { is_landed: 2, ..Glider::at(number * PERIOD) }.bytes());
    }
    let result = run_check(&log);
    let rule = rule("PX-BOOL-01").expect("a rule");
    let groups: Vec<_> = result.findings.groups_of(rule).collect();
    assert_eq!((groups.len(), groups[0].count, groups[0].examples.len()), (1, 5, 3));
    assert_eq!(result.findings.verdict(rule), Verdict::Fail);
}

/// Real logs have no violations, except for known ones. PX4's own definitions state a range for `max_error` that
/// excludes 0, the value of an unknown error. The built-in definitions don't.
#[test]
fn real_logs_have_the_known_results() {
    let (Some(logs), Some(corpus)) = (shared("corpus/ulog"), shared("corpus/px4")) else { return };
    let mut odd = 0;
    // Only the newest of these releases has a range that the logs violate.
    for release in extent(&["1.15", "1.16", "main"][..], &["main"]) {
        let definitions = Definitions::load(&corpus.join(release)).expect("definitions");
        for entry in fs::read_dir(&logs).expect("a folder") {
            let path = entry.expect("an entry").path();
            let result = check_ulog(fs::File::open(&path).expect("a log"), &definitions);
            assert_eq!(result.records, result.checked, "{}", path.display());
            for group in result.findings.groups() {
                let is_known = group.rule.id.starts_with("PX-FMT-01")
                    || (*release, group.subject.as_str()) == ("main", "battery_status.max_error")
                    || matches!(group.rule.id, "PX-TIME-02" | "PX-QUEUE-01");
                assert!(is_known, "{}: {group:?}", path.display());
                if group.subject == "battery_status.max_error" {
                    assert!(
                        group.messages().iter().all(|text| text.starts_with("0 is outside")),
                        "{group:?}"
                    );
                    odd += group.count;
                }
            }
        }
    }
    assert!(odd >= 94, "only {odd} messages of batteries with an unknown error");
}

#[test]
fn the_built_in_definitions_allow_an_unknown_error_of_a_battery() {
    let Some(logs) = shared("corpus/ulog") else { return };
    for release in ["px4@1.15", "px4@1.17", "px4@1.18", "px4@main"].into_iter().step_by(extent(1, 3)) {
        let library = Library::release(release).expect("a release");
        for entry in fs::read_dir(&logs).expect("a folder") {
            let log = fs::File::open(entry.expect("an entry").path()).expect("a log");
            let result = check_ulog(log, library.base());
            let mut subjects = result.findings.groups().map(|group| &group.subject);
            assert!(!subjects.any(|subject| subject == "battery_status.max_error"), "{release}");
        }
    }
}

/// The oracles describe formats and definitions independently. This test uses them to determine which formats match.
#[test]
fn matches_the_same_formats_as_the_reference_tools() {
    let (Some(logs), Some(corpus)) = (shared("corpus/ulog"), shared("corpus/px4")) else { return };
    let Some(oracle) = shared("oracle") else { return };
    let read = |path: &str| -> Value {
        serde_json::from_slice(&fs::read(oracle.join(path)).expect("a file")).expect("JSON")
    };
    let mut seen = [0, 0, 0];
    for release in extent(&["1.15", "1.16", "main"][..], &["1.15"]) {
        let defined = read(&format!("uorb/{release}.json"));
        let definitions = Definitions::load(&corpus.join(release)).expect("definitions");
        for log in ["sample", "sample_log_small", "sample_logging_tagged_and_default_params"] {
            let found = read(&format!("ulog/{log}.json"));
            let file = fs::File::open(logs.join(format!("{log}.ulg"))).expect("a log");
            for Format { topic, result, .. } in &as_log(&check_ulog(file, &definitions)).formats {
                let of = defined.as_object().expect("messages").iter().find(|(_, message)| {
                    message["topics"].as_array().expect("topics").iter().any(|known| known == topic)
                });
                let expected = match of {
                    None => 0,
                    Some((name, _)) if is_same(topic, name, &found["formats"], &defined) => 1,
                    Some(_) => 2,
                };
                let checked = match result {
                    FormatResult::Undefined => 0,
                    FormatResult::Equal => 1,
                    FormatResult::Differs => 2,
                };
                assert_eq!(checked, expected, "{release}, {log}: {topic}, {result:?}");
                seen[checked] += 1;
            }
        }
    }
    assert!(seen.iter().all(|count| *count > extent(50, 10)), "{seen:?}");
}

/// True if a format of a log has the fields of a message, according to the oracles.
fn is_same(format: &str, message: &str, formats: &Value, messages: &Value) -> bool {
    let fields = |list: &Value| -> Vec<(String, String)> {
        let text = |field: &Value, at: usize| field[at].as_str().expect("a text").to_owned();
        let all = list.as_array().expect("fields").iter();
        let all = all.map(|field| (text(field, 0), text(field, 1)));
        all.filter(|(_, name)| !name.starts_with("_padding")).collect()
    };
    let (found, defined) = (fields(&formats[format]), fields(&messages[message]["fields"]));
    found.len() == defined.len()
        && found.iter().zip(&defined).all(|((ty, name), (defined_ty, defined_name))| {
            let split = |ty: &str| {
                ty.split_once('[')
                    .map_or((ty.to_owned(), String::new()), |(ty, rest)| (ty.to_owned(), rest.to_owned()))
            };
            let ((ty, length), (defined_ty, defined_length)) = (split(ty), split(defined_ty));
            let ty = match ty.as_str() {
                "float" => "float32",
                "double" => "float64",
                other => other.strip_suffix("_t").unwrap_or(other),
            };
            let is_same_type = if formats[ty].is_array() {
                messages[&defined_ty].is_object() && is_same(ty, &defined_ty, formats, messages)
            } else {
                ty == defined_ty
            };
            name == defined_name && length == defined_length && is_same_type
        })
}
