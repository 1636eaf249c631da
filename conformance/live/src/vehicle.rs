//! Listens to a live PX4 vehicle and its applications, and checks the messages.
//!
//! ```text
//!  bus ──event──▶ recorder ──record──▶ file
//!                     └──────record──▶ checker ──▶ findings
//! ```
//!
//! The probe records all events as a bag, and checks each record of the bag when it is written. A later
//! [`check`](uavspec_check) of the recording returns the same findings.
//!
//! A probe publishes nothing, unless it has a role: the flight controller or an external component, which take part in
//! arming checks, or an application, which asks for definitions. The messages of a role are recorded as well.

mod actor;
mod autopilot;
mod component;
mod inquiry;
mod namespace;
mod recorder;
mod reference;
mod release;
mod role;
mod temporary;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, HashSet};
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use globset::GlobSet;
use uavspec_capture::mcap::Reader;
use uavspec_check::{
    CaptureResult, Checked, LiveBag, Observer, check_path, choose_for_path, choose_for_recording,
};
use uavspec_model::clock::Clock;
use uavspec_model::text::plural;
use uavspec_model::{ApplicationType, Endpoint, EndpointKind, Qos};
use uavspec_rules::definitions::{Definitions, Library};
use uavspec_rules::px4::Side;

use self::actor::{Actor, Step, role, step};
use self::inquiry::Inquiry;
pub use self::namespace::Namespace;
use self::recorder::{MAX_SIZE, Recorder};
pub use self::reference::serve;
use self::release::Release;
use self::role::{Purpose, Role};
use self::temporary::Temporary;
pub use self::temporary::remove_recordings;
use crate::bus::{Bus, Event, MAX_ENDPOINTS, Topic};

/// The time after which the release of the vehicle is chosen. Publishers are discovered until then.
const START: Duration = Duration::from_millis(1_500);

/// The maximum time until the probe notices that it was asked to stop.
const NOTICE_TIME: Duration = Duration::from_millis(50);

/// The maximum number of notes. Further ones are only counted.
const MAX_NOTES: usize = 50;

/// Options of a probe.
pub struct Options {
    /// The time to listen.
    pub time: Duration,
    /// The topics to receive; all if there are none.
    pub topics: Option<GlobSet>,
    /// The role of the probe. `None` if it publishes nothing.
    pub role: Option<Side>,
    /// The namespace of the vehicle, for the roles. `None` if there is only one vehicle.
    pub namespace: Option<Namespace>,
    /// The types of an application that are compared with those of the flight controller, if there is one.
    pub application: Option<Vec<ApplicationType>>,
    /// The file of the recording.
    pub record: Option<PathBuf>,
    /// Returns true if the probe must end early.
    pub is_stopped: Box<dyn Fn() -> bool>,
}

/// The state of a running probe.
#[derive(Clone, Copy, Debug, Default)]
pub struct Progress {
    /// The elapsed time.
    pub elapsed: Duration,
    /// The number of topics with a publisher.
    pub topics: usize,
    /// The number of messages.
    pub messages: u64,
    /// The number of kinds of findings.
    pub findings: usize,
}

/// Listens to a bus, and checks all messages. Returns the findings, with the definitions that were used.
///
/// # Errors
/// Fails if the recording can't be written or read.
pub fn probe(
    bus: &mut dyn Bus,
    library: &Library,
    options: &Options,
    on_progress: &dyn Fn(&Progress),
) -> io::Result<Checked> {
    let (path, _temporary) = recording(options)?;
    let recorder = Recorder::create(&path)?;
    let mut probe = Probe::new(bus, options, recorder, on_progress);
    let started = probe.start(library);
    if started.is_err() {
        probe.withdraw();
    }
    let definitions = started?;
    let mut live = LiveBag::new(&definitions, None);
    let listened =
        replay(probe.recorder.path(), &mut live).and_then(|()| probe.listen(options.time, Some(&mut live)));
    // A component must unregister, even if the recording can't be written.
    let last = probe.withdraw();
    listened?;
    for event in last.into_iter().chain(probe.bus.remaining_losses()) {
        probe.recorder.record(&event, Some(&mut live))?;
    }
    probe.note_rest();
    probe.record_notes(Some(&mut live))?;
    let Probe { mut recorder, cut_short, .. } = probe;
    if let Some(reason) = cut_short {
        recorder.cut_short(&reason, Some(&mut live))?;
    }
    let (path, size) = recorder.finish()?;
    conclude(&path, library, &definitions, live.finish(size))
}

