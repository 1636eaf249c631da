//! Tests of arrays with a separate count field, which states how many elements are used.

use std::fs;

use tempfile::TempDir;
use uavspec_check::{CaptureResult, check_ulog};
use uavspec_rules::definitions::Definitions;
use uavspec_test_support::Writer;

use super::{FORMAT, Glider, MARK_FORMAT, PERIOD, defined, run_check, violated};

/// A glider log with an array of `marks` elements, of which `num_marks` are in use.
fn glider_of(marks: usize, num_marks: u8) -> Writer {
    let mut log = Writer::with_flags();
    log.format(&format!("glider:{}", FORMAT.replace("mark[3]", &format!("mark[{marks}]"))));
    log.format(MARK_FORMAT);
    log.subscribe(5, 0, "glider");
    let mut payload = Glider { num_marks, ..Glider::at(PERIOD) }.bytes();
    payload.resize(payload.len() + 16 * marks - 16 * 3, 0);
    log.data(5, &payload);
    log
}

/// An array in the log may be longer or shorter than in the definition.
#[test]
fn checks_counts_against_the_array_in_the_log() {
    for (marks, num_marks, is_violating) in
        [(8, 7, false), (8, 8, false), (8, 9, true), (2, 2, false), (2, 3, true)]
    {
        let found = violated(&run_check(&glider_of(marks, num_marks)));
        let found: Vec<_> = found.into_iter().filter(|(rule, _)| *rule != "PX-FMT-01").collect();
        let message =
            ("PX-LEN-01", format!("glider.num_marks: {num_marks} exceeds the array length {marks}"));
        assert_eq!(found, if is_violating { vec![message] } else { vec![] }, "{num_marks} of {marks}");
    }
}

/// The special count 9 is a valid length in the definition, but not in the log.
#[test]
fn accepts_a_special_count_above_the_length_in_the_log() {
    let tow = "uint64 timestamp\nuint8 num_ropes  # [@invalid 9] [@count ropes]\nuint8[12] ropes\n";
    let (_folder, definitions) = defined(&[("Tow.msg", tow)]);
    for (num_ropes, message) in [(2, None), (3, Some("3 exceeds the array length 2")), (9, None)] {
        let mut log = Writer::with_flags();
        log.format("tow:uint64_t timestamp;uint8_t num_ropes;uint8_t[2] ropes;uint8_t[5] _padding0;");
        log.subscribe(5, 0, "tow");
        log.data(5, &[5, 0, 0, 0, 0, 0, 0, 0, num_ropes, 0, 0, 0, 0, 0, 0, 0]);
        let found = violated(&check_ulog(&log.bytes[..], &definitions));
        let found: Vec<_> = found.into_iter().filter(|(rule, _)| *rule != "PX-FMT-01").collect();
        let message = message.map(|message| ("PX-LEN-01", format!("tow.num_ropes: {message}")));
        assert_eq!(found, Vec::from_iter(message), "{num_ropes}");
    }
}

#[test]
fn accepts_any_count_of_a_missing_array() {
    let mut log = Writer::with_flags();
    log.format("glider:uint64_t timestamp;uint8_t num_marks;uint8_t[7] _padding0;");
    log.subscribe(5, 0, "glider");
    log.data(5, &[[0; 8], [200; 8]].concat());
    assert!(violated(&run_check(&log)).iter().all(|(rule, _)| *rule == "PX-FMT-01"));
}

const TOW: &str = "\
# A tow

uint64 timestamp      # [us] Time since system start
uint8 num_ropes       # [-] [@invalid 255] [@count ropes] Ropes in use
uint8[4] ropes        # [m] [@range 10, 90] Lengths
int8 num_knots        # [-] [@count knots] Knots in use
Knot[2] knots         # Knots
";
const KNOT: &str = "\
# A knot

uint64 timestamp      # [us] Time since system start
uint8 num_turns       # [-] [@count turns] Turns in use
uint8[3] turns        # [-] [@range 1, 9] How tight each is
bool is_firm          # Whether it holds
";

fn tow() -> (TempDir, Definitions) {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("Tow.msg"), TOW).expect("a file");
    fs::write(folder.path().join("Knot.msg"), KNOT).expect("a file");
    let definitions = Definitions::load(folder.path()).expect("definitions");
    (folder, definitions)
}

/// Checks a message with counted ropes and counted knots. Each knot contains counted turns.
fn check_tow(ropes: (u8, [u8; 4]), num_knots: i8, knots: [(u8, [u8; 3], u8); 2]) -> CaptureResult {
    let mut log = Writer::with_flags();
    log.format(
        "tow:uint64_t timestamp;uint8_t num_ropes;uint8_t[4] ropes;int8_t num_knots;uint8_t[2] _padding0;\
         knot[2] knots;",
    );
    log.format(
        "knot:uint64_t timestamp;uint8_t num_turns;uint8_t[3] turns;bool is_firm;uint8_t[3] _padding0;",
    );
    log.subscribe(5, 0, "tow");
    let mut payload = 5_u64.to_le_bytes().to_vec();
    payload.push(ropes.0);
    payload.extend(ropes.1);
    payload.extend([num_knots.cast_unsigned(), 0, 0]);
    for (num_turns, turns, is_firm) in knots {
        payload.extend(5_u64.to_le_bytes());
        payload.push(num_turns);
        payload.extend(turns);
        payload.extend([is_firm, 0, 0, 0]);
    }
    log.data(5, &payload);
    let (_folder, definitions) = tow();
    check_ulog(&log.bytes[..], &definitions)
}

#[test]
fn ignores_unused_array_elements() {
    let knot = (3, [1, 2, 3], 1);
    let firm = [knot, knot];
    for (ropes, num_knots, knots, path) in [
        ((4, [10; 4]), 2, firm, ""),
        ((2, [10, 10, 0, 255]), 2, firm, ""),
        ((0, [0; 4]), 0, [(9, [0; 3], 153); 2], ""),
        ((3, [10, 10, 0, 255]), 2, firm, "ropes[2]"),
        ((4, [10; 4]), 1, [knot, (9, [0; 3], 153)], ""),
        ((4, [10; 4]), 2, [knot, (1, [1, 0, 0], 1)], ""),
        ((4, [10; 4]), 2, [knot, (2, [1, 0, 0], 1)], "knots[1].turns[1]"),
        ((4, [10; 4]), 2, [knot, (3, [1, 1, 1], 153)], "knots[1].is_firm"),
        // These counts don't indicate which elements are in use.
        ((4, [10; 4]), -1, [knot, (1, [0; 3], 1)], ""),
        ((255, [0; 4]), 2, firm, ""),
    ] {
        let result = check_tow(ropes, num_knots, knots);
        let paths: Vec<&str> =
            result.findings.groups().map(|group| group.examples[0].1.path.as_str()).collect();
        let expected: &[&str] = if path.is_empty() { &[] } else { &[path] };
        assert_eq!(paths, expected, "{ropes:?} {num_knots} {knots:?}");
    }
}
