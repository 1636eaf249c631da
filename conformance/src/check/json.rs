//! Checks messages as JSON, and tells sessions of Flockwave from them.

mod envelope;
mod templates;

use std::collections::{BTreeSet, HashMap};
use std::io::Read;

use serde::Serialize;
use uavspec_codegen::emit::docs::markdown::plural;
use uavspec_codegen::schema::MessageId;

use self::envelope::{Channels, Fast, Form, Open, Which, form, read};
use self::templates::Templates;
use super::flockwave::{FlockwaveJudge, is_flockwave};
use super::summary::names;
use super::topic::{definition_of, topic_of};
use super::{CaptureResult, Course, Describe, Kind, Line, Summary, Totals};
use crate::capture::json::{Event, Reader};
use crate::definitions::Definitions;
use crate::json::{CUT_OFF, SyntaxError, Tree};
use crate::model::{Channel, Extent, Message, Place};
use crate::px4::json::{Clean, Dialects, Plans, Told};
use crate::rules::px4;
use crate::text::{Grouped, shown};

/// How many topics or types are told apart: hostile input can have any number.
const MAX_CHANNELS: usize = 10_000;

/// The longest name of a topic or type that is kept; ROS 2 allows no longer ones either.
const MAX_NAME: usize = 256;

/// What MCAP calls types of ROS 2, as rosbridge names them.
const ROS: &str = "ros2msg";

pub(super) const KIND: Kind = Kind {
    name: "JSON",
    detect: |start| !is_binary(start),
    check: |input, of, definitions| Ok(check_json(input, of, definitions)),
};

/// True if a capture starts neither like JSON nor like any text. One wrong byte may be damage.
fn is_binary(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    if text.trim_start_matches('\u{feff}').trim_start().starts_with(['{', '[']) {
        return false;
    }
    let is_foreign = |character: &char| {
        *character == char::REPLACEMENT_CHARACTER || character.is_control() && !character.is_whitespace()
    };
    text.chars().filter(is_foreign).count() > 1
}

/// The summary of messages as JSON.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema), schemars(rename = "Json"))]
pub struct JsonSummary {
    /// The number of lines.
    pub lines: u64,
    /// The number of types that its messages have.
    pub types: usize,
    /// The number of rosbridge messages that don't publish anything.
    pub skipped: u64,
    /// The topics or types without a definition, by name.
    #[cfg_attr(test, schemars(with = "Vec<String>"))]
    pub undefined: BTreeSet<String>,
    /// The ways in which it differs from the published schemas that are accepted.
    pub dialects: Dialects,
}

impl Describe for JsonSummary {
    fn facts(&self, totals: Totals) -> Vec<String> {
        let types = plural(self.types as u64, "type");
        vec![plural(self.lines, "line"), format!("{} of {types}", totals.messages())]
    }

    fn lines(&self) -> Vec<Line> {
        let mut lines: Vec<Line> =
            self.dialects.iter().map(|dialect| Line::new("dialect", dialect.to_string())).collect();
        if self.skipped > 0 {
            let text = format!("{} that publish nothing (rosbridge)", Grouped(self.skipped));
            lines.push(Line::new("skipped", text));
        }
        if !self.undefined.is_empty() {
            let line = Line::new("not defined", names(self.undefined.iter().map(String::as_str)));
            lines.push(Line { details: self.undefined.iter().map(|name| shown(name)).collect(), ..line });
        }
        lines
    }
}

/// Checks messages as JSON: JSON Lines, an array, or a single one. They are all of one type where `of` says so;
/// otherwise each says its type or its topic. They are checked as far as they can be read.
pub(crate) fn check_json(
    input: impl Read,
    of: Option<MessageId>,
    definitions: &Definitions,
) -> CaptureResult {
    check_with(input, of, JsonJudge::new(of, definitions))
}

/// Like `check_json`, but compares no message with those before it. It is several times slower and has the same result:
/// tests and benchmarks hold the two to each other.
pub fn check_json_thoroughly(
    input: impl Read,
    of: Option<MessageId>,
    definitions: &Definitions,
) -> CaptureResult {
    check_with(input, of, JsonJudge { templates: Templates::none(), ..JsonJudge::new(of, definitions) })
}

fn check_with(input: impl Read, of: Option<MessageId>, judge: JsonJudge<'_>) -> CaptureResult {
    let mut reader = Reader::new(input);
    let mut judge = Judge::Json { judge, is_decided: of.is_some() };
    loop {
        match reader.next() {
            Ok(Some(item)) => match item.event {
                Event::Problem(problem) => {
                    judge.course().damage(Place::Line(item.line), problem.to_string(), problem.extent());
                }
                Event::Value { bytes, is_last } => judge.value(bytes, item.line, is_last),
            },
            Ok(None) => break,
            // What was judged until then stays judged.
            Err(error) => {
                judge.course().unreadable(Place::Line(reader.lines().max(1)), &error);
                break;
            }
        }
    }
    match judge {
        Judge::Json { judge, .. } => judge.finish(reader.lines(), reader.bytes()),
        Judge::Flockwave(judge) => judge.finish(reader.bytes()),
    }
}