/// Passes the messages of a bus to an observer. Returns the reason why the connection ended, if it ended before the time.
///
/// # Errors
/// Fails if the temporary file, which shows the release, can't be written or read.
pub(crate) fn observe(
    bus: &mut dyn Bus,
    library: &Library,
    options: &Options,
    observer: &mut dyn Observer,
) -> io::Result<Option<String>> {
    let (path, temporary) = recording(options)?;
    let mut probe = Probe::new(bus, options, Recorder::create(&path)?, &|_| {});
    // Without messages, nothing shows the release.
    while probe.progress.messages == 0 && probe.cut_short.is_none() && probe.elapsed() < options.time {
        probe.listen(options.time.min(probe.elapsed() + START), None)?;
    }
    probe.recorder.flush()?;
    let definitions = choose_for_recording(probe.recorder.path(), library)?;
    let mut live = LiveBag::new(&definitions, Some(observer));
    replay(probe.recorder.path(), &mut live)?;
    probe.recorder.discard();
    drop(temporary);
    probe.listen(options.time, Some(&mut live))?;
    Ok(probe.cut_short)
}

/// The path of the recording. Without `--record`, the file is temporary.
fn recording(options: &Options) -> io::Result<(PathBuf, Option<Temporary>)> {
    if let Some(path) = &options.record {
        return Ok((path.clone(), None));
    }
    let file = Temporary::create()?;
    Ok((file.path().to_owned(), Some(file)))
}

/// Checks the records that were written before the release was chosen.
fn replay(path: &Path, live: &mut LiveBag<'_>) -> io::Result<()> {
    let mut reader = Reader::new(File::open(path)?);
    while let Some(item) = reader.next()? {
        // The file has no end yet.
        if !matches!(item.event, uavspec_capture::mcap::Event::Problem(_)) {
            live.record(item.event);
        }
    }
    Ok(())
}

/// The final result. If topics that appeared later show another release, the recording is checked again.
fn conclude(
    path: &Path,
    library: &Library,
    definitions: &Arc<Definitions>,
    result: CaptureResult,
) -> io::Result<Checked> {
    if Arc::ptr_eq(&choose_for_path(path, library)?, definitions) {
        return Ok(Checked { result, definitions: Arc::clone(definitions) });
    }
    check_path(path, None, library, &|input| input)
}

/// A running probe.
struct Probe<'p> {
    bus: &'p mut dyn Bus,
    options: &'p Options,
    recorder: Recorder,
    actors: Vec<Actor>,
    /// The endpoints that exist before the roles join, by id. `None` if no role joins any more.
    endpoints: Option<BTreeMap<String, Endpoint>>,
    clock: Clock,
    started: Instant,
    subscribed: HashSet<Topic>,
    progress: Progress,
    on_progress: &'p dyn Fn(&Progress),
    /// The problems with topics that the bus refused. They weren't recorded yet.
    refused: Vec<String>,
    /// True if the maximum number of topics was reported.
    is_full: bool,
    notes: Vec<String>,
    /// The number of notes beyond the maximum.
    omitted: u64,
    /// The number of notes that were recorded.
    recorded: usize,
    cut_short: Option<String>,
}

