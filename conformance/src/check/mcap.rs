//! Checks MCAP: messages as CDR or as JSON, by the definitions, and what the file itself says of its types.
//!
//! Which definition a channel has is said by the name of its schema, or by its topic. A schema that the file brings is
//! compared with it. Where they differ, CDR is read by the schema of the file, and the rules on values hold
//! for the fields that agree.

mod cdr;
mod json_schema;
mod open;
mod schemas;
mod stated;
mod summary;

use std::collections::{BTreeMap, BTreeSet};
use std::hash::{DefaultHasher, Hasher as _};
use std::io::Read;

use uavspec_codegen::schema::MessageId;

use self::cdr::{CdrJudge, unpacked};
pub use self::open::{Basis, McapChannel, Standing};
use self::open::{Identity, Open, Reading};
use self::schemas::Schemas;
use self::stated::Stated;
pub use self::summary::McapSummary;
use super::topic::{definition_of, is_same_type};
use super::{CaptureResult, Course, Kind, Summary, is_begun};
use crate::capture::MCAP_MAGIC;
use crate::capture::mcap::{Event, Reader};
use crate::definitions::Definitions;
use crate::json::Tree;
use crate::model::{Detail, Findings, Message, Place};
use crate::px4::json::{Clean, Dialects, Plans, Told};
use crate::rules::px4;

/// The longest name of a topic or a schema that is kept; ROS 2 allows no longer ones either.
const MAX_NAME: usize = 256;

/// Most steps of the plans of all channels: a thousand topics of PX4 have a fourth of that.
const MAX_STEPS: usize = 1 << 18;

/// What a channel says of the hash of its type, as `rosbag2` writes it.
const HASH: &str = "topic_type_hash";

/// What the hashes that are known begin with.
const HASH_VERSION: &str = "RIHS01_";

pub(super) const KIND: Kind = Kind {
    name: "MCAP",
    detect: |start| is_begun(start, &MCAP_MAGIC),
    check: |input, _, definitions| Ok(check_mcap(input, definitions)),
};

/// Checks MCAP, as far as it can be read.
pub(crate) fn check_mcap(input: impl Read, definitions: &Definitions) -> CaptureResult {
    let mut judge = McapJudge::new(definitions);
    let mut reader = Reader::new(input);
    loop {
        let item = match reader.next() {
            Ok(Some(item)) => item,
            Ok(None) => break,
            // What was judged until then stays judged.
            Err(error) => {
                judge.course.unreadable(Place::Byte(reader.bytes()), &error);
                break;
            }
        };
        let place = Place::Byte(item.offset);
        match item.event {
            Event::Header { profile, library } => {
                (judge.profile, judge.library) = (shortened(&profile), shortened(&library));
            }
            Event::Schema { id, name, encoding, text } => {
                if let Err(problem) = judge.schemas.add(id, name, encoding, text) {
                    judge.course.gap(place, problem);
                }
            }
            Event::Channel { id, schema, topic, encoding, metadata } => {
                judge.channel(id, &Declared { schema, topic, encoding, metadata }, place);
            }
            Event::Message { channel, payload } => judge.message(channel, payload, place),
            Event::Problem(problem) => judge.course.damage(place, problem.to_string(), problem.extent()),
        }
    }
    judge.finish(reader.bytes())
}

/// What a channel says of itself.
#[derive(Hash)]
struct Declared {
    schema: u16,
    topic: String,
    encoding: String,
    metadata: BTreeMap<String, String>,
}

struct McapJudge<'d> {
    course: Course<'d>,
    profile: String,
    library: String,
    schemas: Schemas,
    channels: BTreeMap<u16, Open>,
    /// Channels that were never declared, and have messages: they are told once.
    undeclared: BTreeSet<u16>,
    /// Steps of the plans of all channels.
    steps: usize,
    /// Made with the first channel of JSON.
    plans: Option<Plans>,
    dialects: Dialects,
    /// What the message of JSON says that is read, as it lies in memory.
    values: Vec<u8>,
}

impl<'d> McapJudge<'d> {
    fn new(definitions: &'d Definitions) -> Self {
        Self {
            course: Course::new(definitions),
            profile: String::new(),
            library: String::new(),
            schemas: Schemas::default(),
            channels: BTreeMap::new(),
            undeclared: BTreeSet::new(),
            steps: 0,
            plans: None,
            dialects: Dialects::default(),
            values: Vec::new(),
        }
    }

