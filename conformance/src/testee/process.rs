//! A testee as a child process. Whatever it does, nothing here waits longer than it is told to.
//!
//! A thread reads its standard output, one drains its standard error, and one writes to its standard input: it may
//! stop reading. The threads end with the pipes, which children of the child may hold open; so nobody waits for them.

use std::collections::VecDeque;
use std::ffi::OsString;
use std::io::{self, BufRead, BufReader, Read, Write as _};
use std::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, channel, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// How much of what it said last on standard error is kept, in bytes.
const EVIDENCE: usize = 8 << 10;

/// How many lines may wait to be judged; then the testee waits.
const BACKLOG: usize = 64;

/// How long is waited for the end of standard error once the process has ended.
const LAST_WORDS: Duration = Duration::from_millis(500);

/// How often is looked whether it has ended.
const POLL: Duration = Duration::from_millis(5);

/// What comes from a testee.
#[derive(Debug)]
pub(super) enum Said {
    /// A line without its end.
    Line(Vec<u8>),
    /// A line longer than the limit. What follows can't be read.
    TooLong,
    /// It has closed its standard output.
    Closed,
    /// Nothing came in time.
    Nothing,
}

/// A running testee. Dropping it kills it.
pub(super) struct Process {
    child: Child,
    to: Option<Sender<String>>,
    from: Receiver<Said>,
    errors: Arc<Mutex<VecDeque<u8>>>,
    errors_end: Receiver<()>,
}

impl Process {
    pub(super) fn start(command: &[OsString], line_limit: usize) -> io::Result<Self> {
        let Some((program, arguments)) = command.split_first() else {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "no command"));
        };
        let mut child = Command::new(program)
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()?;
        let (to, requests) = channel();
        let (lines, from) = sync_channel(BACKLOG);
        let (end, errors_end) = channel();
        let errors = Arc::new(Mutex::new(VecDeque::new()));
        if let Some(input) = child.stdin.take() {
            thread::spawn(move || write(input, &requests));
        }
        if let Some(output) = child.stdout.take() {
            thread::spawn(move || read(output, &lines, line_limit));
        }
        if let Some(output) = child.stderr.take() {
            let errors = Arc::clone(&errors);
            thread::spawn(move || drain(output, &errors, &end));
        }
        Ok(Self { child, to: Some(to), from, errors, errors_end })
    }

    /// Sends a line, sooner or later; if it can't be sent, the process has ended, and that is seen elsewhere.
    pub(super) fn send(&self, line: String) {
        if let Some(to) = &self.to {
            let _ = to.send(line + "\n");
        }
    }

    /// Closes its standard input once all has been sent.
    pub(super) fn close(&mut self) {
        self.to = None;
    }

    pub(super) fn hear(&self, until: Instant) -> Said {
        match self.from.recv_timeout(until.saturating_duration_since(Instant::now())) {
            Ok(said) => said,
            Err(RecvTimeoutError::Timeout) => Said::Nothing,
            Err(RecvTimeoutError::Disconnected) => Said::Closed,
        }
    }

    /// How it ended, in words; none where it still runs at that time.
    pub(super) fn ended(&mut self, until: Instant) -> Option<String> {
        loop {
            match self.child.try_wait() {
                Ok(Some(status)) if status.success() => return Some(String::new()),
                Ok(Some(status)) => return Some(status.to_string()),
                Ok(None) if Instant::now() < until => thread::sleep(POLL),
                Ok(None) => return None,
                Err(error) => return Some(error.to_string()),
            }
        }
    }

    /// Kills it, and gives what it said last on standard error.
    pub(super) fn kill(&mut self) -> String {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
        let _ = self.errors_end.recv_timeout(LAST_WORDS);
        let bytes: Vec<u8> =
            self.errors.lock().unwrap_or_else(PoisonError::into_inner).iter().copied().collect();
        String::from_utf8_lossy(&bytes).trim_end().to_owned()
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn write(mut input: ChildStdin, requests: &Receiver<String>) {
    for line in requests {
        if input.write_all(line.as_bytes()).and_then(|()| input.flush()).is_err() {
            return;
        }
    }
}

fn read(output: ChildStdout, lines: &SyncSender<Said>, limit: usize) {
    let mut output = BufReader::with_capacity(1 << 16, output);
    loop {
        let mut line = Vec::new();
        // One byte for the end of the line.
        let most = u64::try_from(limit).unwrap_or(u64::MAX).saturating_add(1);
        let read = output.by_ref().take(most).read_until(b'\n', &mut line);
        let is_whole = line.pop_if(|byte| *byte == b'\n').is_some();
        let said = match read {
            Ok(_) if is_whole => Said::Line(line),
            Ok(_) if line.len() > limit => Said::TooLong,
            // The last line may lack its end.
            Ok(_) if !line.is_empty() => Said::Line(line),
            Ok(_) | Err(_) => Said::Closed,
        };
        let is_last = matches!(said, Said::TooLong | Said::Closed);
        if lines.send(said).is_err() || is_last {
            return;
        }
    }
}

fn drain(mut output: ChildStderr, errors: &Mutex<VecDeque<u8>>, end: &Sender<()>) {
    let mut chunk = [0; 4096];
    while let Ok(count @ 1..) = output.read(&mut chunk) {
        let mut errors = errors.lock().unwrap_or_else(PoisonError::into_inner);
        errors.extend(&chunk[..count]);
        let excess = errors.len().saturating_sub(EVIDENCE);
        errors.drain(..excess);
    }
    // Nobody may be waiting any more.
    let _ = end.send(());
}
