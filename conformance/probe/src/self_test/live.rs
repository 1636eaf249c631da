//! Probes the reference server without bugs, and with each bug.

use std::collections::BTreeSet;
use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::num::NonZeroUsize;
use std::time::Duration;

use uavspec_check::{check_capture, parallel};
use uavspec_flockwave::transport::endpoint::Endpoint;
use uavspec_model::clock::Clock;
use uavspec_rules::definitions::Definitions;
use uavspec_rules::flockwave::{FlockwaveRule, Needs, RULES};
use uavspec_serve::{InMemory, Server, Transport};

use super::Found;
use crate::{Probed, probe, probe_on};

/// The number of servers that are probed concurrently. Probes mostly wait. More servers would keep two cores busy, so
/// that answers would be late.
const JOBS: usize = 24;

/// The number of attempts to probe a server before its result counts as wrong. On a busy machine, answers are late, and
/// a server may read several requests together.
const TRIES: u32 = 3;

/// The time for which each server is observed.
const OBSERVE: Duration = Duration::from_millis(1_500);

/// The time for which a request may remain unanswered. A local server answers within milliseconds.
const TIMEOUT: Duration = Duration::from_secs(2);

/// The time limit for making UAVs safe. Simulated UAVs land within seconds, unless a bug prevents it.
const LANDING_LIMIT: Duration = Duration::from_secs(10);

/// The time limit for operations. Simulated operations progress within a tenth of this time.
const PROGRESS_TIMEOUT: Duration = Duration::from_secs(3);

/// The time from the first connection until a UAV is lost.
const LOSS: Duration = Duration::from_millis(700);

/// The maximum duration of a connection to a server that sends a farewell. It is longer than any trial on a separate
/// connection.
const FAREWELL_DELAY: Duration = Duration::from_secs(2);

/// The simulation speed. `10` means ten times real time.
const SPEED: f64 = 10.0;

/// The number of status reports per second.
const RATE: f64 = 10.0;

/// The UAVs that receive commands.
const UAVS: [&str; 2] = ["glider-1", "glider-2"];

/// User name and password.
const LOGIN: (&str, &str) = ("pilot", "soar");

/// The transports for servers without a bug, each with its URL query.
const TRANSPORTS: [(Transport, &str); 7] = [
    (Transport::Tcp, ""),
    (Transport::Udp, ""),
    (Transport::Http, ""),
    (Transport::SocketIo, "?protocol=4&transport=websocket"),
    (Transport::SocketIo, "?protocol=4&transport=polling"),
    (Transport::SocketIo, "?protocol=5&transport=websocket"),
    (Transport::SocketIo, "?protocol=5&transport=polling"),
];

/// A configuration of the reference server.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// The bug of the server.
    pub bug: Option<&'static FlockwaveRule>,
    /// The transport.
    pub transport: Transport,
    /// The query of the URL.
    query: &'static str,
    /// True if the server requires a login.
    pub has_login: bool,
    /// True if the server sends a farewell to its clients.
    pub sends_farewell: bool,
}

/// The result for a server.
#[derive(Debug)]
pub struct Row {
    /// The configuration of the server.
    pub case: Case,
    /// The violated and covered rules.
    pub found: Found,
}

impl Case {
    /// True if the server needs no socket. In simulated time, its probe then takes no real time.
    fn is_in_memory(&self) -> bool {
        self.bug.is_some_and(|rule| rule.bug.needs != Needs::Tcp) && self.transport == Transport::Tcp
    }

    /// The name of the case.
    pub fn name(&self) -> String {
        let text_if = |condition: bool, text| if condition { text } else { "" };
        let login = text_if(self.has_login, ", with login");
        let farewell = text_if(self.sends_farewell, ", with farewell");
        format!("{}{}{login}{farewell}", self.transport.name(), self.query)
    }
}

impl Row {
    /// The rules that the server should violate.
    fn expected(&self) -> BTreeSet<&'static str> {
        let bug = self.case.bug;
        let rules = bug.into_iter().flat_map(|entry| entry.bug.also.iter().copied().chain([&entry.rule]));
        rules.map(|rule| rule.id).collect()
    }

    /// True if exactly the expected rules are violated, live and in the recorded session.
    pub fn is_right(&self) -> bool {
        self.found.is_right(&self.expected())
    }

    /// Describes the difference between the expected and the violated rules.
    pub fn mismatch_text(&self) -> String {
        self.found.mismatch_text(&self.expected())
    }
}

