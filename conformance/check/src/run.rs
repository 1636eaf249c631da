//! The state of a check that all kinds of captures share.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::io;
use std::sync::Arc;

use uavspec_dynamic::DynamicView;
use uavspec_flockwave::record::{Connection, Direction, SessionRecord};
use uavspec_flockwave::session::{Exchange, Sessions, message_excerpt};
use uavspec_model::json::Tree;
use uavspec_model::text::{shown, thousands};
use uavspec_model::{ApplicationType, Channel, Endpoint, Extent, Findings, Location, Message, Rule};
use uavspec_px4::event::EventMetadata;
use uavspec_rules::definitions::Definitions;
use uavspec_rules::px4::Interest;
use uavspec_rules::{RuleContext, flockwave, px4};
use uavspec_schema::source::Span;

use super::coverage::Parts;
use super::flockwave::{Listeners, Report};
use super::timeline::{REPLY, contains_events, topic_name};
use super::{CaptureResult, Clock, Observer, Summary, Unit};
use crate::limits::{MAX_CORRUPT_PARTS, MAX_NOTES};

/// The state of a check that all kinds of captures share: channels, sessions, and the rules that span several messages.
pub(super) struct CheckRun<'d> {
    pub(super) definitions: &'d Definitions,
    pub(super) findings: Findings,
    /// The rules on sequences of messages.
    followers: Vec<Follower>,
    /// The checks of session rules.
    listeners: Listeners<'d>,
    /// Receives the records in addition to the rules.
    pub(super) observer: Option<&'d mut dyn Observer>,
    /// The number of channels.
    channels: usize,
    pub(super) sessions: Sessions,
    pub(super) records: u64,
    pub(super) checked: u64,
    /// The time at which logging began, in µs since boot, if the capture contains it.
    start: Option<u64>,
    first: Option<u64>,
    last: u64,
    /// The corrupt parts by description.
    corruption: HashMap<String, CorruptPart>,
    more_corruption: u64,
    notes: Vec<String>,
    cut_short: Vec<String>,
    pub(super) extent: Extent,
    pub(super) clock: Clock,
    /// The time of the current record in µs, if it differs from the timestamp of the message.
    record_time: Option<u64>,
    /// The log time and the sequence number of the current record, if it is in a bag.
    pub(super) logged: Option<Logged>,
    /// The metadata of the events.
    events: Arc<EventMetadata>,
    /// True if a message contained events.
    has_events: bool,
}

/// The log time and the sequence number of a message in a bag.
#[derive(Clone, Copy, Debug)]
pub(super) struct Logged {
    /// The time at which the message was recorded, in ns.
    pub(super) time: u64,
    /// The sequence number.
    pub(super) sequence: Option<u32>,
}

/// A corrupt part: its first location and the number of occurrences.
struct CorruptPart {
    number: usize,
    location: Location,
    times: u64,
}

/// A rule that checks a sequence of messages, with its state.
struct Follower {
    rule: &'static Rule,
    checker: Box<dyn px4::Checker>,
    coverage: u64,
}

/// The rules and the observer that receive the messages of a channel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Subscribers {
    /// The [`Follower`]s that receive the channel's messages: a bit for each index.
    followers: u64,
    /// The highest [`Interest`] among these followers and the observer.
    interest: Interest,
    /// The interest of the observer in the channel.
    observed: Interest,
    /// The timeline topic that the channel carries.
    topic: Option<&'static str>,
}

const _: () = assert!(px4::RULES.len() <= u64::BITS as usize, "each rule needs a bit");

impl Subscribers {
    /// True if a rule or the observer needs the field values of the messages.
    pub(super) fn want_values(self) -> bool {
        self.interest == Interest::Values
    }

    /// True if the observer needs the field values of the messages.
    pub(super) fn observe_values(self) -> bool {
        self.observed == Interest::Values
    }

    /// The indices of the followers.
    fn indices(self) -> impl Iterator<Item = usize> {
        let mut left = self.followers;
        std::iter::from_fn(move || {
            let index = left.trailing_zeros() as usize;
            left &= left.checked_sub(1)?;
            Some(index)
        })
    }
}

