//! Listens to a live PX4 vehicle and its applications, and checks the messages.
//!
//! ```text
//!  bus ──event──▶ recorder ──record──▶ file
//!                     └──────record──▶ checker ──▶ findings
//! ```
//!
//! The probe records all events as a bag, and checks each record when it is written. A later [`check`](uavspec_check)
//! of the recording returns the same findings.
//!
//! A probe publishes nothing, unless it has a role. The flight controller and the external component take part in
//! arming checks. The application asks for definitions. The messages of a role are recorded as well.

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
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use globset::GlobSet;
use uavspec_capture::mcap::{Event as McapEvent, Reader};
use uavspec_check::{Checked, LiveBag, Observer, check_path, choose_for_path, choose_for_recording};
use uavspec_model::clock::Clock;
use uavspec_model::text::plural;
use uavspec_model::{ApplicationType, Endpoint, EndpointKind, Qos};
use uavspec_rules::definitions::{Definitions, Library};
use uavspec_rules::px4::Side;

use self::actor::{Actor, Step, role, step};
use self::inquiry::Inquiry;
pub use self::namespace::Namespace;
use self::recorder::Recorder;
pub use self::reference::serve;
use self::release::Release;
use self::role::{Purpose, Role};
use self::temporary::Temporary;
pub use self::temporary::remove_recordings;
use crate::bus::{Bus, Event, Topic};
use crate::limits::{MAX_ENDPOINTS, MAX_RECORDING};

/// The time from the start of a probe until it chooses the vehicle's release. Publishers are discovered in this time.
const START: Duration = Duration::from_millis(1_500);

/// The maximum time until a probe or a reference notices that it has been asked to stop.
const NOTICE_TIME: Duration = Duration::from_millis(50);

/// The maximum number of notes. Further notes are only counted.
const MAX_NOTES: usize = 50;

/// Options of a probe.
pub struct Options {
    /// The time to listen.
    pub time: Duration,
    /// The topics to receive. `None` if all topics are received.
    pub topics: Option<GlobSet>,
    /// The role of the probe. `None` if it publishes nothing.
    pub role: Option<Side>,
    /// The namespace of the vehicle, for the roles. `None` if there is only one vehicle.
    pub namespace: Option<Namespace>,
    /// The types of an application, which are compared with the types of the flight controller. `None` if there is no
    /// application.
    pub application: Option<Vec<ApplicationType>>,
    /// The file to which the messages are recorded.
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

impl Options {
    /// The options to listen to all topics for a time, without a role.
    pub fn new(time: Duration) -> Self {
        Self {
            time,
            topics: None,
            role: None,
            namespace: None,
            application: None,
            record: None,
            is_stopped: Box::new(|| false),
        }
    }
}

/// Listens to a bus, and checks all messages. Returns the findings, and the definitions that were used.
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
    let mut chosen = None;
    let mut probe =
        Probe::new(bus, options, Recorder::create(&path, library.events())?, on_progress, &|_| {});
    let started = probe.start(library);
    if started.is_err() {
        // The first error is reported.
        let _ = probe.withdraw();
    }
    let definitions = &*chosen.insert(started?);
    let listened = probe.check(definitions, None).and_then(|()| probe.listen(options.time));
    // A component must unregister, even if the recording can't be written.
    let last = probe.withdraw();
    listened?;
    for event in last?.into_iter().chain(probe.bus.remaining_losses()) {
        probe.recorder.record(&event)?;
    }
    let Probe { mut recorder, omitted, cut_short, .. } = probe;
    if omitted > 0 {
        recorder.note(&format!("… and {}", plural(omitted, "more note")))?;
    }
    if let Some(reason) = cut_short {
        recorder.cut_short(&reason)?;
    }
    let result = recorder.finish()?;
    // If topics that appeared later indicate another release, the recording is checked again.
    let is_same = Arc::ptr_eq(&choose_for_path(&path, library)?, definitions);
    match result.filter(|_| is_same) {
        Some(result) => Ok(Checked { result, definitions: Arc::clone(definitions) }),
        None => check_path(&path, None, library, &|input| input),
    }
}

