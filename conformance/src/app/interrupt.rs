//! Ends a probe after a signal. UAVs that received commands must not remain in the air.

use std::io::IsTerminal as _;
use std::sync::OnceLock;
use std::thread;
use std::time::{Duration, Instant};

use anstyle::AnsiColor;
use uavspec_live::vehicle::remove_recordings;
use uavspec_model::clock::Clock;
use uavspec_model::text::terminal;
use uavspec_probe::{Options, Stop};

use super::{Status, uninterruptible};

/// The exit status after an interrupt that ends the program immediately: 128 plus the number of SIGINT.
pub(super) const INTERRUPTED: i32 = 130;

/// The time after the first interrupt during which other interrupts are ignored. `timeout` sends its signal twice, and
/// so does the end of a terminal session. The second signal must not leave UAVs in the air.
const REPEAT_TIME: Duration = Duration::from_secs(1);

/// The time of the first interrupt.
static FIRST: OnceLock<Instant> = OnceLock::new();

/// Installs handlers for signals that end programs. If the probe may send commands, also for signals that suspend
/// programs.
pub(super) fn install(options: &Options) -> Result<(), Status> {
    let (stop, limit) = (options.stop.clone(), options.landing_limit.as_secs());
    // New threads inherit the set of blocked signals.
    #[cfg(unix)]
    if options.uavs.is_empty() {
        signals::outlive_full_files();
    } else {
        signals::take(&stop, limit);
    }
    ctrlc::set_handler(move || end(&stop, limit)).map_err(uninterruptible)
}

/// Requests the end of the probe. The second request ends the program.
fn end(stop: &Stop, limit: u64) {
    let first = *FIRST.get_or_init(|| Clock::real().now());
    if !request(stop, limit) {
        if Clock::real().now() < first + REPEAT_TIME {
            return;
        }
        drop(Danger::new(stop));
        remove_recordings();
        std::process::exit(INTERRUPTED);
    }
}

/// Requests the end of the probe. Returns false if this has already been requested.
fn request(stop: &Stop, limit: u64) -> bool {
    let is_first = stop.request();
    if !is_first {
        return false;
    }
    let state = stop.at_risk().map_or_else(
        || "interrupted: the probe ends".to_owned(),
        |uavs| format!("interrupted: the probe first makes the UAVs safe, for up to {limit} s ({uavs})"),
    );
    print(&format!("{state}. Press Ctrl-C again to leave immediately."));
    true
}

/// Prints a line to standard error. Ignores errors, because the terminal may be gone.
pub(super) fn print(line: &str) {
    // The signal may arrive while a progress bar is shown.
    let start = if std::io::stderr().is_terminal() { "\n" } else { "" };
    terminal::print_error(format_args!("{start}{line}\n"));
}

/// Prints a line in a separate thread, because a terminal that accepts no output must not delay the landing.
pub(super) fn print_later(line: &str) {
    let line = line.to_owned();
    thread::spawn(move || print(&line));
}

/// Prints the UAVs that may be unsafe when it is dropped, even after a panic.
pub(super) struct Danger {
    stop: Stop,
    /// The UAVs that may be unsafe, with the reason. Set after the probe has ended.
    pub(super) known: Option<String>,
}

impl Danger {
    pub(super) fn new(stop: &Stop) -> Self {
        Self { stop: stop.clone(), known: None }
    }
}

impl Drop for Danger {
    fn drop(&mut self) {
        let Some(at_risk) = self.known.take().or_else(|| self.stop.at_risk()) else { return };
        let red = AnsiColor::Red.on_default().bold();
        print(&format!("{red}error: {at_risk}. Take control by other means now.{red:#}"));
    }
}

#[cfg(unix)]
mod signals {
    use std::thread;

    use nix::sys::signal::{SigSet, Signal};

    use super::{Stop, end, print, request};

    /// Blocks SIGXFSZ, so that a write beyond the size limit of a file fails instead of ending the program.
    pub(super) fn outlive_full_files() {
        let mut signals = SigSet::empty();
        signals.add(Signal::SIGXFSZ);
        // If the signal isn't blocked, the program ends like other programs.
        let _ = signals.thread_block();
    }

    /// Blocks all signals, and handles them in a thread, so that no signal ends or suspends the probe while UAVs are
    /// flying.
    pub(super) fn take(stop: &Stop, limit: u64) {
        let signals = SigSet::all();
        if signals.thread_block().is_err() {
            return;
        }
        let stop = stop.clone();
        thread::spawn(move || {
            loop {
                handle(signals.wait().ok(), &stop, limit);
            }
        });
    }

    /// Handles a signal. `None` denotes a signal without a name.
    fn handle(signal: Option<Signal>, stop: &Stop, limit: u64) {
        use Signal::{
            SIGCHLD, SIGCONT, SIGHUP, SIGINT, SIGPIPE, SIGQUIT, SIGTERM, SIGTSTP, SIGTTIN, SIGTTOU, SIGURG,
            SIGWINCH,
        };
        match signal {
            Some(SIGCHLD | SIGCONT | SIGPIPE | SIGTTIN | SIGTTOU | SIGURG | SIGWINCH) => {}
            Some(SIGTSTP) => print("A probe that may send commands can't be suspended."),
            Some(SIGINT | SIGTERM | SIGHUP | SIGQUIT) => end(stop, limit),
            // Limits and timers repeat their signals, so the second signal must not end the program.
            _ => _ = request(stop, limit),
        }
    }
}
