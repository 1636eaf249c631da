//! Tests that real logs have the same findings before and after conversion to JSON.

use std::fmt::Write as _;
use std::fs;

use uavspec_capture::ulog::{Log, Reader};
use uavspec_check::{CaptureResult, check_capture, check_json};
use uavspec_dynamic::Types;
use uavspec_model::Group;
use uavspec_px4::comparison::{Comparison, compare};
use uavspec_rules::definitions::Definitions;
use uavspec_test_captures::head_of_log as head;
use uavspec_test_support::{extent, shared};

use super::{corruption, source};

/// The messages in a log as rosbridge messages, for the topics whose format matches the definition. Also returns these
/// topics.
fn as_json(bytes: &[u8], definitions: &Definitions, types: &Types) -> (String, Vec<String>) {
    let (mut reader, mut log) = (Reader::new(bytes), Log::default());
    let (mut lines, mut topics) = (String::new(), Vec::new());
    while let Some(item) = reader.next().expect("bytes can be read") {
        let Some(record) = log.take(&item, &mut |_, _| {}) else { continue };
        let topic = &record.subscription.topic;
        let defined = definitions.message_of_topic(topic).map(|id| types.get(id));
        if !defined.is_some_and(|defined| compare(record.message_type, defined) == Comparison::Equal) {
            continue;
        }
        // JSON can't represent infinity.
        let view = record.message_type.view_uorb(record.payload).expect("a payload");
        let Ok(message) = view.to_json_text() else { continue };
        // Padding fields exist in logs only.
        let mut message: serde_json::Value = serde_json::from_str(&message).expect("JSON");
        unpad(&mut message);
        let instance = record.subscription.multi_id;
        writeln!(lines, r#"{{"op":"publish","topic":"/{instance}/{topic}","msg":{message}}}"#)
            .expect("memory");
        if !topics.contains(topic) {
            topics.push(topic.clone());
        }
    }
    (lines, topics)
}

fn unpad(value: &mut serde_json::Value) {
    match value {
        serde_json::Value::Object(members) => {
            members.retain(|name, _| !name.starts_with("_padding"));
            members.values_mut().for_each(unpad);
        }
        serde_json::Value::Array(values) => values.iter_mut().for_each(unpad),
        _ => {}
    }
}

/// The findings for these topics, from rules that apply to both kinds of captures.
fn findings(result: &CaptureResult, topics: &[String]) -> Vec<(&'static str, String, u64, Vec<String>)> {
    let of_both =
        ["PX-ENUM-01", "PX-LEN-01", "PX-NAN-01", "PX-QUEUE-01", "PX-RANGE-01", "PX-STR-01", "PX-TIME-01"];
    // The topics of the JSON messages are `/0/battery_status`.
    let name = |group: &Group| match group.subject.strip_prefix('/').and_then(|name| name.split_once('/')) {
        Some((instance, name)) => format!("{name} {instance}"),
        None => format!("{} {}", group.subject, group.instance.unwrap_or(0)),
    };
    let is_wanted = |group: &&Group| {
        let name = name(group);
        topics.iter().any(|topic| name.split(['.', ' ']).next() == Some(topic.as_str()))
    };
    let groups = result.findings.groups().filter(is_wanted);
    let groups = groups.filter(|group| !matches!(group.rule.id, "PX-BOOL-01" | "PX-FMT-01" | "PX-TIME-02"));
    groups
        .map(|group| {
            assert!(of_both.contains(&group.rule.id), "{group:?}");
            let message = group.examples.iter().map(|(_, detail)| detail.to_string()).collect();
            (group.rule.id, name(group), group.count, message)
        })
        .collect()
}

#[test]
fn real_logs_have_the_same_findings_as_json() {
    let (Some(logs), Some(corpus)) = (shared("corpus/ulog"), shared("corpus/px4")) else { return };
    let definitions = Definitions::load(&corpus.join("1.15")).expect("definitions");
    let types = Types::new(&definitions.schema);
    let mut checked = 0;
    for entry in fs::read_dir(&logs).expect("a folder") {
        let path = entry.expect("an entry").path();
        let whole = fs::read(&path).expect("a log");
        let bytes = head(&whole, extent(usize::MAX, 105_000));
        let (lines, topics) = as_json(bytes, &definitions, &types);
        let of_log = check_capture(bytes, None, &definitions).expect("bytes can be read");
        let of_json = check_json(lines.as_bytes(), None, &definitions);
        assert_eq!(corruption(&of_json), Vec::<String>::new(), "{}", path.display());
        assert_eq!(of_json.checked, source(&of_json).lines, "{}", path.display());
        assert_eq!(findings(&of_json, &topics), findings(&of_log, &topics), "{}", path.display());
        checked += of_json.checked;
    }
    assert!(checked > extent(1_000, 100), "{checked} messages have the format of the definitions");
}