impl<'p> Probe<'p> {
    fn new(
        bus: &'p mut dyn Bus,
        options: &'p Options,
        recorder: Recorder,
        on_progress: &'p dyn Fn(&Progress),
    ) -> Self {
        let clock = bus.clock();
        let has_roles = options.role.is_some() || options.application.is_some();
        Self {
            bus,
            options,
            recorder,
            actors: Vec::new(),
            endpoints: has_roles.then(BTreeMap::new),
            started: clock.now(),
            clock,
            subscribed: HashSet::new(),
            progress: Progress::default(),
            on_progress,
            refused: Vec::new(),
            is_full: false,
            notes: Vec::new(),
            omitted: 0,
            recorded: 0,
            cut_short: None,
        }
    }

    fn elapsed(&self) -> Duration {
        self.clock.now() - self.started
    }

    /// Joins the bus in all roles of the probe.
    fn join_all(&mut self, definitions: &Arc<Definitions>, library: &Library) -> io::Result<()> {
        let Some(endpoints) = self.endpoints.take() else { return Ok(()) };
        let endpoints: Vec<Endpoint> = endpoints.into_values().collect();
        let namespace = self.options.namespace.clone();
        let namespace = match namespace.map_or_else(|| Namespace::of_vehicle(&endpoints), Ok) {
            Ok(namespace) => namespace,
            Err(problem) => {
                self.cut_short = Some(problem);
                return Ok(());
            }
        };
        let release = &Arc::new(Release::new(definitions, library, namespace.clone()));
        if let Some(side) = self.options.role {
            self.join(role(side, Purpose::Judge, release), release, &endpoints)?;
        }
        if let Some(application) = &self.options.application {
            application.iter().try_for_each(|ty| self.recorder.application(ty))?;
            let inquiry = Inquiry::new(application, namespace, self.options.topics.clone());
            self.join(Box::new(inquiry), release, &endpoints)?;
        }
        Ok(())
    }

    /// Announces the topics of a role. `known` are the endpoints of others.
    fn join(&mut self, role: Box<dyn Role>, release: &Arc<Release>, known: &[Endpoint]) -> io::Result<()> {
        match Actor::join(self.bus, role, Arc::clone(release), None) {
            Ok((mut actor, endpoints)) => {
                actor.discover(known);
                self.actors.push(actor);
                endpoints.iter().try_for_each(|endpoint| self.recorder.record(endpoint, None))
            }
            Err(problem) => {
                self.cut_short = Some(problem);
                Ok(())
            }
        }
    }

    /// Records events until the release of the vehicle can be chosen. The roles then join in this release.
    fn start(&mut self, library: &Library) -> io::Result<Arc<Definitions>> {
        self.listen(START.min(self.options.time), None)?;
        self.recorder.flush()?;
        let definitions = choose_for_recording(self.recorder.path(), library)?;
        self.join_all(&definitions, library)?;
        self.recorder.flush()?;
        Ok(definitions)
    }

    /// Ends the roles. Returns their last messages.
    fn withdraw(&mut self) -> Vec<Event> {
        let mut last = Vec::new();
        for mut actor in std::mem::take(&mut self.actors) {
            last.extend(actor.leave(self.bus));
            let problems = std::mem::take(&mut actor.problems);
            problems.into_iter().chain(actor.notes()).for_each(|note| self.note(note));
        }
        last
    }

    /// Records events until a time after the start.
    fn listen(&mut self, until: Duration, mut live: Option<&mut LiveBag<'_>>) -> io::Result<()> {
        let end = self.started + until;
        let mut shown = self.clock.now();
        while self.cut_short.is_none() && self.clock.now() < end {
            if (self.options.is_stopped)() {
                self.cut_short = Some("interrupted".to_owned());
            } else if self.recorder.size() > MAX_SIZE {
                self.cut_short = Some(format!("the recording reached {} GiB", MAX_SIZE >> 30));
            }
            let deadline = end.min(self.clock.now() + NOTICE_TIME);
            let Step { received, sent } = step(&mut self.actors, self.bus, deadline);
            for event in received.iter().chain(&sent) {
                self.recorder.record(event, live.as_deref_mut())?;
            }
            if let Some(event) = received {
                self.follow(event);
            }
            self.record_notes(live.as_deref_mut())?;
            if self.clock.now() > shown + NOTICE_TIME {
                shown = self.clock.now();
                self.show(live.as_deref());
            }
        }
        Ok(())
    }

