//! Installs and runs the adapter of a tool, and reads its output.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::SOURCE;
use super::job::Job;
use super::tool::Tool;
use crate::command::cargo;
use crate::paths::repository;

/// The maximum number of buffered lines.
const WAITING_LINES: usize = 1024;

/// The interval at which a process that has closed its output is checked, to find out whether it has exited.
const PAUSE: Duration = Duration::from_millis(10);

/// The output of an adapter.
#[derive(Debug, Default)]
pub(super) struct Answers {
    pub(super) version: Option<String>,
    /// The answers by the number of the job, and of its case. An answer without a case is about the schema.
    pub(super) lines: BTreeMap<(usize, Option<usize>), Line>,
    pub(super) end: End,
    /// The reason why the run ended in this way.
    pub(super) reason: String,
}

/// The end of an adapter's run.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum End {
    /// The adapter exited successfully.
    #[default]
    Finished,
    /// The adapter failed to start, or exited with an error.
    Crashed,
    /// The adapter exceeded the time limit.
    Hung,
    /// The adapter printed an invalid line.
    Garbage,
}

/// A line of output.
#[derive(Debug, Deserialize)]
pub(super) struct Line {
    version: Option<String>,
    job: Option<usize>,
    case: Option<usize>,
    /// The verdict on an instance.
    pub(super) valid: Option<bool>,
    /// The reason why the tool rejects a schema, or failed on an instance.
    pub(super) error: Option<String>,
    /// The reason why the tool rejects an instance.
    pub(super) message: Option<String>,
}

/// The script that installs and runs the adapter of a tool.
pub(super) fn script(action: &str, tool: &Tool) -> Command {
    let mut command = Command::new("sh");
    command.arg(repository().join(SOURCE).join("environment.sh")).env("CARGO", cargo());
    command.args([action, &tool.environment, &tool.adapter]).stdin(Stdio::null());
    command
}

/// Installs the adapter of a tool. If the adapter can't run, returns the reason.
pub(super) fn install(tool: &Tool, may_install: bool) -> Result<(), String> {
    let mut command = script("install", tool);
    if !may_install {
        command.env("NO_INSTALL", "1");
    }
    let output = command.stderr(Stdio::inherit()).output().map_err(|error| format!("sh: {error}"))?;
    let reason = String::from_utf8_lossy(&output.stdout);
    if output.status.success() { Ok(()) } else { Err(reason.trim_end().to_owned()) }
}

/// Runs an adapter for at most `limit`. Its standard error is written to the file `log`.
pub(super) fn run(command: &mut Command, jobs: &[Job], log: &Path, limit: Duration) -> Answers {
    let mut answers = Answers::default();
    if let Err((end, reason)) = answers.read(command, jobs, log, Instant::now() + limit) {
        (answers.end, answers.reason) = (end, reason);
    }
    answers
}

impl Answers {
    /// Runs an adapter and reads its output. If the run doesn't succeed, returns the way in which it ended.
    fn read(
        &mut self,
        command: &mut Command,
        jobs: &[Job],
        log: &Path,
        deadline: Instant,
    ) -> Result<(), (End, String)> {
        let crashed = |error: io::Error| (End::Crashed, error.to_string());
        let log = File::create(log).map_err(crashed)?;
        let mut child = command.stdout(Stdio::piped()).stderr(log).spawn().map_err(crashed)?;
        let (sender, lines) = mpsc::sync_channel(WAITING_LINES);
        // Don't join the thread: a child process of the adapter may keep the pipe open.
        if let Some(out) = child.stdout.take() {
            let lines = serde_json::Deserializer::from_reader(BufReader::new(out)).into_iter::<Line>();
            thread::spawn(move || lines.map(|line| sender.send(line)).find(Result::is_err));
        }
        let end = loop {
            match lines.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
                Ok(line) => {
                    let line = line.map_err(|error| error.to_string());
                    if let Err(error) = line.and_then(|line| self.take(jobs, line)) {
                        break Err((End::Garbage, error));
                    }
                }
                Err(RecvTimeoutError::Timeout) => break Err((End::Hung, String::new())),
                Err(RecvTimeoutError::Disconnected) => match child.try_wait() {
                    Ok(Some(status)) if status.success() => break Ok(()),
                    Ok(Some(status)) => break Err((End::Crashed, status.to_string())),
                    Ok(None) if Instant::now() < deadline => thread::sleep(PAUSE),
                    Ok(None) => break Err((End::Hung, String::new())),
                    Err(error) => break Err(crashed(error)),
                },
            }
        };
        // Stop the adapter if it is still running.
        let _ = child.kill();
        let _ = child.wait();
        end
    }

    fn take(&mut self, jobs: &[Job], line: Line) -> Result<(), String> {
        let Some(index) = line.job else {
            self.version = Some(line.version.ok_or("expected a version or a job")?);
            return Ok(());
        };
        let job = jobs.get(index).ok_or_else(|| format!("unknown job {index}"))?;
        if let Some(case) = line.case {
            if self.lines.get(&(index, None)).is_none_or(|schema| schema.error.is_some()) {
                return Err(format!("a case of job {index} precedes its schema"));
            }
            if case >= job.cases.len() {
                return Err(format!("unknown case {case} of job {index}"));
            }
            if line.valid.is_none() && line.error.is_none() {
                return Err(format!("case {case} of job {index} has no verdict"));
            }
        }
        match self.lines.insert((index, line.case), line) {
            Some(earlier) if earlier.case.is_some() => Err(format!("duplicate case of job {index}")),
            Some(_) => Err(format!("duplicate job {index}")),
            None => Ok(()),
        }
    }
}
