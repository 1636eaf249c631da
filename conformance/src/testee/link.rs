//! The line to a testee, be it a child process or a connection. Whatever it does, nothing here waits longer than it
//! is told to.
//!
//! A thread reads what it says, and one writes what it is asked: it may stop reading. The threads end with the pipes
//! or the connection, and nobody waits for them.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::process::ChildStdin;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, channel, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use super::options::{Options, excerpt};
use super::process::Process;
use super::protocol::Hello;
use super::target::Target;
use crate::net::Connection;

/// How many lines may wait to be judged; then the testee waits. Few, since each may be as long as the limit allows.
const MAX_QUEUED_LINES: usize = 8;

/// How often is looked whether a process that says nothing has ended.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// What comes from a testee.
#[derive(Debug)]
pub(super) enum Received {
    /// A line without its end.
    Line(Vec<u8>),
    /// A line longer than the limit. What follows can't be read.
    TooLong,
    /// It has closed its side.
    Closed,
    /// The connection broke, and how.
    Lost(String),
    /// Nothing came in time.
    Nothing,
}

/// An open line to a testee. Dropping it kills the process, or cuts the connection.
pub(super) struct Link {
    peer: Peer,
    to: Option<Sender<Vec<u8>>>,
    from: Receiver<Received>,
}

enum Peer {
    Process(Process),
    Connection(Connection),
}

impl Link {
    /// Starts the testee, or connects to it. `is_again` says that it was there before.
    pub(super) fn open(options: &Options, is_again: bool) -> Result<Self, String> {
        let until = Instant::now() + options.start_timeout;
        let (to, questions) = channel();
        let (lines, from) = sync_channel(MAX_QUEUED_LINES);
        let limit = options.line_limit;
        let peer = match &options.target {
            Target::Command(command) => {
                let (process, input, output) = Process::start(command)
                    .map_err(|error| format!("can't start {}: {error}", options.target))?;
                thread::spawn(move || write(input, &questions));
                thread::spawn(move || read(output, &lines, limit));
                Peer::Process(process)
            }
            Target::Address(address) => {
                let open = if is_again { Connection::open_again } else { Connection::open };
                let connected = open(address, until).and_then(|connection| {
                    let (input, output) = (connection.stream()?, connection.stream()?);
                    thread::spawn(move || write(input, &questions));
                    thread::spawn(move || read(output, &lines, limit));
                    Ok(connection)
                });
                Peer::Connection(
                    connected
                        .map_err(|error| format!("can't connect to {address}: {error}{}", advice(&error)))?,
                )
            }
        };
        Ok(Self { peer, to: Some(to), from })
    }

    /// Asks the testee to introduce itself; gives the line, too. What is wrong, otherwise.
    pub(super) fn introduction(&mut self, options: &Options) -> Result<(Hello, Vec<u8>), String> {
        self.send(Hello::request());
        let until = Instant::now() + options.start_timeout;
        let wrong = match self.receive(until) {
            Received::Line(line) => match Hello::read(&line) {
                Ok(hello) => return Ok((hello, line)),
                Err(wrong) => format!("{wrong}: {}", excerpt(&line)),
            },
            Received::TooLong => "a line that is too long".to_owned(),
            Received::Closed => self.ending(until),
            Received::Lost(how) => how,
            Received::Nothing => format!("nothing within {} s", options.start_timeout.as_secs_f32()),
        };
        Err(wrong + &remaining_stderr(&self.kill()))
    }

    /// Sends a line, sooner or later; if it can't be sent, the testee has ended, and that is seen elsewhere.
    pub(super) fn send(&self, line: String) {
        self.send_bytes((line + "\n").into_bytes());
    }

    /// Sends bytes with one write.
    pub(super) fn send_bytes(&self, bytes: Vec<u8>) {
        if let Some(to) = &self.to {
            let _ = to.send(bytes);
        }
    }

    /// Closes its input once all has been sent.
    pub(super) fn close(&mut self) {
        self.to = None;
    }

