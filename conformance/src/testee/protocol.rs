//! What testees say: one line of JSON each.
//!
//! ```text
//! → {"op":"hello","protocol":1}
//! ← {"op":"hello","name":"my-codec","version":"1.2","ops":["decode"],"types":["px4/Event"],"formats":["uorb"]}
//! → {"id":17,"op":"decode","type":"px4/Event","format":"uorb","bytes":"<base64>"}
//! ← {"id":17,"ok":{"timestamp":5,…}}   or "rejected":"reason"   or "unsupported":true   or "error":"…"
//! ```
//!
//! | op | asks with | `ok` holds |
//! |---|---|---|
//! | `decode` | `format` (`uorb`, `cdr`), `bytes` | the message |
//! | `encode` | `format`, `value` | bytes |
//! | `roundtrip` | `format`, `bytes` | the bytes after decoding and encoding |
//! | `validate` | `value` | anything |
//! | `severity` | `value`: an error code | `{"class": "warning", "severity": "warning"}` |
//! | `hash` | `format` | PX4's hash of the fields as a number for `uorb`, ROS's `RIHS01_…` for `cdr` |
//! | `layout` | `format` (`uorb`) | `{"size": …, "size_no_padding": …, "offsets": {"timestamp": 0, …}}` |
//!
//! An id is an integer within ±2^53. A question that a testee doesn't understand, since it lacks a member or names an
//! op, a type or a format that the testee doesn't know, is answered with `unsupported` or `error`; what has no id gets
//! no answer, or one with `error` alone.

use std::fmt;

use serde_json::{Value, json};

use super::wire::integer;

/// The version of the protocol.
pub const PROTOCOL: u32 = 1;

/// What may be asked of a testee.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Op {
    /// Bytes to JSON.
    Decode,
    /// JSON to bytes.
    Encode,
    /// Bytes to bytes.
    Roundtrip,
    /// JSON to a verdict.
    Validate,
    /// An error code to its class.
    Severity,
    /// What tells whether two sides mean the same message.
    Hash,
    /// Where fields lie in memory.
    Layout,
}

impl Op {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Decode,
        Self::Encode,
        Self::Roundtrip,
        Self::Validate,
        Self::Severity,
        Self::Hash,
        Self::Layout,
    ];

    /// Its name on the wire.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Decode => "decode",
            Self::Encode => "encode",
            Self::Roundtrip => "roundtrip",
            Self::Validate => "validate",
            Self::Severity => "severity",
            Self::Hash => "hash",
            Self::Layout => "layout",
        }
    }
}

/// A binary form.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Format {
    /// The payload in memory.
    Uorb,
    /// CDR with its header; written little-endian.
    Cdr,
}

impl Format {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Uorb, Self::Cdr];

    /// Its name on the wire.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Uorb => "uorb",
            Self::Cdr => "cdr",
        }
    }
}

/// How a testee introduces itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Hello {
    /// Its name.
    pub name: String,
    /// Its version; empty where it says none.
    pub version: String,
    /// The ops that it takes; names that this version doesn't know are passed over.
    pub ops: Vec<Op>,
    /// The types that it knows, such as `px4/Event`.
    pub types: Vec<String>,
    /// The formats that it takes: both, where it doesn't say.
    pub formats: Vec<Format>,
}

impl Hello {
    /// The line that asks for it.
    pub(crate) fn request() -> String {
        json!({ "op": "hello", "protocol": PROTOCOL }).to_string()
    }

