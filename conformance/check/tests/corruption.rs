//! Tests of corrupt captures of all kinds: readable parts are checked, and corruption is reported.

use std::sync::LazyLock;

use uavspec_check::{CaptureResult, Summary, check_capture};
use uavspec_model::{Group, Level, Location};
use uavspec_rules::definitions::Definitions;
use uavspec_rules::sample::{Flight, PERIOD, ROUNDS, START};
use uavspec_test_support::{Random, extent};

static DEFINITIONS: LazyLock<Definitions> = LazyLock::new(Definitions::built_in);

fn checked(bytes: &[u8]) -> CaptureResult {
    check_capture(bytes, None, &DEFINITIONS).expect("bytes can be read")
}

/// A flight. In quick mode, it ends after a few rounds.
fn flight() -> Flight<'static> {
    let mut flight = Flight::new(&DEFINITIONS);
    let end = START + extent(ROUNDS, 8) * PERIOD;
    flight.messages.retain(|sent| sent.value["timestamp"].as_u64() < Some(end));
    flight
}

/// A capture of each kind, with its number of checked messages.
fn captures() -> Vec<(&'static str, Vec<u8>, u64)> {
    let flight = flight();
    let sources = [
        ("log", flight.log().to_bytes()),
        ("MCAP", flight.bag().to_bytes()),
        ("JSON Lines", flight.lines().to_bytes()),
        ("rosbridge", flight.rosbridge().to_bytes()),
    ];
    sources
        .map(|(name, bytes)| {
            let whole = checked(&bytes);
            assert_eq!((whole.checked, whole.corruption.len()), (flight.messages.len() as u64, 0), "{name}");
            (name, bytes, whole.checked)
        })
        .into()
}

/// Asserts that all reported corruption is within the capture.
fn assert_locations(name: &str, result: &CaptureResult, size: usize) {
    for (location, what) in &result.corruption {
        let (Location::Byte(at)
        | Location::Line(at)
        | Location::Message(at)
        | Location::Channel(at)
        | Location::Endpoint(at)) = *location;
        assert!(at <= size as u64, "{name}: {what} at {location} of {size}");
    }
}

/// A corrupt part may begin within a record. The rest of that record can then have any values.
#[test]
fn a_gap_in_a_log_violates_no_rule() {
    let log = flight().log().to_bytes();
    for fill in [0, 0xff] {
        for at in (0..log.len()).step_by(extent(7, 399)).skip(1) {
            let (start, end) = log.split_at(at);
            let result = checked(&[start, &[fill; 5_000], end].concat());
            let is_violation = |group: &&Group| group.rule.level != Level::Info;
            let found: Vec<_> = result.findings.groups().filter(is_violation).collect();
            assert!(found.is_empty(), "{fill:02x} at byte {at}: {found:?}");
        }
    }
}

#[test]
fn checks_records_before_a_truncation() {
    for (name, bytes, whole) in captures() {
        let mut before = 0;
        // JSON captures are ten times as long, and every truncated copy is read completely.
        let step = extent(1, 4) * if name == "log" || name == "MCAP" { 97 } else { 970 };
        for cut in (0..bytes.len()).step_by(step) {
            let result = checked(&bytes[..cut]);
            assert_locations(name, &result, cut);
            // More data can only increase the number of checked messages.
            assert!(result.checked >= before, "{name} cut at {cut}");
            before = result.checked;
            assert!(result.checked <= whole);
        }
        assert!(before + extent(4, 16) >= whole, "{name}: {before} of {whole} before the last cut");
    }
}

