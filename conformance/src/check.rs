//! Checks a capture: passes its records to the rules and to the check plans for the records' formats.
//!
//! ```
//! use uavspec_conformance::check::check_capture;
//! use uavspec_conformance::definitions::Definitions;
//!
//! let definitions = Definitions::built_in();
//! let message_id = definitions.message_of_type("px4/ArmingCheckRequest");
//! let record = r#"{"timestamp": 7, "request_id": 300, "valid_registrations_mask": 1}"#;
//! let result = check_capture(record.as_bytes(), message_id, &definitions)?;
//! assert_eq!((result.records, result.checked), (1, 1));
//! let group = result.findings.groups().next().unwrap();
//! assert_eq!((group.rule.id, group.subject.as_str()), ("PX-JSON-02", "ArmingCheckRequest.request_id"));
//! let (place, detail) = &group.examples[0];
//! assert_eq!((place.to_string(), detail.actual.as_str()), ("line 1".to_owned(), "300"));
//! # Ok::<(), std::io::Error>(())
//! ```

mod bag;
mod clock;
mod coverage;
mod flockwave;
mod json;
pub(crate) mod known;
mod log;
mod observer;
#[doc(hidden)]
pub mod parallel;
mod release;
mod summary;
mod topic;

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::io::{self, Read};
use std::path::Path;
use std::sync::Arc;

use serde::Serialize;
use uavspec_codegen::dynamic::{MessageType, Placed, PlacedElement};
use uavspec_codegen::schema::{MessageId, Shape};
use uavspec_codegen::source::Span;
use uavspec_runtime::Scalar;

#[cfg(test)]
pub(crate) use self::bag::check_mcap;
pub use self::bag::{BagChannel, BagSummary, Basis, CheckStatus, McapSummary};
pub use self::clock::Clock;
use self::coverage::Parts;
pub use self::coverage::{Coverage, Part, PartResult, Share, Unit};
#[doc(hidden)]
pub use self::flockwave::FlockwaveChecker;
use self::flockwave::Listeners;
pub use self::flockwave::{FlockwaveSummary, TypeCount};
pub use self::json::JsonSummary;
#[doc(hidden)]
pub use self::json::check_json_thoroughly;
pub use self::log::LogSummary;
pub(crate) use self::observer::Observer;
use self::release::Ahead;
pub use self::release::{OtherRelease, ReleaseMatch};
pub(crate) use self::summary::{Describe, Line, List, MAX_LISTED, Totals, names};
#[cfg(test)]
pub(crate) use self::{json::check_json, log::check_ulog};
use crate::capture::input;
use crate::capture::rosbag::{SQLITE_MAGIC, metadata};
use crate::definitions::{Clues, Definitions, Library};
use crate::flockwave::record::{Connection, Direction, SessionRecord};
use crate::flockwave::session::{Exchange, Sessions};
use crate::json::Tree;
use crate::model::{Channel, Extent, Findings, Location, Message, Rule};
use crate::rules::px4::Interest;
use crate::rules::{RuleContext, px4};
use crate::text::Grouped;

/// The number of bytes used to detect the kind of a capture.
const START: usize = SQLITE_MAGIC.len();

/// The number of bytes that messages about unknown files contain.
const SHOWN: usize = 8;

/// The minimum number of magic bytes by which a capture can be identified if it is cut off within its magic.
const MIN_MAGIC: usize = 4;

/// The maximum number of distinct corrupt parts to report.
const MAX_CORRUPT_PARTS: usize = 100;

/// A kind of capture.
struct Kind {
    /// The name of the format.
    name: &'static str,
    /// True if a capture of this kind can start with these bytes.
    detect: fn(&[u8]) -> bool,
    /// Finds the facts that show the release of a capture. Reads as much of the capture as necessary.
    clues: fn(&mut Source<'_>) -> Clues,
    /// Checks the readable part of a capture of this kind.
    check: fn(Source<'_>, Option<MessageId>, CheckRun<'_>) -> CaptureResult,
}

/// The bytes of a capture.
struct Source<'s> {
    bytes: &'s mut dyn Read,
    /// The file that consists of these bytes, if there is one. Some formats aren't read from start to end.
    file: Option<&'s Path>,
}

impl Read for Source<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        self.bytes.read(out)
    }
}

/// Wraps an input before it is read, for example to show the progress.
pub(crate) type Reading<'r> = &'r dyn Fn(Box<dyn Read + Send>) -> Box<dyn Read + Send>;