/// All cases: for each transport, a server without a bug; and for each bug, a server with the transport that reveals
/// the bug.
pub fn cases() -> Vec<Case> {
    let plain =
        |(transport, query)| Case { bug: None, transport, query, has_login: false, sends_farewell: false };
    let tcp = plain((Transport::Tcp, ""));
    let special = [Case { has_login: true, ..tcp }, Case { sends_farewell: true, ..tcp }];
    let with_bug = |entry: &'static FlockwaveRule| {
        let case = match entry.bug.needs {
            Needs::Nothing | Needs::Patience | Needs::Tcp => tcp,
            Needs::Udp => Case { transport: Transport::Udp, ..tcp },
            Needs::SocketIo => Case { transport: Transport::SocketIo, ..tcp },
            Needs::Login => Case { has_login: true, ..tcp },
            Needs::Farewell => Case { sends_farewell: true, ..tcp },
        };
        Case { bug: Some(entry), ..case }
    };
    TRANSPORTS.into_iter().map(plain).chain(special).chain(RULES.into_iter().map(with_bug)).collect()
}

/// Probes a server for each case, and passes the results to `take` in case order.
pub fn live(cases: &[Case], definitions: &Definitions, mut take: impl FnMut(io::Result<Row>)) {
    let work = |case: &Case| {
        let mut result = row(case, definitions);
        for _ in 1..TRIES {
            if result.as_ref().is_ok_and(Row::is_right) {
                break;
            }
            result = row(case, definitions);
        }
        result
    };
    parallel::each(cases, NonZeroUsize::new(JOBS), work, |_, row| take(row));
}

fn row(case: &Case, definitions: &Definitions) -> io::Result<Row> {
    let options = uavspec_serve::Options {
        bug: case.bug,
        speed: SPEED,
        rate: RATE,
        losses: vec![("glider-5".to_owned(), LOSS)],
        stay: case.sends_farewell.then_some(FAREWELL_DELAY),
        login: case.has_login.then(|| (LOGIN.0.to_owned(), LOGIN.1.to_owned())),
        ..uavspec_serve::Options::default()
    };
    if case.is_in_memory() {
        let clock = Clock::simulated();
        let server = InMemory::new(options, &clock);
        let endpoint = "tcp://memory:5001".parse().map_err(io::Error::other)?;
        let options = crate::Options { clock, ..probe_options(case) };
        return found(case, definitions, |tape| {
            probe_on(&server, &endpoint, &options, definitions, Some(Box::new(tape)))
        });
    }
    let free = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
    let server = Server::start(options, &[(case.transport, free)])?;
    let Some(listening) = server.listening().first() else {
        return Err(io::Error::other("the server has no address"));
    };
    let endpoint: Endpoint = format!("{listening}{}", case.query).parse().map_err(io::Error::other)?;
    let options = probe_options(case);
    found(case, definitions, |tape| probe(&endpoint, &options, definitions, Some(Box::new(tape)), &|_, _| {}))
}

/// The options of the probe of a server.
fn probe_options(case: &Case) -> crate::Options {
    // Over HTTP, clients don't receive the results of commands.
    let uavs = if case.transport == Transport::Http { &[][..] } else { &UAVS[..] };
    let login = case.has_login.then(|| (LOGIN.0.to_owned(), LOGIN.1.to_owned()));
    let uavs = uavs.iter().map(|id| (*id).to_owned()).collect();
    let mut options = crate::Options {
        timeout: TIMEOUT,
        landing_limit: LANDING_LIMIT,
        ..crate::Options::new(OBSERVE, login, uavs)
    };
    if case.bug.is_none_or(|rule| rule.bug.needs != Needs::Patience) {
        options.progress_timeout = PROGRESS_TIMEOUT;
    }
    options
}

/// Probes a server, and checks the recording of the probe.
fn found(
    case: &Case,
    definitions: &Definitions,
    probe: impl FnOnce(&mut Vec<u8>) -> Probed,
) -> io::Result<Row> {
    let mut recorded = Vec::new();
    let probed = probe(&mut recorded);
    let replayed = check_capture(&recorded[..], None, definitions)?;
    let failure = probed.failure.or(probed.cut_short);
    Ok(Row { case: *case, found: Found::new(&probed.result, &replayed, failure) })
}
