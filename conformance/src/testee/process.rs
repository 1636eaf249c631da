//! A testee as a child process. Nothing here waits longer than it is told to.
//!
//! It leads a group of processes, and is over when it has ended itself: what it started and left behind is killed
//! with the group, where there are groups. A thread drains its standard error. It ends with the pipe, which children
//! of the child may hold open that have left the group; so nobody waits for it.

use std::collections::{BTreeSet, VecDeque};
use std::ffi::OsString;
use std::io::{self, Read};
use std::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, Once, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// How much of what it said last on standard error is kept, in bytes.
const MAX_STDERR: usize = 8 << 10;

/// How long is waited for the end of standard error once the process has ended.
const STDERR_TIMEOUT: Duration = Duration::from_millis(500);

/// How often is looked whether it has ended.
const POLL_INTERVAL: Duration = Duration::from_millis(5);

/// What a shell says of a program that was interrupted.
const INTERRUPTED: i32 = 130;

/// The groups that run. What a terminal sends to the foreground doesn't reach them.
static GROUPS: Mutex<BTreeSet<u32>> = Mutex::new(BTreeSet::new());

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
            _ => Err(io::Error::other("no pipes to it")),
        }
    }

    /// How it ended, in words, and nothing where that was as it should be; none where it still runs at that time.
    pub(super) fn ended(&mut self, until: Instant) -> Option<String> {
        loop {
            let how = match self.child.try_wait() {
                Ok(Some(status)) if status.success() => String::new(),
                Ok(Some(status)) => status.to_string(),
                Ok(None) if Instant::now() < until => {
                    thread::sleep(POLL_INTERVAL);
                    continue;
                }
                Ok(None) => return None,
                Err(error) => error.to_string(),
            };
            self.kill_group();
            return Some(how);
        }
    }

    /// Kills it, and gives what it said last on standard error.
    pub(super) fn kill(&mut self) -> String {
        self.end();
        let _ = self.errors_end.recv_timeout(STDERR_TIMEOUT);
        let bytes: Vec<u8> =
            self.errors.lock().unwrap_or_else(PoisonError::into_inner).iter().copied().collect();
        String::from_utf8_lossy(&bytes).trim_end().to_owned()
    }

    fn end(&mut self) {
        self.kill_group();
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }

    /// Kills what is left of its group, once: later another group may have the number.
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
        // There may be none left.
        let _ = killpg(Pid::from_raw(leader), Signal::SIGKILL);
    }
}

#[cfg(not(unix))]
fn kill_group(_: u32) {}

/// Nobody else ends testees that hang, when this program is told to end.
fn kill_all_when_interrupted() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // Who has a handler already sees to it.
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
    // Nobody may be waiting any more.
    let _ = end.send(());
}
