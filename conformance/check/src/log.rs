//! Checks PX4 logs.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::Read;
use std::sync::Arc;

use serde::Serialize;
use uavspec_capture::input::UpToError;
use uavspec_capture::ulog::{Event, Item, Log, LogProblem, Problem, Reader, Record};
use uavspec_capture::{ENCRYPTED_MAGIC, ULOG_MAGIC};
use uavspec_dynamic::{FormatProblem, MessageType};
use uavspec_model::text::{plural, shown, thousands};
use uavspec_model::{Channel, Detail, Extent, Location, Message, Rule, SubjectName};
use uavspec_px4::comparison::Comparison;
use uavspec_px4::memory::Plan;
use uavspec_rules::definitions::{Definitions, FormatPlan, Library};
use uavspec_rules::px4;
use uavspec_schema::MessageId;
use uavspec_schema::limits::MAX_EVENTS_LEN;

use super::coverage::{PartResult, Parts, Share, Tally, Unit};
use super::release::{ComparedTopic, ReleaseMatch, release_lines, release_matches};
use super::run::Subscribers;
use super::{CaptureResult, CheckRun, Describe, Kind, Line, Summary, Totals, has_magic};
use crate::limits::MAX_LOG_FIELDS;

pub(super) const KIND: Kind = Kind {
    name: "ULog",
    detect: |start| has_magic(start, &ULOG_MAGIC),
    choose: |source, library| match source.file.and_then(|path| File::open(path).ok()) {
        // Bytes that aren't read don't have to be kept for the check.
        Some(file) => choose(file, library),
        None => choose(&mut *source.bytes, library),
    },
    check: |input, _, run| check_log(input, run),
};

/// The kind for encrypted logs, which are detected but can't be read.
pub(super) const ENCRYPTED: Kind = Kind {
    name: "ULog",
    detect: |start| start.starts_with(&ENCRYPTED_MAGIC),
    choose: |_, library| Arc::clone(library.base()),
    check: |_, _, _| CaptureResult::unknown(ENCRYPTED_TEXT),
};

/// The reason why an encrypted log can't be read.
pub(super) const ENCRYPTED_TEXT: &str = "an encrypted PX4 log (.ulge): decrypt it with its key first; see \
                                         https://docs.px4.io/main/en/dev_log/log_encryption";

/// The summary of a log.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
#[schemars(rename = "Ulog")]
pub struct LogSummary {
    /// The name and version of the firmware.
    pub firmware: Option<String>,
    /// The number of dropouts.
    pub dropouts: u64,
    /// The releases that the formats were compared with.
    pub releases: Vec<ReleaseMatch>,
    /// The topics by name, each compared with its definition.
    pub formats: Vec<Format>,
}

/// The format of a topic, compared with its definition.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct Format {
    /// The topic.
    pub topic: String,
    /// The result of the comparison.
    pub result: FormatResult,
    /// The differences; empty if there are none.
    pub message: String,
}

/// The result of comparing a format with its definition.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum FormatResult {
    /// All fields have the same types and offsets.
    Equal,
    /// Something differs.
    Differs,
    /// There is no known definition for the format.
    Undefined,
}

impl Format {
    fn new(topic: String, comparison: &Comparison) -> Self {
        let (result, message) = match comparison {
            Comparison::Equal => (FormatResult::Equal, String::new()),
            Comparison::Undefined => (FormatResult::Undefined, String::new()),
            Comparison::Differs(differences) => (FormatResult::Differs, differences.to_string()),
        };
        Self { topic, result, message }
    }
}

impl Describe for LogSummary {
    fn facts(&self, totals: Totals) -> Vec<String> {
        vec![
            self.firmware.as_deref().map_or_else(|| "unknown firmware".to_owned(), shown),
            totals.duration(),
            plural(self.formats.len(), "topic"),
            plural(totals.records, "record"),
            plural(self.dropouts, "dropout"),
        ]
    }

    fn lines(&self) -> Vec<Line> {
        let with_result = |wanted| self.formats.iter().filter(move |format| format.result == wanted);
        let text = format!(
            "{} of {} topics match, {} differ, {} unknown",
            with_result(FormatResult::Equal).count(),
            self.formats.len(),
            with_result(FormatResult::Differs).count(),
            with_result(FormatResult::Undefined).count(),
        );
        let differing =
            with_result(FormatResult::Differs).map(|format| (format.topic.as_str(), shown(&format.message)));
        let definitions = Line::new("definitions", text).list("differs", differing);
        release_lines(&self.releases, definitions)
    }

