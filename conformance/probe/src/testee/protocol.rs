//! The protocol between uavspec and a testee: one line of JSON per message.
//!
//! ```text
//! → {"op":"hello","protocol":1}
//! ← {"op":"hello","name":"my-codec","version":"1.2","ops":["decode"],"types":["px4/Event"],"formats":["uorb"]}
//! → {"id":17,"op":"decode","type":"px4/Event","format":"uorb","bytes":"<base64>"}
//! ← {"id":17,"ok":{"timestamp":5,…}}   or "rejected":"reason"   or "unsupported":true   or "error":"…"
//! ```
//!
//! | op | input | `ok` contains |
//! |---|---|---|
//! | `decode` | `format` (`uorb`, `cdr`), `bytes` | the message |
//! | `encode` | `format`, `value` | bytes |
//! | `roundtrip` | `format`, `bytes` | the bytes after decoding and encoding |
//! | `validate` | `value` | any value |
//! | `severity` | `value`: an error code | `{"class": "warning", "severity": "warning"}` |
//! | `hash` | `format` | for `uorb`, PX4's hash of the fields as a number; for `cdr`, the ROS hash `RIHS01_…` |
//! | `decode-event` | `event`: its id; `bytes`: its arguments; `profile` (`normal`, `dev`) | `{"id": …, "name": …, "arguments": {…}, "message": …, "description": …}` |
//! | `layout` | `format` (`uorb`) | `{"size": …, "size_no_padding": …, "offsets": {"timestamp": 0, …}}` |
//!
//! An id is an integer within ±2^53. The response is `unsupported` or `error` if the request lacks a member, or names
//! an op, type or format that the testee doesn't know. A request without an id gets no response, or an `error` without
//! an id.

use std::collections::BTreeSet;
use std::fmt;

use serde_json::{Value, json};
use uavspec_model::json::shortened;
use uavspec_model::text::utf8;

use super::wire::integer;

/// The version of the protocol.
pub const PROTOCOL: u32 = 1;

/// An operation of a testee.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Op {
    /// Converts bytes to JSON.
    Decode,
    /// Converts JSON to bytes.
    Encode,
    /// Decodes bytes and encodes the result.
    Roundtrip,
    /// Accepts or rejects JSON.
    Validate,
    /// Returns the class and severity of an error code.
    Severity,
    /// Returns the hash that shows whether two sides use the same message definition.
    Hash,
    /// Returns the size and field offsets of the message in memory.
    Layout,
    /// Returns the arguments and texts of an event.
    DecodeEvent,
}

impl Op {
    /// All operations.
    pub const ALL: [Self; 8] = [
        Self::Decode,
        Self::Encode,
        Self::Roundtrip,
        Self::Validate,
        Self::Severity,
        Self::Hash,
        Self::Layout,
        Self::DecodeEvent,
    ];

    /// The name on the wire.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Decode => "decode",
            Self::Encode => "encode",
            Self::Roundtrip => "roundtrip",
            Self::Validate => "validate",
            Self::Severity => "severity",
            Self::Hash => "hash",
            Self::Layout => "layout",
            Self::DecodeEvent => "decode-event",
        }
    }
}

/// A binary format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Format {
    /// The message in memory, as PX4 stores it.
    Uorb,
    /// CDR with its encapsulation header; written in little-endian order.
    Cdr,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 2] = [Self::Uorb, Self::Cdr];

    /// The name on the wire.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Uorb => "uorb",
            Self::Cdr => "cdr",
        }
    }
}

/// The introduction of a testee.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Hello {
    /// The name of the testee.
    pub name: String,
    /// The version of the testee; empty if unknown.
    pub version: String,
    /// The supported operations, without names that this version doesn't know.
    pub ops: Vec<Op>,
    /// The supported types, such as `px4/Event`.
    pub types: BTreeSet<String>,
    /// The supported formats; all formats if the testee doesn't list them.
    pub formats: Vec<Format>,
}

impl Hello {
    /// The request for a hello.
    pub(crate) fn request() -> String {
        json!({ "op": "hello", "protocol": PROTOCOL }).to_string()
    }

