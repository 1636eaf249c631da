//! Tests of the exact limits of rules on timing.

use serde_json::json;
use uavspec_check::{CaptureResult, PartResult, check_capture, check_ulog};
use uavspec_rules::rule;
use uavspec_test_support::Writer;

use super::{Glider, PERIOD, defined, run_check, start, violated};

/// The time of the first message. It isn't a multiple of the period, because logging starts later than the system.
const FIRST: u64 = 1_234_567;

/// Adds glider messages at these times.
fn at(log: &mut Writer, times: impl IntoIterator<Item = u64>) {
    for time in times {
        log.data(5, &Glider::at(time).bytes());
    }
}

/// Creates a log with this number of messages at regular times. Returns the log and the time of its last message.
fn regular(messages: u64) -> (Writer, u64) {
    let mut log = start();
    at(&mut log, (0..messages).map(|number| FIRST + number * PERIOD));
    (log, FIRST + (messages - 1) * PERIOD)
}

/// The first message of a topic may have been published long before logging began.
#[test]
fn the_duration_starts_when_logging_began() {
    let mut log = start();
    let began = u64::from_le_bytes(log.bytes[8..16].try_into().expect("8 bytes"));
    at(&mut log, [began - 900, began + PERIOD, began + 3 * PERIOD]);
    let result = run_check(&log);
    assert_eq!((result.checked, result.duration), (3, 2 * PERIOD));
    assert_eq!(violated(&result), []);
}

fn covered(result: &CaptureResult, id: &str) -> u64 {
    result.findings.covered(rule(id).expect("a rule"))
}

/// Asserts that a message at the time `last` has no finding, and that a message one microsecond later is reported after
/// a gap.
fn check_longest(log: &Writer, last: u64) {
    for (time, is_pause) in [(last, false), (last + 1, true)] {
        let mut log = log.clone();
        at(&mut log, [time]);
        let found: Vec<&str> = violated(&run_check(&log)).iter().map(|(rule, _)| *rule).collect();
        assert_eq!(found, if is_pause { vec!["PX-TIME-02"] } else { vec![] }, "at {time}");
    }
}

#[test]
fn reports_gaps_of_more_than_ten_periods() {
    let (mut log, last) = regular(40);
    check_longest(&log, last + 10 * PERIOD);
    at(&mut log, [last + 11 * PERIOD]);
    let result = run_check(&log);
    let group = result.findings.groups().next().expect("a finding");
    let detail = &group.examples[0].1;
    assert_eq!(detail.message, "no message for 220 ms, but the period is 20 ms");
    assert_eq!((&*detail.expected, &*detail.actual), ("at most 200 ms, or a dropout record", "220 ms"));
}

#[test]
fn reports_no_gap_before_the_period_is_learned() {
    for (messages, is_known) in [(32, false), (33, true)] {
        let (mut log, last) = regular(messages);
        at(&mut log, [last + 20 * PERIOD]);
        let result = run_check(&log);
        assert_eq!(violated(&result).len(), usize::from(is_known), "{messages}");
        assert_eq!(covered(&result, "PX-TIME-02"), u64::from(is_known), "{messages}");
    }
}

/// A log starts with the latest message of each topic. These messages may be old, and may have the same time.
#[test]
fn reports_no_gap_after_an_old_first_message() {
    for first in [FIRST - 1, FIRST - 100, FIRST - 500_000] {
        let mut log = start();
        at(&mut log, [first]);
        at(&mut log, (0..400).map(|number| FIRST + number * PERIOD));
        assert_eq!(violated(&run_check(&log)), [], "{first}");
    }
    let mut log = start();
    at(&mut log, (0..40).map(|number| FIRST + number * 20));
    at(&mut log, [FIRST + 39 * 20 + 300]);
    let result = run_check(&log);
    let detail = &result.findings.groups().next().expect("a finding").examples[0].1;
    assert_eq!(detail.message, "no message for 300 µs, but the period is 20 µs");
}