/// All kinds of captures, in the order of detection.
static KINDS: [Kind; 6] = [log::ENCRYPTED, log::KIND, bag::MCAP, bag::SQLITE, bag::ROS1, json::KIND];

/// The summary of a capture, with a variant for each kind.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Summary {
    /// A PX4 log.
    #[serde(rename = "ulog")]
    Log(LogSummary),
    /// JSON messages.
    Json(JsonSummary),
    /// An MCAP file.
    Mcap(McapSummary),
    /// A rosbag2 bag: a `SQLite` file, or a folder with `metadata.yaml`.
    #[serde(rename = "rosbag2")]
    Bag(BagSummary),
    /// A recorded Flockwave session. Only messages from the server are counted.
    Flockwave(FlockwaveSummary),
    /// A file that isn't a capture, or a capture that can't be read.
    Unknown(UnknownSummary),
}

/// The summary of a file of which nothing can be read.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema), schemars(rename = "Unknown"))]
pub struct UnknownSummary {
    /// The reason.
    pub reason: String,
}

impl Describe for UnknownSummary {
    fn facts(&self, _: Totals) -> Vec<String> {
        vec!["not a readable capture".to_owned()]
    }

    fn lines(&self) -> Vec<Line> {
        Vec::new()
    }
}

impl Summary {
    /// The releases that the capture was compared with.
    pub(crate) fn releases(&self) -> &[ReleaseMatch] {
        match self {
            Self::Log(summary) => &summary.releases,
            Self::Mcap(summary) => &summary.releases,
            Self::Bag(summary) => &summary.releases,
            Self::Json(_) | Self::Flockwave(_) | Self::Unknown(_) => &[],
        }
    }

    /// The parts of the summary that human-readable reports print.
    pub(crate) fn describe(&self) -> &dyn Describe {
        match self {
            Self::Log(summary) => summary,
            Self::Json(summary) => summary,
            Self::Mcap(summary) => summary,
            Self::Bag(summary) => summary,
            Self::Flockwave(summary) => summary,
            Self::Unknown(summary) => summary,
        }
    }
}

/// The result of checking a capture.
#[derive(Debug)]
pub struct CaptureResult {
    /// The summary of the capture.
    pub summary: Summary,
    /// The number of bytes read.
    pub bytes: u64,
    /// The time from the first to the last timestamp, in µs. In a PX4 log, timestamps before the start of logging don't
    /// count.
    pub duration: u64,
    /// The last of these timestamps; 0 if there are none.
    pub end: u64,
    /// The number of messages.
    pub records: u64,
    /// The number of checked messages. Messages are checked if their type is known and they can be decoded.
    pub checked: u64,
    /// The distinct corrupt parts in order of appearance, each with its first location.
    pub corruption: Vec<(Location, String)>,
    /// The number of additional corrupt parts that aren't listed.
    pub more_corruption: u64,
    /// The extent to which the capture could be read.
    pub extent: Extent,
    /// The clock of the times in the findings.
    pub clock: Clock,
    /// The topics or types, and the extent to which they were checked.
    pub coverage: Coverage,
    /// All violations.
    pub findings: Findings,
}

impl CaptureResult {
    /// The result for a file of which nothing can be read.
    pub(crate) fn unknown(reason: impl Into<String>) -> Self {
        Self {
            summary: Summary::Unknown(UnknownSummary { reason: reason.into() }),
            bytes: 0,
            duration: 0,
            end: 0,
            records: 0,
            checked: 0,
            corruption: Vec::new(),
            more_corruption: 0,
            extent: Extent::Unreadable,
            clock: Clock::default(),
            coverage: Parts::default().finish(Unit::default(), 0),
            findings: Findings::default(),
        }
    }
}

/// Checks a capture of any kind. The kind is detected from the first bytes. If `message_id` is set, JSON input
/// consists of bare messages of that type.
///
/// # Errors
/// Fails if the first bytes can't be read. Later problems, including an early end and an unknown kind, are part of the
/// result.
pub fn check_capture(
    mut input: impl Read,
    message_id: Option<MessageId>,
    definitions: &Definitions,
) -> io::Result<CaptureResult> {
    let source = Source { bytes: &mut input, file: None };
    let check =
        &mut |kind: &Kind, source: Source<'_>| (kind.check)(source, message_id, CheckRun::new(definitions));
    check_source(source, message_id, check)
}

