//! Checks JSON messages, and detects Flockwave sessions.

mod clues;
mod envelope;

use std::collections::{BTreeSet, HashMap};
use std::io::Read;

use serde::Serialize;
use uavspec_capture::input::UpToError;
use uavspec_capture::json::{Event, Problem, Reader};
use uavspec_dynamic::DynamicView;
use uavspec_model::json::{SyntaxError, TRUNCATED, Tree};
use uavspec_model::limits::MAX_NAME;
use uavspec_model::text::{plural, shown, utf8};
use uavspec_model::{Channel, Extent, Location, Message};
use uavspec_px4::json::{Clean, Dialects, MessageOrigin, Plans, decode};
use uavspec_rules::definitions::Definitions;
use uavspec_rules::px4;
use uavspec_schema::MessageId;

pub(crate) use self::clues::Found;
use self::envelope::{Channels, Fast, Open, read};
pub(crate) use self::envelope::{Form, NameKind, Names, form};
use super::coverage::{PartResult, Parts, Share, Tally, Unit};
use super::flockwave::{FlockwaveChecker, is_flockwave};
use super::release::{ComparedTopic, ReleaseMatch, release_line, release_matches};
use super::run::Subscribers;
use super::summary::names;
use super::topic::{definition_of, definition_of_json, shows_type, topic_of};
use super::{CaptureResult, CheckRun, Describe, Kind, Line, Summary, Totals};
use crate::limits::MAX_CHANNELS;

/// The schema encoding that MCAP uses for ROS 2 types. rosbridge uses the same type names.
pub(crate) const ROS: &str = "ros2msg";

pub(super) const KIND: Kind = Kind {
    name: "JSON",
    detect: |start| !is_binary(&start[..start.len().min(MAX_START)]),
    choose: |source, library| library.choose(&clues::clues(source)),
    check: |input, message_id, run| check_with(input, message_id, JsonChecker::new(message_id, run)),
};

/// True if the start of a capture is neither JSON nor other text. One invalid character is accepted, since it may be
/// the result of corruption.
fn is_binary(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    if starts_like_json(start) {
        return false;
    }
    let is_foreign = |character: &char| {
        *character == char::REPLACEMENT_CHARACTER || character.is_control() && !character.is_whitespace()
    };
    text.chars().filter(is_foreign).count() > 1
}

/// The number of bytes that show whether a file is text.
const MAX_START: usize = 16;

/// True if the first character starts a JSON object or array.
pub(super) fn starts_like_json(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    text.trim_start_matches('\u{feff}').trim_start().starts_with(['{', '['])
}

/// True if a value starts like a JSON object. The first byte may be corrupt.
pub(crate) fn starts_like_object(bytes: &[u8]) -> bool {
    bytes.iter().take(2).any(|byte| *byte == b'{')
}

/// The summary of JSON messages.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
#[schemars(rename = "Json")]
pub struct JsonSummary {
    /// The number of lines.
    pub lines: u64,
    /// The number of message types.
    pub types: usize,
    /// The number of rosbridge messages other than `publish`.
    pub skipped: u64,
    /// The releases that the keys of the messages were compared with.
    pub releases: Vec<ReleaseMatch>,
    /// The topics or types without a definition, by name.
    #[schemars(with = "Vec<String>")]
    pub undefined: BTreeSet<String>,
    /// The accepted deviations from the published schemas.
    pub dialects: Dialects,
    /// True if a value starts like a JSON object.
    #[serde(skip)]
    pub has_objects: bool,
}

impl Describe for JsonSummary {
    fn facts(&self, totals: Totals) -> Vec<String> {
        let types = plural(self.types, "type");
        vec![plural(self.lines, "line"), format!("{} of {types}", totals.messages())]
    }

    fn lines(&self) -> Vec<Line> {
        let mut lines: Vec<Line> = self.releases.iter().map(release_line).collect();
        lines.extend(self.dialects.iter().map(|dialect| Line::new("dialect", dialect.to_string())));
        if self.skipped > 0 {
            let text = format!("{} other than `publish`", plural(self.skipped, "rosbridge message"));
            lines.push(Line::new("skipped", text));
        }
        if !self.undefined.is_empty() {
            let line = Line::new("not defined", names(self.undefined.iter().map(String::as_str)));
            lines.push(Line { details: self.undefined.iter().map(|name| shown(name)).collect(), ..line });
        }
        lines
    }
}

