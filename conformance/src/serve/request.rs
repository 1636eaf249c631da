//! What a client sent: a request, something that is nearly one, or nothing that can be answered.

use std::collections::HashSet;

use serde::Deserialize;
use serde_json::Value;
use uavspec::flockwave::json::Request;

/// How many things a request may ask for. Answers are many times as long as the ids that they are about.
const LIST_LIMIT: usize = 10_000;

/// The longest reason for which a body isn't read, in characters.
const REASON_LIMIT: usize = 300;

/// What came in.
#[derive(Debug, PartialEq)]
pub(super) enum Incoming {
    /// A request.
    Request {
        /// Its id.
        id: String,
        /// The type of its body.
        kind: String,
        /// Its body: an object.
        body: Value,
    },
    /// No proper request, but it has an id by which the answer can say so.
    Malformed {
        /// The id.
        id: String,
        /// What is wrong.
        reason: String,
    },
    /// Nothing that an answer could refer to, or an answer itself, which nobody answers.
    Ignored,
}

impl Incoming {
    /// Reads what came in.
    pub(super) fn parse(bytes: &[u8]) -> Self {
        serde_json::from_slice(bytes).map_or(Self::Ignored, Self::from_value)
    }

    /// The same of a message that was read.
    pub(super) fn from_value(message: Value) -> Self {
        let Value::Object(mut message) = message else { return Self::Ignored };
        let Some(Value::String(id)) = message.remove("id") else { return Self::Ignored };
        if message.contains_key("refs") {
            return Self::Ignored;
        }
        let malformed = |reason: &str| Self::Malformed { id: id.clone(), reason: reason.to_owned() };
        match message.get("$fw.version") {
            None => return malformed("the envelope has no $fw.version"),
            Some(Value::String(version)) if is_version(version) => {}
            Some(_) => return malformed("$fw.version is no version, such as \"1.0\""),
        }
        if message.contains_key("error") {
            return malformed("a request has a body, and no error");
        }
        let Some(body) = message.remove("body").filter(Value::is_object) else {
            return malformed("the body is no object");
        };
        let Some(Value::String(kind)) = body.get("type") else {
            return malformed("the type of the body is no string");
        };
        Self::Request { id: id.clone(), kind: kind.clone(), body }
    }
}

/// One to three numbers with dots between them.
fn is_version(text: &str) -> bool {
    let is_number = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    text.split('.').count() <= 3 && text.split('.').all(is_number)
}

/// Reads the body of a request.
pub(super) fn read(body: &Value) -> Result<Request, String> {
    // What is wrong with a body is told with words of it, which can be as long as a message.
    Request::deserialize(body).map_err(|error| error.to_string().chars().take(REASON_LIMIT).collect())
}

/// A list that isn't too long.
pub(super) fn limited<T>(list: Vec<T>) -> Result<Vec<T>, String> {
    if list.len() <= LIST_LIMIT {
        Ok(list)
    } else {
        Err(format!("a list has more than {LIST_LIMIT} elements: ask for less at once"))
    }
}

/// The elements of a list that isn't too long, each once.
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
        fn nothing_makes_it_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = Incoming::parse(&bytes);
        }
    }
}
