//! Probes the reference autopilot and the reference component without bugs, and with each bug.
//!
//! By default, the participants communicate within this process, in simulated time. They can also use real buses, with
//! one pair of participants at a time on each bus.

use std::collections::BTreeSet;
use std::net::{IpAddr, Ipv4Addr};
use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use std::{io, thread};

use uavspec_check::{Checked, check_path, parallel};
use uavspec_definitions::PX4_EVENTS;
use uavspec_live::bus::memory::Network;
use uavspec_live::bus::{self, Address, Bus, Event};
use uavspec_live::vehicle::{Namespace, Options, probe, serve};
use uavspec_model::clock::Clock;
use uavspec_model::{ApplicationType, Findings};
use uavspec_px4::event::EventOrigin;
use uavspec_rules::definitions::{EventMetadata, Family, Library};
use uavspec_rules::px4::{Bug, Needs, Px4Rule, RULES, Side};

use super::Found;

/// The simulated duration of each probe within the process.
const TIME: Duration = Duration::from_millis(6_500);

/// The duration of each probe over a bus, including discovery.
const BUS_TIME: Duration = Duration::from_secs(10);

/// The time between the starts of two participants.
const PAUSE: Duration = Duration::from_millis(150);

/// The time in which the participants of a bus are discovered.
const DISCOVERY_TIME: Duration = Duration::from_secs(3);

/// The peers in a DDS domain. They limit the communication to this computer.
const PEERS: [IpAddr; 1] = [IpAddr::V4(Ipv4Addr::LOCALHOST)];

/// The rules that are covered by participants without a bug.
const COVERED: [&str; 8] =
    ["PX-EVT-02", "PX-EVT-03", "PX-EXT-01", "PX-EXT-02", "PX-EXT-03", "PX-EXT-05", "PX-EXT-06", "PX-TIME-01"];

/// A probe of one or two references.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// The references.
    references: &'static [Side],
    /// The role of the probe.
    role: Option<Side>,
    /// The rule that a reference violates.
    pub bug: Option<&'static Px4Rule>,
}

/// The result of a probe.
#[derive(Debug)]
pub struct Row {
    /// The case.
    pub case: Case,
    /// The violated and covered rules.
    pub found: Found,
    /// The first finding of each kind.
    details: Vec<String>,
    /// The notes of the probe.
    notes: Vec<String>,
}

/// Connects a node to a bus.
type Connect<'c> = dyn Fn(&str, &Clock) -> Result<Box<dyn Bus>, String> + Sync + 'c;

/// The bus of a pair, and its clock.
struct Place<'p> {
    connect: &'p Connect<'p>,
    clock: Clock,
    time: Duration,
}

const AUTOPILOT: Case = Case { references: &[Side::Autopilot], role: Some(Side::Component), bug: None };
const COMPONENT: Case = Case { references: &[Side::Component], role: Some(Side::Autopilot), bug: None };
const BOTH: Case = Case { references: &[Side::Autopilot, Side::Component], role: None, bug: None };

/// All cases: the references without a bug, and a reference with each bug.
pub fn cases() -> Vec<Case> {
    [AUTOPILOT, COMPONENT, BOTH].into_iter().chain(RULES.into_iter().filter_map(Case::with_bug)).collect()
}

/// The property that a bus lacks and that is needed to show a bug, with an example of a bus that has it. `None` if the
/// bus has all properties.
pub fn missing(needs: Needs, address: &Address) -> Option<&'static str> {
    match needs {
        Needs::TypeHashes if address.is_dds() => {
            Some("a bus that announces type hashes, such as zenoh://HOST:PORT")
        }
        Needs::Qos if !address.is_dds() => Some(
            "a bus that matches publishers and subscribers by their quality of service, such as dds://DOMAIN",
        ),
        Needs::Headers if address.is_dds() => {
            Some("a bus that sends encapsulation headers unchanged, such as zenoh://HOST:PORT")
        }
        Needs::Nothing | Needs::TypeHashes | Needs::Headers | Needs::Qos => None,
    }
}

impl Case {
    /// A probe of the reference that has the bug of a rule.
    fn with_bug(entry: &'static Px4Rule) -> Option<Self> {
        let case = match entry.bug.as_ref()?.side {
            Side::Autopilot => AUTOPILOT,
            Side::Component => COMPONENT,
        };
        Some(Self { bug: Some(entry), ..case })
    }