    /// Subscribes to new topics, and notes problems.
    fn follow(&mut self, event: Event) {
        match event {
            Event::Endpoint(endpoint) => {
                if let Some(known) = &mut self.endpoints
                    && (known.len() < MAX_ENDPOINTS || known.contains_key(&endpoint.id))
                {
                    known.insert(endpoint.id.clone(), endpoint.clone());
                }
                if endpoint.kind == EndpointKind::Publisher {
                    self.subscribe(endpoint);
                }
            }
            Event::Ended(id) => {
                if let Some(known) = &mut self.endpoints {
                    known.remove(&id);
                }
            }
            Event::Message(_) => self.progress.messages += 1,
            Event::Problem(problem) => self.note(problem),
            Event::Closed(reason) => self.cut_short = Some(reason),
            Event::Lost { .. } | Event::Unreadable(_) => {}
        }
    }

    /// Subscribes to the topic of a publisher if the user selected it.
    fn subscribe(&mut self, publisher: Endpoint) {
        let is_selected = self.options.topics.as_ref().is_none_or(|topics| topics.is_match(&publisher.topic));
        let topic = Topic {
            name: publisher.topic.into(),
            type_name: publisher.type_name.into(),
            type_hash: publisher.type_hash.map(Into::into),
        };
        if !is_selected || self.subscribed.contains(&topic) {
            return;
        }
        if self.subscribed.len() >= MAX_ENDPOINTS {
            if !std::mem::replace(&mut self.is_full, true) {
                let limit =
                    format!("only the first {MAX_ENDPOINTS} topics are received: select fewer with --topics");
                self.refused.push(limit);
            }
            return;
        }
        self.subscribed.insert(topic.clone());
        if !topic.name.starts_with('/') {
            // In DDS, such names belong to services and parameters.
            if !publisher.is_matched_by_qos {
                let name = topic.name.escape_debug();
                self.note(format!("{name}: not checked, because the names of ROS topics start with `/`"));
            }
            return;
        }
        self.progress.topics += 1;
        if let Err(problem) = self.bus.subscribe(&topic, &Qos::WEAKEST) {
            self.refused.push(format!("{}: {problem}", topic.name.escape_debug()));
        }
    }

    /// Writes the new notes and the refused topics to the recording, so that a later check reports them as well.
    fn record_notes(&mut self, mut live: Option<&mut LiveBag<'_>>) -> io::Result<()> {
        for text in std::mem::take(&mut self.refused) {
            self.recorder.record(&Event::Unreadable(text), live.as_deref_mut())?;
        }
        for note in &self.notes[self.recorded..] {
            self.recorder.note(note, live.as_deref_mut())?;
        }
        self.recorded = self.notes.len();
        Ok(())
    }

    fn note(&mut self, text: String) {
        if self.notes.contains(&text) {
            return;
        }
        if self.notes.len() < MAX_NOTES {
            self.notes.push(text);
        } else {
            self.omitted += 1;
        }
    }

    /// Notes the number of the notes beyond the maximum.
    fn note_rest(&mut self) {
        if self.omitted > 0 {
            self.notes.push(format!("… and {}", plural(self.omitted, "more note")));
        }
    }

    fn show(&mut self, live: Option<&LiveBag<'_>>) {
        self.progress.elapsed = self.elapsed();
        self.progress.findings = live.map_or(0, |live| live.findings().groups().count());
        (self.on_progress)(&self.progress);
    }
}
