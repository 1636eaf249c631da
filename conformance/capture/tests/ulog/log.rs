//! Tests of each problem with formats, subscriptions and data.

use uavspec_test_support::Writer;

use super::problems::{check, definitions};
use super::seen::problems;

#[test]
fn reports_data_without_a_type() {
    let mut log = definitions();
    let early = log.data(2, &[0; 16]);
    let again = log.data(2, &[0; 16]);
    let late = log.subscribe(2, 0, "wind");
    log.data(2, &[0; 16]);
    log.subscribe(3, 0, "nothing");
    let missing = log.data(3, &[0; 16]);
    log.unsubscribe(1);
    let gone = log.data(1, &[0; 16]);
    let twice = log.unsubscribe(1);
    log.subscribe(1, 0, "wind");
    log.data(1, &[0; 16]);
    let same = log.subscribe(1, 0, "wind");
    let other = log.subscribe(1, 1, "wind");
    let short = log.data(1, &[0; 11]);
    let between = log.data(1, &[0; 14]);
    let longer = log.data(1, &[0; 17]);
    log.data(1, &[0; 12]);
    let size = |found| format!("expected 16 or 12 bytes of data for id 1, found {found}");
    check(
        &log.bytes,
        &[
            (early, "data for id 2, which isn't subscribed"),
            (again, "data for id 2, which isn't subscribed"),
            (late, &format!("2 messages with id 2 precede its subscription; the first is at byte {early}")),
            (missing, "data for id 3, whose topic has no format"),
            (gone, "data for id 1, which was unsubscribed"),
            (twice, "id 1 is unsubscribed, but wasn't subscribed"),
            (same, "id 1 is subscribed again"),
            (other, "id 1 changes from `wind` instance 0 to `wind` instance 1"),
            (short, &size(11)),
            (between, &size(14)),
            (longer, &size(17)),
        ],
    );
    assert_eq!(problems(&log.bytes).1, 3);
}

#[test]
fn reports_unusable_and_late_formats() {
    let mut log = Writer::with_flags();
    let own = log.format("self:self a;");
    let waits = log.format("waits:later a;");
    log.format("good:uint8_t a;");
    log.format("good:uint8_t a;");
    log.subscribe(1, 0, "self");
    log.subscribe(2, 0, "waits");
    log.subscribe(3, 0, "good");
    let recursive = log.data(1, &[0; 4]);
    let waiting = log.data(2, &[0; 4]);
    log.data(3, &[0]);
    let later = log.format("later:uint32_t a;");
    log.data(2, &[0; 4]);
    log.data(3, &[0]);
    let more = log.format("more:uint8_t[9] a;");
    log.subscribe(4, 0, "more");
    log.data(4, &[0; 9]);
    let recursive_still = log.data(1, &[0; 4]);
    let unused = log.format("unused:what is it;");
    check(
        &log.bytes,
        &[
            (own, "format `self` contains itself"),
            (waits, "format `waits` has the field `a` with the unknown type `later`"),
            (recursive, "data for id 1, whose format is invalid"),
            (waiting, "data for id 2, whose format is invalid"),
            (later, "format `later` appears after the definitions section"),
            (more, "format `more` appears after the definitions section"),
            (recursive_still, "data for id 1, whose format is invalid"),
            (unused, "format `unused` appears after the definitions section"),
            (unused, "format `unused` has the field declaration `what is it`, expected a type and a name"),
        ],
    );
    assert_eq!(problems(&log.bytes).1, 4);
}

/// If a format is declared twice with different fields, the layout of its data is unknown.
#[test]
fn returns_no_data_of_ambiguous_formats() {
    let mut log = Writer::with_flags();
    log.format("good:uint8_t a;");
    let outer = log.format("outer:good a;");
    log.format("other:uint8_t a;");
    let changed = log.format("good:int8_t a;");
    let again = log.format("good:uint8_t b;");
    log.subscribe(1, 0, "good");
    log.subscribe(2, 0, "outer");
    log.subscribe(3, 0, "other");
    let data = log.data(1, &[0]);
    let nested = log.data(2, &[0]);
    log.data(3, &[0]);
    let late = log.format("other:int8_t a;");
    let after = log.data(3, &[0]);
    log.subscribe(4, 0, "good");
    let more = log.data(4, &[0]);
    let text = |name: &str| {
        format!("format `{name}` is declared again with different fields; data after this can't be decoded")
    };
    check(
        &log.bytes,
        &[
            (changed, &text("good")),
            (again, &text("good")),
            (outer, "format `outer` contains the unusable type `good`"),
            (data, "data for id 1, whose format is invalid"),
            (nested, "data for id 2, whose format is invalid"),
            (late, &text("other")),
            (after, "data for id 3, whose format is invalid"),
            (more, "data for id 4, whose format is invalid"),
        ],
    );
    assert_eq!(problems(&log.bytes).1, 1);
}

#[test]
fn stores_a_bounded_number_of_formats() {
    let mut log = Writer::with_flags();
    for index in 0..8_192 {
        log.format(&format!("f{index}:uint8_t a;"));
    }
    let more = log.format("more:uint8_t a;");
    check(&log.bytes, &[(more, "there are more than 8192 formats; the rest are ignored")]);

    let mut log = Writer::with_flags();
    let text = "x".repeat(60_000);
    for index in 0..17 {
        log.format(&format!("f{index}:uint8_t {text}"));
    }
    let more = log.format(&format!("more:uint8_t {text}"));
    let topic = log.subscribe(1, 0, &text);
    let problem = "ignored a format or topic: the limit for all formats and topics together is 1048576 bytes";
    check(&log.bytes, &[(more, problem), (topic, problem)]);

    let mut log = Writer::with_flags();
    for index in 0..15 {
        log.format(&format!("f{index}:uint8_t {text}"));
    }
    for id in 0..30 {
        log.format(&format!("late{id}:uint8_t a"));
        log.subscribe(id, 0, &format!("late{id}"));
        log.data(id, &[0]);
    }
    let found = problems(&log.bytes).0;
    let problem = "too many formats appear after the definitions section; later ones are ignored";
    assert_eq!(found.iter().filter(|found| found.ends_with(problem)).count(), 1, "{found:?}");
    assert!(found.last().is_some_and(|last| last.ends_with("data for id 29, whose format is invalid")));
}
