//! Differences between the specification and the answers that the client Skybrush Live expects.

use serde_json::{Value, json};

/// The prefix of types that the client uses instead of the specified ones, as in `X-RTK-SOURCE`.
const PREFIX: &str = "X-";

/// Replaces the client's type of a request with the specified type.
pub(super) fn specified(request: &Value) -> Value {
    let mut request = request.clone();
    if let Some(kind) = request["type"].as_str().and_then(|kind| kind.strip_prefix(PREFIX)) {
        request["type"] = kind.into();
    }
    request
}

/// Converts the specified answer to a request to the form that the client expects.
pub(super) fn expected(request: &Value, mut answer: Value) -> Value {
    let asked = request["type"].as_str().unwrap_or_default();
    let kind = asked.strip_prefix(PREFIX).unwrap_or(asked);
    if answer["type"] != kind {
        return answer;
    }
    match kind {
        "RTK-SURVEY" if request.get("settings").is_some() => return json!({ "type": "ACK-ACK" }),
        "UAV-PREFLT" => answer["result"] = answer["status"].clone(),
        _ => {}
    }
    answer["type"] = asked.into();
    answer
}
