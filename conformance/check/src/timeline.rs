//! The timeline of a flight: the changes in a capture that explain what the vehicle did, and why.
//!
//! ```text
//!  check ──records──▶ Follower ──▶ lanes ──▶ Timeline ──report──▶ text, JSON, HTML
//!                        ▲
//!        definitions, translations
//! ```
//!
//! The topics of the timeline, and the kinds of lanes that they produce, are listed in `px4.rs` and `session.rs`. All
//! other texts come from the definitions.

mod context;
mod label;
mod lane;
mod px4;
mod session;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::sync::Arc;

use serde::Serialize;
use uavspec_capture::input::Input;
use uavspec_flockwave::record::SessionRecord;
use uavspec_model::{Channel, Extent, Message};
use uavspec_px4::event::EventMetadata;
use uavspec_rules::definitions::{Definitions, Library};
use uavspec_rules::px4::Interest;
use uavspec_schema::MessageId;

use self::context::Context;
pub use self::label::{Item, Label, Texts};
use self::lane::Lanes;
pub use self::lane::{Change, Lane, LaneKind, Part, Severity, Value};
pub use self::px4::{
    Flight, Overview, Refusal, Refused, SentEvent, flags, full_name, number, reasons_text, refused_modes,
    reply_events, reported_modes, required_flags, state_value, text, topic_name,
};
use self::px4::{Px4, TOPICS};
pub(crate) use self::px4::{REPLY, contains_events};
use self::session::{Session, TYPES};
use crate::{
    CaptureResult, Checked, Clock, Observer, Part as CheckedPart, PartResult, Reading, ReleaseMatch, Summary,
};

/// The version of the JSON format.
const VERSION: u32 = 1;

/// The timeline of a capture.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
pub struct Timeline {
    /// The version of this format. The version increases if a member is removed or changes meaning.
    pub version: u32,
    /// The version of uavspec.
    pub uavspec: String,
    /// The path of the capture.
    pub capture: String,
    /// The path of the definitions, the release, or the name of the built-in definitions.
    pub definitions: String,
    /// The event metadata that explains the events, if there are any.
    pub event_metadata: Option<String>,
    /// The releases that the capture agrees with.
    pub releases: Vec<ReleaseMatch>,
    /// The time of the start in UTC, if the capture states it.
    pub start_utc: Option<String>,
    /// The time from the start to the last message, in µs.
    pub duration_us: u64,
    /// The extent to which the capture is readable.
    pub extent: Extent,
    /// The corrupt parts of the capture.
    pub corruption: Vec<String>,
    /// The number of messages on topics of the timeline that can't be read.
    pub unreadable_messages: u64,
    /// The languages of the labels other than English, by tag.
    pub languages: BTreeMap<String, String>,
    /// The topics of the timeline, or the message types if the capture is a session.
    pub topics: Vec<Topic>,
    /// The summary for a pilot. `None` if the capture doesn't show the state of a single PX4 vehicle.
    pub overview: Option<Overview>,
    /// The lanes.
    pub lanes: Vec<Lane>,
    /// The number of values without a lane, because there are too many lanes.
    pub values_without_lane: u64,
    /// The first events that PX4 sent, in the order of the capture.
    #[serde(skip)]
    pub events: Vec<SentEvent>,
    /// The event metadata that explains them.
    #[serde(skip)]
    pub metadata: Arc<EventMetadata>,
    /// True if the times of a report are in UTC instead of relative to the start.
    #[serde(skip)]
    pub is_session: bool,
    #[serde(skip)]
    clock: Clock,
    #[serde(skip)]
    start: u64,
}

/// A topic of the timeline.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct Topic {
    /// The name of the topic or message type.
    pub name: String,
    /// The status.
    pub status: TopicStatus,
}

/// The status of a topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum TopicStatus {
    /// The topic is in the timeline.
    Explained,
    /// The topic is in the timeline, but its format differs from the definition. The meaning of values may differ too.
    Differs,
    /// The topic is in the capture, but has no definition.
    Undefined,
    /// The topic isn't in the capture.
    Absent,
}