impl Follower {
    /// The checker, and the context that it needs.
    fn parts<'c>(
        &'c mut self,
        definitions: &'c Definitions,
        events: &'c EventMetadata,
        findings: &'c mut Findings,
    ) -> (&'c mut dyn px4::Checker, RuleContext<'c>) {
        let Self { rule, checker, coverage } = self;
        (&mut **checker, RuleContext { rule, definitions, events, findings, coverage })
    }
}

impl<'d> CheckRun<'d> {
    pub(super) fn new(definitions: &'d Definitions) -> Self {
        let followers = px4::RULES.iter().filter_map(|rule| match rule.check {
            px4::Check::State(start) => Some(Follower { rule: &rule.rule, checker: start(), coverage: 0 }),
            px4::Check::Value | px4::Check::Source => None,
        });
        Self {
            definitions,
            findings: Findings::default(),
            followers: followers.collect(),
            listeners: Listeners::new(definitions),
            observer: None,
            channels: 0,
            sessions: Sessions::default(),
            records: 0,
            checked: 0,
            start: None,
            first: None,
            last: 0,
            corruption: HashMap::new(),
            more_corruption: 0,
            notes: Vec::new(),
            cut_short: Vec::new(),
            extent: Extent::Whole,
            clock: Clock::default(),
            record_time: None,
            logged: None,
            events: Arc::clone(&definitions.events),
            has_events: false,
        }
    }