/// Like [`check_capture`], and also passes the records to an observer.
#[cfg(any(fuzzing, test))]
pub(crate) fn observe_capture(
    mut input: impl Read,
    definitions: &Definitions,
    observer: &mut dyn Observer,
) -> io::Result<CaptureResult> {
    let source = Source { bytes: &mut input, file: None };
    let check = &mut |kind: &Kind, source: Source<'_>| {
        (kind.check)(source, None, CheckRun::observed_by(definitions, Some(observer)))
    };
    check_source(source, None, check)
}

/// The result of checking a capture, with the definitions against which it was checked.
pub(crate) struct Checked {
    pub(crate) result: CaptureResult,
    pub(crate) definitions: Arc<Definitions>,
}

/// Like [`check_capture`], for a file, a folder of a bag or standard input. The library chooses the definitions. Fails if
/// the path can't be opened.
pub(crate) fn check_path(
    path: &Path,
    message_id: Option<MessageId>,
    library: &Library,
    reading: Reading<'_>,
) -> io::Result<Checked> {
    check_path_with(path, message_id, library, None, reading)
}

/// Like [`check_path`], and also passes the records to an observer.
pub(crate) fn observe_path(
    path: &Path,
    library: &Library,
    observer: &mut dyn Observer,
    reading: Reading<'_>,
) -> io::Result<Checked> {
    check_path_with(path, None, library, Some(observer), reading)
}

fn check_path_with(
    path: &Path,
    message_id: Option<MessageId>,
    library: &Library,
    observer: Option<&mut dyn Observer>,
    reading: Reading<'_>,
) -> io::Result<Checked> {
    if let Some(folder) = metadata::folder_of(path) {
        let clues = if library.depends_on_capture() { bag::folder_clues(folder) } else { Clues::default() };
        let definitions = library.choose(&clues);
        let result = bag::check_folder(folder, CheckRun::observed_by(&definitions, observer), reading)?;
        return Ok(Checked { result, definitions });
    }
    let input = reading(input::open(path)?);
    let checked = input::decompressed(input).and_then(|(mut bytes, is_plain)| {
        let file = (is_plain && path.is_file()).then_some(path);
        check_with(Source { bytes: &mut bytes, file }, message_id, library, observer)
    });
    Ok(checked.unwrap_or_else(|error| {
        let result = CaptureResult::unknown(format!("the file can't be read: {error}"));
        Checked { result, definitions: Arc::clone(library.base()) }
    }))
}

/// Like [`check_capture`], with the definitions that the library chooses.
#[cfg(any(fuzzing, test))]
pub(crate) fn check_bytes(mut bytes: &[u8], library: &Library) -> io::Result<Checked> {
    check_with(Source { bytes: &mut bytes, file: None }, None, library, None)
}

/// Chooses the definitions of a capture from its start, and checks the readable part.
fn check_with(
    source: Source<'_>,
    message_id: Option<MessageId>,
    library: &Library,
    mut observer: Option<&mut dyn Observer>,
) -> io::Result<Checked> {
    let mut definitions = None;
    let result = check_source(source, message_id, &mut |kind, source| {
        let (mut start, mut clues) = (Vec::new(), Clues::default());
        if library.depends_on_capture() {
            let mut ahead = Ahead::new(source.bytes);
            clues = (kind.clues)(&mut Source { bytes: &mut ahead, file: source.file });
            start = ahead.bytes;
        }
        let chosen = definitions.insert(library.choose(&clues));
        let whole = &mut io::Cursor::new(start).chain(source.bytes);
        let run = CheckRun::observed_by(chosen, observer.as_deref_mut());
        (kind.check)(Source { bytes: whole, file: source.file }, message_id, run)
    })?;
    let definitions = definitions.unwrap_or_else(|| Arc::clone(library.base()));
    Ok(Checked { result, definitions })
}