    fn noun(&self) -> &'static str {
        "log"
    }
}

/// Chooses the definitions for a log from its content before the first data.
fn choose(input: impl Read, library: &Library) -> Arc<Definitions> {
    let (mut reader, mut log, mut version) = (Reader::new(input), library.log(), None);
    while let Ok(Some(item)) = reader.next() {
        match item.event {
            Event::Data { .. } => break,
            Event::Information { key: "ver_sw_release", value: [_, _, minor, major], .. } => {
                version = Some((*major, *minor));
            }
            _ => {}
        }
        log.take(&item, &mut |_, _| {});
    }
    library.choose_for_log(&log, version)
}

/// Checks the readable part of a PX4 log.
pub fn check_ulog(input: impl Read, definitions: &Definitions) -> CaptureResult {
    check_log(input, CheckRun::new(definitions))
}

fn check_log(input: impl Read, run: CheckRun<'_>) -> CaptureResult {
    let mut checker = LogChecker::new(run);
    let mut input = UpToError::new(input);
    let mut reader = Reader::new(&mut input);
    let mut log = Log::sharing(&checker.run.definitions.shared.formats);
    while let Ok(Some(item)) = reader.next() {
        if let Event::Data { id, .. } = item.event {
            checker.data(id, &item, &mut log);
            continue;
        }
        checker.item(&item);
        let topic = match item.event {
            Event::Subscription { id, .. } => Some(id),
            _ => None,
        };
        log.take(&item, &mut |offset, problem| checker.report_problem(offset, &problem));
        match topic.map(|id| (id, log.subscription(id))) {
            Some((id, Some(subscription))) => {
                checker.open(id, &subscription.topic, subscription.multi_id, item.offset);
            }
            // The subscription wasn't stored, because there was no room.
            Some((id, None)) => checker.drop_topic(id),
            None => {}
        }
    }
    let position = reader.position();
    if let Some(error) = &input.error {
        // The findings up to here remain valid.
        checker.run.unreadable(Location::Byte(position), error);
    }
    if checker.open.is_empty() && checker.run.extent == Extent::Whole {
        let text = "the log has no subscriptions: it ends within or directly after its definitions section"
            .to_owned();
        checker.run.corruption(Location::Byte(position), text, Extent::EndsEarly);
    }
    log.finish(&mut |offset, problem| checker.report_problem(offset, &problem));
    checker.finish(&log, position)
}

/// The event metadata of a log, in pieces.
#[derive(Default)]
pub(crate) struct Metadata {
    bytes: Vec<u8>,
    /// The location of the first piece.
    place: Option<Location>,
    /// The stated hash, in hexadecimal digits.
    digest: Option<Vec<u8>>,
}

impl Metadata {
    /// The key of the pieces.
    pub(crate) const KEY: &'static str = "metadata_events";

    /// The key of the SHA-256 hash of all pieces.
    const DIGEST: &'static str = "metadata_events_sha256";

    pub(crate) fn add(&mut self, piece: &[u8], location: Location) {
        self.place.get_or_insert(location);
        if self.bytes.len() <= MAX_EVENTS_LEN {
            self.bytes.extend_from_slice(piece);
        }
    }

    /// The event metadata in all pieces. Fails if it is too long.
    pub(crate) fn bytes(&self) -> Result<&[u8], String> {
        if self.bytes.len() > MAX_EVENTS_LEN {
            return Err(format!("it is longer than {} bytes", thousands(MAX_EVENTS_LEN)));
        }
        Ok(&self.bytes)
    }
}

/// A topic of the log, with its state.
struct Open {
    index: usize,
    topic: String,
    multi_id: u8,
    offset: u64,
    definition: Option<MessageId>,
    subscribers: Subscribers,
    /// Set when the first message arrives.
    format: Option<TopicFormat>,
    tally: Tally,
    /// The number of records whose values have no meaning, because the topic was never published.
    unpublished: u64,
}