/// Who judges.
#[allow(clippy::large_enum_variant)] // there is one of it
enum Judge<'d> {
    Json {
        judge: JsonJudge<'d>,
        /// Whether it stays so; the first object says whether it is Flockwave.
        is_decided: bool,
    },
    Flockwave(FlockwaveJudge<'d>),
}

impl<'d> Judge<'d> {
    fn course(&mut self) -> &mut Course<'d> {
        match self {
            Self::Json { judge, .. } => &mut judge.course,
            Self::Flockwave(judge) => &mut judge.course,
        }
    }

    fn value(&mut self, bytes: &[u8], line: u64, is_last: bool) {
        self.decide(bytes);
        match self {
            Self::Json { judge, .. } => judge.value(bytes, line, is_last),
            Self::Flockwave(judge) => judge.line(bytes, line, is_last),
        }
    }

    /// Finds out what the source is, if this is its first object.
    fn decide(&mut self, bytes: &[u8]) {
        let Self::Json { judge, is_decided } = self else { return };
        if *is_decided {
            return;
        }
        let tree = std::str::from_utf8(bytes).ok().and_then(|text| Tree::read(text).ok());
        let Some(tree) = tree.filter(|tree| matches!(tree, Tree::Object(_))) else { return };
        *is_decided = true;
        if is_flockwave(&tree) {
            let definitions = judge.course.definitions;
            let course = std::mem::replace(&mut judge.course, Course::new(definitions));
            *self = Self::Flockwave(FlockwaveJudge::new(course));
        }
    }
}

struct JsonJudge<'d> {
    course: Course<'d>,
    plans: Plans,
    channels: Channels,
    templates: Templates,
    /// Topics whose type was named, with its definition, if there is one.
    advertised: HashMap<String, Option<MessageId>>,
    skipped: u64,
    dialects: Dialects,
    /// What the message says that is read, as it lies in memory.
    values: Vec<u8>,
}

impl<'d> JsonJudge<'d> {
    fn new(of: Option<MessageId>, definitions: &'d Definitions) -> Self {
        let mut judge = Self {
            course: Course::new(definitions),
            plans: Plans::new(&definitions.schema, &px4::VALUES),
            channels: Channels {
                only: None,
                open: Vec::new(),
                by_type: HashMap::new(),
                by_topic: HashMap::new(),
            },
            templates: Templates::default(),
            advertised: HashMap::new(),
            skipped: 0,
            dialects: Dialects::default(),
            values: Vec::new(),
        };
        judge.channels.only = of.and_then(|id| {
            let name = definitions.schema.message(id).name.clone();
            let at = judge.open(Which::Type, &name, Some(id), 1)?;
            judge.channels.open[at].key = None;
            Some(at)
        });
        judge
    }

    fn value(&mut self, bytes: &[u8], line: u64, is_last: bool) {
        let place = Place::Line(line);
        let text = match std::str::from_utf8(bytes) {
            Ok(text) => text,
            Err(error) => {
                let text = format!("no UTF-8 from its byte {} on", error.valid_up_to());
                return self.course.gap(place, text);
            }
        };
        if let Some((at, clean)) = self.templates.read(text, &self.plans, &mut self.values) {
            return self.message(at, clean, place);
        }
        match read(text, &self.channels, &self.plans, &mut self.values) {
            Fast::Clean(at, clean) => {
                if clean.dialects == Dialects::default() {
                    self.templates.learn(text, &self.channels.open[at], at, &self.plans);
                }
                self.message(at, clean, place);
            }
            Fast::Skipped => self.skipped += 1,
            Fast::Undefined => self.course.records += 1,
            Fast::Unclear => self.explain(text, line, is_last),
        }
    }