    pub(super) fn receive(&mut self, until: Instant) -> Received {
        loop {
            let left = until.saturating_duration_since(Instant::now());
            match self.from.recv_timeout(left.min(POLL_INTERVAL)) {
                Ok(text) => return text,
                Err(RecvTimeoutError::Disconnected) => return Received::Closed,
                Err(RecvTimeoutError::Timeout) if left <= POLL_INTERVAL => return Received::Nothing,
                Err(RecvTimeoutError::Timeout) => {}
            }
            // What it left behind may hold its output open, and ends with it.
            if let Peer::Process(process) = &mut self.peer {
                process.ended(Instant::now());
            }
        }
    }

    /// How it ended, in words, after it has closed its side.
    pub(super) fn ending(&mut self, until: Instant) -> String {
        match &mut self.peer {
            Peer::Process(process) => match process.ended(until) {
                Some(how) if how.is_empty() => "it ended by itself".to_owned(),
                Some(how) => format!("it ended: {how}"),
                None => "it closed its standard output".to_owned(),
            },
            Peer::Connection(_) => "it closed the connection".to_owned(),
        }
    }

    /// Closes its input, hands on the lines that it still says, and tells what is wrong with how it ends.
    pub(super) fn part(&mut self, within: Duration, mut receive: impl FnMut(&[u8])) -> Result<(), String> {
        self.close();
        let until = Instant::now() + within;
        let mut text = self.receive(until);
        while let Received::Line(line) = &text {
            receive(line);
            // Lines without end don't win time.
            text = if Instant::now() < until { self.receive(until) } else { Received::Nothing };
        }
        match (&mut self.peer, text) {
            (Peer::Process(process), _) => match process.ended(until) {
                None => Err("it doesn't end when its standard input does".to_owned()),
                Some(how) if !how.is_empty() => Err(format!("it ends with {how}")),
                Some(_) => Ok(()),
            },
            (Peer::Connection(_), Received::Closed) => Ok(()),
            (Peer::Connection(_), Received::Lost(how)) => Err(how),
            (Peer::Connection(_), _) => {
                Err("it doesn't close the connection when this side has closed its half".to_owned())
            }
        }
    }

    /// Kills it, and gives what it said last on standard error; cuts a connection, which has none.
    pub(super) fn kill(&mut self) -> String {
        match &mut self.peer {
            Peer::Process(process) => process.kill(),
            Peer::Connection(connection) => {
                connection.shut_down();
                String::new()
            }
        }
    }
}

/// What to do about a connection that can't be opened.
fn advice(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::ConnectionRefused => {
            "\n  help: nobody listens there; start the testee, and compare the port"
        }
        io::ErrorKind::TimedOut => "\n  help: look for a mistake in the address, or a firewall on the way",
        _ => "\n  help: look for a mistake in the name or the address",
    }
}

/// What to add to a message of something that the end of standard error may explain.
pub(super) fn remaining_stderr(stderr: &str) -> String {
    if stderr.is_empty() { String::new() } else { format!("\nIts standard error ends:\n{stderr}") }
}

/// What is written to, and closed so that the other side sees it.
trait Input: Write {
    fn close(self);
}

impl Input for ChildStdin {
    fn close(self) {}
}

impl Input for TcpStream {
    fn close(self) {
        // The other handles keep the connection open, which may have ended by itself.
        let _ = self.shutdown(Shutdown::Write);
    }
}

fn write(mut input: impl Input, questions: &Receiver<Vec<u8>>) {
    for bytes in questions {
        if input.write_all(&bytes).and_then(|()| input.flush()).is_err() {
            return;
        }
    }
    input.close();
}

fn read(output: impl Read, lines: &SyncSender<Received>, limit: usize) {
    let mut output = BufReader::with_capacity(1 << 16, output);
    loop {
        let mut line = Vec::new();
        // One byte for the end of the line.
        let most = u64::try_from(limit).unwrap_or(u64::MAX).saturating_add(1);
        let read = output.by_ref().take(most).read_until(b'\n', &mut line);
        let is_whole = line.pop_if(|byte| *byte == b'\n').is_some();
        let text = match read {
            Ok(_) if is_whole => Received::Line(line),
            Ok(_) if line.len() > limit => Received::TooLong,
            // The last line may lack its end.
            Ok(_) if !line.is_empty() => Received::Line(line),
            Ok(_) => Received::Closed,
            Err(error) => Received::Lost(format!("reading from it failed: {error}")),
        };
        let is_last = matches!(text, Received::TooLong | Received::Closed | Received::Lost(_));
        if lines.send(text).is_err() || is_last {
            return;
        }
    }
}
