//! Malformed requests. A server may refuse, ignore or answer a malformed request, but it must serve the next request.

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
}

/// One malformed request of each kind, with this id if possible.
pub(super) fn all(id: &str) -> Vec<Malformed> {
    let messages = envelopes(id).into_iter().chain(bodies(id)).chain(no_messages());
    let mut all: Vec<Malformed> =
        messages.map(|(how, message)| Malformed { how, text: message.to_string() }).collect();
    all.extend(texts(id));
    all
}

/// Requests with an invalid envelope.
fn envelopes(id: &str) -> Vec<(&'static str, Value)> {
    let valid = json!({ "$fw.version": "1.0", "id": id, "body": { "type": "SYS-PING" } });
    let with = |key: &str, value: Value| {
        let mut message = valid.clone();
        message[key] = value;
        message
    };
    let without = |key: &str| {
        let mut message = valid.clone();
        message.as_object_mut().and_then(|message| message.remove(key));
        message
    };
    vec![
        ("no version", without("$fw.version")),
        ("a version that is null", with("$fw.version", Value::Null)),
        ("a version that is a number", with("$fw.version", json!(1))),
        ("no id", without("id")),
        ("an id that is null", with("id", Value::Null)),
        ("an id that is a number", with("id", json!(17))),
        ("an id that is an object", with("id", json!({ "id": id }))),
        ("an empty id", with("id", json!(""))),
        ("an id of 65 characters", with("id", json!("x".repeat(65)))),
        ("an id of ten thousand characters", with("id", json!("x".repeat(LONG_LENGTH)))),
        ("`refs` that is null", with("refs", Value::Null)),
        ("`refs` that is a number", with("refs", json!(17))),
        ("no body", without("body")),
        ("a body that is null", with("body", Value::Null)),
        ("a body that is a string", with("body", json!("SYS-PING"))),
        ("a body that is a list", with("body", json!([{ "type": "SYS-PING" }]))),
        ("an error that is null", with("error", Value::Null)),
        ("both a body and an error", with("error", json!({ "code": 1, "message": "invalid" }))),
    ]
}

/// Requests with an invalid body. `FW-ENV-07` tests unknown types.
fn bodies(id: &str) -> Vec<(&'static str, Value)> {
    let bodies = [
        ("a body without a type", json!({})),
        ("a type that is null", json!({ "type": null })),
        ("a type that is a number", json!({ "type": 17 })),
        ("a type that is an object", json!({ "type": { "type": "SYS-PING" } })),
        ("an empty type", json!({ "type": "" })),
        ("a type with ten thousand characters", json!({ "type": "X".repeat(LONG_LENGTH) })),
        ("missing ids", json!({ "type": "UAV-INF" })),
        ("`ids` that is null", json!({ "type": "UAV-INF", "ids": null })),
        ("`ids` that is a string", json!({ "type": "UAV-INF", "ids": "all" })),
        ("`ids` that is an object", json!({ "type": "UAV-INF", "ids": { "id": 1 } })),
        ("numbers in the list of ids", json!({ "type": "UAV-INF", "ids": [1, 2.5, -3] })),
        ("a list nested in the list of ids", json!({ "type": "UAV-INF", "ids": [["uav"]] })),
        ("an empty id in the list of ids", json!({ "type": "UAV-INF", "ids": [""] })),
        ("a filter that is a string", json!({ "type": "OBJ-LIST", "filter": "uav" })),
    ];
    let envelope = |(how, body)| (how, json!({ "$fw.version": "1.0", "id": id, "body": body }));
    bodies.into_iter().map(envelope).collect()
}

/// JSON values that are not messages.
fn no_messages() -> Vec<(&'static str, Value)> {
    vec![
        ("an empty object", json!({})),
        ("an empty list", json!([])),
        ("a number alone", json!(42)),
        ("a string alone", json!("SYS-PING")),
        ("null alone", Value::Null),
    ]
}

/// Requests that some JSON parsers reject.
fn texts(id: &str) -> Vec<Malformed> {
    let nested = format!("{}{}", "[".repeat(DEEP_NESTING), "]".repeat(DEEP_NESTING));
    let digits = "7".repeat(1_000);
    let bodies = [
        ("a duplicate key", r#"{"type":"SYS-PING","wing":1,"wing":2}"#.to_owned()),
        ("a number out of range", r#"{"type":"SYS-PING","height":1e999999}"#.to_owned()),
        ("a number with a thousand digits", format!(r#"{{"type":"SYS-PING","height":{digits}}}"#)),
        ("an unpaired surrogate", r#"{"type":"SYS-PING","wing":"\ud800"}"#.to_owned()),
        ("lists nested five thousand levels deep", format!(r#"{{"type":"SYS-PING","wings":{nested}}}"#)),
    ];
    let id = Value::from(id);
    let envelope =
        |(how, body)| Malformed { how, text: format!(r#"{{"$fw.version":"1.0","id":{id},"body":{body}}}"#) };
    bodies.into_iter().map(envelope).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn malformed_requests_have_distinct_descriptions() {
        let all = all("kind-1");
        for how in ["an empty id", "an id that is null", "`refs` that is null", "an error that is null"] {
            assert!(all.iter().any(|kind| kind.how == how), "{how}");
        }
        let hows: BTreeSet<&str> = all.iter().map(|kind| kind.how).collect();
        assert_eq!(hows.len(), all.len());
        for kind in &all {
            assert!(!kind.text.contains('\n'), "{}", kind.how);
        }
    }
}
