//! Protocol violations that `uavspec testee lint` detects. `testee MODE` selects one of them.

use std::io::{self, BufRead, Write};
use std::process::{self, ExitCode};
use std::thread;
use std::time::Duration;

use serde_json::{Value, json};

/// The line limit of a testee with a fixed-size buffer.
const BUFFER: usize = 64 << 10;

pub(crate) struct ProtocolFault {
    mode: String,
}

impl ProtocolFault {
    pub(crate) fn read(arguments: &[String]) -> Self {
        Self { mode: arguments.first().cloned().unwrap_or_default() }
    }

    fn is(&self, mode: &str) -> bool {
        self.mode == mode
    }

    /// Reads the next line; `None` at the end.
    pub(crate) fn read_line(&self, input: &mut impl BufRead) -> io::Result<Option<Vec<u8>>> {
        let mut line = Vec::new();
        if self.is("first-line-of-read") || self.is("read-is-line") {
            line.extend(input.fill_buf()?);
            input.consume(line.len());
            if line.is_empty() {
                return Ok(None);
            }
            if self.is("first-line-of-read") {
                line.truncate(line.iter().position(|byte| *byte == b'\n').unwrap_or(line.len()));
            }
            return Ok(Some(line));
        }
        if input.read_until(b'\n', &mut line)? == 0 {
            return Ok(None);
        }
        if self.is("short-buffer") {
            line.truncate(BUFFER);
        }
        Ok(Some(line))
    }

    /// Handles a line that isn't JSON.
    pub(crate) fn unreadable(&self, line: &[u8]) {
        let is_empty = line.trim_ascii().is_empty();
        let is_utf8 = std::str::from_utf8(line).is_ok();
        if self.is("crash-empty") && is_empty
            || self.is("crash-not-utf8") && !is_utf8
            || self.is("crash-not-json") && is_utf8 && !is_empty
        {
            process::exit(9);
        }
    }

    /// True if the request gets no response. `count` is the number of preceding requests, including the hello.
    pub(crate) fn is_ignored(&self, request: &Value, count: usize) -> bool {
        let is_second_hello = request["op"] == "hello" && count > 0;
        if self.is("crash-second-hello") && is_second_hello {
            process::exit(8);
        }
        self.is("silent-unknown-op") && request["op"] == "levitate"
    }

    /// Applies faults that precede the response. In `guess-…` modes, replaces invalid members of the request.
    pub(crate) fn before(&self, request: &mut Value, output: &mut impl Write) -> io::Result<()> {
        let is_known = |value: &Value| value == "uorb" || value == "cdr";
        match self.mode.as_str() {
            "chatty" if request["op"] != "hello" => writeln!(output, "asked for {}", request["op"])?,
            "guess-format" if request.get("format").is_some_and(|format| !is_known(format)) => {
                request["format"] = "uorb".into();
            }
            "guess-member" if request.get("format").is_none() && request.get("bytes").is_some() => {
                request["format"] = "uorb".into();
            }
            "short-ids" => {
                #[allow(clippy::cast_possible_truncation)] // this is the fault
                if let Some(id) = request["id"].as_i64() {
                    request["id"] = (id as i32).into();
                }
            }
            "unsigned-ids" => {
                if let Some(id) = request["id"].as_i64() {
                    request["id"] = id.unsigned_abs().into();
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Corrupts the response.
    pub(crate) fn corrupt(&self, request: &Value, response: &mut Value) {
        let is_hello = request["op"] == "hello";
        match self.mode.as_str() {
            "hello-unknown-op" if is_hello => response["ops"] = json!(["decode", "levitate"]),
            "hello-unknown-format" if is_hello => response["formats"] = json!(["uorb", "morse"]),
            "hello-no-version" if is_hello => response["version"] = Value::Null,
            "hello-odd-type" if is_hello => response["types"] = json!(["px4/Event", "Event"]),
            "hello-protocol" if is_hello => response["protocol"] = json!(2),
            "accept-unknown-op" if request["op"] == "levitate" => replace(response, "ok", Value::Null),
            "reject-unknown" if !is_hello && response.get("unsupported").is_some() => {
                replace(response, "rejected", "no such type".into());
            }
            "reject-missing" if !is_hello && response.get("error").is_some() => {
                replace(response, "rejected", "no such member".into());
            }
            "untagged-integers" if request["op"] == "decode" => untag(response, &["$u64", "$i64"]),
            "untagged-floats" if request["op"] == "decode" => untag(response, &["$f"]),
            "ignore-tags" if request["op"] == "encode" && request.to_string().contains("$u64") => {
                replace(response, "rejected", "no number".into());
            }
            _ => {}
        }
    }

    /// Ends the testee.
    pub(crate) fn at_end(&self) -> ExitCode {
        if self.is("stays") {
            loop {
                thread::sleep(Duration::from_secs(60));
            }
        }
        ExitCode::from(if self.is("ends-badly") { 5 } else { 0 })
    }
}

fn replace(response: &mut Value, member: &str, value: Value) {
    let mut other = json!({ "id": response["id"] });
    other[member] = value;
    *response = other;
}

/// Replaces tagged numbers with plain JSON numbers. NaN becomes null.
fn untag(value: &mut Value, tags: &[&str]) {
    let tagged = value.as_object().filter(|members| members.len() == 1).and_then(|members| {
        let (tag, text) = members.iter().next()?;
        tags.contains(&tag.as_str()).then(|| text.as_str().map(str::to_owned))?
    });
    match (tagged, value) {
        (Some(text), location) => *location = serde_json::from_str(&text).unwrap_or_default(),
        (None, Value::Array(items)) => items.iter_mut().for_each(|item| untag(item, tags)),
        (None, Value::Object(members)) => members.values_mut().for_each(|member| untag(member, tags)),
        (None, _) => {}
    }
}