/// The format of a topic with data. All instances of the topic share it.
#[derive(Clone)]
struct TopicFormat {
    /// The offset of the subscription.
    offset: u64,
    plan: Arc<FormatPlan>,
    /// The checks of the values. `None` if there is no data, or if there are too many fields.
    values: Option<Arc<Plan>>,
}

struct LogChecker<'d> {
    run: CheckRun<'d>,
    /// The topics by message id.
    open: Vec<Option<Box<Open>>>,
    /// The formats of the topics with data. A log may declare a format again after its data, so these are the formats that
    /// were valid when the data was read.
    formats: BTreeMap<String, TopicFormat>,
    /// The number of additional fields whose values can be checked.
    room: usize,
    /// The topics whose subscription has ended.
    parts: Parts,
    /// The topics that have instances other than the first.
    several: BTreeSet<String>,
    firmware: Option<String>,
    dropouts: u64,
    /// The log's event metadata. `None` after the definitions.
    metadata: Option<Metadata>,
    /// The location of the previous item, if the item is a record.
    latest: Option<Location>,
    /// True if the current item is a corrupt part.
    is_gap: bool,
    /// True if the previous item is a corrupt part.
    is_behind_gap: bool,
}

impl<'d> LogChecker<'d> {
    fn new(run: CheckRun<'d>) -> Self {
        Self {
            run,
            open: Vec::new(),
            formats: BTreeMap::new(),
            room: MAX_LOG_FIELDS,
            parts: Parts::default(),
            several: BTreeSet::new(),
            firmware: None,
            dropouts: 0,
            metadata: Some(Metadata::default()),
            latest: None,
            is_gap: false,
            is_behind_gap: false,
        }
    }

    fn item(&mut self, item: &Item<'_>) {
        let location = Location::Byte(item.offset);
        let is_gap = matches!(&item.event, Event::Problem(problem) if problem.extent() != Extent::Whole);
        self.is_behind_gap = std::mem::replace(&mut self.is_gap, is_gap);
        if let Some(record) = self.latest.take().filter(|_| is_gap) {
            // The corrupt part may begin within the previous record.
            self.run.findings.retract(record);
        }
        match &item.event {
            Event::Start { timestamp, .. } => self.run.started(*timestamp),
            Event::Unsubscription { id } => {
                if let Some(Some(open)) = self.open.get(usize::from(*id)) {
                    self.run.closed(&open.channel());
                }
            }
            Event::Information { key: "ver_sw_release" | "ver_sw_branch" | "sys_name", value, ty } => {
                self.information(ty, value);
            }
            Event::MultiInformation { key: Metadata::KEY, value, .. } => {
                if let Some(metadata) = &mut self.metadata {
                    metadata.add(value, location);
                }
            }
            Event::Information { key: Metadata::DIGEST, value, .. } => {
                if let Some(metadata) = &mut self.metadata {
                    metadata.digest = Some(value.to_vec());
                }
            }
            Event::Subscription { .. } => self.read_metadata(),
            Event::Logging { level, timestamp, text, .. } => {
                self.run.text(level.saturating_sub(b'0'), text, *timestamp);
            }
            Event::Dropout { milliseconds } => {
                self.dropouts += 1;
                self.run.dropout(*milliseconds, location);
            }
            // The message may have contained data of any topic.
            Event::Unknown { .. } => self.run.lost_any(location),
            // Version 0 of the log format has no flag bits.
            Event::Problem(Problem::NoFlagBits { version: 0 }) => {}
            Event::Problem(problem) if problem.is_harmless() => self.run.note(&problem.to_string()),
            Event::Problem(problem) => self.run.corruption(location, problem.to_string(), problem.extent()),
            _ => {}
        }
    }

    /// Reads the event metadata at the end of the definitions.
    fn read_metadata(&mut self) {
        let Some(metadata) = self.metadata.take() else { return };
        let Some(place) = metadata.place else { return };
        let problem = self.run.read_metadata(metadata.bytes(), metadata.digest.as_deref());
        match problem {
            // After a corrupt part, a piece may be missing.
            Some(text) if self.run.extent != Extent::Whole => self.run.note(&text),
            problem => {
                self.run.findings.cover(&px4::EVT_01.rule, 1);
                if let Some(text) = problem {
                    let detail = || Detail::new(text);
                    self.run.findings.report(&px4::EVT_01.rule, Metadata::KEY, place, None, detail);
                }
            }
        }
    }