/// Checks JSON messages: JSON Lines, an array or a single message. If `message_id` is set, all messages have that type.
/// Otherwise, each message names its type or topic. Unreadable parts are skipped.
pub fn check_json(
    input: impl Read,
    message_id: Option<MessageId>,
    definitions: &Definitions,
) -> CaptureResult {
    check_with(input, message_id, JsonChecker::new(message_id, CheckRun::new(definitions)))
}

fn check_with(input: impl Read, message_id: Option<MessageId>, checker: JsonChecker<'_>) -> CaptureResult {
    let mut input = UpToError::new(input);
    let mut reader = Reader::new(&mut input);
    let mut checker = AnyChecker::Json { checker, is_decided: message_id.is_some() };
    while let Ok(Some(item)) = reader.next() {
        match item.event {
            // All values can be read.
            Event::Problem(problem @ Problem::ByteOrderMark) => checker.run().note(&problem.to_string()),
            Event::Problem(problem) => {
                let location = Location::Line(item.line);
                checker.run().corruption(location, problem.to_string(), problem.extent());
            }
            Event::Value { bytes, is_last, .. } => checker.value(bytes, item.line, is_last),
        }
    }
    let (lines, bytes) = (reader.lines(), reader.bytes());
    if let Some(error) = &input.error {
        // The findings up to here remain valid.
        checker.run().unreadable(Location::Line(lines.max(1)), error);
    }
    match checker {
        AnyChecker::Json { checker, .. } => checker.finish(lines, bytes),
        AnyChecker::Flockwave(checker) => checker.finish(bytes),
    }
}

/// The checker for the detected kind of capture.
#[allow(clippy::large_enum_variant)] // there is a single instance
enum AnyChecker<'d> {
    Json {
        checker: JsonChecker<'d>,
        /// True if the kind is final. The first object determines whether the capture is a Flockwave session.
        is_decided: bool,
    },
    Flockwave(FlockwaveChecker<'d>),
}

impl<'d> AnyChecker<'d> {
    fn run(&mut self) -> &mut CheckRun<'d> {
        match self {
            Self::Json { checker, .. } => &mut checker.run,
            Self::Flockwave(checker) => &mut checker.run,
        }
    }

    fn value(&mut self, bytes: &[u8], line: u64, is_last: bool) {
        self.decide(bytes);
        match self {
            Self::Json { checker, .. } => checker.value(bytes, line, is_last),
            Self::Flockwave(checker) => checker.line(bytes, line, is_last),
        }
    }

    /// Detects the kind of the capture from its first object.
    fn decide(&mut self, bytes: &[u8]) {
        let Self::Json { checker, is_decided } = self else { return };
        if *is_decided {
            return;
        }
        let tree = std::str::from_utf8(bytes).ok().and_then(|text| Tree::read(text).ok());
        let Some(tree) = tree.filter(|tree| matches!(tree, Tree::Object(_))) else { return };
        *is_decided = true;
        if is_flockwave(&tree) {
            let definitions = checker.run.definitions;
            let run = std::mem::replace(&mut checker.run, CheckRun::new(definitions));
            *self = Self::Flockwave(FlockwaveChecker::with_run(run));
        }
    }
}

struct JsonChecker<'d> {
    run: CheckRun<'d>,
    plans: Plans<'d>,
    channels: Channels,
    /// The topics with a stated type, each with the type's definition if it exists.
    advertised: HashMap<String, Option<MessageId>>,
    skipped: u64,
    has_objects: bool,
    dialects: Dialects,
    /// The field values of the current message, in memory layout.
    values: Vec<u8>,
}

impl<'d> JsonChecker<'d> {
    fn new(message_id: Option<MessageId>, run: CheckRun<'d>) -> Self {
        let definitions = run.definitions;
        let mut checker = Self {
            run,
            plans: Plans::new(&definitions.schema, definitions.types(), &px4::VALUES),
            channels: Channels::default(),
            advertised: HashMap::new(),
            skipped: 0,
            has_objects: false,
            dialects: Dialects::default(),
            values: Vec::new(),
        };
        checker.channels.only = message_id.and_then(|id| {
            let name = definitions.schema.message(id).name.clone();
            let at = checker.open(NameKind::Type, &name, Some(id), 1)?;
            checker.channels.open[at].key = None;
            Some(at)
        });
        checker
    }

    fn value(&mut self, bytes: &[u8], line: u64, is_last: bool) {
        self.has_objects |= starts_like_object(bytes);
        let location = Location::Line(line);
        let text = match utf8(bytes) {
            Ok(text) => text,
            Err(error) => return self.run.gap(location, error),
        };
        match read(text, &self.channels, &self.plans, &mut self.values) {
            Fast::Clean(at, _) if self.needs_tree(at) => self.explain(text, line, is_last),
            Fast::Clean(at, clean) => self.message(at, clean, location, None),
            Fast::Skipped => self.skipped += 1,
            Fast::Undefined(at) => self.undefined(at),
            Fast::Unclear => self.explain(text, line, is_last),
        }
    }

