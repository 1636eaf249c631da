//! The recording of a probe. Each line is checked when it is written, with the same code that checks recordings. A live
//! run and its recording therefore have the same findings.
//!
//! Until the first Flockwave message arrives, lines are only buffered. If none arrives, the server uses another
//! protocol, and no rule applies to its data.

use std::io::{self, Write};

use serde_json::Value;
use uavspec_check::{CaptureResult, FlockwaveChecker};
use uavspec_flockwave::record::{Direction, Trial};
use uavspec_flockwave::transport::secrets::Secrets;
use uavspec_model::clock::Clock;
use uavspec_model::json::Tree;
use uavspec_model::text::thousands;
use uavspec_rules::definitions::Definitions;

use crate::limits::{MAX_KEPT, MAX_RECORDED};

/// The text that is recorded in place of a received message that exceeds the length limit.
pub(super) const TOO_LONG: &[u8] = b"(more than 16 MiB)";

/// The maximum length of the recorded content of an event that isn't a Flockwave message, in bytes.
const MAX_OTHER: usize = 1_000;

/// The maximum length of the quotation from data of an unknown protocol, in characters.
const MAX_UNKNOWN: usize = 60;

/// A recording in progress.
pub(super) struct Tape<'d> {
    /// The secrets to replace with placeholders in all lines.
    secrets: Secrets,
    definitions: &'d Definitions,
    clock: Clock,
    checker: FlockwaveChecker<'d>,
    /// False after a panic, which may have left the checker in an invalid state.
    is_checking: bool,
    /// The buffered lines before the first Flockwave message. `None` after this message.
    kept: Option<Kept>,
    file: Option<Box<dyn Write + 'd>>,
    failure: Option<io::Error>,
    lines: u64,
    bytes: u64,
    /// The maximum size of the file, in bytes.
    limit: u64,
}

/// The lines before the first Flockwave message.
#[derive(Default)]
struct Kept {
    /// The lines. The flag is true for an event.
    lines: Vec<(bool, String)>,
    bytes: usize,
    /// The start of the first data that the server sent.
    unknown: Option<String>,
}

impl<'d> Tape<'d> {
    /// Starts a recording, which is also written to `file`. In all lines, secrets are replaced with placeholders.
    pub(super) fn new(
        definitions: &'d Definitions,
        clock: Clock,
        secrets: Secrets,
        file: Option<Box<dyn Write + 'd>>,
    ) -> Self {
        Self {
            secrets,
            definitions,
            clock,
            checker: FlockwaveChecker::new(definitions),
            is_checking: true,
            kept: Some(Kept::default()),
            file,
            failure: None,
            lines: 0,
            bytes: 0,
            limit: MAX_RECORDED,
        }
    }

    /// Drops all findings. Later messages are only recorded.
    pub(super) fn stop_checking(&mut self) {
        (self.is_checking, self.checker) = (false, FlockwaveChecker::new(self.definitions));
    }

    /// Records a message.
    pub(super) fn message(
        &mut self,
        connection: &str,
        direction: Direction,
        bytes: &[u8],
        trial: Option<Trial<'_>>,
    ) {
        if direction == Direction::In {
            self.identify(bytes);
        }
        let direction = if direction == Direction::In { "in" } else { "out" };
        let content = match std::str::from_utf8(bytes) {
            // A line end between JSON tokens has no meaning, and JSON strings can't contain line ends.
            Ok(text) if Tree::read(text).is_ok() => {
                format!("\"msg\":{}", text.replace(['\n', '\r'], " "))
            }
            Ok(text) => format!("\"raw\":{}", quoted(text)),
            Err(_) => {
                format!("\"raw\":{}", quoted(&format!("(not UTF-8) {}", String::from_utf8_lossy(bytes))))
            }
        };
        self.line(connection, direction, &content, trial);
    }

    /// Records an event that isn't a Flockwave message, but may contain one.
    pub(super) fn other_event(&mut self, connection: &str, bytes: &[u8]) {
        self.identify(bytes);
        let content = String::from_utf8_lossy(&bytes[..bytes.len().min(MAX_OTHER)]);
        self.event(connection, "other", &content, None);
    }

    /// Records a new connection.
    pub(super) fn connected(&mut self, connection: &str, url: &str) {
        let content = format!("\"event\":\"connect\",\"url\":{}", quoted(url));
        self.line(connection, "event", &content, None);
    }

    /// Records an event with its reason: a connection was `refused` or `closed`, or the latest HTTP request `failed`
    /// because it has no valid response.
    pub(super) fn event(&mut self, connection: &str, event: &str, why: &str, trial: Option<Trial<'_>>) {
        let content = format!("\"event\":\"{event}\",\"why\":{}", quoted(why));
        self.line(connection, "event", &content, trial);
    }