    /// Reads the answer; what is wrong with it, otherwise.
    pub(crate) fn read(line: &[u8]) -> Result<Self, String> {
        let value: Value = serde_json::from_slice(line).map_err(|error| format!("no JSON: {error}"))?;
        if value["op"] != "hello" {
            return Err("no member \"op\" with the value \"hello\"".to_owned());
        }
        if let Some(other) = value.get("protocol").filter(|version| **version != PROTOCOL) {
            return Err(format!(
                "it speaks version {other} of the protocol, and this program version {PROTOCOL}"
            ));
        }
        let text = |name: &str| value[name].as_str().map(str::to_owned);
        let list = |name: &str| -> Result<Vec<String>, String> {
            let items = value[name].as_array().ok_or_else(|| format!("no list \"{name}\""))?;
            let items = items.iter().map(|item| item.as_str().map(str::to_owned));
            items.collect::<Option<_>>().ok_or_else(|| format!("\"{name}\" holds more than strings"))
        };
        let (ops, formats) = (list("ops")?, value.get("formats").map(|_| list("formats")).transpose()?);
        let is_listed = |name: &str| formats.as_ref().is_none_or(|listed| listed.iter().any(|it| it == name));
        Ok(Self {
            name: text("name").ok_or("no member \"name\"")?,
            version: text("version").unwrap_or_default(),
            ops: Op::ALL.into_iter().filter(|op| ops.iter().any(|name| name == op.name())).collect(),
            types: list("types")?,
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

/// What a testee says to a case.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Answer {
    /// What came of it.
    Ok(Value),
    /// The input is wrong, and why.
    Rejected(String),
    /// It doesn't do this.
    Unsupported,
    /// It couldn't, through no fault of the input.
    Error(String),
}

impl Answer {
    /// Reads a line: the id, and the answer or what is wrong with it.
    pub(crate) fn read(line: &[u8]) -> Result<(i64, Self), String> {
        let value = json(line)?;
        let id = Some(&value["id"]).filter(|id| id.is_number()).and_then(integer);
        let id = id.and_then(|id| i64::try_from(id).ok()).ok_or("no member \"id\" with an integer")?;
        let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        let mut found = ["ok", "rejected", "unsupported", "error"]
            .into_iter()
            .filter_map(|name| Some((name, value.get(name)?)));
        let (Some((name, member)), None) = (found.next(), found.next()) else {
            // The case is known, so this is the answer to it, and needn't be waited for.
            let wrong = "not exactly one of \"ok\", \"rejected\", \"unsupported\" and \"error\"";
            return Ok((id, Self::Error(wrong.to_owned())));
        };
        let answer = match name {
            "ok" => Self::Ok(member.clone()),
            "rejected" => Self::Rejected(text(member)),
            "unsupported" if *member == true => Self::Unsupported,
            "unsupported" => Self::Error(format!("\"unsupported\" is {member}, where it can only be true")),
            _ => Self::Error(text(member)),
        };
        Ok((id, answer))
    }

    /// The same; of a line that can't be read the answer is that, where its id stands at its beginning. Many libraries
    /// write NaN by its name, and nobody has to wait for an answer that has come.
    pub(crate) fn read_or_blame(line: &[u8]) -> Result<(i64, Self), String> {
        Self::read(line).or_else(|wrong| match leading_id(line) {
            Some(id) => Ok((id, Self::Error(wrong))),
            None => Err(wrong),
        })
    }
}

fn json(line: &[u8]) -> Result<Value, String> {
    let text =
        std::str::from_utf8(line).map_err(|error| format!("no UTF-8 from byte {}", error.valid_up_to()))?;
    serde_json::from_str(text).map_err(|error| format!("no JSON: {error}"))
}

/// The id of a line that can't be read, where it stands at its beginning.
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
            ("hello", "no JSON"),
            (r#"{"op":"hello","ops":[],"types":[]}"#, "\"name\""),
            (r#"{"op":"hello","name":"x","types":[]}"#, "\"ops\""),
            (r#"{"op":"hello","name":"x","ops":[1],"types":[]}"#, "strings"),
            (r#"{"op":"hello","protocol":2}"#, "version 2"),
        ] {
            let text = Hello::read(line.as_bytes()).expect_err(line);
            assert!(text.contains(wrong), "{text}");
        }
    }

    #[test]
    fn an_answer_is_one_of_four() {
        let read = |line: &str| Answer::read(line.as_bytes());
        assert_eq!(read(r#"{"id":1,"ok":null}"#), Ok((1, Answer::Ok(Value::Null))));
        assert_eq!(read(r#"{"id":2,"rejected":"short"}"#), Ok((2, Answer::Rejected("short".to_owned()))));
        assert_eq!(read(r#"{"id":3,"unsupported":true}"#), Ok((3, Answer::Unsupported)));
        assert_eq!(read(r#"{"id":4,"error":{"no":1}}"#), Ok((4, Answer::Error(r#"{"no":1}"#.to_owned()))));
        for wrong in [r#"{"id":1}"#, r#"{"id":1,"ok":1,"error":""}"#] {
            assert!(matches!(read(wrong), Ok((1, Answer::Error(_)))), "{wrong}");
        }
        for wrong in ["false", "null", "1", "\"no\""] {
            let (_, text) = read(&format!("{{\"id\":5,\"unsupported\":{wrong}}}")).expect("an answer");
            assert!(matches!(&text, Answer::Error(why) if why.contains(wrong)), "{text:?}");
        }
        // Not every writer of JSON tells whole floats and integers apart.
        assert_eq!(read(r#"{"id":-5.0,"ok":null}"#), Ok((-5, Answer::Ok(Value::Null))));
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
        assert!(Answer::read(b"\xff").expect_err("no UTF-8").contains("no UTF-8"));
        for (line, wrong) in [
            (&b"{ \"id\": 7, \"ok\": {\"speed\": NaN}}"[..], "no JSON"),
            (b"{\"id\":7,\"ok\":\"\xff\"}", "no UTF-8 from byte 14"),
            (b"{\"id\":7,", "no JSON"),
        ] {
            let Ok((7, Answer::Error(why))) = Answer::read_or_blame(line) else { panic!("{line:?}") };
            assert!(why.starts_with(wrong), "{why}");
            assert_eq!(Answer::read(line), Err(why));
        }
        for line in
            ["{\"id\":7", "{\"id\":\"7\"", "{\"ok\":{\"id\":7,", "{\"id\" 7,", "\"id\":7,", "{\"id\":-,"]
        {
            assert!(Answer::read_or_blame(line.as_bytes()).is_err(), "{line}");
        }
    }
}