    /// Checks a value on the slow path, which creates the findings.
    fn explain(&mut self, text: &str, line: u64, is_last: bool) {
        let location = Location::Line(line);
        let tree = match Tree::read(text) {
            Ok(tree) => tree,
            Err(SyntaxError { problem: TRUNCATED, at }) if is_last => {
                let text = format!("the last value is truncated after {at} bytes");
                return self.run.corruption(location, text, Extent::EndsEarly);
            }
            Err(error) => return self.run.gap(location, error.to_string()),
        };
        let (which, name, message) = match self.channels.only {
            Some(at) => return self.check_message(at, &tree, location, false),
            None => match form(&tree) {
                Form::Message(which, name, message) => (which, name, message),
                Form::Advertised(topic, ty) => {
                    self.advertise(topic, ty);
                    return self.skipped += 1;
                }
                Form::Skipped => return self.skipped += 1,
                Form::Unknown(problem) => return self.run.gap(location, problem.to_owned()),
            },
        };
        if name.len() > MAX_NAME {
            let text = format!("the name of the topic or type is longer than {MAX_NAME} bytes");
            return self.run.gap(location, text);
        }
        if let Some(at) = self.channels.decided(which, name) {
            return self.check_message(at, message, location, which == NameKind::Topic);
        }
        let definitions = self.run.definitions;
        let definition = match which {
            NameKind::Type => definitions.message_of_type(name),
            NameKind::Topic => {
                let guessed = || definition_of_json(name, None, message, definitions);
                self.advertised.get(name).copied().unwrap_or_else(guessed)
            }
        };
        // An empty message doesn't indicate the type of its topic. A later message will.
        let is_decided = which == NameKind::Type || definition.is_some() || shows_type(message);
        if !is_decided && let Some(at) = self.channels.get(which, name) {
            return self.undefined(at);
        }
        let Some(at) = self.open(which, name, definition, line) else {
            return self.run.gap(location, format!("more than {MAX_CHANNELS} topics and types"));
        };
        self.channels.open[at].is_decided = is_decided;
        self.channels.open[at].has_keys = self.has_keys(at, message);
        // The channel is open now. If the first message has no findings, rules may need its values.
        if let Fast::Clean(at, clean) = read(text, &self.channels, &self.plans, &mut self.values)
            && !self.needs_tree(at)
        {
            return self.message(at, clean, location, None);
        }
        self.check_message(at, message, location, which == NameKind::Topic);
    }

    /// True if a message has the keys of its definition.
    fn has_keys(&self, at: usize, message: &Tree<'_>) -> bool {
        let (Some((id, _)), Tree::Object(members)) = (self.channels.open[at].defined, message) else {
            return false;
        };
        let fields = &self.run.definitions.schema.message(id).fields;
        let names: BTreeSet<&str> = fields.iter().map(|field| &*field.name).collect();
        names == members.iter().map(|(key, _)| &**key).collect()
    }

    /// True if the observer needs the values of a channel's messages, and their size varies. Only trees can represent
    /// such values.
    fn needs_tree(&self, at: usize) -> bool {
        let open = &self.channels.open[at];
        open.num_bytes == 0 && open.subscribers.observe_values()
    }

    /// Stores the stated type of a topic.
    fn advertise(&mut self, topic: &str, ty: &str) {
        if self.advertised.len() < MAX_CHANNELS && topic.len() <= MAX_NAME {
            let definition = definition_of(topic, Some((ty, ROS)), self.run.definitions);
            self.advertised.insert(topic.to_owned(), definition);
        }
    }

    /// Checks a message of an open channel.
    fn check_message(&mut self, at: usize, tree: &Tree<'_>, location: Location, is_rosbridge: bool) {
        let open = &self.channels.open[at];
        let Some((id, _)) = open.defined else { return self.undefined(at) };
        let origin =
            MessageOrigin { id, name: &open.full_name, location, key: open.key, is_rosbridge, shared: None };
        let dialects = self.plans.explain(origin, tree, &mut self.run.findings);
        let timestamp = self.plans.timestamp(id, tree);
        // A message with findings may have other wrong values, so its values aren't passed to stateful rules.
        self.values.clear();
        let decoded = if open.subscribers.observe_values() {
            decode(tree, self.run.definitions.types().get(id), is_rosbridge).ok()
        } else {
            None
        };
        let observed = decoded.as_ref().map(|(message, _)| message.view());
        self.message(at, Clean { timestamp, dialects }, location, observed);
    }