/// One irregular interval changes the learned period only slightly.
#[test]
fn learns_the_period_in_small_steps() {
    for (interval, period) in [(180_000, 21_250), (20_500, 20_500), (19_500, 19_500), (5_000, 18_750)] {
        let (mut log, last) = regular(40);
        at(&mut log, [last + interval]);
        check_longest(&log, last + interval + 10 * period);
    }
}

#[test]
fn ignores_equal_and_missing_times_when_learning_the_period() {
    let mut log = start();
    at(&mut log, (0..80).map(|number| FIRST + number / 2 * PERIOD));
    check_longest(&log, FIRST + 49 * PERIOD);
    at(&mut log, [0, 0, 0]);
    let last = FIRST + 60 * PERIOD;
    at(&mut log, [last]);
    assert_eq!(violated(&run_check(&log)), []);
    check_longest(&log, last + 10 * PERIOD);
}

#[test]
fn a_dropout_excuses_gaps_for_its_duration_and_one_second() {
    for (messages, is_excused) in [(70, true), (71, false)] {
        let (mut log, last) = regular(40);
        log.dropout(400);
        at(&mut log, (1..=messages).map(|number| last + number * PERIOD));
        at(&mut log, [last + (messages + 20) * PERIOD]);
        let found = violated(&run_check(&log)).len();
        assert_eq!(found, usize::from(!is_excused), "{messages} messages after it");
    }
}

#[test]
fn checks_impossible_times_like_others() {
    let mut log = start();
    at(&mut log, [1, u64::MAX].repeat(60));
    log.dropout(u16::MAX);
    at(&mut log, [1, u64::MAX, 0].repeat(60));
    let result = run_check(&log);
    assert_eq!(result.checked, 300);
    assert!(violated(&result).iter().all(|(rule, _)| *rule == "PX-TIME-01"));
}

#[test]
fn reports_one_finding_per_wrong_time() {
    let count = |times: &[u64]| {
        let mut log = start();
        at(&mut log, times.iter().copied());
        let result = run_check(&log);
        let found: Vec<u64> =
            result.findings.groups_of(rule("PX-TIME-01").expect("a rule")).map(|group| group.count).collect();
        found.first().copied().unwrap_or_default()
    };
    let [second, third, fourth] = [2, 3, 4].map(|number| FIRST + number * PERIOD);
    assert_eq!(count(&[FIRST, second, third]), 0);
    assert_eq!(count(&[1 << 60, FIRST, second, third]), 1, "the first is wrong");
    assert_eq!(count(&[FIRST, third, second, fourth]), 1, "one is late");
    assert_eq!(count(&[third, fourth, FIRST, second]), 1, "the flight controller restarts");
    assert_eq!(count(&[third, second, FIRST]), 2, "both go back");
    assert_eq!(count(&[third, 0, second]), 1, "a message without a time is ignored");
    assert_eq!(count(&[FIRST, 0, second]), 0);
}

/// After a new subscription with the same id, timing checks start over, even if the topic is the same.
#[test]
fn a_new_subscription_starts_over() {
    let (mut log, last) = regular(40);
    log.subscribe(5, 0, "glider");
    let mut pause = log.clone();
    at(&mut pause, [last + 20 * PERIOD]);
    assert_eq!(violated(&run_check(&pause)), []);
    at(&mut log, [FIRST]);
    assert_eq!(violated(&run_check(&log)), []);
}

#[test]
fn reports_a_queue_overflow_once() {
    for (messages, found) in [(1, 0), (2, 0), (3, 1), (9, 1)] {
        let (mut log, last) = regular(40);
        // Unpublished instances have no time, and are ignored.
        at(&mut log, [0; 5]);
        at(&mut log, vec![last + PERIOD; messages]);
        at(&mut log, [last + 2 * PERIOD, last + 2 * PERIOD]);
        let result = run_check(&log);
        let violated = violated(&result);
        assert_eq!(violated.len(), found, "{messages}: {violated:?}");
        assert_eq!(covered(&result, "PX-QUEUE-01"), 42 + messages as u64);
        if let Some(group) = result.findings.groups().next() {
            assert_eq!((group.rule.id, group.count), ("PX-QUEUE-01", 1));
        }
    }
}