    fn line(&mut self, connection: &str, direction: &str, content: &str, trial: Option<Trial<'_>>) {
        let now = self.clock.since_1970();
        let (seconds, micros) = (now.as_secs(), now.subsec_micros());
        let tried = trial.map_or_else(String::new, |trial| {
            format!(",\"trial\":{},\"how\":{}", quoted(trial.rule.id), quoted(trial.how))
        });
        let line = format!(
            "{{\"t\":{seconds}.{micros:06},\"conn\":{},\"dir\":\"{direction}\",{}{tried}}}",
            quoted(connection),
            self.secrets.hide(content)
        );
        match &mut self.kept {
            None => self.write(&line),
            Some(kept) if kept.bytes < MAX_KEPT => {
                kept.bytes += line.len();
                kept.lines.push((direction == "event", line));
            }
            Some(_) => {}
        }
    }

    fn write(&mut self, line: &str) {
        self.lines += 1;
        self.bytes += line.len() as u64 + 1;
        if self.is_checking {
            self.checker.line(line.as_bytes(), self.lines, false);
        }
        if let Some(file) = &mut self.file
            && let Err(error) = within(self.bytes, self.limit).and_then(|()| writeln!(file, "{line}"))
        {
            (self.file, self.failure) = (None, Some(error));
        }
    }

    /// Writes the buffered lines if this is the first Flockwave message.
    fn identify(&mut self, bytes: &[u8]) {
        let Some(kept) = &mut self.kept else { return };
        if !serde_json::from_slice(bytes).is_ok_and(|value| is_flockwave(&value)) {
            kept.unknown.get_or_insert_with(|| {
                self.secrets.hide(&String::from_utf8_lossy(bytes)).chars().take(MAX_UNKNOWN).collect()
            });
            return;
        }
        for (_, line) in self.kept.take().unwrap_or_default().lines {
            self.write(&line);
        }
    }

    /// True if the server has sent a Flockwave message.
    pub(super) fn is_identified(&self) -> bool {
        self.kept.is_none()
    }

    /// Drops the buffered lines before a new attempt to connect.
    pub(super) fn forget(&mut self) {
        if let Some(kept) = &mut self.kept {
            *kept = Kept::default();
        }
    }

    /// True if the server has sent anything.
    pub(super) fn is_heard(&self) -> bool {
        self.is_identified() || self.unknown().is_some()
    }

    /// The start of the first data from a server that hasn't sent a Flockwave message.
    pub(super) fn unknown(&self) -> Option<&str> {
        self.kept.as_ref()?.unknown.as_deref()
    }

    /// Returns the findings, and the error if the recording couldn't be written completely.
    pub(super) fn finish(mut self) -> (CaptureResult, Option<io::Error>) {
        // No rule applies to messages of another protocol. The events show what happened.
        for (_, event) in self.kept.take().unwrap_or_default().lines.iter().filter(|(is_event, _)| *is_event)
        {
            self.write(event);
        }
        let flushed = self.file.as_mut().map_or(Ok(()), Write::flush);
        (self.checker.finish(self.bytes), self.failure.or(flushed.err()))
    }
}

/// Fails if a recording of this size exceeds the limit. Later messages are still checked.
fn within(size: u64, limit: u64) -> io::Result<()> {
    let problem = || format!("it would exceed {} bytes; the rest is missing", thousands(limit));
    if size > limit { Err(io::Error::new(io::ErrorKind::FileTooLarge, problem())) } else { Ok(()) }
}

/// True if the value is a Flockwave message. The message may violate some rules.
fn is_flockwave(value: &Value) -> bool {
    match value {
        Value::Object(_) => value.get("$fw.version").is_some() || value["body"]["type"].is_string(),
        Value::Array(values) => values.first().is_some_and(|first| first.is_object() && is_flockwave(first)),
        _ => false,
    }
}

fn quoted(text: &str) -> String {
    Value::from(text).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recording_ends_at_its_limit_but_the_checks_go_on() {
        let (definitions, mut written) = (Definitions::built_in(), Vec::new());
        let mut tape =
            Tape::new(&definitions, Clock::real(), Secrets::default(), Some(Box::new(&mut written)));
        tape.limit = 1_000;
        for number in 0..100 {
            let message = format!(r#"{{"$fw.version":"1.0","id":"{number}","body":{{"type":"SYS-PING"}}}}"#);
            tape.message("tcp#1", Direction::In, message.as_bytes(), None);
        }
        let (result, failure) = tape.finish();
        assert_eq!(result.records, 100);
        let failure = failure.expect("a limit").to_string();
        assert_eq!(failure, "it would exceed 1,000 bytes; the rest is missing");
        assert!((900..=1_000).contains(&written.len()) && written.ends_with(b"\n"), "{}", written.len());
    }
}