    /// Reads again what isn't clean, or is new.
    fn explain(&mut self, text: &str, line: u64, is_last: bool) {
        let place = Place::Line(line);
        let tree = match Tree::read(text) {
            Ok(tree) => tree,
            Err(SyntaxError { what: CUT_OFF, at }) if is_last => {
                let text = format!("the last value is cut off after {at} bytes");
                return self.course.damage(place, text, Extent::EndsEarly);
            }
            Err(error) => return self.course.gap(place, error.to_string()),
        };
        let (which, name, message) = match self.channels.only {
            Some(at) => return self.judge(at, &tree, place, false),
            None => match form(&tree) {
                Form::Message(which, name, message) => (which, name, message),
                Form::Advertised(topic, ty) => {
                    self.advertise(topic, ty);
                    return self.skipped += 1;
                }
                Form::Skipped => return self.skipped += 1,
                Form::Unknown(problem) => return self.course.gap(place, problem.to_owned()),
            },
        };
        if name.len() > MAX_NAME {
            let text = format!("a topic or type whose name has more than {MAX_NAME} bytes");
            return self.course.gap(place, text);
        }
        let definition = |judge: &Self| match which {
            Which::Type => judge.course.definitions.message_of_type(name),
            Which::Topic => {
                let guessed = || definition_of(name, None, judge.course.definitions);
                judge.advertised.get(name).copied().unwrap_or_else(guessed)
            }
        };
        let known = self.channels.get(which, name);
        let Some(at) = known.or_else(|| {
            let definition = definition(self);
            self.open(which, name, definition, line)
        }) else {
            return self.course.gap(place, format!("more than {MAX_CHANNELS} topics and types"));
        };
        // Now that its channel is open, a first message with which nothing is wrong is read as those that follow:
        // rules want to know what it says, too.
        if known.is_none()
            && let Fast::Clean(at, clean) = read(text, &self.channels, &self.plans, &mut self.values)
        {
            return self.message(at, clean, place);
        }
        self.judge(at, message, place, which == Which::Topic);
    }

    /// A topic is of this type, whatever it is called.
    fn advertise(&mut self, topic: &str, ty: &str) {
        if self.advertised.len() < MAX_CHANNELS && topic.len() <= MAX_NAME {
            let definition = definition_of(topic, Some((ty, ROS)), self.course.definitions);
            self.advertised.insert(topic.to_owned(), definition);
        }
    }

    /// Judges a message of an open channel.
    fn judge(&mut self, at: usize, tree: &Tree<'_>, place: Place, is_rosbridge: bool) {
        let open = &self.channels.open[at];
        let Some((id, _)) = open.defined else { return self.course.records += 1 };
        let told = Told { id, name: &open.name, place, key: open.key, is_rosbridge };
        let dialects = self.plans.explain(told, tree, &mut self.course.findings);
        let timestamp = self.plans.timestamp(id, tree);
        // What is broken somewhere may be so anywhere: nobody draws conclusions from its values.
        self.values.clear();
        self.message(at, Clean { timestamp, dialects }, place);
    }

    fn message(&mut self, at: usize, clean: Clean, place: Place) {
        self.course.records += 1;
        self.dialects.absorb(clean.dialects);
        let open = &mut self.channels.open[at];
        open.messages += 1;
        if let Some(channel) = open.channel() {
            let definitions = self.course.definitions;
            let view = |id| definitions.types().get(id).view_uorb(&self.values).ok();
            let values = channel.definition.filter(|_| !self.values.is_empty()).and_then(view);
            let message = Message { timestamp: clean.timestamp, values, place };
            self.course.message(&channel, &message);
        }
    }

    /// Opens a channel; none where there are too many.
    fn open(&mut self, which: Which, name: &str, definition: Option<MessageId>, line: u64) -> Option<usize> {
        let at = self.channels.open.len();
        if at >= MAX_CHANNELS {
            return None;
        }
        let defined = definition.map(|id| (id, self.course.number_channel()));
        let name_told = match which {
            // Whose it is says why it isn't known.
            _ if definition.is_none() => name,
            Which::Type => name.rsplit('/').next().unwrap_or(name),
            Which::Topic => topic_of(name),
        };
        let name_told = name_told.escape_debug().to_string();
        let key = Some(which.key());
        let mut open = Open { name: name_told, defined, key, messages: 0, kept: 0, line };
        if let Some(channel) = open.channel() {
            self.course.opened(&channel);
            if self.course.wants_values(channel.index) {
                let size = definition.and_then(|id| self.course.definitions.types().get(id).size());
                open.kept = size.map_or(0, |size| size.padded);
            }
        }
        self.channels.insert(which, name, open);
        Some(at)
    }

    fn finish(mut self, lines: u64, bytes: u64) -> CaptureResult {
        let mut types = BTreeSet::new();
        let mut undefined = BTreeSet::new();
        for open in self.channels.open {
            match open.defined {
                Some((id, _)) => {
                    self.plans.count(id, open.messages, &mut self.course.findings);
                    if open.messages > 0 {
                        types.insert(id);
                    }
                }
                None => _ = undefined.insert(open.name),
            }
        }
        let summary = JsonSummary {
            lines,
            types: types.len(),
            skipped: self.skipped,
            undefined,
            dialects: self.dialects,
        };
        self.course.finish(bytes, Summary::Json(summary))
    }
}

impl Open {
    fn channel(&self) -> Option<Channel<'_>> {
        let (id, index) = self.defined?;
        let place = Place::Line(self.line);
        Some(Channel { index, topic: &self.name, multi_id: None, definition: Some(id), version: None, place })
    }
}