const SONDE: &str = "\
uint32 MESSAGE_VERSION = 3

uint64 timestamp # [us] Time since system start

# TOPICS sonde sonde_v8 sonde_v9
";

/// Checks a log with these topics and times. The definition of these topics specifies no queue length.
fn check_sonde(topics: &[&str], times: &[u64]) -> CaptureResult {
    let (_folder, definitions) = defined(&[("Sonde.msg", SONDE)]);
    let mut log = Writer::with_flags();
    for topic in topics {
        log.format(&format!("{topic}:uint64_t timestamp;"));
    }
    for (id, topic) in (0..).zip(topics) {
        log.subscribe(id, 0, topic);
        for time in times {
            log.data(id, &time.to_le_bytes());
        }
    }
    check_ulog(&log.bytes[..], &definitions)
}

/// Checks a rosbridge message on each of these PX4 topics.
fn check_published(topics: &[&str]) -> CaptureResult {
    let (_folder, definitions) = defined(&[("Sonde.msg", SONDE)]);
    let line = |topic: &&str| {
        let topic = format!("/fmu/out/{topic}");
        json!({"op": "publish", "topic": topic, "msg": {"timestamp": FIRST}}).to_string()
    };
    let lines: Vec<String> = topics.iter().map(line).collect();
    check_capture(lines.join("\n").as_bytes(), None, &definitions).expect("bytes can be read")
}

#[test]
fn a_topic_with_bursts_has_no_regular_period() {
    let mut log = start();
    // Five messages follow each other quickly. Then, there is a longer pause.
    at(&mut log, (0..40).flat_map(|burst| (0..5).map(move |number| FIRST + burst * 40 * PERIOD + number)));
    assert_eq!(violated(&run_check(&log)), []);
}

#[test]
fn a_topic_without_a_queue_may_repeat_times() {
    let result = check_sonde(&["sonde"], &[FIRST, FIRST, FIRST, FIRST + 1]);
    assert_eq!(violated(&result), []);
    assert_eq!(covered(&result, "PX-QUEUE-01"), 0);
}

#[test]
fn checks_only_timestamps_without_a_definition() {
    let result = check_sonde(&["balloon"], &[FIRST; 4]);
    assert_eq!(violated(&result), []);
    assert_eq!(covered(&result, "PX-QUEUE-01"), 0);
    assert_eq!(covered(&result, "PX-TIME-01"), 3);
}

#[test]
fn reads_a_version_suffix_unless_a_topic_has_that_name() {
    let result = check_published(&["sonde", "sonde_v8", "sonde_v9"]);
    assert_eq!((violated(&result), covered(&result, "PX-VER-01")), (vec![], 0));
    let result = check_published(&["sonde_v3"]);
    assert_eq!((violated(&result), covered(&result, "PX-VER-01")), (vec![], 1));
    let result = check_published(&["sonde_v3", "sonde_v4"]);
    let message = "/fmu/out/sonde_v4: the topic name has version 4, but the definition has version 3";
    assert_eq!(violated(&result), [("PX-VER-01", message.to_owned())]);
}

/// The name of a vendor's topic may end with any number.
#[test]
fn topics_in_logs_have_no_version() {
    let result = check_sonde(&["sonde", "sonde_v3", "sonde_v4", "sonde_v8"], &[FIRST]);
    assert_eq!((violated(&result), covered(&result, "PX-VER-01")), (vec![], 0));
    let results: Vec<PartResult> = result.coverage.parts.iter().map(|part| part.result).collect();
    let [checked, undefined] = [PartResult::Checked, PartResult::Undefined];
    assert_eq!(results, [checked, undefined, undefined, checked]);
}