    /// Parses a hello.
    pub(crate) fn read(line: &[u8]) -> Result<Self, String> {
        let value: Value = serde_json::from_slice(line).map_err(|error| format!("invalid JSON: {error}"))?;
        if value["op"] != "hello" {
            return Err("expected \"op\":\"hello\"".to_owned());
        }
        if let Some(other) = value.get("protocol").filter(|version| **version != PROTOCOL) {
            return Err(format!(
                "expected protocol version {PROTOCOL}, found {}",
                shortened(&other.to_string())
            ));
        }
        let text = |name: &str| value[name].as_str().map(str::to_owned);
        let list = |name: &str| -> Result<Vec<String>, String> {
            let items = value[name].as_array().ok_or_else(|| format!("expected \"{name}\" to be a list"))?;
            let items = items.iter().map(|item| item.as_str().map(str::to_owned));
            items.collect::<Option<_>>().ok_or_else(|| format!("expected \"{name}\" to contain only strings"))
        };
        let (ops, formats) = (list("ops")?, value.get("formats").map(|_| list("formats")).transpose()?);
        let is_listed = |name: &str| formats.as_ref().is_none_or(|listed| listed.iter().any(|it| it == name));
        Ok(Self {
            name: text("name").ok_or("\"name\" is missing")?,
            version: text("version").unwrap_or_default(),
            ops: Op::ALL.into_iter().filter(|op| ops.iter().any(|name| name == op.name())).collect(),
            types: list("types")?.into_iter().collect(),
            formats: Format::ALL.into_iter().filter(|format| is_listed(format.name())).collect(),
        })
    }
}

impl fmt::Display for Hello {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let space = if self.version.is_empty() { "" } else { " " };
        write!(f, "{}{space}{}", self.name, self.version)
    }
}

/// The response of a testee to a case.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Response {
    /// The result.
    Ok(Value),
    /// The input is invalid, for this reason.
    Rejected(String),
    /// The testee doesn't support the request.
    Unsupported,
    /// The request failed for a reason other than invalid input.
    Error(String),
}

impl Response {
    /// Parses a line into the id and the response.
    pub(crate) fn read(line: &[u8]) -> Result<(i64, Self), String> {
        let mut value = json(line)?;
        let id = Some(&value["id"]).filter(|id| id.is_number()).and_then(integer);
        let id = id.and_then(|id| i64::try_from(id).ok()).ok_or("expected \"id\" to be an integer")?;
        let Some(name) = Self::kind(&value) else {
            // The id is known, so this is the response to that case. No other response is expected.
            let wrong = "expected exactly one of \"ok\", \"rejected\", \"unsupported\" and \"error\"";
            return Ok((id, Self::Error(wrong.to_owned())));
        };
        // A result may be megabytes long, so it isn't copied.
        let member = value.get_mut(name).map(Value::take).unwrap_or_default();
        let answer = match name {
            "ok" => Self::Ok(member),
            "rejected" => Self::Rejected(text(member)),
            "unsupported" if member == true => Self::Unsupported,
            "unsupported" => Self::Error(format!("\"unsupported\": expected true, found {member}")),
            _ => Self::Error(text(member)),
        };
        Ok((id, answer))
    }

    /// The name of the member that contains the response; `None` if there are several, or none.
    fn kind(value: &Value) -> Option<&'static str> {
        let kinds = ["ok", "rejected", "unsupported", "error"];
        let mut found = kinds.into_iter().filter(|name| value.get(*name).is_some());
        found.next().filter(|_| found.next().is_none())
    }

    /// Like [`read`](Self::read), but returns an error response for an unreadable line that starts with an id. Many
    /// libraries write a bare `NaN`, for example. If such a line were ignored, the probe would wait for the response
    /// until the timeout.
    pub(crate) fn read_lenient(line: &[u8]) -> Result<(i64, Self), String> {
        Self::read(line).or_else(|wrong| match leading_id(line) {
            Some(id) => Ok((id, Self::Error(wrong))),
            None => Err(wrong),
        })
    }
}

fn json(line: &[u8]) -> Result<Value, String> {
    let text = utf8(line)?;
    serde_json::from_str(text).map_err(|error| format!("invalid JSON: {error}"))
}

/// The text of a reason, which should be a string.
fn text(value: Value) -> String {
    match value {
        Value::String(text) => text,
        other => other.to_string(),
    }
}