    /// Checks data.
    fn data(&mut self, id: u16, item: &Item<'_>, log: &mut Log) {
        self.is_behind_gap = std::mem::take(&mut self.is_gap);
        self.latest = None;
        self.run.records += 1;
        if let Some(Some(open)) = self.open.get_mut(usize::from(id)) {
            open.tally.records += 1;
        }
        let record = log.take(item, &mut |offset, problem| self.report_problem(offset, &problem));
        if let Some(record) = record {
            self.record(id, &record, item.offset);
        }
    }

    fn open(&mut self, id: u16, topic: &str, multi_id: u8, offset: u64) {
        // Repeated subscriptions reuse the slot, so memory stays bounded.
        let slot = usize::from(id);
        if slot >= self.open.len() {
            self.open.resize_with(slot + 1, || None);
        }
        let before = self.open[slot].take();
        if let Some(before) = &before {
            self.run.closed(&before.channel());
        }
        if multi_id > 0 {
            self.several.insert(topic.to_owned());
        }
        let index = before.as_ref().map_or_else(|| self.run.number_channel(), |before| before.index);
        let mut open = Open {
            index,
            topic: topic.to_owned(),
            multi_id,
            offset,
            definition: self.run.definitions.message_of_logged_topic(topic),
            subscribers: Subscribers::default(),
            format: None,
            tally: Tally::default(),
            unpublished: 0,
        };
        open.subscribers = self.run.opened(&open.channel());
        self.open[slot] = Some(Box::new(open));
        if let Some(before) = before {
            before.close(&mut self.run, &mut self.parts);
        }
    }

    /// Closes the topic of an id whose new subscription wasn't stored, and clears the topic's name.
    fn drop_topic(&mut self, id: u16) {
        if let Some(Some(open)) = self.open.get_mut(usize::from(id)) {
            self.run.closed(&open.channel());
            open.topic = String::new();
        }
    }

    #[inline]
    fn record(&mut self, id: u16, record: &Record<'_>, offset: u64) {
        let Some(Some(open)) = self.open.get_mut(usize::from(id)) else { return };
        let location = Location::Byte(offset);
        let subject = SubjectName { name: &open.topic, instance: Some(open.multi_id) };
        let format = match &mut open.format {
            Some(format) => format,
            empty => {
                let format = self.formats.entry(open.topic.clone()).or_insert_with(|| {
                    let plan = self.run.definitions.plan(record.message_type, record.compiled);
                    check_timestamp(record.message_type, &plan, location, &mut self.run);
                    // Once a topic doesn't fit, the values of later topics aren't checked.
                    let rest = self.room.checked_sub(plan.all_fields.max(1));
                    self.room = rest.unwrap_or(0);
                    let values = rest.map(|_| plan.values(record.message_type, self.run.definitions));
                    TopicFormat { offset: open.offset, plan, values }
                });
                empty.insert(format.clone())
            }
        };
        let plan = &format.plan;
        let time_at = |offset: Option<usize>| {
            let bytes = record.payload.get(offset?..)?;
            Some(u64::from_le_bytes(*bytes.first_chunk()?))
        };
        let timestamp = time_at(plan.timestamp);
        // Older PX4 releases log topics that were never published. Their memory is empty, so no value has a meaning.
        let is_published = timestamp != Some(0) || record.payload.iter().any(|byte| *byte != 0);
        if let Some(values) = format.values.as_ref().filter(|_| is_published) {
            values.check(record.payload, subject, location, &mut self.run.findings);
        }
        self.latest = Some(location);
        if let Some((timestamp, utc)) = timestamp.zip(time_at(plan.utc)) {
            self.run.clock.set_utc(timestamp, utc);
        }
        open.tally.count(open.definition.is_some() && format.values.is_some(), self.run.logged(timestamp));
        open.unpublished += u64::from(!is_published);
        let view = || record.message_type.view_uorb(record.payload).ok();
        let values = open.subscribers.want_values().then(view).flatten();
        let message = Message { timestamp, logged: None, values: values.filter(|_| is_published), location };
        self.run.message(open.subscribers, &open.channel(), &message, values);
    }

