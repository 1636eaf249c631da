//! A connection to a testee, over the pipes of a child process or over TCP. No call here blocks longer than its time
//! limit.
//!
//! One thread reads from the testee. Another thread writes to the testee, because the testee may stop reading. The
//! threads end when the pipes or the connection are closed. Nothing waits for them.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, channel, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use uavspec_model::clock::Clock;
use uavspec_model::net::Connection;
use uavspec_model::text::shown;

#[cfg(test)]
use super::memory::Memory;
use super::options::{Options, excerpt};
use super::process::Process;
use super::protocol::Hello;
use super::target::Target;

/// The maximum number of queued lines. Each line may be as long as the line limit. If the queue is full, the testee
/// must wait.
const MAX_QUEUED_LINES: usize = 2;

/// The interval between checks of whether a silent process has ended.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// An item read from a testee.
#[derive(Debug)]
pub(super) enum Received {
    /// A line without its line end.
    Line(Vec<u8>),
    /// A line exceeded the limit; nothing can be read after it.
    TooLong,
    /// The end of the output.
    Closed,
    /// A connection error.
    Lost(String),
    /// No data arrived before the time limit.
    Nothing,
}

/// An open connection to a testee. Dropping it kills the process or closes the connection.
pub(super) struct Link {
    peer: Peer,
    to: Option<Sender<Vec<u8>>>,
    from: Receiver<Received>,
    clock: Clock,
}

enum Peer {
    Process(Process),
    Connection(Connection),
    #[cfg(test)]
    Memory(Memory),
}

impl Link {
    /// Starts the testee, or connects to it. `is_reconnect` is true if an earlier connection succeeded.
    pub(super) fn open(options: &Options, is_reconnect: bool) -> Result<Self, String> {
        let (to, requests) = channel();
        let (lines, from) = sync_channel(MAX_QUEUED_LINES);
        let limit = options.line_limit;
        let peer = match &options.target {
            Target::Command(command) => {
                let (process, input, output) = Process::start(command).map_err(|error| {
                    format!("can't start {}: {error}", shown(&options.target.to_string()))
                })?;
                thread::spawn(move || write(input, &requests, drop));
                thread::spawn(move || read(output, &lines, limit));
                Peer::Process(process)
            }
            Target::Address(address) => {
                let retrying = if is_reconnect { options.start_timeout } else { Duration::ZERO };
                let limits = (options.start_timeout, retrying);
                let connected =
                    Connection::open_again(address, limits, &options.clock).and_then(|connection| {
                        let (input, output) = (connection.stream()?, connection.stream()?);
                        // Dropping this handle isn't sufficient, because other handles keep the socket open. An error
                        // only means that the socket is already disconnected.
                        let close = |input: TcpStream| _ = input.shutdown(Shutdown::Write);
                        thread::spawn(move || write(input, &requests, close));
                        thread::spawn(move || read(output, &lines, limit));
                        Ok(connection)
                    });
                Peer::Connection(connected.map_err(|error| {
                    format!("can't connect to {}: {error}{}", shown(&address.to_string()), advice(&error))
                })?)
            }
            #[cfg(test)]
            Target::Memory(program) => Peer::Memory(program.start(requests, limit)),
        };
        Ok(Self { peer, to: Some(to), from, clock: options.clock.clone() })
    }

    /// Requests a hello, and returns it together with the line that contained it.
    pub(super) fn introduction(&mut self, options: &Options) -> Result<(Hello, Vec<u8>), String> {
        self.send(Hello::request());
        let until = self.clock.now() + options.start_timeout;
        let wrong = match self.receive(until) {
            Received::Line(line) => match Hello::read(&line) {
                Ok(hello) => return Ok((hello, line)),
                Err(wrong) => format!("{wrong}: {}", excerpt(&line)),
            },
            Received::TooLong => "the testee sent a line longer than the limit".to_owned(),
            Received::Closed => self.ending(until),
            Received::Lost(how) => how,
            Received::Nothing => format!("no response within {} s", options.start_timeout.as_secs_f32()),
        };
        Err(wrong + &remaining_stderr(&self.kill()))
    }

    /// Queues a line to be sent. A failure to send is ignored, because it means that the testee has ended, which
    /// `receive` reports.
    pub(super) fn send(&self, line: String) {
        self.send_bytes((line + "\n").into_bytes());
    }

    /// Queues bytes to be sent with one write.
    pub(super) fn send_bytes(&self, bytes: Vec<u8>) {
        if let Some(to) = &self.to {
            let _ = to.send(bytes);
        }
    }

    /// Closes the input of the testee after all queued data has been sent.
    pub(super) fn close(&mut self) {
        self.to = None;
    }

