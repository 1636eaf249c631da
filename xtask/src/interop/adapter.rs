//! Runs a tool's adapter, and reads what it says.

use std::fs::File;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::job::Job;

/// The longest line that is read: a version or a verdict with its message is far shorter.
const LONGEST_LINE: u64 = 1 << 16;

/// How many lines may wait to be read.
const WAITING_LINES: usize = 1024;

/// How often a process that has said all is asked whether it has ended.
const PAUSE: Duration = Duration::from_millis(10);

/// All that an adapter said.
#[derive(Debug)]
pub(super) struct Answers {
    pub(super) version: Option<String>,
    /// What came of each job, in their order.
    pub(super) jobs: Vec<Answer>,
    pub(super) end: End,
    pub(super) time: Duration,
}

/// What came of a job.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Answer {
    /// Nothing was said.
    Nothing,
    /// The tool can't use the schema.
    NoSchema(String),
    /// The verdict on each case.
    Verdicts(Vec<Option<Verdict>>),
}

/// What a tool makes of an instance.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    Valid,
    /// It isn't valid, and why.
    Invalid(String),
    /// The tool failed.
    Failed(String),
}

/// How an adapter ended.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum End {
    /// By itself, with success.
    Finished,
    /// It failed to start, or ended with another status.
    Crashed(String),
    /// It took too long.
    Hung,
    /// It said what no adapter may say.
    Garbage(String),
}

/// A line of an adapter.
#[derive(Deserialize)]
struct Line {
    version: Option<String>,
    job: Option<usize>,
    case: Option<usize>,
    valid: Option<bool>,
    error: Option<String>,
    message: Option<String>,
}

/// Runs an adapter for at most `limit`; what it writes besides goes to the file `log`.
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
            // Whatever it is still doing is of no use.
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
    let out = child.stdout.take().ok_or("no standard output")?;
    let (sender, lines) = mpsc::sync_channel(WAITING_LINES);
    // The thread isn't joined: something that the adapter started may hold the pipe open for ever.
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
            self.version = Some(line.version.ok_or("neither a version nor a job")?);
            return Ok(());
        };
        let (Some(job), Some(answer)) = (jobs.get(index), self.jobs.get_mut(index)) else {
            return Err(format!("there is no job {index}"));
        };
        let Some(case) = line.case else {
            if *answer != Answer::Nothing {
                return Err(format!("job {index} for the second time"));
            }
            *answer =
                line.error.map_or_else(|| Answer::Verdicts(vec![None; job.cases.len()]), Answer::NoSchema);
            return Ok(());
        };
        let Answer::Verdicts(verdicts) = answer else {
            return Err(format!("a case of job {index}, whose schema isn't compiled"));
        };
        let verdict =
            verdicts.get_mut(case).ok_or_else(|| format!("there is no case {case} of job {index}"))?;
        if verdict.is_some() {
            return Err(format!("case {case} of job {index} for the second time"));
        }
        *verdict = Some(match (line.valid, line.error) {
            (_, Some(error)) => Verdict::Failed(error),
            (Some(true), None) => Verdict::Valid,
            (Some(false), None) => Verdict::Invalid(line.message.unwrap_or_default()),
            (None, None) => return Err(format!("no verdict on case {case} of job {index}")),
        });
        Ok(())
    }
}