    /// Reports a problem with a format, a subscription or a size. If a rule covers the problem, it is a violation of
    /// that rule, unless part of the log is missing. The missing part may have contained the format or subscription.
    fn report_problem(&mut self, offset: u64, problem: &LogProblem) {
        let location = Location::Byte(offset);
        self.latest = Some(location);
        let detail = Detail::new(problem.to_string());
        let is_whole = self.run.extent == Extent::Whole;
        match problem {
            // The corrupt part may include the size.
            LogProblem::DataSize { .. } if self.is_behind_gap => {
                self.run.corruption(location, problem.to_string(), Extent::WithGaps);
                self.run.lost_any(location);
            }
            LogProblem::DataSize { id, padded, no_padding, found } => {
                let expected = if padded == no_padding {
                    format!("{padded} bytes")
                } else {
                    format!("{padded} bytes, or {no_padding} without padding")
                };
                let detail = detail.expected(expected).actual(format!("{found} bytes"));
                self.drop_data(*id, &px4::DATA_01.rule, detail, location);
            }
            LogProblem::UnknownId { id } | LogProblem::Unsubscribed { id } if is_whole => {
                let detail = detail.expected("a subscribed id").actual(format!("id {id}"));
                self.drop_data(*id, &px4::DATA_02.rule, detail, location);
            }
            LogProblem::Format { name, problem: FormatProblem::UnknownType { ty, .. } } if is_whole => {
                let ty = ty.escape_debug();
                let detail = detail.expected(format!("a format `{ty}`")).actual("none");
                let definition = self.run.definition_of(name);
                self.run.findings.report(&px4::FMT_02.rule, name, location, definition, || detail);
            }
            LogProblem::MissingFormat { id } | LogProblem::UnusableFormat { id } => {
                match known(&self.open, *id).map(|open| open.subscribers) {
                    Some(subscribers) => {
                        self.run.corrupt_part(location, problem.to_string(), Extent::Whole);
                        self.run.lost(subscribers, location);
                    }
                    None => self.run.corruption(location, problem.to_string(), Extent::Whole),
                }
            }
            LogProblem::LateFormat { .. } | LogProblem::Resubscribed { .. } => {
                self.run.note(&problem.to_string());
            }
            _ => self.run.corruption(location, problem.to_string(), Extent::Whole),
        }
    }

    /// Handles data that violates a rule and can't be read. If the topic is unknown, the data may belong to any topic.
    fn drop_data(&mut self, id: u16, rule: &'static Rule, detail: Detail, location: Location) {
        let Some(open) = known(&self.open, id) else {
            self.run.findings.report(rule, &format!("id {id}"), location, None, || detail);
            return self.run.lost_any(location);
        };
        let definition = open.definition.map(|id| self.run.definitions.schema.message(id).span);
        self.run.findings.report(rule, open.channel().subject(), location, definition, || detail);
        self.run.lost(open.subscribers, location);
    }

    fn finish(mut self, log: &Log, bytes: u64) -> CaptureResult {
        for open in std::mem::take(&mut self.open).into_iter().flatten() {
            open.close(&mut self.run, &mut self.parts);
        }
        for rule in [&px4::DATA_01.rule, &px4::DATA_02.rule] {
            self.run.findings.cover(rule, self.run.records);
        }
        self.run.findings.hide_only_instances(|topic| !self.several.contains(topic));
        let formats = formats(log, self.formats, &mut self.run);
        // Records without a definition, or in a different format, aren't fully checked.
        for (topic, format) in &formats {
            self.parts.add_result(topic, (&format.plan.comparison).into());
        }
        let definitions = self.run.definitions;
        let topics = formats.iter().map(|(topic, format)| ComparedTopic {
            topic,
            definition: definitions.message_of_logged_topic(topic),
            is_equal: format.plan.comparison == Comparison::Equal,
        });
        let releases = release_matches(definitions, &topics);
        let formats = formats
            .iter()
            .map(|(topic, format)| Format::new(topic.clone(), &format.plan.comparison))
            .collect();
        let summary = LogSummary { firmware: self.firmware, dropouts: self.dropouts, releases, formats };
        self.run.finish(bytes, Summary::Log(summary), Unit::Topic, self.parts)
    }

