//! Tests of ROS 2 messages with variable size: strings and sequences.

use std::fs;
use std::sync::LazyLock;

use serde_json::{Value, json};
use uavspec_check::{CaptureResult, check_mcap};
use uavspec_px4::memory::shared_fields;
use uavspec_rules::definitions::Definitions;
use uavspec_runtime::cdr::ByteOrder;
use uavspec_schema::fingerprint::ros_name;
use uavspec_test_captures::mcap::{channel, file, message, schema};

use super::{corrupt_count, equal, source, violated};

const ROPE: &str = "\
uint64 timestamp
string<=4 name
bool[] knots
Strand[<=3] strands
float32 tension  # [N] [@range 0, 10] Pull
string[2] ends
string[] marks
";
const STRAND: &str = "uint8 KIND_SILK = 1\nuint8 kind  # [@enum KIND] Of what\nwstring label\n";

static DEFINITIONS: LazyLock<Definitions> = LazyLock::new(|| definitions(ROPE));

/// Definitions that contain the message `Rope` with this text.
fn definitions(rope: &str) -> Definitions {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("a file");
    write("Rope.msg", rope);
    write("Strand.msg", STRAND);
    write("uavspec.toml", "[[package]]\nname = \"club_msgs\"\ndialect = \"ros2\"\ninclude = [\"*.msg\"]\n");
    Definitions::load(folder.path()).expect("definitions")
}

fn rope() -> Value {
    json!({
        "timestamp": 7, "name": "long", "knots": [true, false], "tension": 2.5, "ends": ["bow", "mast"],
        "marks": ["red", "blue"],
        "strands": [{"kind": 1, "label": "a"}, {"kind": 1, "label": "😀"}],
    })
}

fn cdr(rope: &Value) -> Vec<u8> {
    let ty = DEFINITIONS.types().find("club_msgs", "Rope").expect("a type");
    ty.from_json(rope).expect("a message").to_cdr(ByteOrder::LittleEndian).expect("CDR")
}

fn checked(payload: &[u8]) -> CaptureResult {
    let rope = DEFINITIONS.schema.messages.iter().find(|message| message.name == "Rope").expect("a message");
    let name = ros_name(&DEFINITIONS.schema, rope);
    let text = format!("{ROPE}{}\nMSG: club_msgs/Strand\n{STRAND}", "=".repeat(80));
    let records = [
        schema(1, &name, "ros2msg", text.as_bytes()),
        channel(3, 1, "/tow/rope", "cdr", &[("topic_type_hash", &rope.type_hash)]),
        message(3, payload),
    ];
    check_mcap(&file(&records.concat())[..], &DEFINITIONS)
}

#[test]
fn conforming_messages_have_no_findings() {
    let result = checked(&cdr(&rope()));
    assert_eq!((violated(&result), corrupt_count(&result), result.checked), (vec![], vec![], 1));
    let status = &source(&result).channels[0].status;
    assert_eq!(*status, uavspec_check::CheckStatus::Checked(equal()));
}

/// The decoder checks the bound of the format, not the bound of the definition.
#[test]
fn strings_with_another_bound_are_not_shared() {
    let id = DEFINITIONS.message_of_type("club_msgs/msg/Rope").expect("a message");
    let shared = |text: &str| {
        let other = definitions(text);
        let format = other.types().find("club_msgs", "Rope").expect("a type");
        shared_fields(format, Some(DEFINITIONS.types().get(id)))
    };
    assert_eq!(shared(ROPE), (7, 7));
    for ty in ["string", "string<=5"] {
        assert_eq!(shared(&ROPE.replace("string<=4", ty)), (6, 7), "{ty}");
    }
}

/// The maximum length of a string is specified by the schema in the file, not by the definition.
#[test]
fn strings_with_another_bound_are_a_difference() {
    let text = ROPE.replace("string<=4 name", "string<=6 name");
    let other = definitions(&text);
    let ty = other.types().find("club_msgs", "Rope").expect("a type");
    let mut rope = rope();
    rope["name"] = json!("longer");
    let payload = ty.from_json(&rope).expect("a message").to_cdr(ByteOrder::LittleEndian).expect("CDR");
    let schema_text = format!("{text}{}\nMSG: club_msgs/Strand\n{STRAND}", "=".repeat(80));
    let records = [
        schema(1, "club_msgs/msg/Rope", "ros2msg", schema_text.as_bytes()),
        channel(3, 1, "/tow/rope", "cdr", &[]),
        message(3, &payload),
    ];
    let result = check_mcap(&file(&records.concat())[..], &DEFINITIONS);
    let expected = "/tow/rope: fields of a different type: name (string<=6, defined as string<=4)";
    assert_eq!((violated(&result), result.checked), (vec![("PX-FMT-01", expected.to_owned())], 1));
}