    fn channel(&mut self, id: u16, declared: &Declared, place: Place) {
        let digest = digest(declared);
        if let Some(known) = self.channels.get(&id) {
            if known.digest != digest {
                let text = format!("channel {id} is another than before; the first one is used");
                self.course.gap(place, text);
            }
            return;
        }
        if declared.topic.len() > MAX_NAME || declared.encoding.len() > MAX_NAME {
            let text = format!("channel {id} has a topic or an encoding of more than {MAX_NAME} bytes");
            return self.course.gap(place, text);
        }
        let schema = self.schemas.get(declared.schema);
        if declared.schema != 0 && schema.is_none() {
            let text =
                format!("channel {id} is of schema {}, which isn't declared before it", declared.schema);
            self.course.gap(place, text);
        }
        let definitions = self.course.definitions;
        let definition = definition_of(&declared.topic, schema, definitions);
        let mut open = Open::new(declared, schema, definition, place, digest, self.course.number_channel());
        if let (Some(of), true) = (definition, matches!(declared.encoding.as_str(), "cdr" | "json")) {
            self.read(&mut open, declared, of);
        }
        self.channels.insert(id, open);
    }

    /// Opens a channel that has a definition, and finds out how its messages are read.
    fn read(&mut self, open: &mut Open, declared: &Declared, of: MessageId) {
        let definitions = self.course.definitions;
        let is_json = declared.encoding == "json";
        let (basis, stated, version) = self.schemas.beside(declared.schema, of, is_json, definitions);
        (open.standing, open.identity.version) = (Standing::Judged(basis), version);
        self.course.opened(&open.identity.channel());
        if is_json {
            self.plans.get_or_insert_with(|| Plans::new(&definitions.schema, &px4::VALUES));
            open.reading = Reading::Json(of);
            return self.format(open);
        }
        if let (None, Some(defect)) = (&stated, definitions.types().get(of).defect()) {
            open.standing = Standing::Judged(Basis::Unusable(defect.to_string()));
            return;
        }
        // To make a plan takes time, too, so none is made only to be dropped.
        if self.steps >= MAX_STEPS {
            open.standing = Standing::Judged(Basis::TooMany);
            return;
        }
        let judge = CdrJudge::new(of, stated, definitions, &open.identity.name);
        self.steps += judge.steps();
        if let Some(lacks) = judge.lacks_timestamp(definitions) {
            let Identity { name, place, .. } = &open.identity;
            self.course.findings.exercise(&px4::FMT_03.rule, 1);
            if lacks {
                let definition = Some(definitions.schema.message(of).span);
                self.course.findings.report(&px4::FMT_03.rule, name, *place, definition, || {
                    Detail::new("its schema has no `uint64 timestamp`")
                        .expected("uint64 timestamp")
                        .actual("no such field")
                });
            }
        }
        open.reading = Reading::Cdr(Box::new(judge));
        self.hash(open, declared, of);
        self.format(open);
    }

    /// Compares the hash that a channel states with that of the definition.
    fn hash(&mut self, open: &mut Open, declared: &Declared, of: MessageId) {
        let Some(stated) = declared.metadata.get(HASH).filter(|hash| hash.starts_with(HASH_VERSION)) else {
            return;
        };
        let schema = &self.course.definitions.schema;
        let message = schema.message(of);
        // A hash is also one of names: that of a copy in another package is another.
        let is_of_definition =
            open.schema.as_ref().is_none_or(|(name, _)| is_same_type(name, message, schema));
        if !is_of_definition {
            return;
        }
        let (findings, is_other) = (&mut self.course.findings, *stated != message.type_hash);
        if open.differences().is_some() {
            open.has_other_hash = is_other;
            return;
        }
        findings.exercise(&px4::HASH_01.rule, 1);
        if is_other {
            let stated: String = stated.chars().take(HASH_VERSION.len() + 64).collect();
            findings.report(
                &px4::HASH_01.rule,
                &open.identity.name,
                open.identity.place,
                Some(message.span),
                || Detail::differs(&message.type_hash, stated.escape_debug()),
            );
        }
    }