impl Timeline {
    /// Checks a capture, and reads its timeline. The inner error is the reason why nothing can be read.
    ///
    /// Fails if the capture can't be opened.
    pub fn check(
        input: &Input,
        message_id: Option<MessageId>,
        library: &Library,
        texts: &Texts,
        reading: Reading<'_>,
    ) -> io::Result<(Checked, Result<Self, String>)> {
        let mut follower = Follower::new(texts);
        let checked = crate::check_input(input, message_id, library, Some(&mut follower), reading)?;
        let timeline = follower.finish(input.name(), &checked.result, &checked.definitions);
        Ok((checked, timeline))
    }

    /// Checks a capture. If `texts` are passed, also creates its timeline, if anything in the capture can be read.
    pub fn check_with(
        texts: Option<&Texts>,
        input: &Input,
        message_id: Option<MessageId>,
        library: &Library,
        reading: Reading<'_>,
    ) -> io::Result<(Checked, Option<Self>)> {
        let Some(texts) = texts else {
            return Ok((crate::check_input(input, message_id, library, None, reading)?, None));
        };
        let (checked, timeline) = Self::check(input, message_id, library, texts, reading)?;
        Ok((checked, timeline.ok()))
    }

    /// The timeline of bytes in memory.
    pub fn of_bytes(bytes: &[u8], definitions: &Definitions, texts: &Texts) -> Result<Self, String> {
        let mut follower = Follower::new(texts);
        let result = crate::observe_capture(bytes, definitions, &mut follower);
        let result = result.map_err(|error| error.to_string())?;
        follower.finish("capture".to_owned(), &result, definitions)
    }

    /// Converts a time since the start to UTC, as text. `None` if the capture doesn't state the time in UTC.
    pub fn utc(&self, time_us: i64) -> Option<String> {
        self.clock.utc(self.start.checked_add_signed(time_us)?)
    }

    /// Converts a time since the start to UTC, in µs since 1970. `None` if the capture doesn't state the time in UTC.
    pub fn utc_micros(&self, time_us: i64) -> Option<u64> {
        self.clock.utc_micros(self.start.checked_add_signed(time_us)?)
    }

    /// The names of the topics with a status.
    pub fn topics(&self, status: TopicStatus) -> impl Iterator<Item = &str> {
        self.topics.iter().filter(move |topic| topic.status == status).map(|topic| &*topic.name)
    }
}

/// Builds the lanes from the records of a capture.
struct Follower<'t> {
    texts: &'t Texts,
    metadata: Arc<EventMetadata>,
    lanes: Lanes,
    px4: Px4,
    session: Session,
    /// The names of the topics with readable messages.
    seen: BTreeSet<&'static str>,
    /// The time of the latest record. A record without a time takes the time of the previous record.
    latest: u64,
    unreadable: u64,
}

impl Observer for Follower<'_> {
    fn opened(&mut self, channel: &Channel<'_>, definitions: &Definitions) -> Interest {
        if self.px4.opened(channel, definitions) { Interest::Values } else { Interest::Nothing }
    }

    fn metadata(&mut self, metadata: &Arc<EventMetadata>) {
        self.metadata = Arc::clone(metadata);
    }

    fn message(
        &mut self,
        channel: &Channel<'_>,
        message: &Message<'_>,
        time: Option<u64>,
        definitions: &Definitions,
    ) {
        self.latest = time.unwrap_or(self.latest);
        let mut context = Context {
            definitions,
            texts: self.texts,
            metadata: &self.metadata,
            lanes: &mut self.lanes,
            time: self.latest,
        };
        match self.px4.message(channel, message, &mut context) {
            Some(Ok(topic)) => _ = self.seen.insert(topic),
            Some(Err(topic)) => {
                self.seen.insert(topic);
                self.unreadable += 1;
            }
            None => {}
        }
    }

    fn text(&mut self, level: u8, text: &str, time: u64) {
        px4::logged_text(level, text, time, &mut self.lanes);
    }

    fn session_record(&mut self, record: &SessionRecord<'_>, time: Option<u64>, definitions: &Definitions) {
        self.latest = time.unwrap_or(self.latest);
        let mut context = Context {
            definitions,
            texts: self.texts,
            metadata: &self.metadata,
            lanes: &mut self.lanes,
            time: self.latest,
        };
        self.seen.extend(self.session.record(record, &mut context));
    }
}

