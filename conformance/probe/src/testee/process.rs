//! Runs a testee as a child process. No call here blocks longer than its time limit.
//!
//! On platforms with process groups, the child leads a process group. When the child ends, the rest of the group is
//! killed. A thread drains standard error. The thread ends when the pipe is closed. Descendants outside the group may
//! keep the pipe open, so nothing waits for the thread.

use std::collections::{BTreeSet, VecDeque};
use std::ffi::OsString;
use std::io::{self, Read};
use std::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, Once, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use uavspec_model::clock::Clock;

use crate::limits::MAX_STDERR;

/// The time limit for standard error to close after the process has ended.
const STDERR_TIMEOUT: Duration = Duration::from_millis(500);

/// The interval between checks of whether the process has ended.
const POLL_INTERVAL: Duration = Duration::from_millis(5);

/// The exit status of an interrupted program, as in shells.
const INTERRUPTED: i32 = 130;

/// The running process groups. They don't receive the signals that a terminal sends to the foreground group.
static GROUPS: Mutex<BTreeSet<u32>> = Mutex::new(BTreeSet::new());

/// A running testee. Dropping it kills the process.
pub(super) struct Process {
    child: Child,
    errors: Arc<Mutex<VecDeque<u8>>>,
    errors_end: Receiver<()>,
}

impl Process {
    /// Starts a testee. Returns the process with its standard input and output.
    pub(super) fn start(command: &[OsString]) -> io::Result<(Self, ChildStdin, ChildStdout)> {
        let Some((program, arguments)) = command.split_first() else {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "no command"));
        };
        kill_all_when_interrupted();
        let mut command = Command::new(program);
        command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut child = command.spawn()?;
        groups(|groups| groups.insert(child.id()));
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
            _ => Err(io::Error::other("the process has no pipes")),
        }
    }

    /// Waits until the process has ended, or until a time. Returns a description of how the process exited, which is
    /// empty after a success. Returns `None` if the process is still running.
    pub(super) fn await_end(&mut self, until: Instant, clock: &Clock) -> Option<String> {
        loop {
            let how = self.ended();
            if how.is_some() || clock.now() >= until {
                return how;
            }
            Clock::real().sleep(POLL_INTERVAL);
        }
    }

    /// A description of how the process exited, which is empty after a success. `None` if the process is still running.
    pub(super) fn ended(&mut self) -> Option<String> {
        let how = match self.child.try_wait() {
            Ok(Some(status)) if status.success() => String::new(),
            Ok(Some(status)) => status.to_string(),
            Ok(None) => return None,
            Err(error) => error.to_string(),
        };
        self.kill_group();
        Some(how)
    }

    /// Kills the process, and returns the last part of its standard error.
    pub(super) fn kill(&mut self) -> String {
        self.end();
        let clock = Clock::real();
        let _ = clock.receive(&self.errors_end, clock.now() + STDERR_TIMEOUT);
        let bytes: Vec<u8> =
            self.errors.lock().unwrap_or_else(PoisonError::into_inner).iter().copied().collect();
        String::from_utf8_lossy(&bytes).trim_end().to_owned()
    }

    fn end(&mut self) {
        self.kill_group();
        // The process may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }

    /// Kills the remaining processes of the group. This is done only once, because the operating system may later
    /// assign the same id to another group.
    fn kill_group(&self) {
        if groups(|groups| groups.remove(&self.child.id())) {
            kill_group(self.child.id());
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.end();
    }
}

fn groups<T>(what: impl FnOnce(&mut BTreeSet<u32>) -> T) -> T {
    what(&mut GROUPS.lock().unwrap_or_else(PoisonError::into_inner))
}

#[cfg(unix)]
fn kill_group(leader: u32) {
    use nix::sys::signal::{Signal, killpg};
    use nix::unistd::Pid;
    if let Ok(leader) = i32::try_from(leader) {
        // All processes of the group may have ended.
        let _ = killpg(Pid::from_raw(leader), Signal::SIGKILL);
    }
}

#[cfg(not(unix))]
fn kill_group(_: u32) {}

/// Kills all testees when this program is interrupted; otherwise, hanging testees would continue to run.
fn kill_all_when_interrupted() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // If the application has its own signal handler, that handler must kill the testees.
        let _ = ctrlc::try_set_handler(|| {
            groups(std::mem::take).into_iter().for_each(kill_group);
            std::process::exit(INTERRUPTED);
        });
    });
}

fn drain(mut output: ChildStderr, errors: &Mutex<VecDeque<u8>>, end: &Sender<()>) {
    let mut chunk = [0; 4096];
    while let Ok(count @ 1..) = output.read(&mut chunk) {
        let mut errors = errors.lock().unwrap_or_else(PoisonError::into_inner);
        errors.extend(&chunk[..count]);
        let excess = errors.len().saturating_sub(MAX_STDERR);
        errors.drain(..excess);
    }
    // The receiver may be gone.
    let _ = end.send(());
}