    pub(super) fn receive(&mut self, until: Instant) -> Received {
        #[cfg(test)]
        if let Peer::Memory(testee) = &mut self.peer {
            return testee.receive(until, &self.clock);
        }
        loop {
            let left = self.clock.left(until);
            let real = Clock::real();
            match real.receive(&self.from, real.now() + left.min(POLL_INTERVAL)) {
                Ok(text) => return text,
                Err(RecvTimeoutError::Disconnected) => return Received::Closed,
                Err(RecvTimeoutError::Timeout) if self.clock.left(until).is_zero() => {
                    return Received::Nothing;
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
            // Descendants of the process may keep its output open. They are killed when the process ends.
            if let Peer::Process(process) = &mut self.peer {
                process.ended();
            }
        }
    }

    /// Describes how the testee exited after it had closed its output.
    pub(super) fn ending(&mut self, until: Instant) -> String {
        match &mut self.peer {
            Peer::Process(process) => match process.await_end(until, &self.clock) {
                Some(how) if how.is_empty() => "the process exited with status 0".to_owned(),
                Some(how) => format!("the process ended ({how})"),
                None => "the testee closed its standard output".to_owned(),
            },
            Peer::Connection(_) => "the testee closed the connection".to_owned(),
            #[cfg(test)]
            Peer::Memory(_) => "the testee ended".to_owned(),
        }
    }

    /// Closes the input, and passes on the remaining lines. Fails if the testee doesn't end properly.
    pub(super) fn finish(&mut self, within: Duration, mut receive: impl FnMut(&[u8])) -> Result<(), String> {
        self.close();
        let until = self.clock.now() + within;
        let mut text = self.receive(until);
        while let Received::Line(line) = &text {
            receive(line);
            // A testee that never stops writing gets no extra time.
            text = if self.clock.now() < until { self.receive(until) } else { Received::Nothing };
        }
        match (&mut self.peer, text) {
            (Peer::Process(process), _) => match process.await_end(until, &self.clock) {
                None => Err("the testee doesn't exit after its standard input is closed".to_owned()),
                Some(how) if !how.is_empty() => Err(format!("expected an exit with status 0, got {how}")),
                Some(_) => Ok(()),
            },
            (Peer::Connection(_), Received::Closed) => Ok(()),
            (Peer::Connection(_), Received::Lost(how)) => Err(how),
            (Peer::Connection(_), _) => {
                Err("the testee doesn't close the connection after uavspec closes its side".to_owned())
            }
            #[cfg(test)]
            (Peer::Memory(_), _) => Ok(()),
        }
    }

    /// Kills the process, or closes the connection. Returns the last part of the process's standard error.
    pub(super) fn kill(&mut self) -> String {
        match &mut self.peer {
            Peer::Process(process) => process.kill(),
            Peer::Connection(connection) => {
                connection.shut_down();
                String::new()
            }
            #[cfg(test)]
            Peer::Memory(_) => String::new(),
        }
    }
}

/// Advice for a connection that can't be opened.
fn advice(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::ConnectionRefused => {
            "\n  help: nothing listens on this port; check the port, and make sure that the testee is running"
        }
        io::ErrorKind::TimedOut => {
            "\n  help: check the address, and whether a firewall blocks the connection"
        }
        _ => "\n  help: check the host name or address",
    }
}

/// The end of standard error, formatted for the end of an error message.
pub(super) fn remaining_stderr(stderr: &str) -> String {
    if stderr.is_empty() {
        String::new()
    } else {
        format!("\nThe last lines of the testee's standard error:\n{stderr}")
    }
}

/// Writes the requests. Then calls `close`, which signals the end of the data to the other side.
fn write<I: Write>(mut input: I, requests: &Receiver<Vec<u8>>, close: impl FnOnce(I)) {
    for bytes in requests {
        if input.write_all(&bytes).and_then(|()| input.flush()).is_err() {
            return;
        }
    }
    close(input);
}

fn read(output: impl Read, lines: &SyncSender<Received>, limit: usize) {
    let mut output = BufReader::with_capacity(1 << 16, output);
    loop {
        let mut line = Vec::new();
        // One more byte for the line end.
        let max = u64::try_from(limit).unwrap_or(u64::MAX).saturating_add(1);
        let read = output.by_ref().take(max).read_until(b'\n', &mut line);
        let is_whole = line.pop_if(|byte| *byte == b'\n').is_some();
        let text = match read {
            Ok(_) if is_whole => Received::Line(line),
            Ok(_) if line.len() > limit => Received::TooLong,
            // The last line may lack a line end.
            Ok(_) if !line.is_empty() => Received::Line(line),
            Ok(_) => Received::Closed,
            Err(error) => Received::Lost(format!("can't read from the testee: {error}")),
        };
        let is_last = matches!(text, Received::TooLong | Received::Closed | Received::Lost(_));
        if lines.send(text).is_err() || is_last {
            return;
        }
    }
}