    fn information(&mut self, ty: &str, value: &[u8]) {
        let text = match <[u8; 4]>::try_from(value) {
            // The version as a number: major, minor, patch and release type.
            Ok(bytes) if ty == "uint32_t" => {
                let [_, patch, minor, major] = bytes;
                format!("v{major}.{minor}.{patch}")
            }
            _ if ty.starts_with("char[") => String::from_utf8_lossy(value).into_owned(),
            _ => return,
        };
        self.firmware = Some(match self.firmware.take() {
            Some(known) => format!("{known} {text}"),
            None => text,
        });
    }
}

impl Open {
    fn channel(&self) -> Channel<'_> {
        Channel {
            index: self.index,
            topic: &self.topic,
            full_topic: &self.topic,
            multi_id: Some(self.multi_id),
            definition: self.definition,
            version: None,
            location: Location::Byte(self.offset),
        }
    }

    fn close(self, run: &mut CheckRun<'_>, parts: &mut Parts) {
        let Self { topic, tally, format, unpublished, .. } = self;
        let (mut result, mut fields) = (PartResult::Checked, Share::default());
        if let Some(TopicFormat { plan, values, .. }) = format {
            let (shared, all) = plan.fields;
            fields = Share::of(if values.is_some() { shared } else { 0 }, all);
            match values {
                Some(values) => values.count(tally.decoded - unpublished, &mut run.findings),
                None => result = PartResult::TooMany,
            }
        }
        run.include(tally.span());
        parts.add(&topic, result, tally, fields.times(tally.checked, tally.records));
    }
}

/// The topic of a message id. `None` if its subscription is unknown.
fn known(open: &[Option<Box<Open>>], id: u16) -> Option<&Open> {
    open.get(usize::from(id))?.as_deref().filter(|open| !open.topic.is_empty())
}

/// Checks that messages of a format have a timestamp.
fn check_timestamp(format: MessageType<'_>, plan: &FormatPlan, location: Location, run: &mut CheckRun<'_>) {
    run.findings.cover(&px4::FMT_03.rule, 1);
    if plan.timestamp.is_none() {
        let definition = run.definition_of(format.name());
        run.findings.report(&px4::FMT_03.rule, format.name(), location, definition, || {
            Detail::new("the format has no `uint64_t timestamp` field")
                .expected("uint64_t timestamp")
                .actual("no such field")
        });
    }
}

/// Reports the formats that differ from the definitions, and returns all formats of topics. `formats` contains the topics
/// with data. The formats of the other subscribed topics are compared here, and checked for a timestamp.
fn formats(
    log: &Log,
    mut formats: BTreeMap<String, TopicFormat>,
    run: &mut CheckRun<'_>,
) -> BTreeMap<String, TopicFormat> {
    let mut opened: BTreeMap<&str, u64> = BTreeMap::new();
    for subscription in log.subscriptions() {
        opened.entry(&subscription.topic).or_insert(subscription.offset);
    }
    // Without data, a format that the log declares in two ways isn't compared. Such a format has no fields.
    for (name, _) in log.formats().filter(|(_, fields)| fields.is_empty()) {
        opened.remove(name);
    }
    for format in log.types().iter() {
        run.findings.cover(&px4::FMT_02.rule, 1);
        // The fields of the format, or of a format that it contains, are unknown.
        if format.defect().is_some() {
            continue;
        }
        let Some(offset) = opened.get(format.name()).copied() else { continue };
        if let Entry::Vacant(new) = formats.entry(format.name().to_owned()) {
            let plan = run.definitions.plan(format, log.compiled());
            check_timestamp(format, &plan, Location::Byte(offset), run);
            new.insert(TopicFormat { offset, plan, values: None });
        }
    }
    for (topic, TopicFormat { offset, plan, .. }) in &formats {
        if plan.comparison != Comparison::Undefined {
            run.findings.cover(&px4::FMT_01.rule, 1);
        }
        if let Comparison::Differs(differences) = &plan.comparison {
            // The location doesn't depend on which instance has data first.
            let location = Location::Byte(*opened.get(topic.as_str()).unwrap_or(offset));
            let definition = run.definition_of(topic);
            run.findings.report(&px4::FMT_01.rule, topic, location, definition, || differences.detail());
        }
    }
    formats
}