/// Checks the readable part of a capture with `check`, which receives the kind and the whole capture.
fn check_source(
    mut input: Source<'_>,
    message_id: Option<MessageId>,
    check: &mut dyn FnMut(&Kind, Source<'_>) -> CaptureResult,
) -> io::Result<CaptureResult> {
    let mut start = Vec::new();
    input.by_ref().take(START as u64).read_to_end(&mut start)?;
    if start.is_empty() {
        return Ok(CaptureResult::unknown("the file is empty"));
    }
    let Some(kind) = KINDS.iter().find(|kind| (kind.detect)(&start)) else {
        return Ok(unknown_type(&start));
    };
    let source = Source { bytes: &mut io::Cursor::new(&start).chain(input.bytes), file: input.file };
    let result = check(kind, source);
    // Other text looks like corrupt JSON until the end.
    let is_text = matches!(&result.summary, Summary::Json(summary) if !summary.has_objects)
        && !json::starts_like_json(&start);
    Ok(if is_text && message_id.is_none() { unknown_type(&start) } else { result })
}

/// The result for a file of an unknown type that starts with these bytes.
fn unknown_type(start: &[u8]) -> CaptureResult {
    let start = &start[..start.len().min(SHOWN)];
    let mut names: Vec<&str> = KINDS.iter().map(|kind| kind.name).collect();
    names.dedup();
    let last = names.pop().unwrap_or_default();
    let is_text = start.iter().all(|byte| matches!(byte, b' '..=b'~' | b'\t' | b'\r' | b'\n'));
    let found = if is_text {
        format!("`{}`", start.escape_ascii())
    } else {
        let bytes: Vec<String> = start.iter().map(|byte| format!("{byte:02x}")).collect();
        format!("the bytes {}", bytes.join(" "))
    };
    CaptureResult::unknown(format!(
        "unknown file type: expected {} or {last}, found {found}",
        names.join(", ")
    ))
}

/// True if a capture starts with the magic, or ends within the magic after at least [`MIN_MAGIC`] bytes.
fn has_magic(start: &[u8], magic: &[u8]) -> bool {
    start.starts_with(magic) || start.len() >= MIN_MAGIC && magic.starts_with(start)
}

/// The part of a check that all kinds of captures share: channels, sessions, and the rules that span several messages.
struct CheckRun<'d> {
    definitions: &'d Definitions,
    findings: Findings,
    /// The rules on sequences of messages.
    followers: Vec<Follower>,
    /// The checks of session rules.
    listeners: Listeners<'d>,
    /// Receives the records in addition to the rules.
    observer: Option<&'d mut dyn Observer>,
    /// The subscribers of each channel, by channel index.
    channels: Vec<Subscribers>,
    sessions: Sessions,
    records: u64,
    checked: u64,
    /// The time at which logging began, in µs since boot, if the capture states it.
    start: Option<u64>,
    first: Option<u64>,
    last: u64,
    /// The corrupt parts by description.
    corruption: HashMap<String, CorruptPart>,
    more_corruption: u64,
    extent: Extent,
    clock: Clock,
    /// The time of the current record in µs, if it isn't the timestamp of the message.
    record_time: Option<u64>,
    /// The log time and the sequence number of the current record, if it is in a bag.
    logged: Option<Logged>,
}

/// The facts that a bag states about a message.
#[derive(Clone, Copy, Debug)]
struct Logged {
    /// The time at which the message was recorded, in ns.
    time: u64,
    /// The sequence number.
    sequence: Option<u32>,
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

/// The rules that check the messages of a channel.
#[derive(Default)]
struct Subscribers {
    /// The indices of the [`Follower`]s that receive the channel's messages.
    followers: Vec<usize>,
    /// The highest [`Interest`] among these followers.
    interest: Interest,
}

impl Follower {
    fn check<T>(
        &mut self,
        definitions: &Definitions,
        findings: &mut Findings,
        check: impl FnOnce(&mut dyn px4::Checker, &mut RuleContext<'_>) -> T,
    ) -> T {
        let Self { rule, checker, coverage } = self;
        check(&mut **checker, &mut RuleContext { rule, definitions, findings, coverage })
    }
}

impl<'d> CheckRun<'d> {
    fn new(definitions: &'d Definitions) -> Self {
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
            channels: Vec::new(),
            sessions: Sessions::default(),
            records: 0,
            checked: 0,
            start: None,
            first: None,
            last: 0,
            corruption: HashMap::new(),
            more_corruption: 0,
            extent: Extent::Whole,
            clock: Clock::default(),
            record_time: None,
            logged: None,
        }
    }

    /// Creates a run that passes the records to an observer as well, if there is one.
    fn observed_by<'o: 'd>(
        definitions: &'d Definitions,
        observer: Option<&'d mut (dyn Observer + 'o)>,
    ) -> Self {
        let mut run = Self::new(definitions);
        if let Some(observer) = observer {
            run.observer = Some(observer);
        }
        run
    }