impl<'t> Follower<'t> {
    fn new(texts: &'t Texts) -> Self {
        Self {
            texts,
            metadata: Arc::default(),
            lanes: Lanes::default(),
            px4: Px4::default(),
            session: Session::default(),
            seen: BTreeSet::new(),
            latest: 0,
            unreadable: 0,
        }
    }

    fn finish(
        self,
        capture: String,
        result: &CaptureResult,
        definitions: &Definitions,
    ) -> Result<Timeline, String> {
        if let Summary::Unknown(unknown) = &result.summary {
            return Err(unknown.reason.clone());
        }
        let is_session = matches!(result.summary, Summary::Flockwave(_));
        let start = result.clock.start_time().unwrap_or(result.end.saturating_sub(result.duration));
        let end = result.end.max(self.latest);
        let corruption = result.corruption.iter();
        let corruption = corruption.map(|(location, text)| format!("{location}: {text}")).collect();
        let topics = self.topics(is_session, &result.coverage.parts);
        let values_without_lane = self.lanes.more;
        let mut lanes = self.lanes.finish(start, end);
        px4::remove_repeated_texts(&mut lanes);
        px4::hide_only_channels(&mut lanes);
        Ok(Timeline {
            version: VERSION,
            uavspec: env!("CARGO_PKG_VERSION").to_owned(),
            capture,
            definitions: definitions.name.clone(),
            event_metadata: result.event_metadata.clone(),
            releases: result.summary.releases().to_vec(),
            start_utc: result.clock.utc(start),
            duration_us: end.saturating_sub(start),
            extent: result.extent,
            corruption,
            unreadable_messages: self.unreadable,
            languages: self.texts.languages(),
            topics,
            values_without_lane,
            overview: self.px4.flights.finish(start),
            events: self.px4.events.finish(start, &lanes),
            metadata: self.metadata,
            lanes,
            is_session,
            clock: result.clock,
            start,
        })
    }

    /// The topics of the timeline with their statuses.
    fn topics(&self, is_session: bool, parts: &[CheckedPart]) -> Vec<Topic> {
        let names: Vec<&str> =
            if is_session { TYPES.to_vec() } else { TOPICS.iter().map(|topic| topic.name).collect() };
        let status = |name: &str| {
            let mut same = parts.iter().filter(|part| is_same_topic(&part.name, name));
            match same.find(|part| part.result != PartResult::Checked).map(|part| part.result) {
                Some(PartResult::Different) if self.seen.contains(name) => TopicStatus::Differs,
                _ if self.seen.contains(name) => TopicStatus::Explained,
                Some(PartResult::Undefined) => TopicStatus::Undefined,
                _ => TopicStatus::Absent,
            }
        };
        names.into_iter().map(|name| Topic { name: name.to_owned(), status: status(name) }).collect()
    }
}

/// True if a name in a capture denotes a topic. Examples of names: `/fmu/out/vehicle_status_v1`, or the type
/// `px4/VehicleStatus`.
fn is_same_topic(name: &str, topic: &str) -> bool {
    let last = name.rsplit('/').next().unwrap_or(name);
    let is_version = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    let last = last.rsplit_once("_v").filter(|(_, end)| is_version(end)).map_or(last, |(start, _)| start);
    let letters = |text: &str| text.replace('_', "").to_lowercase();
    letters(last) == letters(topic)
}