/// Passes the messages of a bus to an observer, and its events to a function. Returns the reason why the connection
/// ended, if it ended early.
///
/// # Errors
/// Fails if the temporary file that is used to find the release can't be written or read.
pub(crate) fn observe(
    bus: &mut dyn Bus,
    library: &Library,
    options: &Options,
    observer: &mut dyn Observer,
    on_event: &dyn Fn(&Event),
) -> io::Result<Option<String>> {
    let (path, temporary) = recording(options)?;
    let mut chosen = None;
    let mut probe = Probe::new(bus, options, Recorder::create(&path, library.events())?, &|_| {}, on_event);
    // Without messages, nothing indicates the release.
    while probe.progress.messages == 0 && probe.cut_short.is_none() && probe.elapsed() < options.time {
        probe.listen(options.time.min(probe.elapsed() + START))?;
    }
    probe.recorder.flush()?;
    let definitions = &*chosen.insert(choose_for_recording(&path, library)?);
    probe.check(definitions, Some(observer))?;
    probe.recorder.discard();
    drop(temporary);
    probe.listen(options.time)?;
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

/// A running probe.
struct Probe<'p> {
    bus: &'p mut dyn Bus,
    options: &'p Options,
    recorder: Recorder<'p>,
    actors: Vec<Actor>,
    /// The endpoints that were discovered before the roles join, by id. `None` once no further role can join.
    endpoints: Option<BTreeMap<String, Endpoint>>,
    clock: Clock,
    started: Instant,
    subscribed: HashSet<Topic>,
    progress: Progress,
    on_progress: &'p dyn Fn(&Progress),
    on_event: &'p dyn Fn(&Event),
    /// True if the maximum number of topics has been reported.
    is_full: bool,
    notes: Vec<String>,
    /// The number of notes beyond the maximum.
    omitted: u64,
    cut_short: Option<String>,
}