#[test]
fn each_mutant_violates_its_rule() {
    let value = |path: &str, to: Value| {
        let mut rope = rope();
        *rope.pointer_mut(path).expect("a place") = to;
        cdr(&rope)
    };
    let good = cdr(&rope());
    // The characters of the name follow its length, after the header and the time.
    let name = 4 + 8 + 4;
    assert_eq!(&good[name..name + 5], b"long\0");
    let knots = (name + 5).next_multiple_of(4) + 4;
    assert_eq!(good[knots..knots + 2], [1, 0]);
    let with = |at: usize, byte: u8| {
        let mut payload = good.clone();
        payload[at] = byte;
        payload
    };
    let at = |bytes: &[u8]| good.windows(bytes.len()).position(|found| found == bytes).expect("the bytes");
    // In JSON, the label 😀 has two code units: a pair of surrogates.
    let label = at(&[0x3d, 0xd8, 0, 0, 0, 0xde, 0, 0]);
    for (id, payload, message) in [
        ("PX-BOOL-01", with(knots + 1, 9), "/tow/rope.knots: knots[1]: expected 0 or 1, found 9"),
        ("PX-CDR-02", with(name + 4, b'x'), "/tow/rope: name at byte "),
        ("PX-CDR-02", with(label + 2, 1), "/tow/rope: strands[1].label at byte "),
        ("PX-CDR-02", with(knots - 4, 200), "/tow/rope: knots at byte "),
        ("PX-CDR-02", with(name - 4, 255), "/tow/rope: name at byte "),
        ("PX-ENUM-01", value("/strands/1/kind", json!(2)), "/tow/rope.strands.kind: strands[1].kind: 2 "),
        ("PX-RANGE-01", value("/tension", json!(11.0)), "/tow/rope.tension: 11 is outside the range 0 to 10"),
        ("PX-STR-01", with(name + 1, 0xff), "/tow/rope.name: invalid UTF-8 at byte 1"),
        ("PX-STR-01", with(at(b"mast"), 0xff), "/tow/rope.ends: ends[1]: invalid UTF-8 at byte 0"),
        ("PX-STR-01", with(at(b"blue"), 0xff), "/tow/rope.marks: marks[1]: invalid UTF-8 at byte 0"),
        (
            "PX-STR-01",
            with(label + 1, 0),
            "/tow/rope.strands.label: strands[1].label: unpaired surrogate at code unit 1",
        ),
    ] {
        let found = violated(&checked(&payload));
        assert!(
            found.len() == 1 && found[0].0 == id && found[0].1.starts_with(message),
            "{message}: {found:?}"
        );
    }
}

#[test]
fn checks_the_other_values_of_a_message_with_invalid_text() {
    let mut rope = rope();
    rope["tension"] = json!(11.0);
    let mut payload = cdr(&rope);
    payload[4 + 8 + 4] = 0xff;
    let result = checked(&payload);
    let ids: Vec<_> = violated(&result).into_iter().map(|(id, _)| id).collect();
    assert_eq!((ids, result.checked), (vec!["PX-RANGE-01", "PX-STR-01"], 1));
    // The name and the two ends. The number of elements in a sequence isn't known in advance.
    let group = result.findings.groups().find(|group| group.rule.id == "PX-STR-01").expect("a finding");
    assert_eq!(result.findings.covered(group.rule), 3);
}

#[test]
fn counts_each_violation_in_a_sequence() {
    let mut payload = cdr(&rope());
    let knots = (4 + 8 + 4 + 5_usize).next_multiple_of(4) + 4;
    payload[knots..knots + 2].copy_from_slice(&[9, 7]);
    let result = checked(&payload);
    let groups: Vec<_> = result.findings.groups().collect();
    assert_eq!(groups.len(), 1);
    assert_eq!(
        (groups[0].rule.id, groups[0].subject.as_str(), groups[0].count),
        ("PX-BOOL-01", "/tow/rope.knots", 2)
    );
    let details: Vec<_> =
        groups[0].examples.iter().map(|(_, detail)| (&*detail.path, &*detail.actual)).collect();
    assert_eq!(details, [("knots[0]", "9"), ("knots[1]", "7")]);
}
