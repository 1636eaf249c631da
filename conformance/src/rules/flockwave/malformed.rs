//! Malformed requests. A server can answer malformed requests that have an id. In all cases, it must serve the next
//! request.

use serde_json::{Value, json};

/// The length of a string that is unreasonably long but still easy to process.
const LONG_LENGTH: usize = 10_000;

/// A nesting depth at which recursive JSON parsers fail.
const DEEP_NESTING: usize = 5_000;

/// A malformed request.
#[derive(Debug)]
pub(super) struct Malformed {
    /// A description of the fault.
    pub(super) how: &'static str,
    /// The text of the request.
    pub(super) text: String,
    /// True if a response with this id in `refs` can be expected.
    pub(super) has_id: bool,
}

/// One malformed request of each kind, with this id.
pub(super) fn all(id: &str) -> Vec<Malformed> {
    let envelope = |body: Value| json!({ "$fw.version": "1.0", "id": id, "body": body });
    let mut kinds: Vec<(&'static str, String, bool)> = [
        ("no version", json!({ "id": id, "body": { "type": "SYS-PING" } })),
        ("a version that is a number", json!({ "$fw.version": 1, "id": id, "body": { "type": "SYS-PING" } })),
        ("no body", json!({ "$fw.version": "1.0", "id": id })),
        ("a body that is null", envelope(Value::Null)),
        ("a body that is a string", envelope(json!("SYS-PING"))),
        ("a body that is a list", envelope(json!([{ "type": "SYS-PING" }]))),
        ("a body without a type", envelope(json!({}))),
        ("a type that is null", envelope(json!({ "type": null }))),
        ("a type that is a number", envelope(json!({ "type": 17 }))),
        ("a type that is an object", envelope(json!({ "type": { "type": "SYS-PING" } }))),
        ("missing ids", envelope(json!({ "type": "UAV-INF" }))),
        ("ids that are null", envelope(json!({ "type": "UAV-INF", "ids": null }))),
        ("ids that are a string", envelope(json!({ "type": "UAV-INF", "ids": "all" }))),
        ("ids that are an object", envelope(json!({ "type": "UAV-INF", "ids": { "id": 1 } }))),
        ("ids that are numbers", envelope(json!({ "type": "UAV-INF", "ids": [1, 2.5, -3] }))),
        ("a list nested in the list of ids", envelope(json!({ "type": "UAV-INF", "ids": [["uav"]] }))),
        ("an empty id in the list of ids", envelope(json!({ "type": "UAV-INF", "ids": [""] }))),
        ("a filter that is a string", envelope(json!({ "type": "OBJ-LIST", "filter": "uav" }))),
        (
            "both a body and an error",
            json!({
                "$fw.version": "1.0", "id": id,
                "body": { "type": "SYS-PING" }, "error": { "code": 1, "message": "invalid" },
            }),
        ),
    ]
    .map(|(how, message)| (how, message.to_string(), true))
    .into();
    let nested = format!("{}{}", "[".repeat(DEEP_NESTING), "]".repeat(DEEP_NESTING));
    let texts = [
        ("a duplicate key", r#"{"type":"SYS-PING","wing":1,"wing":2}"#.to_owned(), true),
        // Some JSON parsers reject these texts and never see the id.
        ("a number out of range", r#"{"type":"SYS-PING","height":1e999999}"#.to_owned(), false),
        (
            "a number with a thousand digits",
            format!(r#"{{"type":"SYS-PING","height":{}}}"#, "7".repeat(1_000)),
            false,
        ),
        ("an unpaired surrogate", r#"{"type":"SYS-PING","wing":"\ud800"}"#.to_owned(), false),
        (
            "lists nested five thousand levels deep",
            format!(r#"{{"type":"SYS-PING","wings":{nested}}}"#),
            false,
        ),
    ];
    let id_text = Value::from(id).to_string();
    for (how, body, has_id) in texts {
        kinds.push((how, format!(r#"{{"$fw.version":"1.0","id":{id_text},"body":{body}}}"#), has_id));
    }
    // FW-ENV-07 tests unknown types. Ids that are not strings are omitted, because the specification does not say what
    // a response should refer to.
    kinds.extend(
        [
            ("an empty type", envelope(json!({ "type": "" }))),
            ("a type with ten thousand characters", envelope(json!({ "type": "X".repeat(LONG_LENGTH) }))),
            ("no id", json!({ "$fw.version": "1.0", "body": { "type": "SYS-PING" } })),
            ("an empty object", json!({})),
            ("an empty list", json!([])),
            ("a number alone", json!(42)),
            ("a string alone", json!("SYS-PING")),
            ("null alone", Value::Null),
        ]
        .map(|(how, message)| (how, message.to_string(), false)),
    );
    kinds.into_iter().map(|(how, text, has_id)| Malformed { how, text, has_id }).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn malformed_requests_have_distinct_descriptions() {
        let all = all("kind-1");
        assert!(all.len() >= 20, "{}", all.len());
        let hows: BTreeSet<&str> = all.iter().map(|kind| kind.how).collect();
        assert_eq!(hows.len(), all.len());
        for kind in &all {
            assert!(!kind.text.contains('\n'), "{}", kind.how);
            assert!(!kind.has_id || kind.text.contains(r#""id":"kind-1""#), "{}", kind.how);
        }
    }
}
