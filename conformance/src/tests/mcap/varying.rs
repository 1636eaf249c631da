//! Tests of ROS 2 messages with variable size: strings and sequences.

use std::fs;
use std::sync::LazyLock;

use crate::check::{CaptureResult, check_mcap};
use crate::definitions::Definitions;
use serde_json::{Value, json};
use uavspec_codegen::schema::fingerprint::ros_name;
use uavspec_runtime::cdr::ByteOrder;

use super::file::{channel, file, message, schema};
use super::{corrupt_count, equal, source, violated};

const ROPE: &str = "\
uint64 timestamp
string<=4 name
bool[] knots
Strand[<=3] strands
float32 tension  # [N] [@range 0, 10] Pull
";
const STRAND: &str = "uint8 KIND_SILK = 1\nuint8 kind  # [@enum KIND] Of what\nwstring label\n";

static DEFINITIONS: LazyLock<Definitions> = LazyLock::new(|| {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("a file");
    write("Rope.msg", ROPE);
    write("Strand.msg", STRAND);
    write("uavspec.toml", "[[package]]\nname = \"club_msgs\"\ndialect = \"ros2\"\ninclude = [\"*.msg\"]\n");
    Definitions::load(folder.path()).expect("definitions")
});

fn rope() -> Value {
    json!({
        "timestamp": 7, "name": "long", "knots": [true, false], "tension": 2.5,
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
    assert_eq!(*status, crate::check::CheckStatus::Checked(equal()));
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
    for (id, payload, message) in [
        ("PX-BOOL-01", with(knots + 1, 9), "rope.knots: knots[1]: expected 0 or 1, found 9"),
        ("PX-CDR-02", with(name + 4, b'x'), "rope: name at byte "),
        ("PX-CDR-02", with(name, 0xff), "rope: name at byte "),
        ("PX-CDR-02", with(knots - 4, 200), "rope: knots at byte "),
        ("PX-CDR-02", with(name - 4, 255), "rope: name at byte "),
        ("PX-ENUM-01", value("/strands/1/kind", json!(2)), "rope.strands.kind: strands[1].kind: 2 "),
        ("PX-RANGE-01", value("/tension", json!(11.0)), "rope.tension: 11 is outside the range 0 to 10"),
    ] {
        let found = violated(&checked(&payload));
        assert!(
            found.len() == 1 && found[0].0 == id && found[0].1.starts_with(message),
            "{message}: {found:?}"
        );
    }
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
        ("PX-BOOL-01", "rope.knots", 2)
    );
    let details: Vec<_> =
        groups[0].examples.iter().map(|(_, detail)| (&*detail.path, &*detail.actual)).collect();
    assert_eq!(details, [("knots[0]", "9"), ("knots[1]", "7")]);
}