    /// Counts a message without a definition.
    fn undefined(&mut self, at: usize) {
        self.run.records += 1;
        self.channels.open[at].tally.records += 1;
    }

    /// Counts a message, and passes it on. `observed` are values that only the observer receives.
    fn message(&mut self, at: usize, clean: Clean, location: Location, observed: Option<DynamicView<'_>>) {
        self.run.records += 1;
        self.dialects.absorb(clean.dialects);
        let open = &mut self.channels.open[at];
        open.tally.records += 1;
        open.tally.count(open.defined.is_some(), clean.timestamp);
        let subscribers = open.subscribers;
        if let Some(channel) = open.channel() {
            let definitions = self.run.definitions;
            let view = |id| definitions.types().get(id).view_uorb(&self.values).ok();
            let values = channel.definition.filter(|_| !self.values.is_empty()).and_then(view);
            let message = Message { timestamp: clean.timestamp, logged: None, values, location };
            self.run.message(subscribers, &channel, &message, values.or(observed));
        }
    }

    /// Opens a new or undecided channel, unless there are too many channels.
    fn open(
        &mut self,
        which: NameKind,
        name: &str,
        definition: Option<MessageId>,
        line: u64,
    ) -> Option<usize> {
        if self.channels.open.len() >= MAX_CHANNELS && self.channels.get(which, name).is_none() {
            return None;
        }
        let defined = definition.map(|id| (id, self.run.number_channel()));
        let shown_name = match which {
            // The namespace in the name may show why the type is unknown.
            _ if definition.is_none() => name,
            NameKind::Type => name.rsplit('/').next().unwrap_or(name),
            NameKind::Topic => topic_of(name),
        };
        let shown_name = shown_name.escape_debug().to_string();
        let key = Some(which.key());
        let full_name = name.escape_debug().to_string();
        let mut open = Open {
            name: shown_name,
            full_name,
            defined,
            key,
            is_decided: false,
            has_keys: false,
            subscribers: Subscribers::default(),
            tally: Tally::default(),
            num_bytes: 0,
            line,
        };
        if let Some(channel) = open.channel() {
            let subscribers = self.run.opened(&channel);
            open.subscribers = subscribers;
            if subscribers.want_values() {
                let size = definition.and_then(|id| self.run.definitions.types().get(id).size());
                open.num_bytes = size.map_or(0, |size| size.padded);
            }
        }
        Some(self.channels.insert(which, name, open))
    }

    fn finish(mut self, lines: u64, bytes: u64) -> CaptureResult {
        let defined = self.channels.open.iter().filter(|open| open.defined.is_some());
        let compared = defined.map(|open| ComparedTopic {
            topic: &open.full_name,
            definition: open.defined.map(|(id, _)| id),
            is_equal: open.has_keys,
        });
        let releases = release_matches(self.run.definitions, &compared);
        let mut types = BTreeSet::new();
        let (mut undefined, mut parts) = (BTreeSet::new(), Parts::default());
        for open in self.channels.open {
            let tally = open.tally;
            self.run.include(tally.span());
            let (result, values) = match open.defined {
                Some((id, _)) => {
                    let fields = self.run.definitions.schema.message(id).fields.len() as u64;
                    let is_full = tally.checked == tally.records;
                    let result = if is_full { PartResult::Checked } else { PartResult::Keyless };
                    (result, Share::of(fields, fields))
                }
                None => (PartResult::Undefined, Share::default()),
            };
            parts.add(&open.full_name, result, tally, values.times(tally.checked, tally.records));
            match open.defined {
                Some((id, _)) => {
                    self.plans.count(id, None, tally.checked, &mut self.run.findings);
                    if tally.records > 0 {
                        types.insert(id);
                    }
                }
                None => _ = undefined.insert(open.full_name),
            }
        }
        let summary = JsonSummary {
            lines,
            types: types.len(),
            skipped: self.skipped,
            releases,
            undefined,
            dialects: self.dialects,
            has_objects: self.has_objects,
        };
        self.run.finish(bytes, Summary::Json(summary), Unit::Type, parts)
    }
}

impl Open {
    fn channel(&self) -> Option<Channel<'_>> {
        let (id, index) = self.defined?;
        let location = Location::Line(self.line);
        Some(Channel {
            index,
            topic: &self.name,
            full_topic: &self.full_name,
            multi_id: None,
            definition: Some(id),
            version: None,
            location,
        })
    }
}