#[test]
fn a_flipped_bit_loses_few_messages() {
    let mut all_corrupt = 0;
    for (name, bytes, whole) in captures() {
        let mut random = Random(97);
        let mut corrupt = 0;
        let flips = if name == "log" || name == "MCAP" { extent(1_000, 20) } else { extent(250, 20) };
        for _ in 0..flips {
            // The magic and the flag bits are excluded: errors there make a log unreadable.
            let head = if name == "log" { 59 } else { 0 };
            let (at, bit) = (head + random.index(bytes.len() - head), random.below(8));
            let mut flipped = bytes.clone();
            flipped[at] ^= 1 << bit;
            let result = checked(&flipped);
            assert_locations(name, &result, bytes.len());
            corrupt += u64::from(!result.corruption.is_empty());
            // The flipped bit may affect a definition. In that case, all messages of its topic are lost, and this is
            // reported.
            let lost = whole - result.checked.min(whole);
            let is_ordered = !result.corruption.is_empty()
                || result.records > result.checked
                || result.findings.groups().next().is_some();
            // A data message that turned into a text message counts as one lost message.
            assert!(lost <= 1 || is_ordered, "{name}: {lost} lost after bit {bit} of byte {at}");
            assert!(
                lost <= 3 * ROUNDS,
                "{name}: {lost} lost after bit {bit} of byte {at}: {:?}",
                result.corruption
            );
        }
        assert!(
            corrupt >= extent(11, 0),
            "{name}: only {corrupt} of {flips} flipped bits were reported as corruption"
        );
        all_corrupt += corrupt;
    }
    // In quick mode, there may be too few flipped bits in a single capture.
    assert!(all_corrupt > 2, "only {all_corrupt} flipped bits were reported as corruption");
}

#[test]
fn checks_sections_in_the_wrong_order() {
    for (name, bytes, _) in captures() {
        let mut random = Random(5);
        for _ in 0..extent(50, 15) {
            let mut cuts = [random.index(bytes.len()), random.index(bytes.len()), random.index(bytes.len())];
            cuts.sort_unstable();
            let [first, second, third] = cuts;
            let swapped =
                [&bytes[..first], &bytes[second..third], &bytes[first..second], &bytes[third..]].concat();
            let result = checked(&swapped);
            assert_locations(name, &result, bytes.len());
        }
    }
}

#[test]
fn reports_noise_from_the_start() {
    let unknown = |bytes: &[u8]| match checked(bytes).summary {
        Summary::Unknown(summary) => Some(summary.reason),
        _ => None,
    };
    let noise = Random(3).bytes(1 << 20);
    for start in
        [&b"{"[..], b"ULog\x01\x12\x35\x01\0\0\0\0\0\0\0\0", b"[", b"{\"type\":\"px4/Event\",\"message\":"]
    {
        let result = checked(&[start, &noise].concat());
        assert_eq!(result.checked, 0, "{start:?}");
        assert!(!result.corruption.is_empty(), "{start:?}");
        assert_locations("noise", &result, start.len() + noise.len());
    }
    for start in [&b"ULoG\x01\x12\x35\x01"[..], &[0; 20], &noise, b"\xff\xfd{\0}\0", b"\x01\x02"] {
        let expected = format!(
            "unknown file type: expected ULog, MCAP, rosbag2 or JSON, found the bytes {:02x} ",
            start[0]
        );
        let reason = unknown(start);
        assert!(reason.as_deref().is_some_and(|reason| reason.starts_with(&expected)), "{reason:?}");
    }
    for (start, reason) in [
        (&b""[..], "the file is empty"),
        (
            b"# Notes\nfine {day}\n",
            "unknown file type: expected ULog, MCAP, rosbag2 or JSON, found `# Notes\\n`",
        ),
        (b"%FDF-1.7\n%\xe2", "unknown file type: expected ULog, MCAP, rosbag2 or JSON, found `%FDF-1.7`"),
    ] {
        assert_eq!(unknown(start).as_deref(), Some(reason));
    }
    // A file with a single wrong byte, or with text in another script, counts as corrupt, not as an unknown type.
    for start in [&b"\x1b{\"type\":1}\n"[..], "\u{feff}{\"ключ\":1}".as_bytes()] {
        assert_eq!(unknown(start), None, "{}", start.escape_ascii());
    }
}