    /// The name of the case.
    pub fn name(&self) -> &'static str {
        match (self.bug, self.references) {
            (Some(entry), _) => entry.rule.id,
            (None, [Side::Autopilot]) => "autopilot",
            (None, [Side::Component]) => "component",
            (None, _) => "both",
        }
    }

    /// The property that one of the buses lacks and that is needed to show the bug.
    pub fn missing(&self, buses: &[Address]) -> Option<&'static str> {
        let bug = self.bug()?;
        buses.iter().find_map(|address| missing(bug.needs, address))
    }

    fn bug(&self) -> Option<&'static Bug> {
        self.bug?.bug.as_ref()
    }

    /// The rules that the references should violate.
    fn expected(&self) -> BTreeSet<&'static str> {
        let also = self.bug().into_iter().flat_map(|bug| bug.also);
        also.copied().chain(self.bug).map(|entry| entry.rule.id).collect()
    }

    fn run(self, place: &Place<'_>, library: &Library) -> io::Result<Row> {
        let folder = tempfile::tempdir()?;
        let file = folder.path().join("run.mcap");
        let (Checked { result, .. }, failure) = self.probe(place, library, &file)?;
        let recorded = check_path(&file, None, library, &|input| input)?;
        Ok(Row {
            case: self,
            details: details(&result.findings),
            found: Found::new(
                &result,
                &recorded.result,
                failure.or_else(|| result.cut_short.first().cloned()),
            ),
            notes: result.notes,
        })
    }

    /// Probes the references. Also returns the reason why a reference failed.
    fn probe(
        self,
        place: &Place<'_>,
        library: &Library,
        record: &Path,
    ) -> io::Result<(Checked, Option<String>)> {
        let is_over = AtomicBool::new(false);
        // A component compares its definitions with those of the flight controller.
        let is_component = self.role == Some(Side::Component);
        let options = Options {
            role: self.role,
            application: is_component.then(|| ApplicationType::all(&library.newest(Family::Px4).schema)),
            record: Some(record.to_path_buf()),
            ..Options::new(place.time)
        };
        thread::scope(|scope| {
            let references = (1..).zip(self.references).map(|(index, side)| {
                let is_over = &is_over;
                place.clock.spawn(scope, move |clock| {
                    clock.sleep(PAUSE * index);
                    self.serve(*side, place.connect, clock, library, is_over)
                })
            });
            let references: Vec<_> = references.collect();
            let bus = (place.connect)("/probe", &place.clock).map_err(io::Error::other);
            let probed = bus.and_then(|mut bus| probe(&mut *bus, library, &options, &|_| {}));
            is_over.store(true, Ordering::Relaxed);
            let results = references
                .into_iter()
                .map(|reference| reference.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
            // All references must end.
            let failures: Vec<String> = results.filter_map(Result::err).collect();
            Ok((probed?, failures.into_iter().next()))
        })
    }

    /// Serves a reference until the probe is over.
    fn serve(
        self,
        side: Side,
        connect: &Connect<'_>,
        clock: &Clock,
        library: &Library,
        is_over: &AtomicBool,
    ) -> Result<(), String> {
        let mut bus = connect(&format!("/{side:?}"), clock)?;
        let is_over = || is_over.load(Ordering::Relaxed);
        serve(&mut *bus, library, &Namespace::default(), side, self.bug(), &is_over)
    }
}

impl Row {
    /// True if exactly the expected rules are violated, live and in the recording. References without a bug must also
    /// cover all rules on their messages.
    pub fn is_right(&self) -> bool {
        let is_complete = self.case.bug.is_some() || self.missing().is_empty() && self.notes.is_empty();
        self.found.is_right(&self.case.expected()) && self.found.failure.is_none() && is_complete
    }

    /// Describes the difference between the expected and the actual result.
    pub fn mismatch_text(&self) -> String {
        let mut parts = vec![self.found.mismatch_text(&self.case.expected())];
        if self.case.bug.is_none() && !self.missing().is_empty() {
            parts.push(format!("not covered: {}", self.missing().join(", ")));
        }
        parts
            .into_iter()
            .chain(self.details.iter().chain(&self.notes).cloned())
            .collect::<Vec<_>>()
            .join("; ")
    }

    /// The rules that should be covered, but aren't.
    fn missing(&self) -> Vec<&'static str> {
        COVERED.into_iter().filter(|id| !self.found.covered.contains(id)).collect()
    }
}

/// Checks that a bus can be reached, and that no vehicle uses it.
///
/// # Errors
/// The error describes the problem.
pub fn check_bus(address: &Address) -> Result<(), String> {
    let mut bus = bus::connect(address, &PEERS, &[])?;
    let end = bus.clock().now() + DISCOVERY_TIME;
    while let Some(event) = bus.receive(end) {
        match event {
            Event::Endpoint(endpoint) if endpoint.topic.starts_with("/fmu/") => {
                let (kind, topic) = (endpoint.kind, endpoint.topic.escape_debug());
                return Err(format!(
                    "the bus is in use: found a {kind} of {topic}; choose a bus without a vehicle"
                ));
            }
            Event::Closed(reason) => return Err(reason),
            _ => {}
        }
    }
    Ok(())
}

/// Probes the references of each case, and passes the results to `take` in case order. Without `buses`, the participants
/// communicate within this process.
pub fn pairs(cases: &[Case], buses: &[Address], mut take: impl FnMut(io::Result<Row>)) {
    // The references send built-in events.
    let mut events = EventMetadata::built_in(PX4_EVENTS);
    events.origin = EventOrigin::Capture;
    let library = Library::built_in().with_events(events);
    let free = Mutex::new(buses.to_vec());
    let work = |case: &Case| {
        let address = free.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let row = match &address {
            Some(address) => over(*case, address, &library),
            None => within(*case, &library),
        };
        free.lock().unwrap_or_else(PoisonError::into_inner).extend(address);
        row
    };
    parallel::each(cases, NonZeroUsize::new(buses.len()), work, |_, row| take(row));
}

/// Runs a case over a bus.
fn over(case: Case, address: &Address, library: &Library) -> io::Result<Row> {
    let connect = |_: &str, _: &Clock| bus::connect(address, &PEERS, &[]);
    case.run(&Place { connect: &connect, clock: Clock::real(), time: BUS_TIME }, library)
}

/// Runs a case within this process.
fn within(case: Case, library: &Library) -> io::Result<Row> {
    let network = Network::default();
    let connect = |node: &str, clock: &Clock| -> Result<Box<dyn Bus>, String> {
        Ok(Box::new(network.connect(node, clock)))
    };
    case.run(&Place { connect: &connect, clock: Clock::simulated(), time: TIME }, library)
}

fn details(findings: &Findings) -> Vec<String> {
    let first = findings.groups().filter_map(|group| {
        let (_, detail) = group.examples.first()?;
        Some(format!("{} {}: {detail}", group.rule.id, group.subject))
    });
    first.collect()
}