/// The id at the beginning of a line that can't be parsed.
fn leading_id(line: &[u8]) -> Option<i64> {
    let mut rest = line;
    for part in ["{", "\"id\"", ":"] {
        rest = rest.strip_prefix(part.as_bytes())?.trim_ascii_start();
    }
    let end = rest.iter().position(|byte| !byte.is_ascii_digit() && *byte != b'-')?;
    std::str::from_utf8(&rest[..end]).ok()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_the_capabilities_of_a_hello() {
        let line =
            r#"{"op":"hello","name":"x","ops":["decode","dance"],"types":["px4/Event"],"formats":["cdr"]}"#;
        let hello = Hello::read(line.as_bytes()).expect("a hello");
        assert_eq!(
            (hello.ops.as_slice(), hello.formats.as_slice()),
            ([Op::Decode].as_slice(), [Format::Cdr].as_slice())
        );
        assert_eq!(hello.to_string(), "x");
        for (line, wrong) in [
            ("{}", "\"op\""),
            ("hello", "invalid JSON"),
            (r#"{"op":"hello","ops":[],"types":[]}"#, "\"name\""),
            (r#"{"op":"hello","name":"x","types":[]}"#, "\"ops\""),
            (r#"{"op":"hello","name":"x","ops":[1],"types":[]}"#, "strings"),
            (r#"{"op":"hello","protocol":2}"#, "found 2"),
            (&format!(r#"{{"op":"hello","protocol":"{}"}}"#, "2".repeat(10_000)), "found \"2"),
        ] {
            let text = Hello::read(line.as_bytes()).expect_err(line);
            assert!(text.contains(wrong) && text.len() < 200, "{text}");
        }
    }

    #[test]
    fn reads_the_four_kinds_of_responses() {
        let read = |line: &str| Response::read(line.as_bytes());
        assert_eq!(read(r#"{"id":1,"ok":null}"#), Ok((1, Response::Ok(Value::Null))));
        let message = json!({ "mark": [{ "ok": 1 }, null, "ok"] });
        assert_eq!(read(&format!("{{\"id\":1,\"ok\":{message}}}")), Ok((1, Response::Ok(message))));
        assert_eq!(read(r#"{"id":2,"rejected":"short"}"#), Ok((2, Response::Rejected("short".to_owned()))));
        assert_eq!(read(r#"{"id":3,"unsupported":true}"#), Ok((3, Response::Unsupported)));
        assert_eq!(read(r#"{"id":4,"error":{"no":1}}"#), Ok((4, Response::Error(r#"{"no":1}"#.to_owned()))));
        for wrong in [r#"{"id":1}"#, r#"{"id":1,"ok":1,"error":""}"#] {
            assert!(matches!(read(wrong), Ok((1, Response::Error(_)))), "{wrong}");
        }
        for wrong in ["false", "null", "1", "\"no\""] {
            let (_, text) = read(&format!("{{\"id\":5,\"unsupported\":{wrong}}}")).expect("a response");
            assert!(matches!(&text, Response::Error(why) if why.contains(wrong)), "{text:?}");
        }
        // Some JSON writers don't distinguish integers from whole floats.
        assert_eq!(read(r#"{"id":-5.0,"ok":null}"#), Ok((-5, Response::Ok(Value::Null))));
        for wrong in [
            r#"{"ok":1}"#,
            r#"{"id":0.5,"ok":1}"#,
            r#"{"id":{"$u64":"1"},"ok":1}"#,
            r#"{"id":"1","ok":1}"#,
            "[]",
            "",
        ] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
        assert!(Response::read(b"\xff").expect_err("invalid UTF-8").contains("invalid UTF-8"));
        for (line, wrong) in [
            (&b"{ \"id\": 7, \"ok\": {\"speed\": NaN}}"[..], "invalid JSON"),
            (b"{\"id\":7,\"ok\":\"\xff\"}", "invalid UTF-8 at byte 14"),
            (b"{\"id\":7,", "invalid JSON"),
        ] {
            let Ok((7, Response::Error(why))) = Response::read_lenient(line) else { panic!("{line:?}") };
            assert!(why.starts_with(wrong), "{why}");
            assert_eq!(Response::read(line), Err(why));
        }
        for line in
            ["{\"id\":7", "{\"id\":\"7\"", "{\"ok\":{\"id\":7,", "{\"id\" 7,", "\"id\":7,", "{\"id\":-,"]
        {
            assert!(Response::read_lenient(line.as_bytes()).is_err(), "{line}");
        }
    }
}