    /// Reports how the schema of a channel differs.
    fn format(&mut self, open: &Open) {
        let Standing::Judged(Basis::Compared(_)) = &open.standing else { return };
        self.course.findings.exercise(&px4::FMT_01.rule, 1);
        if let Some(differences) = open.differences() {
            let hash = if open.has_other_hash { "; its hash is another, too" } else { "" };
            let Identity { name, place, definition, .. } = &open.identity;
            let definition = definition.map(|id| self.course.definitions.schema.message(id).span);
            self.course.findings.report(&px4::FMT_01.rule, name, *place, definition, || {
                let mut detail = differences.detail();
                detail.message += hash;
                detail
            });
        }
    }

    fn message(&mut self, id: u16, payload: &[u8], place: Place) {
        self.course.records += 1;
        let Some(open) = self.channels.get_mut(&id) else {
            if !self.undeclared.insert(id) {
                return;
            }
            return self
                .course
                .gap(place, format!("a message of channel {id}, which isn't declared before it"));
        };
        open.messages += 1;
        let channel = open.identity.channel();
        let definitions = self.course.definitions;
        match &mut open.reading {
            Reading::Skipped => {}
            Reading::Cdr(judge) => {
                let payload = &*match unpacked(payload) {
                    Ok(payload) => payload,
                    Err(problem) => return self.course.gap(place, problem),
                };
                let wants_values = self.course.wants_values(channel.index);
                let findings = &mut self.course.findings;
                let judged = judge.judge(payload, wants_values, &channel, place, definitions, findings);
                let Some(seen) = judged else { return self.course.lost(channel.index, place) };
                let values = judge.view(&seen, definitions);
                self.course.message(&channel, &Message { timestamp: seen.timestamp, values, place });
            }
            Reading::Json(of) => {
                let Some(plans) = &self.plans else { return };
                let told = Told { id: *of, name: channel.topic, place, key: None, is_rosbridge: true };
                let size =
                    definitions.types().get(*of).size().filter(|_| self.course.wants_values(channel.index));
                self.values.clear();
                self.values.resize(size.map_or(0, |size| size.padded), 0);
                match check_message(plans, told, payload, &mut self.values, &mut self.course.findings) {
                    Err(problem) => self.course.gap(place, problem),
                    Ok(Clean { timestamp, dialects }) => {
                        self.dialects.absorb(dialects);
                        open.judged += 1;
                        let view = |of| definitions.types().get(of).view_uorb(&self.values).ok();
                        let values = (!self.values.is_empty()).then(|| view(*of)).flatten();
                        self.course.message(&channel, &Message { timestamp, values, place });
                    }
                }
            }
        }
    }

    fn finish(mut self, bytes: u64) -> CaptureResult {
        let mut channels = Vec::new();
        for (_, open) in std::mem::take(&mut self.channels) {
            channels.push(open.close(self.plans.as_ref(), &mut self.course.findings));
        }
        channels.sort_by(|left, right| left.topic.cmp(&right.topic));
        let summary =
            McapSummary { profile: self.profile, library: self.library, channels, dialects: self.dialects };
        self.course.finish(bytes, Summary::Mcap(summary))
    }
}

/// Judges a message of JSON. `values` gets what it says, or becomes empty where something is wrong with it. An error
/// says why it isn't JSON.
fn check_message(
    plans: &Plans,
    told: Told<'_>,
    payload: &[u8],
    values: &mut Vec<u8>,
    findings: &mut Findings,
) -> Result<Clean, String> {
    let text = std::str::from_utf8(payload)
        .map_err(|error| format!("no UTF-8 from its byte {} on", error.valid_up_to()))?;
    // Foxglove writes bytes as base64, as rosbridge does.
    if let Ok(clean) = plans.read_text(told.id, text, told.is_rosbridge, values) {
        return Ok(clean);
    }
    values.clear();
    let tree = Tree::read(text).map_err(|error| error.to_string())?;
    let dialects = plans.explain(told, &tree, findings);
    Ok(Clean { timestamp: plans.timestamp(told.id, &tree), dialects })
}

/// A text of the file that is shown, harmless and not too long.
fn shortened(text: &str) -> String {
    text.chars().take(MAX_NAME).collect::<String>().escape_debug().to_string()
}

/// What tells contents apart, without keeping them.
fn digest(of: &impl std::hash::Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    of.hash(&mut hasher);
    hasher.finish()
}