    /// Reserves the index of a new channel.
    fn number_channel(&mut self) -> usize {
        self.channels.push(Subscribers::default());
        self.channels.len() - 1
    }

    fn opened(&mut self, channel: &Channel<'_>) {
        let mut subscribers = Subscribers::default();
        for (at, follower) in self.followers.iter_mut().enumerate() {
            let opened = |checker: &mut dyn px4::Checker, context: &mut RuleContext<'_>| {
                checker.opened(channel, context)
            };
            let interest = follower.check(self.definitions, &mut self.findings, opened);
            if interest > Interest::Nothing {
                subscribers.followers.push(at);
                subscribers.interest = subscribers.interest.max(interest);
            }
        }
        if let Some(observer) = &mut self.observer {
            subscribers.interest = subscribers.interest.max(observer.opened(channel, self.definitions));
        }
        self.channels[channel.index] = subscribers;
    }

    fn closed(&mut self, channel: &Channel<'_>) {
        self.followers.iter_mut().for_each(|follower| follower.checker.closed(channel));
    }

    /// Passes the capture's start time, in µs since boot, to the rules.
    fn started(&mut self, time: u64) {
        self.clock.start(time);
        self.start = Some(time);
        self.followers.iter_mut().for_each(|follower| follower.checker.started(time));
    }

    /// True if a rule needs the field values of a channel's messages.
    fn wants_values(&self, channel: usize) -> bool {
        self.channels[channel].interest == Interest::Values
    }

    /// Passes a message to the rules of its channel. The message's values have already been checked.
    fn message(&mut self, channel: &Channel<'_>, message: &Message<'_>) {
        self.checked += 1;
        // A log time of 0 is unknown.
        if self.record_time.unwrap_or_default() == 0 {
            self.include_timestamp(message.timestamp);
        }
        for at in &self.channels[channel.index].followers {
            let message = |checker: &mut dyn px4::Checker, context: &mut RuleContext<'_>| {
                checker.message(channel, message, context);
            };
            self.followers[*at].check(self.definitions, &mut self.findings, message);
        }
        if let Some(observer) = &mut self.observer {
            let is_known = |time: &u64| *time > 0;
            let time = self.record_time.filter(is_known).or(message.timestamp.filter(is_known));
            observer.message(channel, message, time, self.definitions);
        }
        self.place(message.location, message.timestamp);
    }

    /// Adds the time to the findings in a message. `timestamp` is the timestamp of the message in µs.
    fn place(&mut self, location: Location, timestamp: Option<u64>) {
        let time = self.record_time.or(timestamp);
        let logged = self.logged;
        self.findings.complete(location, |detail| {
            detail.time = time;
            detail.log_time = logged.map(|logged| logged.time);
            detail.sequence = logged.and_then(|logged| logged.sequence);
        });
    }

    /// Sets the time of the current record, in µs since 1970, and extends the time span to include it. The timestamps of
    /// messages don't count then, because they may have another clock.
    fn record_at(&mut self, time: u64) {
        self.record_time = Some(time);
        self.include_timestamp(Some(time));
        self.clock.start(time);
        self.clock.set_utc(time, time);
    }

    /// Extends the time span to include a timestamp in µs. The first message of a topic may be older than the log: its
    /// publisher sent it before logging began.
    fn include_timestamp(&mut self, timestamp: Option<u64>) {
        let is_logged =
            |timestamp: &u64| *timestamp > 0 && self.start.is_none_or(|start| *timestamp >= start);
        if let Some(timestamp) = timestamp.filter(is_logged) {
            self.first = Some(self.first.map_or(timestamp, |first| first.min(timestamp)));
            self.last = self.last.max(timestamp);
        }
    }

    /// Extends the time span to include a time in seconds.
    fn include_time(&mut self, time: Option<f64>) {
        if let Some(time) = time.and_then(microseconds) {
            self.record_at(time);
        }
    }

    /// Passes a record of a session to the rules.
    fn session_record(&mut self, record: &SessionRecord<'_>) {
        if let Some(observer) = &mut self.observer {
            observer.session_record(record, record.time.and_then(microseconds), self.definitions);
        }
        let exchange = self.sessions.follow(record, self.definitions.body_schemas());
        self.record(&exchange);
    }

    /// Like `session_record`, for a status report whose content has already been checked.
    fn checked_report(&mut self, record: &SessionRecord<'_>) {
        let exchange = self.sessions.follow_checked(record);
        self.listeners.checked_report(&exchange, &mut self.findings);
        self.complete(&exchange);
    }

    /// Handles the end of a connection. `why` is the reason, if known.
    fn disconnected(&mut self, connection: Connection<'_>, why: Option<&str>) {
        let (serial, unanswered) = self.sessions.ended(connection.index);
        for request in unanswered {
            let record = SessionRecord {
                connection,
                direction: Direction::Event,
                time: None,
                text: "",
                value: None,
                trial: None,
                note: why,
                location: request.location,
            };
            self.record(&Exchange::unanswered(&record, serial, request));
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
            detail.request = request.map(|request| request.excerpt.clone()).unwrap_or_default();
            // The value of a status report is reduced to some members, but the text is complete.
            let line = Tree::read(record.text).ok();
            let bare = line.as_ref().filter(|line| line.get("$fw.version").is_some());
            if let Some(message) = line.as_ref().and_then(|line| line.get("msg")).or(bare)
                && matches!(message, Tree::Object(_))
            {
                let path = if detail.path.is_empty() { "/body" } else { &detail.path };
                detail.excerpt = message.excerpt_at(path);
            }
        });
    }

    fn dropout(&mut self, milliseconds: u16, location: Location) {
        self.followers.iter_mut().for_each(|follower| follower.checker.dropout(milliseconds, location));
    }

    /// Handles an unreadable message on a channel. Stateful rules may depend on the message.
    fn lost(&mut self, channel: usize, location: Location) {
        self.place(location, None);
        for at in &self.channels[channel].followers {
            self.followers[*at].checker.corruption(location);
        }
    }

    /// Like `lost`, for a message of an unknown channel.
    fn lost_any(&mut self, location: Location) {
        self.followers.iter_mut().for_each(|follower| follower.checker.corruption(location));
        self.listeners.corruption(location);
    }

    /// The location of a topic's definition, if there is one.
    fn definition_of(&self, topic: &str) -> Option<Span> {
        let id = self.definitions.message_of_topic(topic)?;
        Some(self.definitions.schema.message(id).span)
    }

    /// Records an unreadable part that was skipped.
    fn gap(&mut self, location: Location, text: String) {
        self.corruption(location, text, Extent::WithGaps);
    }

    /// Records a corrupt part, and the extent to which the capture is readable.
    fn corruption(&mut self, location: Location, text: String, extent: Extent) {
        self.extent = self.extent.max(extent);
        self.lost_any(location);
        self.sessions.lose();
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

    /// Records a read error, after which nothing more can be read.
    fn unreadable(&mut self, location: Location, error: &io::Error) {
        self.corruption(location, format!("the rest is unreadable: {error}"), Extent::Unreadable);
    }

    fn finish(mut self, bytes: u64, summary: Summary, unit: Unit, parts: Parts) -> CaptureResult {
        for follower in &mut self.followers {
            follower.check(self.definitions, &mut self.findings, |checker, context| checker.end(context));
            self.findings.cover(follower.rule, follower.coverage);
        }
        self.listeners.end(&mut self.findings);
        self.findings.close();
        let mut corruption: Vec<(String, CorruptPart)> = self.corruption.into_iter().collect();
        corruption.sort_by_key(|(_, reported)| reported.number);
        let reported = |(text, reported): (String, CorruptPart)| match reported.times {
            1 => (reported.location, text),
            times => (reported.location, format!("{text} ({} times)", Grouped(times))),
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
            extent: self.extent,
            clock: self.clock,
            coverage: parts.finish(unit, self.records),
            findings: self.findings,
        }
    }
}

/// A time in µs. `None` if it is negative.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // the cast saturates
fn microseconds(seconds: f64) -> Option<u64> {
    (seconds >= 0.0).then_some((seconds * 1e6) as u64)
}

/// The offset of a field of type `uint64_t` in messages of a type, in bytes.
fn time_offset(message_id: MessageType<'_>, name: &str) -> Option<usize> {
    let is_time = |field: &Placed<'_>| {
        field.name == name
            && matches!(field.element, PlacedElement::Scalar(Scalar::UInt64))
            && field.shape == Shape::Single
    };
    message_id.layout().find(is_time).map(|field| field.offset)
}
