//! Bad manners: what `uavspec testee lint` looks for. `testee MODE` shows one of them, and is right otherwise.

use std::io::{self, BufRead, Write};
use std::process::{self, ExitCode};
use std::thread;
use std::time::Duration;

use serde_json::{Value, json};

/// How long a line may be for who has a buffer of a fixed size.
const BUFFER: usize = 64 << 10;

pub(crate) struct Rude {
    mode: String,
}

impl Rude {
    pub(crate) fn read(arguments: &[String]) -> Self {
        Self { mode: arguments.first().cloned().unwrap_or_default() }
    }

    fn is(&self, mode: &str) -> bool {
        self.mode == mode
    }

    /// The next line; none at the end.
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

    /// What is done about a line that is no JSON.
    pub(crate) fn cannot_read(&self, line: &[u8]) {
        let is_empty = line.trim_ascii().is_empty();
        let is_utf8 = std::str::from_utf8(line).is_ok();
        if self.is("crash-empty") && is_empty
            || self.is("crash-not-utf8") && !is_utf8
            || self.is("crash-not-json") && is_utf8 && !is_empty
        {
            process::exit(9);
        }
    }

    /// Whether nothing is said to this. `count` is how many questions came before, with the hello.
    pub(crate) fn is_passed_over(&self, question: &Value, count: usize) -> bool {
        let is_second_hello = question["op"] == "hello" && count > 0;
        if self.is("crash-second-hello") && is_second_hello {
            process::exit(8);
        }
        self.is("silent-unknown-op") && question["op"] == "levitate"
    }

    /// What happens before an answer. Makes a question from what is none, in modes that guess.
    pub(crate) fn before(&self, question: &mut Value, output: &mut impl Write) -> io::Result<()> {
        let is_known = |value: &Value| value == "uorb" || value == "cdr";
        match self.mode.as_str() {
            "chatty" if question["op"] != "hello" => writeln!(output, "asked for {}", question["op"])?,
            "guess-format" if question.get("format").is_some_and(|format| !is_known(format)) => {
                question["format"] = "uorb".into();
            }
            "guess-member" if question.get("format").is_none() && question.get("bytes").is_some() => {
                question["format"] = "uorb".into();
            }
            "short-ids" => {
                #[allow(clippy::cast_possible_truncation)] // that is the mistake
                if let Some(id) = question["id"].as_i64() {
                    question["id"] = (id as i32).into();
                }
            }
            "unsigned-ids" => {
                if let Some(id) = question["id"].as_i64() {
                    question["id"] = id.unsigned_abs().into();
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Makes the reply wrong.
    pub(crate) fn corrupt(&self, question: &Value, reply: &mut Value) {
        let is_hello = question["op"] == "hello";
        match self.mode.as_str() {
            "hello-unknown-op" if is_hello => reply["ops"] = json!(["decode", "levitate"]),
            "hello-unknown-format" if is_hello => reply["formats"] = json!(["uorb", "morse"]),
            "hello-no-version" if is_hello => reply["version"] = Value::Null,
            "hello-odd-type" if is_hello => reply["types"] = json!(["px4/Event", "Event"]),
            "hello-protocol" if is_hello => reply["protocol"] = json!(2),
            "accept-unknown-op" if question["op"] == "levitate" => replace(reply, "ok", Value::Null),
            "reject-unknown" if !is_hello && reply.get("unsupported").is_some() => {
                replace(reply, "rejected", "no such type".into());
            }
            "reject-missing" if !is_hello && reply.get("error").is_some() => {
                replace(reply, "rejected", "no such member".into());
            }
            "untagged-integers" if question["op"] == "decode" => untag(reply, &["$u64", "$i64"]),
            "untagged-floats" if question["op"] == "decode" => untag(reply, &["$f"]),
            "ignore-tags" if question["op"] == "encode" && question.to_string().contains("$u64") => {
                replace(reply, "rejected", "no number".into());
            }
            _ => {}
        }
    }

    /// How it ends.
    pub(crate) fn at_end(&self) -> ExitCode {
        if self.is("stays") {
            loop {
                thread::sleep(Duration::from_secs(60));
            }
        }
        ExitCode::from(if self.is("ends-badly") { 5 } else { 0 })
    }
}

fn replace(reply: &mut Value, member: &str, value: Value) {
    let mut other = json!({ "id": reply["id"] });
    other[member] = value;
    *reply = other;
}

/// Writes numbers as JSON has them; NaN as null.
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