    /// Creates a run. If there is an observer, the run passes the records to it as well.
    pub(super) fn observed_by<'o: 'd>(
        definitions: &'d Definitions,
        observer: Option<&'d mut (dyn Observer + 'o)>,
    ) -> Self {
        let mut run = Self::new(definitions);
        if let Some(observer) = observer {
            observer.metadata(&run.events);
            run.observer = Some(observer);
        }
        run
    }

    /// Reserves the index of a new channel.
    pub(super) fn number_channel(&mut self) -> usize {
        self.channels += 1;
        self.channels - 1
    }

    /// Uses the event metadata of the capture, if it is valid. Returns the problem with the metadata, if any. `stated` is the
    /// SHA-256 hash in the capture, in hexadecimal digits.
    pub(super) fn read_metadata(
        &mut self,
        bytes: Result<&[u8], String>,
        stated: Option<&[u8]>,
    ) -> Option<String> {
        let read = bytes.and_then(|bytes| {
            let events = self.definitions.read_events(bytes);
            match stated.filter(|stated| !stated.eq_ignore_ascii_case(events.sha256.as_bytes())) {
                Some(stated) => Err(format!(
                    "its SHA-256 hash is {}, but the hash in the log is {}",
                    events.sha256,
                    shown(&String::from_utf8_lossy(stated))
                )),
                None => events.read.clone(),
            }
        });
        match read {
            Ok((metadata, mistake)) => {
                self.events = metadata;
                if let Some(observer) = &mut self.observer {
                    observer.metadata(&self.events);
                }
                mistake.map(|mistake| format!("the event metadata has mistakes: {mistake}"))
            }
            Err(problem) => Some(format!("the event metadata can't be used: {problem}")),
        }
    }

    /// Passes a line of text to the observer. `level` is a syslog level, from 0 to 7.
    pub(super) fn text(&mut self, level: u8, text: &str, time: u64) {
        if let Some(observer) = &mut self.observer {
            observer.text(level, text, time);
        }
    }

    pub(super) fn opened(&mut self, channel: &Channel<'_>) -> Subscribers {
        let topic = topic_name(channel, self.definitions);
        // Only the values of a reply show whether it contains events.
        let interest = if topic == Some(REPLY) { Interest::Values } else { Interest::Nothing };
        let mut subscribers = Subscribers { interest, topic, ..Subscribers::default() };
        for (at, follower) in self.followers.iter_mut().enumerate() {
            let (checker, mut context) = follower.parts(self.definitions, &self.events, &mut self.findings);
            let interest = checker.opened(channel, &mut context);
            if interest > Interest::Nothing {
                subscribers.followers |= 1 << at;
                subscribers.interest = subscribers.interest.max(interest);
            }
        }
        if let Some(observer) = &mut self.observer {
            subscribers.observed = observer.opened(channel, self.definitions);
            subscribers.interest = subscribers.interest.max(subscribers.observed);
        }
        subscribers
    }

    /// Handles an open channel whose messages aren't read, because their release is unknown.
    pub(super) fn undecided(&mut self, channel: &Channel<'_>) {
        if let Some(observer) = &mut self.observer {
            observer.undecided(channel, self.definitions);
        }
    }

    pub(super) fn closed(&mut self, channel: &Channel<'_>) {
        self.followers.iter_mut().for_each(|follower| follower.checker.closed(channel));
    }

    /// Passes the start time of the capture, in µs since boot, to the rules.
    pub(super) fn started(&mut self, time: u64) {
        self.clock.start(time);
        self.start = Some(time);
        self.followers.iter_mut().for_each(|follower| follower.checker.started(time));
    }

    /// Passes a message to the rules of its channel. The message's values have already been checked. `observed` are
    /// values that only the observer receives: rules receive no values of messages whose size varies, of JSON messages
    /// with findings, or of topics that were never published.
    pub(super) fn message(
        &mut self,
        subscribers: Subscribers,
        channel: &Channel<'_>,
        message: &Message<'_>,
        observed: Option<DynamicView<'_>>,
    ) {
        self.checked += 1;
        self.has_events |=
            subscribers.topic.is_some_and(|topic| contains_events(topic, observed.or(message.values)));
        for at in subscribers.indices() {
            let (checker, mut context) =
                self.followers[at].parts(self.definitions, &self.events, &mut self.findings);
            checker.message(channel, message, &mut context);
        }
        if let Some(observer) = &mut self.observer {
            let is_known = |time: &u64| *time > 0;
            let time = self.record_time.filter(is_known).or(message.timestamp.filter(is_known));
            let Message { timestamp, logged, location, .. } = *message;
            let message = Message { timestamp, logged, values: observed, location };
            observer.message(channel, &message, time, self.definitions);
        }
        self.place(message.location, message.timestamp);
    }

    /// Adds the location and the time to the findings in a message. `timestamp` is the timestamp of the message in µs.
    fn place(&mut self, location: Location, timestamp: Option<u64>) {
        let time = self.record_time.or(timestamp);
        let logged = self.logged;
        self.findings.complete(location, |detail| {
            detail.time = time;
            detail.log_time = logged.map(|logged| logged.time);
            detail.sequence = logged.and_then(|logged| logged.sequence);
        });
    }

    /// Sets the time of the current record, in µs since 1970, and extends the time span to include it. The timestamps
    /// of messages then don't count, because they may refer to another clock.
    pub(super) fn record_at(&mut self, time: u64) {
        self.record_time = Some(time);
        self.include([time]);
        self.clock.start(time);
        self.clock.set_utc(time, time);
    }

    /// Returns a timestamp in µs, if it is known and isn't older than the log. The first message of a topic may be
    /// older, because its publisher may have sent it before logging began.
    pub(super) fn logged(&self, timestamp: Option<u64>) -> Option<u64> {
        timestamp.filter(|timestamp| *timestamp > 0 && self.start.is_none_or(|start| *timestamp >= start))
    }

    /// Extends the time span to include times of records, in µs. A time of 0 is unknown.
    pub(super) fn include(&mut self, times: impl IntoIterator<Item = u64>) {
        for time in times.into_iter().filter(|time| *time > 0) {
            self.first = Some(self.first.map_or(time, |first| first.min(time)));
            self.last = self.last.max(time);
        }
    }

    /// Extends the time span to include a time in seconds.
    pub(super) fn include_time(&mut self, time: Option<f64>) {
        if let Some(time) = time.and_then(microseconds) {
            self.record_at(time);
        }
    }

    /// Passes a record of a session to the rules.
    pub(super) fn session_record(&mut self, record: &SessionRecord<'_>) {
        if let Some(observer) = &mut self.observer {
            observer.session_record(record, record.time.and_then(microseconds), self.definitions);
        }
        let exchange = self.sessions.follow(record, self.definitions.body_schemas());
        self.record(&exchange);
    }

    /// Like `session_record`, for a status report whose content has already been checked. The record needs no value.
    pub(super) fn checked_report(&mut self, record: &SessionRecord<'_>, report: &Report<'_>) {
        let mut exchange = Exchange::checked_notification(record, Report::TYPE, report.id);
        self.sessions.follow_checked(&mut exchange);
        self.listeners.checked_report(&exchange, &report.timestamps, &mut self.findings);
        self.complete(&exchange);
    }

    /// Handles the end of a connection. `why` is the reason, if known.
    pub(super) fn disconnected(&mut self, connection: Connection<'_>, why: Option<&str>) {
        let (serial, unanswered) = self.sessions.ended(connection.index);
        for request in unanswered {
            let record = SessionRecord {
                connection,
                direction: Direction::Event,
                time: None,
                text: "",
                value: None,
                trial: None,
                note: request.failure.as_deref().or(why),
                location: request.location,
            };
            self.record(&Exchange::unanswered(&record, serial, request.clone()));
        }
    }

    fn record(&mut self, exchange: &Exchange<'_>) {
        self.listeners.record(exchange, &mut self.findings);
        self.complete(exchange);
    }

    /// Adds the exchange to the findings that it caused.
    fn complete(&mut self, exchange: &Exchange<'_>) {
        let record = exchange.record;
        self.findings.complete(record.location, |detail| {
            let request = exchange.request.as_ref();
            let time = record.time.or_else(|| request.and_then(|request| request.time));
            detail.time = time.and_then(microseconds);
            record.connection.name.clone_into(&mut detail.connection);
            detail.only = flockwave::shown_by(exchange).unwrap_or_default();
            if detail.request.is_empty() {
                detail.request = request.map(|request| request.excerpt.clone()).unwrap_or_default();
            }
            // The record of a checked status report has no value, but its text is complete.
            let line = Tree::read(record.text).ok();
            let bare = line.as_ref().filter(|line| line.get("$fw.version").is_some());
            if let Some(message) = line.as_ref().and_then(|line| line.get("msg")).or(bare)
                && matches!(message, Tree::Object(_))
            {
                let path = if detail.path.is_empty() { "/body" } else { &detail.path };
                detail.excerpt = message_excerpt(message, path);
            } else if detail.excerpt.is_empty() {
                detail.excerpt = exchange.excerpt();
            }
        });
    }

    /// Passes a publisher or subscriber of a live vehicle to the rules.
    pub(super) fn endpoint(&mut self, endpoint: &Endpoint, location: Location) {
        for follower in &mut self.followers {
            let (checker, mut context) = follower.parts(self.definitions, &self.events, &mut self.findings);
            checker.endpoint(endpoint, location, &mut context);
        }
        self.place(location, None);
    }

    /// Passes the end of a publisher or subscriber to the rules.
    pub(super) fn endpoint_ended(&mut self, id: &str) {
        self.followers.iter_mut().for_each(|follower| follower.checker.endpoint_ended(id));
    }

    /// Passes a type that an application uses to the rules.
    pub(super) fn application(&mut self, ty: &ApplicationType) {
        self.followers.iter_mut().for_each(|follower| follower.checker.application(ty));
    }

    pub(super) fn dropout(&mut self, milliseconds: u16, location: Location) {
        self.followers.iter_mut().for_each(|follower| follower.checker.dropout(milliseconds, location));
    }

    /// Handles an unreadable message on a channel. Notifies stateful rules, which may depend on the message.
    pub(super) fn lost(&mut self, subscribers: Subscribers, location: Location) {
        self.place(location, None);
        for at in subscribers.indices() {
            self.followers[at].checker.corruption(location);
        }
    }

    /// Like `lost`, for a message of an unknown channel.
    pub(super) fn lost_any(&mut self, location: Location) {
        self.followers.iter_mut().for_each(|follower| follower.checker.corruption(location));
        self.listeners.corruption(location);
    }

    /// The location of a topic's definition, if there is one.
    pub(crate) fn definition_of(&self, topic: &str) -> Option<Span> {
        let id = self.definitions.message_of_logged_topic(topic)?;
        Some(self.definitions.schema.message(id).span)
    }

    /// Records an unreadable part that was skipped.
    pub(super) fn gap(&mut self, location: Location, text: String) {
        self.corruption(location, text, Extent::WithGaps);
    }

    /// Records a corrupt part, and the extent to which the capture is readable. The part may have contained messages of
    /// any channel.
    pub(super) fn corruption(&mut self, location: Location, text: String, extent: Extent) {
        self.lost_any(location);
        self.sessions.lose();
        self.corrupt_part(location, text, extent);
    }

    /// Records a corrupt part, and the extent to which the capture is readable.
    pub(super) fn corrupt_part(&mut self, location: Location, text: String, extent: Extent) {
        self.extent = self.extent.max(extent);
        let number = self.corruption.len();
        match self.corruption.entry(text) {
            Entry::Occupied(mut known) => known.get_mut().times += 1,
            // The reason for an early stop is always reported.
            Entry::Vacant(new) if number < MAX_CORRUPT_PARTS || extent == Extent::Unreadable => {
                _ = new.insert(CorruptPart { number, location, times: 1 });
            }
            Entry::Vacant(_) => self.more_corruption += 1,
        }
    }

    /// Adds a notable event of a live vehicle.
    pub(super) fn note(&mut self, text: &str) {
        add(&mut self.notes, text);
    }

    /// Adds a reason why the capture is incomplete although it can be read.
    pub(super) fn cut_short(&mut self, reason: &str) {
        add(&mut self.cut_short, reason);
    }

    /// Records a read error, after which nothing more can be read.
    pub(super) fn unreadable(&mut self, location: Location, error: &io::Error) {
        self.corruption(location, format!("the rest is unreadable: {error}"), Extent::Unreadable);
    }

    pub(super) fn finish(mut self, bytes: u64, summary: Summary, unit: Unit, parts: Parts) -> CaptureResult {
        for follower in &mut self.followers {
            let (checker, mut context) = follower.parts(self.definitions, &self.events, &mut self.findings);
            checker.end(&mut context);
            self.findings.cover(follower.rule, follower.coverage);
        }
        self.listeners.end(&mut self.findings);
        self.findings.close();
        let mut corruption: Vec<(String, CorruptPart)> = self.corruption.into_iter().collect();
        corruption.sort_by_key(|(_, reported)| reported.number);
        let reported = |(text, reported): (String, CorruptPart)| match reported.times {
            1 => (reported.location, text),
            times => (reported.location, format!("{text} ({} times)", thousands(times))),
        };
        CaptureResult {
            summary,
            bytes,
            duration: self.first.map_or(0, |first| self.last - first),
            end: self.last,
            records: self.records,
            checked: self.checked,
            corruption: corruption.into_iter().map(reported).collect(),
            more_corruption: self.more_corruption,
            notes: self.notes,
            cut_short: self.cut_short,
            extent: self.extent,
            clock: self.clock,
            coverage: parts.finish(unit, self.records),
            event_metadata: self.has_events.then(|| self.events.origin.to_string()),
            findings: self.findings,
        }
    }
}

/// Adds a text, unless it is already in the list or the list is full.
fn add(texts: &mut Vec<String>, text: &str) {
    let text = shown(text);
    if texts.len() < MAX_NOTES && !texts.contains(&text) {
        texts.push(text);
    }
}

/// A time in µs. `None` if it is negative.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // the cast saturates
pub(super) fn microseconds(seconds: f64) -> Option<u64> {
    (seconds >= 0.0).then_some((seconds * 1e6) as u64)
}
