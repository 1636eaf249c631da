//! Runs the adapter of a tool and reads its output.

use std::fs::File;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::job::Job;

/// The maximum length of a line. Lines that contain a version or a verdict are much shorter.
const LONGEST_LINE: u64 = 1 << 16;

/// The maximum number of buffered lines.
const WAITING_LINES: usize = 1024;

/// The interval at which a process that has closed its output is checked, to find out whether it has exited.
const PAUSE: Duration = Duration::from_millis(10);

/// The output of an adapter.
#[derive(Debug)]
pub(super) struct Answers {
    pub(super) version: Option<String>,
    /// The answer to each job, in order.
    pub(super) jobs: Vec<Answer>,
    pub(super) end: End,
    pub(super) time: Duration,
}

/// The answer to a job.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Answer {
    /// No answer.
    Nothing,
    /// The tool rejects the schema.
    NoSchema(String),
    /// The verdict on each case, if any.
    Verdicts(Vec<Option<Verdict>>),
}

/// The verdict of a tool on an instance.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    Valid,
    /// Invalid, with the reason.
    Invalid(String),
    /// The tool failed.
    Failed(String),
}

/// The end of an adapter's run.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum End {
    /// The adapter exited successfully.
    Finished,
    /// The adapter failed to start, or exited with an error.
    Crashed(String),
    /// The adapter exceeded the time limit.
    Hung,
    /// The adapter printed an invalid line.
    Garbage(String),
}

/// A line of output.
#[derive(Deserialize)]
struct Line {
    version: Option<String>,
    job: Option<usize>,
    case: Option<usize>,
    valid: Option<bool>,
    error: Option<String>,
    message: Option<String>,
}

/// Runs an adapter for at most `limit`. Its standard error is written to the file `log`.
pub(super) fn run(command: &mut Command, jobs: &[Job], log: &Path, limit: Duration) -> Answers {
    let started = Instant::now();
    let mut answers = Answers {
        version: None,
        jobs: vec![Answer::Nothing; jobs.len()],
        end: End::Finished,
        time: Duration::ZERO,
    };
    answers.end = match start(command, log) {
        Err(error) => End::Crashed(error),
        Ok((mut child, lines)) => {
            let end = listen(&mut answers, jobs, &mut child, &lines, started + limit);
            // Stop the adapter if it is still running.
            let _ = child.kill();
            let _ = child.wait();
            end
        }
    };
    answers.time = started.elapsed();
    answers
}

fn start(command: &mut Command, log: &Path) -> Result<(Child, Receiver<Vec<u8>>), String> {
    let log = File::create(log).map_err(|error| format!("{}: {error}", log.display()))?;
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(log);
    let program = command.get_program().to_string_lossy().into_owned();
    let mut child = command.spawn().map_err(|error| format!("{program}: {error}"))?;
    let out = child.stdout.take().ok_or("the adapter has no standard output")?;
    let (sender, lines) = mpsc::sync_channel(WAITING_LINES);
    // Don't join the thread: a child process of the adapter may keep the pipe open.
    thread::spawn(move || {
        let mut out = BufReader::new(out);
        loop {
            let mut line = Vec::new();
            match out.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut line) {
                Ok(1..) if sender.send(line).is_ok() => {}
                _ => break,
            }
        }
    });
    Ok((child, lines))
}

fn listen(
    answers: &mut Answers,
    jobs: &[Job],
    child: &mut Child,
    lines: &Receiver<Vec<u8>>,
    deadline: Instant,
) -> End {
    for number in 1_usize.. {
        match lines.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
            Ok(line) => {
                if let Err(error) = answers.take(jobs, &line) {
                    return End::Garbage(format!("line {number}: {error}"));
                }
            }
            Err(RecvTimeoutError::Timeout) => return End::Hung,
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    loop {
        match child.try_wait() {
            Ok(Some(status)) if status.success() => return End::Finished,
            Ok(Some(status)) => return End::Crashed(status.to_string()),
            Ok(None) if Instant::now() < deadline => thread::sleep(PAUSE),
            Ok(None) => return End::Hung,
            Err(error) => return End::Crashed(error.to_string()),
        }
    }
}

impl Answers {
    fn take(&mut self, jobs: &[Job], line: &[u8]) -> Result<(), String> {
        let line: Line = serde_json::from_slice(line).map_err(|error| error.to_string())?;
        let Some(index) = line.job else {
            self.version = Some(line.version.ok_or("expected a version or a job")?);
            return Ok(());
        };
        let (Some(job), Some(answer)) = (jobs.get(index), self.jobs.get_mut(index)) else {
            return Err(format!("unknown job {index}"));
        };
        let Some(case) = line.case else {
            if *answer != Answer::Nothing {
                return Err(format!("duplicate job {index}"));
            }
            *answer =
                line.error.map_or_else(|| Answer::Verdicts(vec![None; job.cases.len()]), Answer::NoSchema);
            return Ok(());
        };
        let Answer::Verdicts(verdicts) = answer else {
            return Err(format!("a case of job {index} precedes its schema"));
        };
        let verdict = verdicts.get_mut(case).ok_or_else(|| format!("unknown case {case} of job {index}"))?;
        if verdict.is_some() {
            return Err(format!("duplicate case {case} of job {index}"));
        }
        *verdict = Some(match (line.valid, line.error) {
            (_, Some(error)) => Verdict::Failed(error),
            (Some(true), None) => Verdict::Valid,
            (Some(false), None) => Verdict::Invalid(line.message.unwrap_or_default()),
            (None, None) => return Err(format!("case {case} of job {index} has no verdict")),
        });
        Ok(())
    }
}
