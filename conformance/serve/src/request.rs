//! Parses messages from clients: valid requests, malformed requests, and messages that get no answer.

use std::collections::HashSet;

use serde::Deserialize;
use serde_json::Value;
use uavspec_types::flockwave::json::Request;

/// The maximum length of lists in requests. Lists are limited because answers are much longer than the requested ids.
const LIST_LIMIT: usize = 10_000;

/// The maximum length of an error message, in characters.
const REASON_LIMIT: usize = 300;

/// A received message.
#[derive(Debug, PartialEq)]
pub(super) enum Incoming {
    /// A valid request.
    Request {
        /// The id of the message.
        id: String,
        /// The type of its body.
        kind: String,
        /// The body, which is an object.
        body: Value,
    },
    /// An invalid request with an id.
    Malformed {
        /// The id of the message.
        id: String,
        /// The error.
        reason: String,
    },
    /// A message without an id, or a response. Neither gets an answer.
    Ignored,
}

impl Incoming {
    /// Parses a message.
    pub(super) fn parse(bytes: &[u8]) -> Self {
        serde_json::from_slice(bytes).map_or(Self::Ignored, Self::from_value)
    }

    /// Reads a message from parsed JSON.
    pub(super) fn from_value(message: Value) -> Self {
        let Value::Object(mut message) = message else { return Self::Ignored };
        let Some(Value::String(id)) = message.remove("id") else { return Self::Ignored };
        if message.contains_key("refs") {
            return Self::Ignored;
        }
        let malformed = |reason: &str| Self::Malformed { id: id.clone(), reason: reason.to_owned() };
        match message.get("$fw.version") {
            None => return malformed("$fw.version is missing"),
            Some(Value::String(version)) if is_version(version) => {}
            Some(_) => return malformed("$fw.version must be a version such as \"1.0\""),
        }
        if message.contains_key("error") {
            return malformed("a request must not have an error");
        }
        let Some(body) = message.remove("body").filter(Value::is_object) else {
            return malformed("the body must be an object");
        };
        let Some(Value::String(kind)) = body.get("type") else {
            return malformed("the type of the body must be a string");
        };
        Self::Request { id: id.clone(), kind: kind.clone(), body }
    }
}

/// True if a text consists of one to three numbers, separated by dots.
fn is_version(text: &str) -> bool {
    let is_number = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    text.split('.').count() <= 3 && text.split('.').all(is_number)
}

/// Parses the body of a request.
pub(super) fn read(body: &Value) -> Result<Request, String> {
    // The error message may contain text from the body, which can be very long.
    Request::deserialize(body).map_err(|error| error.to_string().chars().take(REASON_LIMIT).collect())
}

/// Returns the list unchanged. Fails if it is too long.
pub(super) fn limited<T>(list: Vec<T>) -> Result<Vec<T>, String> {
    if list.len() <= LIST_LIMIT {
        Ok(list)
    } else {
        Err(format!("a list has more than {LIST_LIMIT} elements; request fewer"))
    }
}

/// Removes repeated elements from a list. Fails if the list is too long.
pub(super) fn each_once<T: Into<String>>(list: Vec<T>) -> Result<Vec<String>, String> {
    let list = limited(list)?;
    let mut seen = HashSet::new();
    let texts = list.into_iter().map(T::into);
    Ok(texts.filter(|text: &String| seen.insert(text.clone())).collect())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn distinguishes_requests_from_other_messages() {
        let good = r#"{"$fw.version":"1.0","id":"a","body":{"type":"SYS-VER"},"extra":1}"#;
        assert!(
            matches!(Incoming::parse(good.as_bytes()), Incoming::Request { id, kind, .. } if id == "a" && kind == "SYS-VER")
        );
        for (text, wrong) in [
            (r#"{"id":"a","body":{"type":"SYS-VER"}}"#, "$fw.version"),
            (r#"{"$fw.version":1.0,"id":"a","body":{"type":"SYS-VER"}}"#, "$fw.version"),
            (r#"{"$fw.version":"1.","id":"a","body":{"type":"SYS-VER"}}"#, "$fw.version"),
            (r#"{"$fw.version":"1.0","id":"a","body":[]}"#, "body"),
            (r#"{"$fw.version":"1.0","id":"a"}"#, "body"),
            (r#"{"$fw.version":"1.0","id":"a","body":{"type":7}}"#, "type"),
            (r#"{"$fw.version":"1.0","id":"a","body":{"type":"SYS-VER"},"error":{}}"#, "error"),
        ] {
            let Incoming::Malformed { reason, .. } = Incoming::parse(text.as_bytes()) else {
                panic!("{text}")
            };
            assert!(reason.contains(wrong), "{reason}");
        }
        for text in [
            "",
            "glider",
            "[]",
            r#"{"$fw.version":"1.0","id":7,"body":{"type":"SYS-VER"}}"#,
            r#"{"$fw.version":"1.0","id":"a","refs":"b","body":{"type":"ACK-ACK"}}"#,
        ] {
            assert_eq!(Incoming::parse(text.as_bytes()), Incoming::Ignored, "{text}");
        }
    }

    proptest! {
        #[test]
        fn parses_arbitrary_bytes_without_panicking(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = Incoming::parse(&bytes);
        }
    }
}
