//! A testee as a child process. Nothing here waits longer than it is told to.
//!
//! A thread drains its standard error. It ends with the pipe, which children of the child may hold open; so nobody
//! waits for it.

use std::collections::VecDeque;
use std::ffi::OsString;
use std::io::{self, Read};
use std::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// How much of what it said last on standard error is kept, in bytes.
const EVIDENCE: usize = 8 << 10;

/// How long is waited for the end of standard error once the process has ended.
const LAST_WORDS: Duration = Duration::from_millis(500);

/// How often is looked whether it has ended.
const POLL: Duration = Duration::from_millis(5);

/// A running testee. Dropping it kills it.
pub(super) struct Process {
    child: Child,
    errors: Arc<Mutex<VecDeque<u8>>>,
    errors_end: Receiver<()>,
}

impl Process {
    /// Starts it; gives its standard input and output, too.
    pub(super) fn start(command: &[OsString]) -> io::Result<(Self, ChildStdin, ChildStdout)> {
        let Some((program, arguments)) = command.split_first() else {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "no command"));
        };
        let mut child = Command::new(program)
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()?;
        let (end, errors_end) = channel();
        let errors = Arc::new(Mutex::new(VecDeque::new()));
        let (input, output) = (child.stdin.take(), child.stdout.take());
        if let Some(output) = child.stderr.take() {
            let errors = Arc::clone(&errors);
            thread::spawn(move || drain(output, &errors, &end));
        }
        let process = Self { child, errors, errors_end };
        match (input, output) {
            (Some(input), Some(output)) => Ok((process, input, output)),
            _ => Err(io::Error::other("no pipes to it")),
        }
    }

    /// How it ended, in words, and nothing where that was as it should be; none where it still runs at that time.
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
