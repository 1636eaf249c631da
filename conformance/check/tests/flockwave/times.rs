//! Tests of the times of records.

use super::*;

/// A session with three status reports at these record times. The second report has an earlier timestamp than the
/// first.
fn session(times: [&str; 3]) -> Vec<u8> {
    let report = |id: &str, timestamp: u64| {
        let status = json!({ "kite": { "id": "kite", "timestamp": timestamp, "heading": 3600 } });
        json!({ "$fw.version": "1.0", "id": id, "body": { "type": "UAV-INF", "status": status } })
    };
    let line = |time: &str, key: &str, value: &Value| {
        let direction = if key == "event" { "event" } else { "in" };
        format!("{{\"t\":{time},\"conn\":\"hill\",\"dir\":\"{direction}\",\"{key}\":{value}}}\n")
    };
    let [first, second, third] = times;
    let lines = [
        line(first, "event", &json!("connect")),
        line(second, "msg", &report("a", 1_790_000_001_000)),
        line(third, "msg", &report("b", 1_790_000_002_500)),
    ];
    lines.concat().into_bytes()
}

/// The times of the findings, in µs.
fn times_of(result: &CaptureResult) -> Vec<Option<u64>> {
    let examples = result.findings.groups().flat_map(|group| group.examples.iter());
    examples.map(|(_, detail)| detail.time).collect()
}

#[test]
fn all_forms_of_times_have_the_same_result() {
    let usual = checked(&session(["1790000000", "1790000001.5", "1790000003.25"]));
    assert_eq!(times_of(&usual), [Some(1_790_000_001_500_000), Some(1_790_000_003_250_000)]);
    for times in [
        ["\"1790000000\"", "\"1790000001.5\"", "\"1790000003.25\""],
        ["1790000000000", "1790000001500", "1790000003250"],
        ["1790000000000000000", "1790000001500000000", "1790000003250000000"],
        ["\"2026-09-21T14:13:20Z\"", "\"2026-09-21T14:13:21.5Z\"", "\"2026-09-21T16:13:23.250+02:00\""],
    ] {
        let result = checked(&session(times));
        assert_eq!(times_of(&result), times_of(&usual), "{times:?}");
        assert_eq!(source(&result).lines().len(), source(&usual).lines().len(), "{times:?}");
    }
}

/// A time that can't be read is reported, but doesn't affect the findings.
#[test]
fn reports_times_that_cannot_be_read() {
    for (times, expected) in [
        (["-1790000000.0", "-1", "-0.5"], "3 times can't be read, so these records have no time: "),
        (["\"2026-09-21T14:13:20\"", "1790000001", "1790000002"], "found \"2026-09-21T14:13:20\" at line 1"),
        (["1790000000", "1e20", "1790000002"], "1 time can't be read"),
        (["null", "1790000001", "\"now\""], "found \"now\" at line 3"),
    ] {
        let result = checked(&session(times));
        assert_eq!(violated(&result), BTreeMap::from([("FW-UST-HEADING", 2)]), "{times:?}");
        let lines = source(&result).lines();
        let line = lines.iter().find(|line| line.label == "times").map(|line| line.text.clone());
        assert!(line.as_ref().is_some_and(|line| line.contains(expected)), "{times:?}: {line:?}");
    }
}
