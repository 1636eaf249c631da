//! The thread that reads messages and discovery from rustdds.

use std::collections::HashSet;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use rustdds::mio1::{Events, Interest, Poll, Token, Waker};
use rustdds::{
    DomainParticipant, DomainParticipantStatusEvent as Status, DomainParticipantStatusListener, RTPSEntity,
    StatusEvented,
};
use uavspec_model::clock::Clock;
use uavspec_model::net::open_files;
use uavspec_model::{Endpoint, EndpointKind, Qos};

use super::super::problems::Problems;
use super::super::queue::Sender;
use super::super::{Event, Topic};
use super::endpoints::{Endpoints, Found, limit, stores};
use super::memory::{self, Memory};
use super::partitions::Partitions;
use super::peers::Announcer;
use super::reader::Readers;
use super::source::Source;

const WAKE: Token = Token(0);
const STATUS: Token = Token(1);
const FIRST_SOURCE: usize = 2;

/// The period of announcements, and of comparisons with the tables of rustdds. The comparisons are needed because
/// rustdds drops events if there are many.
const PERIOD: Duration = Duration::from_secs(2);

/// The maximum number of discovery events that are handled in one turn.
const MAX_STATUS: usize = 4096;

/// The maximum number of topics that are subscribed in one turn. rustdds accepts 100 new subscribers at a time.
const MAX_NEW: usize = 32;

/// The time between turns while topics wait to be subscribed.
const PAUSE: Duration = Duration::from_millis(5);

/// The maximum number of subscribed topics.
const MAX_SOURCES: usize = 1_000;

/// The number of open files for each topic: two subscribers, each with two pairs of sockets.
const FILES_OF_A_SOURCE: u64 = 8;

/// The number of files that the process may open, if all topics are subscribed. Half of them are reserved for other
/// purposes.
pub(crate) const FILES: u64 = 2 * FILES_OF_A_SOURCE * MAX_SOURCES as u64;

/// The running thread. Dropping this value ends it.
pub(crate) struct Worker {
    commands: Option<mpsc::Sender<(Topic, Qos)>>,
    waker: Waker,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    pub(crate) fn start(
        participant: &DomainParticipant,
        announcer: Announcer,
        memory: Memory,
        events: Sender,
    ) -> Result<Self, String> {
        let readers = Readers::new(participant)?;
        let partitions = Partitions::new(&readers)?;
        let (commands, received) = mpsc::channel();
        let start = || -> io::Result<Self> {
            let poll = Poll::new()?;
            let waker = Waker::new(poll.registry(), WAKE)?;
            let mut status = participant.status_listener();
            poll.registry().register(&mut status, STATUS, Interest::READABLE)?;
            let state = State {
                endpoints: Endpoints::new(participant.guid(), partitions),
                memory,
                participant: participant.clone(),
                poll,
                status,
                announcer,
                commands: received,
                readers,
                sources: Vec::new(),
                max_sources: max_sources(),
                has_more_topics: false,
                events,
                problems: Problems::default(),
            };
            let thread = thread::Builder::new().name("dds".to_owned()).spawn(move || run(state))?;
            Ok(Self { commands: Some(commands), waker, thread: Some(thread) })
        };
        start().map_err(|error| format!("can't start a thread: {error}"))
    }

