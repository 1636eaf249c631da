//! The same of live servers: the reference server is probed as it is, and with each of its bugs.

use std::collections::BTreeSet;
use std::io::{self, Write};
use std::net::{Ipv4Addr, SocketAddr};
use std::num::NonZeroUsize;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use super::list;
use crate::check::{CaptureResult, check_capture, parallel};
use crate::definitions::Definitions;
use crate::flockwave::transport::endpoint::Endpoint;
use crate::probe::{self, probe};
use crate::rules::flockwave::{FlockwaveRule, Needs, RULES};
use crate::serve::{self, Server, Transport};

/// How many servers are probed at the same time: most of it is waiting.
const JOBS: usize = 32;

/// How long it is listened to each.
const OBSERVE: Duration = Duration::from_millis(1_500);

/// When the UAV that gets lost does so.
const LOSS: Duration = Duration::from_millis(700);

/// How long a client may stay at the server that says farewell: longer than any trial on a connection of its own takes.
const FAREWELL_DELAY: Duration = Duration::from_secs(2);

/// How many times as fast as life the simulation goes.
const SPEED: f64 = 10.0;

/// How often clients are told of the fleet, a second.
const RATE: f64 = 10.0;

/// The UAVs that commands are sent to.
const UAVS: [&str; 2] = ["glider-1", "glider-2"];

/// Name and password, where a login is needed.
const LOGIN: (&str, &str) = ("pilot", "soar");

/// The ways to a server without a bug: transport, and what follows host and port.
const TRANSPORTS: [(Transport, &str); 7] = [
    (Transport::Tcp, ""),
    (Transport::Udp, ""),
    (Transport::Http, ""),
    (Transport::SocketIo, "?protocol=4&transport=websocket"),
    (Transport::SocketIo, "?protocol=4&transport=polling"),
    (Transport::SocketIo, "?protocol=5&transport=websocket"),
    (Transport::SocketIo, "?protocol=5&transport=polling"),
];

/// How a server is, and how it is reached.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Case {
    /// The bug that it has.
    pub bug: Option<&'static FlockwaveRule>,
    /// What it is reached over.
    pub transport: Transport,
    /// What follows host and port in its URL.
    rest: &'static str,
    /// Whether it wants a login.
    pub has_login: bool,
    /// Whether it says farewell to its clients.
    pub sends_farewell: bool,
}

/// What came of probing a server.
#[derive(Debug)]
pub(crate) struct Row {
    /// How it was.
    pub case: Case,
    /// The rules that were broken.
    pub violated: BTreeSet<&'static str>,
    /// The rules that are broken by the recording.
    pub replayed: BTreeSet<&'static str>,
    /// The rules that were exercised.
    pub covered: BTreeSet<&'static str>,
    /// Why not all could be asked.
    pub failure: Option<String>,
}

impl Case {
    /// A name for people.
    pub(crate) fn name(&self) -> String {
        let with = |is: bool, what| if is { what } else { "" };
        let (login, parting) =
            (with(self.has_login, ", with a login"), with(self.sends_farewell, ", parting"));
        format!("{}{}{login}{parting}", self.transport.name(), self.rest)
    }
}

impl Row {
    /// The rules that it should break.
    pub(crate) fn expected(&self) -> BTreeSet<&'static str> {
        let bug = self.case.bug;
        let rules = bug.into_iter().flat_map(|of| of.bug.also.iter().copied().chain([&of.rule]));
        rules.map(|rule| rule.id).collect()
    }

    /// What should have been found, and what was.
    pub(crate) fn mismatch_text(&self) -> String {
        let (expected, found) = (list(&self.expected()), list(&self.violated));
        let recorded = match &self.replayed {
            same if *same == self.violated => String::new(),
            other => format!(", and {} in the recording", list(other)),
        };
        let failure = self.failure.as_ref().map_or_else(String::new, |failure| format!("; {failure}"));
        format!("expected {expected}, found {found}{recorded}{failure}")
    }

    /// Whether it broke what it should, and nothing else, live and recorded.
    pub(crate) fn is_right(&self) -> bool {
        self.violated == self.expected() && self.replayed == self.violated
    }
}

