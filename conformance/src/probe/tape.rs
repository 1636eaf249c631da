//! The recording of a probe. Each line is checked as it is written, with the same code that checks recordings. A live
//! run and its recording therefore have the same findings.

use std::io::{self, Write};
use std::time::{SystemTime, UNIX_EPOCH};

use serde_json::Value;

use crate::check::{CaptureResult, FlockwaveChecker};
use crate::definitions::Definitions;
use crate::flockwave::record::{Direction, Trial};
use crate::json::Tree;

/// The text recorded for a message over the length limit.
const TOO_LONG: &[u8] = b"(more than 16 MiB)";

/// A recording in progress.
pub(super) struct Tape<'d> {
    checker: FlockwaveChecker<'d>,
    file: Option<Box<dyn Write + 'd>>,
    failure: Option<io::Error>,
    lines: u64,
    bytes: u64,
}

impl<'d> Tape<'d> {
    /// Starts a recording, which is also written to `file`.
    pub(super) fn new(definitions: &'d Definitions, file: Option<Box<dyn Write + 'd>>) -> Self {
        Self { checker: FlockwaveChecker::new(definitions), file, failure: None, lines: 0, bytes: 0 }
    }

    /// Records a message.
    pub(super) fn message(
        &mut self,
        connection: &str,
        direction: Direction,
        bytes: &[u8],
        trial: Option<Trial<'_>>,
    ) {
        let direction = if direction == Direction::In { "in" } else { "out" };
        let content = match std::str::from_utf8(bytes) {
            // A line end between JSON tokens is insignificant, and JSON strings can't contain line ends.
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

    /// Records a received message over the length limit.
    pub(super) fn too_long(&mut self, connection: &str) {
        self.message(connection, Direction::In, TOO_LONG, None);
    }

    /// Records a new connection.
    pub(super) fn connected(&mut self, connection: &str, url: &str) {
        let content = format!("\"event\":\"connect\",\"url\":{}", quoted(url));
        self.line(connection, "event", &content, None);
    }

    /// Records a refused connection.
    pub(super) fn refused(&mut self, connection: &str, why: &str, trial: Option<Trial<'_>>) {
        let content = format!("\"event\":\"refused\",\"why\":{}", quoted(why));
        self.line(connection, "event", &content, trial);
    }

    /// Records an HTTP request without a valid response.
    pub(super) fn failed(&mut self, connection: &str, why: &str) {
        let content = format!("\"event\":\"failed\",\"why\":{}", quoted(why));
        self.line(connection, "event", &content, None);
    }

    /// Records the end of a connection.
    pub(super) fn closed(&mut self, connection: &str, why: &str) {
        let content = format!("\"event\":\"closed\",\"why\":{}", quoted(why));
        self.line(connection, "event", &content, None);
    }

    fn line(&mut self, connection: &str, direction: &str, content: &str, trial: Option<Trial<'_>>) {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let (seconds, micros) = (now.as_secs(), now.subsec_micros());
        let tried = trial.map_or_else(String::new, |trial| {
            format!(",\"trial\":{},\"how\":{}", quoted(trial.rule.id), quoted(trial.how))
        });
        let line = format!(
            "{{\"t\":{seconds}.{micros:06},\"conn\":{},\"dir\":\"{direction}\",{content}{tried}}}",
            quoted(connection)
        );
        self.lines += 1;
        self.bytes += line.len() as u64 + 1;
        self.checker.line(line.as_bytes(), self.lines, false);
        if let Some(file) = &mut self.file
            && let Err(error) = writeln!(file, "{line}")
        {
            (self.file, self.failure) = (None, Some(error));
        }
    }

    /// Returns the findings, and the error if the recording couldn't be written completely.
    pub(super) fn finish(mut self) -> (CaptureResult, Option<io::Error>) {
        let flushed = self.file.as_mut().map_or(Ok(()), Write::flush);
        (self.checker.finish(self.bytes), self.failure.or(flushed.err()))
    }
}

fn quoted(text: &str) -> String {
    Value::from(text).to_string()
}