    /// Subscribes to a topic, unless it is already subscribed.
    pub(crate) fn subscribe(&self, topic: Topic, qos: Qos) -> Result<(), String> {
        let is_sent = self.commands.as_ref().is_some_and(|commands| commands.send((topic, qos)).is_ok());
        if !is_sent {
            return Err("the connection ended".to_owned());
        }
        self.waker.wake().map_err(|error| format!("can't subscribe: {error}"))
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        drop(self.commands.take());
        let _ = self.waker.wake();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// The number of topics for which the process can open enough files.
fn max_sources() -> usize {
    // Half of the files are reserved for other purposes.
    let sources = open_files().and_then(|files| usize::try_from(files / 2 / FILES_OF_A_SOURCE).ok());
    sources.map_or(MAX_SOURCES, |sources| sources.min(MAX_SOURCES))
}

/// Runs until the bus is dropped. A panic in rustdds ends the connection, but not the program.
fn run(mut state: State) {
    let result = catch_unwind(AssertUnwindSafe(|| state.work()));
    let reason = match result {
        Ok(Ok(())) => None,
        Ok(Err(reason)) => Some(reason),
        Err(_) => Some("rustdds panicked".to_owned()),
    };
    if let Some(reason) = reason {
        state.events.send(Event::Closed(reason));
    }
    let _ = catch_unwind(AssertUnwindSafe(|| drop(state)));
}

/// The state of the thread.
struct State {
    poll: Poll,
    status: DomainParticipantStatusListener,
    announcer: Announcer,
    commands: Receiver<(Topic, Qos)>,
    readers: Readers,
    sources: Vec<Source>,
    max_sources: usize,
    /// True if topics wait to be subscribed.
    has_more_topics: bool,
    endpoints: Endpoints,
    memory: Memory,
    participant: DomainParticipant,
    events: Sender,
    problems: Problems,
}

impl State {
    /// Works until the bus is dropped. The error is the reason why the connection ended.
    fn work(&mut self) -> Result<(), String> {
        let mut events = Events::with_capacity(256);
        let mut next = Clock::real().now();
        loop {
            self.wait(&mut events, next)?;
            self.memory.check()?;
            if !self.subscribe() {
                return Ok(());
            }
            self.read_status()?;
            if Clock::real().now() >= next {
                self.compare()?;
                next = Clock::real().now() + PERIOD;
            }
            self.read_messages();
        }
    }

    /// Waits for messages or discovery events.
    fn wait(&mut self, events: &mut Events, until: Instant) -> Result<(), String> {
        let timeout = if self.sources.iter().any(|source| source.has_more) {
            Duration::ZERO
        } else if self.has_more_topics {
            PAUSE
        } else {
            Clock::real().left(until).min(memory::INTERVAL)
        };
        match self.poll.poll(events, Some(timeout)) {
            Err(error) if error.kind() != io::ErrorKind::Interrupted => {
                return Err(format!("can't wait for messages: {error}"));
            }
            _ => {}
        }
        for event in &*events {
            let source = event.token().0.checked_sub(FIRST_SOURCE);
            if let Some(source) = source.and_then(|index| self.sources.get_mut(index)) {
                // The other end belongs to a thread of rustdds.
                if event.is_read_closed() {
                    return Err("rustdds stopped receiving messages".to_owned());
                }
                source.notice();
            }
        }
        Ok(())
    }

    /// Subscribes to new topics. Returns false if the bus has been dropped.
    fn subscribe(&mut self) -> bool {
        self.has_more_topics = true;
        for _ in 0..MAX_NEW {
            match self.commands.try_recv() {
                Ok((topic, qos)) => self.add_source(topic, &qos),
                Err(TryRecvError::Empty) => {
                    self.has_more_topics = false;
                    break;
                }
                Err(TryRecvError::Disconnected) => return false,
            }
        }
        true
    }

    fn add_source(&mut self, topic: Topic, qos: &Qos) {
        let name = topic.name.escape_debug().to_string();
        if let Some(source) = self.sources.iter().find(|source| source.topic.name == topic.name) {
            let (first, second) = (source.topic.type_name.escape_debug(), topic.type_name.escape_debug());
            if source.topic.type_name != topic.type_name {
                self.unreadable(format!(
                    "{name}: messages of type {second} may be missing: the topic has two types, and {first} was \
                     subscribed first"
                ));
            }
            return;
        }
        if self.sources.len() >= self.max_sources {
            let count = self.max_sources;
            self.unreadable(format!(
                "only the first {count} topics are received: each needs open files (`ulimit -n`)"
            ));
            return;
        }
        let has_stored = self.endpoints.stores(&topic.name, &topic.type_name);
        let token = Token(FIRST_SOURCE + self.sources.len());
        match Source::create(topic, qos, &self.readers, self.poll.registry(), token) {
            Ok(source) => self.sources.push(source),
            Err(error) => return self.unreadable(format!("{name}: {error}")),
        }
        if has_stored {
            self.request_stored(self.sources.len() - 1);
        }
    }

    fn request_stored(&mut self, index: usize) {
        let source = &mut self.sources[index];
        if let Err(error) = source.request_stored(&self.readers, self.poll.registry()) {
            let problem = format!("{}: no stored messages: {error}", source.topic.name.escape_debug());
            self.unreadable(problem);
        }
    }

    fn read_messages(&mut self) {
        let mut problems = Vec::new();
        for source in self.sources.iter_mut().filter(|source| source.has_more) {
            problems.extend(source.read(&self.endpoints, &self.events).err());
        }
        for problem in problems {
            self.unreadable(problem);
        }
    }

    /// Reports a remark, unless it has already been reported.
    fn problem(&mut self, text: String) {
        if let Some(event) = self.problems.remark(text) {
            self.events.send(event);
        }
    }

    /// Reports data that isn't received or can't be read, unless it has already been reported.
    fn unreadable(&mut self, text: String) {
        if let Some(event) = self.problems.unreadable(text) {
            self.events.send(event);
        }
    }

    fn read_status(&mut self) -> Result<(), String> {
        let mut events = Vec::new();
        let mut result = Ok(());
        for _ in 0..MAX_STATUS {
            let Some(status) = self.status.try_recv_status() else { break };
            result = self.apply(status, &mut events);
            if result.is_err() {
                break;
            }
        }
        self.report(events);
        result
    }

    fn apply(&mut self, status: Status, events: &mut Vec<Event>) -> Result<(), String> {
        let known = &mut self.endpoints;
        match status {
            Status::WriterDetected { writer } => {
                known.add(&Found::described(EndpointKind::Publisher, &writer), events)?;
            }
            Status::ReaderDetected { reader } => {
                known.add(&Found::described(EndpointKind::Subscriber, &reader), events)?;
            }
            Status::WriterLost { guid, .. } | Status::ReaderLost { guid, .. } => known.remove(guid, events),
            Status::ParticipantLost { id, .. } => {
                let mut prefix = [0; 12];
                prefix.copy_from_slice(id.as_ref());
                known.remove_participant(prefix, events);
            }
            Status::ParticipantDiscovered { dpd } => {
                known.add_participant(dpd.guid, dpd.entity_name.as_deref(), events)?;
            }
            _ => {}
        }
        Ok(())
    }

    /// Announces this participant, and compares the known endpoints with the tables of rustdds.
    fn compare(&mut self) -> Result<(), String> {
        self.announcer.announce();
        let is_alive = self.participant.assert_liveliness().is_ok();
        is_alive.then_some(()).ok_or("the discovery of rustdds ended")?;
        limit(self.participant.discovered_topics().len(), "topics")?;
        let writers = self.participant.discovered_writers();
        let readers = self.participant.discovered_readers();
        limit(writers.len() + readers.len(), "endpoints")?;
        self.endpoints.read_partitions();
        let (mut events, mut present) = (Vec::new(), HashSet::new());
        for found in writers.iter().map(Found::writer).chain(readers.iter().map(Found::reader)) {
            present.insert(found.guid);
            self.endpoints.add(&found, &mut events)?;
        }
        self.endpoints.remove_all(|guid| !present.contains(&guid), &mut events);
        self.report(events);
        for source in &mut self.sources {
            source.report_missing(&self.events);
            source.has_more = true;
        }
        Ok(())
    }

    fn report(&mut self, events: Vec<Event>) {
        for event in events {
            match event {
                Event::Problem(text) => self.problem(text),
                event => {
                    if let Event::Endpoint(endpoint) = &event {
                        if stores(endpoint) {
                            self.follow(endpoint);
                        }
                        self.problems_of(endpoint);
                    }
                    self.events.send(event);
                }
            }
        }
    }

    /// Reports why this program doesn't receive the messages of a publisher, if so. Our subscribers are in the default
    /// partition, whose name is empty. A partition may be a pattern.
    fn problems_of(&mut self, endpoint: &Endpoint) {
        let partitions = endpoint.qos.as_ref().map_or(&[][..], |qos| &qos.partitions);
        let is_received = partitions.is_empty() || partitions.iter().any(|name| matches!(&**name, "" | "*"));
        if endpoint.kind == EndpointKind::Publisher && endpoint.topic.starts_with('/') && !is_received {
            let (topic, names) = (endpoint.topic.escape_debug(), partitions.join(", "));
            self.problem(format!(
                "{topic}: the messages of a publisher in partition {} aren't received",
                names.escape_debug()
            ));
        }
    }

    /// Requests the messages that a new publisher stores.
    fn follow(&mut self, publisher: &Endpoint) {
        let is_match =
            |topic: &Topic| *topic.name == *publisher.topic && *topic.type_name == *publisher.type_name;
        if let Some(index) = self.sources.iter().position(|source| is_match(&source.topic)) {
            self.request_stored(index);
        }
    }
}