/// All cases: a server without a bug over each transport, and each bug over the one that it shows on.
pub(crate) fn cases() -> Vec<Case> {
    let plain =
        |(transport, rest)| Case { bug: None, transport, rest, has_login: false, sends_farewell: false };
    let tcp = plain((Transport::Tcp, ""));
    let odd = [Case { has_login: true, ..tcp }, Case { sends_farewell: true, ..tcp }];
    let with_bug = |of: &'static FlockwaveRule| {
        let case = match of.bug.needs {
            Needs::Nothing => tcp,
            Needs::Udp => Case { transport: Transport::Udp, ..tcp },
            Needs::SocketIo => Case { transport: Transport::SocketIo, ..tcp },
            Needs::Login => Case { has_login: true, ..tcp },
            Needs::Farewell => Case { sends_farewell: true, ..tcp },
        };
        Case { bug: Some(of), ..case }
    };
    TRANSPORTS.into_iter().map(plain).chain(odd).chain(RULES.into_iter().map(with_bug)).collect()
}

/// Probes a server for each case, and hands on what came of it, in their order.
pub(crate) fn live(cases: &[Case], definitions: &Definitions, mut take: impl FnMut(io::Result<Row>)) {
    let work = |case: &Case| row(case, definitions);
    parallel::each(cases, NonZeroUsize::new(JOBS), work, |_, row| take(row));
}

fn row(case: &Case, definitions: &Definitions) -> io::Result<Row> {
    let options = serve::Options {
        bug: case.bug,
        speed: SPEED,
        rate: RATE,
        losses: vec![("glider-5".to_owned(), LOSS)],
        stay: case.sends_farewell.then_some(FAREWELL_DELAY),
        login: case.has_login.then(|| (LOGIN.0.to_owned(), LOGIN.1.to_owned())),
        ..serve::Options::default()
    };
    let free = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
    let server = Server::start(options, &[(case.transport, free)])?;
    let Some(listening) = server.listening().first() else {
        return Err(io::Error::other("it listens nowhere"));
    };
    let endpoint: Endpoint = format!("{listening}{}", case.rest).parse().map_err(io::Error::other)?;
    // Over HTTP nobody hears what comes of a command.
    let uavs = if case.transport == Transport::Http { &[][..] } else { &UAVS[..] };
    let login = case.has_login.then(|| (LOGIN.0.to_owned(), LOGIN.1.to_owned()));
    let uavs = uavs.iter().map(|id| (*id).to_owned()).collect();
    let options = probe::Options::new(OBSERVE, login, uavs);
    let tape = Tape::default();
    let probed = probe(&endpoint, &options, definitions, Some(Box::new(tape.clone())), &|_, _| {});
    let recording = tape.0.lock().unwrap_or_else(PoisonError::into_inner);
    let replayed = check_capture(&**recording, None, definitions)?;
    Ok(Row {
        case: *case,
        violated: violated(&probed.result),
        replayed: violated(&replayed),
        covered: covered(&probed.result),
        failure: probed.failure,
    })
}

fn violated(result: &CaptureResult) -> BTreeSet<&'static str> {
    result.findings.groups().map(|group| group.rule.id).collect()
}

fn covered(result: &CaptureResult) -> BTreeSet<&'static str> {
    let is_covered = |rule: &&&'static crate::model::Rule| result.findings.covered(rule) > 0;
    crate::rules::RULES.iter().filter(is_covered).map(|rule| rule.id).collect()
}

/// A recording in memory.
#[derive(Clone, Default)]
struct Tape(Arc<Mutex<Vec<u8>>>);

impl Write for Tape {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