impl<'p> Probe<'p> {
    fn new(
        bus: &'p mut dyn Bus,
        options: &'p Options,
        recorder: Recorder<'p>,
        on_progress: &'p dyn Fn(&Progress),
        on_event: &'p dyn Fn(&Event),
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
            on_event,
            is_full: false,
            notes: Vec::new(),
            omitted: 0,
            cut_short: None,
        }
    }

    fn elapsed(&self) -> Duration {
        self.clock.now() - self.started
    }

    /// Checks the records that were written before the release was chosen, and all later ones.
    fn check(
        &mut self,
        definitions: &'p Definitions,
        observer: Option<&'p mut dyn Observer>,
    ) -> io::Result<()> {
        let mut live = LiveBag::new(definitions, observer);
        let mut reader = Reader::new(File::open(&self.recorder.path)?);
        while let Some(item) = reader.next()? {
            // The file isn't complete yet. If it has an attachment, this is event metadata that the library contains as
            // well.
            if !matches!(item.event, McapEvent::Problem(_) | McapEvent::Attachment { .. }) {
                live.record(item.event);
            }
        }
        self.recorder.live = Some(live);
        Ok(())
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

    /// Announces the topics of a role. `known` contains the endpoints of others.
    fn join(&mut self, role: Box<dyn Role>, release: &Arc<Release>, known: &[Endpoint]) -> io::Result<()> {
        match Actor::join(self.bus, role, Arc::clone(release), None) {
            Ok((mut actor, endpoints)) => {
                actor.discover(known);
                self.actors.push(actor);
                endpoints.iter().try_for_each(|endpoint| self.recorder.record(endpoint))
            }
            Err(problem) => {
                self.cut_short = Some(problem);
                Ok(())
            }
        }
    }

    /// Records events until the release of the vehicle can be chosen. The roles then join, using this release.
    fn start(&mut self, library: &Library) -> io::Result<Arc<Definitions>> {
        self.listen(START.min(self.options.time))?;
        self.recorder.flush()?;
        let definitions = choose_for_recording(&self.recorder.path, library)?;
        self.join_all(&definitions, library)?;
        self.recorder.flush()?;
        Ok(definitions)
    }

    /// Ends the roles, and returns their last messages.
    fn withdraw(&mut self) -> io::Result<Vec<Event>> {
        let mut actors = std::mem::take(&mut self.actors);
        let last = actors.iter_mut().flat_map(|actor| actor.leave(self.bus)).collect();
        for actor in actors {
            let notes = actor.notes();
            actor.problems.into_iter().chain(notes).try_for_each(|note| self.note(note))?;
        }
        Ok(last)
    }

    /// Records events until this time after the start.
    fn listen(&mut self, until: Duration) -> io::Result<()> {
        let end = self.started + until;
        let mut shown = self.clock.now();
        while self.cut_short.is_none() && self.clock.now() < end {
            if (self.options.is_stopped)() {
                self.cut_short = Some("interrupted".to_owned());
            } else if self.recorder.size() > MAX_RECORDING {
                self.cut_short = Some(format!("the recording reached {} GiB", MAX_RECORDING >> 30));
            }
            let deadline = end.min(self.clock.now() + NOTICE_TIME);
            let Step { received, sent } = step(&mut self.actors, self.bus, deadline);
            for event in received.iter().chain(&sent) {
                self.record(event)?;
            }
            if let Some(event) = received {
                self.follow(event)?;
            }
            if self.clock.now() > shown + NOTICE_TIME {
                shown = self.clock.now();
                self.show();
            }
        }
        Ok(())
    }

    fn record(&mut self, event: &Event) -> io::Result<()> {
        (self.on_event)(event);
        self.recorder.record(event)
    }

    /// Subscribes to new topics, and notes problems.
    fn follow(&mut self, event: Event) -> io::Result<()> {
        match event {
            Event::Endpoint(endpoint) => {
                if let Some(known) = &mut self.endpoints
                    && (known.len() < MAX_ENDPOINTS || known.contains_key(&endpoint.id))
                {
                    known.insert(endpoint.id.clone(), endpoint.clone());
                }
                if endpoint.kind == EndpointKind::Publisher {
                    self.subscribe(endpoint)?;
                }
            }
            Event::Ended(id) => {
                if let Some(known) = &mut self.endpoints {
                    known.remove(&id);
                }
            }
            Event::Message(_) => self.progress.messages += 1,
            Event::Problem(problem) => self.note(problem)?,
            Event::Closed(reason) => self.cut_short = Some(reason),
            Event::Lost { .. } | Event::Unreadable(_) => {}
        }
        Ok(())
    }

    /// Subscribes to the topic of a publisher, if the user selected the topic. If the bus refuses the topic, this is
    /// recorded, so a later check of the recording reports it as well.
    fn subscribe(&mut self, publisher: Endpoint) -> io::Result<()> {
        let is_selected = self.options.topics.as_ref().is_none_or(|topics| topics.is_match(&publisher.topic));
        let topic = Topic {
            name: publisher.topic.into(),
            type_name: publisher.type_name.into(),
            type_hash: publisher.type_hash.map(Into::into),
        };
        if !is_selected || self.subscribed.contains(&topic) {
            return Ok(());
        }
        if self.subscribed.len() >= MAX_ENDPOINTS {
            if std::mem::replace(&mut self.is_full, true) {
                return Ok(());
            }
            let limit =
                format!("only the first {MAX_ENDPOINTS} topics are received: select fewer with --topics");
            return self.record(&Event::Unreadable(limit));
        }
        self.subscribed.insert(topic.clone());
        let name = topic.name.escape_debug();
        if !topic.name.starts_with('/') {
            // In DDS, such names belong to services and parameters.
            if publisher.is_matched_by_qos {
                return Ok(());
            }
            return self.note(format!("{name}: not checked, because the names of ROS topics start with `/`"));
        }
        self.progress.topics += 1;
        match self.bus.subscribe(&topic, &Qos::WEAKEST) {
            Ok(()) => Ok(()),
            Err(problem) => self.record(&Event::Unreadable(format!("{name}: {problem}"))),
        }
    }

    /// Writes a note to the recording, unless it has already been written.
    fn note(&mut self, text: String) -> io::Result<()> {
        if self.notes.contains(&text) {
            return Ok(());
        }
        if self.notes.len() >= MAX_NOTES {
            self.omitted += 1;
            return Ok(());
        }
        self.recorder.note(&text)?;
        self.notes.push(text);
        Ok(())
    }

    fn show(&mut self) {
        self.progress.elapsed = self.elapsed();
        self.progress.findings =
            self.recorder.live.as_ref().map_or(0, |live| live.findings().groups().count());
        (self.on_progress)(&self.progress);
    }
}
