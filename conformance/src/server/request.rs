//! What a client sent: a request, something that is nearly one, or nothing that can be answered.

use serde_json::{Map, Value};

/// The fields of a body.
pub(super) type Body = Map<String, Value>;

/// How many things a request may ask for. Answers are many times as long as the ids that they are about.
const LIST_LIMIT: usize = 10_000;

/// What came in.
#[derive(Debug, PartialEq)]
pub(super) enum Incoming {
    /// A request.
    Request {
        /// Its id.
        id: String,
        /// The type of its body.
        kind: String,
        /// Its body.
        body: Body,
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
        serde_json::from_slice(bytes).map_or(Self::Ignored, Self::of)
    }

    /// The same of a message that was read.
    pub(super) fn of(message: Value) -> Self {
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
        let Some(Value::Object(body)) = message.remove("body") else {
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

/// A list of strings that has to be there, each once.
pub(super) fn strings(body: &Body, name: &str) -> Result<Vec<String>, String> {
    optional_strings(body, name)?.ok_or_else(|| format!("{name} is missing"))
}

/// A list of strings that may be absent, each once.
pub(super) fn optional_strings(body: &Body, name: &str) -> Result<Option<Vec<String>>, String> {
    let items = match body.get(name) {
        None => return Ok(None),
        Some(Value::Array(items)) if items.len() > LIST_LIMIT => {
            return Err(format!("{name} has more than {LIST_LIMIT} elements: ask for less at once"));
        }
        Some(Value::Array(items)) => items,
        Some(_) => return Err(format!("{name} is no list")),
    };
    let mut seen = std::collections::HashSet::new();
    let mut found = Vec::new();
    for item in items {
        let Value::String(text) = item else {
            return Err(format!("{name} holds something that is no string"));
        };
        if seen.insert(text.as_str()) {
            found.push(text.clone());
        }
    }
    Ok(Some(found))
}

/// A string that has to be there.
pub(super) fn string<'b>(body: &'b Body, name: &str) -> Result<&'b str, String> {
    body.get(name)
        .ok_or_else(|| format!("{name} is missing"))?
        .as_str()
        .ok_or_else(|| format!("{name} is no string"))
}

/// A boolean; what it is where it is absent.
pub(super) fn boolean(body: &Body, name: &str, otherwise: Option<bool>) -> Result<bool, String> {
    match body.get(name) {
        None => otherwise.ok_or_else(|| format!("{name} is missing")),
        Some(value) => value.as_bool().ok_or_else(|| format!("{name} is no boolean")),
    }
}

/// An object that may be absent.
pub(super) fn object<'b>(body: &'b Body, name: &str) -> Result<Option<&'b Body>, String> {
    match body.get(name) {
        None => Ok(None),
        Some(value) => value.as_object().map(Some).ok_or_else(|| format!("{name} is no object")),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn requests_are_told_from_what_is_none() {
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
