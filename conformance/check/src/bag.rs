//! Checks bags: their CDR and JSON messages, and the schemas that they contain. A bag is an MCAP file, a `SQLite` file
//! of rosbag2, or a folder with such files and their `metadata.yaml`.
//!
//! A channel's definition is determined by its schema name, or otherwise by its topic. The schema in the file is
//! compared with the definition. If the two differ, CDR messages are decoded with the schema in the file, and rules on
//! values apply only to the fields that match. JSON messages are checked only in these fields.

mod cdr;
mod clues;
mod folder;
mod json_schema;
mod mcap;
mod network;
mod open;
mod schemas;
mod sqlite;
mod summary;

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::hash::{DefaultHasher, Hasher as _};
use std::sync::Arc;

use uavspec_capture::mcap::OWN;
use uavspec_dynamic::{DynamicMessage, MessageType};
use uavspec_model::json::Tree;
use uavspec_model::limits::MAX_NAME;
use uavspec_model::text::utf8;
use uavspec_model::{Detail, Extent, Findings, Location, Message};
use uavspec_px4::comparison::{Comparison, compare_declared};
use uavspec_px4::json::{Clean, Dialects, MessageOrigin, Plans, decode};
use uavspec_px4::memory::FieldCounts;
use uavspec_rules::definitions::{Definitions, plain_name};
use uavspec_rules::px4;
use uavspec_schema::source::Span;
use uavspec_schema::{MessageId, derived_from};

pub use self::cdr::decompressed;
use self::cdr::{CdrChecker, TypeSource};
pub(super) use self::clues::{DISTRIBUTION, recording as recording_clues, stated_distribution};
pub(super) use self::folder::{check_folder, clues as folder_clues};
pub(super) use self::mcap::KIND as MCAP;
pub use self::mcap::{LiveBag, check_mcap};
use self::network::Network;
pub use self::network::{BusEndpoint, BusTopic};
pub use self::open::{BagChannel, Basis, ChannelResult, CheckStatus};
use self::open::{Identity, Open, Reading};
use self::schemas::{ComparedSchema, Schemas};
pub(super) use self::sqlite::{CopiedFile, ROS1, SQLITE, copy, definitions_of};
pub use self::summary::{BagSummary, McapSummary};
use super::coverage::{Parts, Share, Unit};
use super::release::{ReleaseMatch, release_matches};
use super::summary::names;
use super::topic::{confirms, definition_of, is_guess, is_same_type};
use super::{CaptureResult, CheckRun, Logged, Summary};
use crate::limits::{MAX_BAG_CHANNELS, MAX_BAG_FIELDS};

/// The metadata key for the type hash of a channel, as written by `rosbag2`.
pub const HASH: &str = "topic_type_hash";

/// The prefix of the supported hashes.
const HASH_VERSION: &str = "RIHS01_";

/// The number of digits of the supported hashes.
const HASH_DIGITS: usize = 64;

/// The declaration of a channel.
#[derive(Clone, Hash)]
struct Declared {
    /// The index of the schema.
    schema: Option<usize>,
    topic: String,
    encoding: String,
    metadata: BTreeMap<String, String>,
}

/// The type that a channel states, compared with a definition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StatedType {
    /// The type of the definition.
    Same,
    /// Another type.
    Other,
    /// Neither the schema nor the metadata contains a type.
    Unknown,
}

/// Compares the type of a channel with a definition. The type is read from the schema (its name, encoding and text). If
/// the schema contains no type, the hash in the metadata is used. Empty schemas, invalid schemas, and schemas in other
/// encodings contain no type.
pub fn stated_type(
    schema: Option<(&str, &str, &[u8])>,
    metadata: &BTreeMap<String, String>,
    definition: MessageId,
    definitions: &Definitions,
) -> StatedType {
    let is_same = if let Some((name, "ros2msg", text)) = schema
        && !text.is_empty()
        && let Ok(stated) = definitions.shared.stated(name, text)
    {
        compare_declared(stated.root(), definitions.types().get(definition)) == Comparison::Equal
    } else if let Some(stated) = metadata.get(HASH).filter(|hash| is_comparable(hash)) {
        let message = definitions.schema.message(definition);
        definitions.has_type_hash(message, stated)
    } else {
        return StatedType::Unknown;
    };
    if is_same { StatedType::Same } else { StatedType::Other }
}

/// True if the metadata of a channel contains a type hash of the supported version.
fn has_hash(metadata: &BTreeMap<String, String>) -> bool {
    metadata.get(HASH).is_some_and(|hash| is_comparable(hash))
}

/// A file of a bag.
#[derive(Clone, Copy, Default)]
struct BagFile<'f> {
    /// The name of the file in a bag of several files; otherwise, empty.
    name: &'f str,
    /// The encodings of the topics' messages in the bag's metadata.
    encodings: Option<&'f BTreeMap<String, String>>,
}

/// The content of a bag, for its summary.
struct BagContent {
    channels: Vec<BagChannel>,
    /// The accepted deviations of JSON messages.
    dialects: Dialects,
    releases: Vec<ReleaseMatch>,
    /// The topics of a live vehicle, with their publishers and subscribers.
    bus: Vec<BusTopic>,
}

/// The channels of a bag, and the state of their check. The files of a bag are read one after the other.
struct Channels<'d> {
    run: CheckRun<'d>,
    schemas: Schemas,
    open: Vec<Open>,
    /// The indices of the channels in `open`, by the hash of their declaration.
    by_digest: HashMap<u64, Vec<usize>>,
    /// The number of fields in the types of the channels that are checked.
    fields: usize,
    /// Created when the first JSON channel is opened.
    plans: Option<Plans<'d>>,
    dialects: Dialects,
    /// The publishers and subscribers of a live vehicle.
    network: Network,
    /// The field values of the current message, in memory layout.
    values: Vec<u8>,
}

impl<'d> Channels<'d> {
    fn new(run: CheckRun<'d>) -> Self {
        Self {
            run,
            schemas: Schemas::default(),
            open: Vec::new(),
            by_digest: HashMap::new(),
            fields: 0,
            plans: None,
            dialects: Dialects::default(),
            network: Network::default(),
            values: Vec::new(),
        }
    }

    /// Opens a channel, and returns its index. If an earlier file declared the same channel, that channel is continued.
    /// `claimed` contains the channels of this file. The error describes the problem.
    fn declare(
        &mut self,
        declared: &Declared,
        location: Location,
        claimed: &mut BTreeSet<usize>,
    ) -> Result<usize, String> {
        if declared.topic.len() > MAX_NAME || declared.encoding.len() > MAX_NAME {
            return Err(format!("the topic or the encoding is longer than {MAX_NAME} bytes"));
        }
        let same = self.by_digest.entry(digest(declared)).or_default();
        if let Some(index) = same.iter().find(|index| !claimed.contains(index)) {
            claimed.insert(*index);
            return Ok(*index);
        }
        if self.open.len() >= MAX_BAG_CHANNELS {
            return Err(format!("the bag has more than {MAX_BAG_CHANNELS} channels"));
        }
        same.push(self.open.len());
        claimed.insert(self.open.len());
        let schema = declared.schema.map(|schema| self.schemas.name(schema));
        let definitions = self.run.definitions;
        let found = definition_of(&declared.topic, schema, definitions);
        let is_json = declared.encoding == "json";
        let guess = found.filter(|id| is_json && is_guess(&declared.topic, schema, *id, definitions));
        let definition = found.filter(|_| guess.is_none());
        let mut open = Open::new(declared, schema, definition, location, self.run.number_channel());
        if let Some(message_id) = guess {
            open.reading = Reading::Guess(message_id, Box::new(declared.clone()));
        }
        match (definition, declared.encoding.as_str()) {
            (Some(message_id), "cdr" | "json") => self.read(&mut open, declared, message_id),
            (None, "cdr") => self.read_own(&mut open, declared),
            (None, "json") if guess.is_none() => open.remark = self.schemas.unused(declared.schema),
            _ => {}
        }
        self.malformed_hash(&open, declared, definition);
        self.open.push(open);
        Ok(self.open.len() - 1)
    }

    /// Counts a message, and returns its number. Subsequent calls concern this message, until the next call of `begin`.
    fn begin(&mut self, logged: Logged) -> u64 {
        self.run.records += 1;
        self.run.record_at(logged.time / 1_000);
        self.run.logged = Some(logged);
        self.run.records
    }

    /// True if parts of the bag can't be read.
    fn has_gaps(&self) -> bool {
        self.run.extent != Extent::Whole
    }

    /// Reports a corrupt part. `file` is the name of the file within the bag; empty if the bag has only one file.
    fn corruption(&mut self, file: &str, location: Location, text: &str, extent: Extent) {
        let text = if file.is_empty() { text.to_owned() } else { format!("{file}: {text}") };
        self.run.corruption(location, text, extent);
    }

    /// Opens a channel that has a definition, and chooses the reader for its messages.
    fn read(&mut self, open: &mut Open, declared: &Declared, message_id: MessageId) {
        let definitions = self.run.definitions;
        let is_json = declared.encoding == "json";
        let ComparedSchema { mut basis, stated, shared, version } =
            self.schemas.compared(declared.schema, message_id, is_json, definitions);
        // The type hash covers the names and types of all fields.
        if basis == Basis::NoSchema && self.has_defined_hash(declared, message_id) {
            basis = Basis::Compared(Arc::new(Comparison::Equal));
        }
        // An empty, invalid or unsupported schema doesn't describe the fields.
        let lacks_schema = !matches!(basis, Basis::Compared(_));
        (open.status, open.identity.version) = (CheckStatus::Checked(basis), version);
        open.subscribers = self.run.opened(&open.identity.channel());
        if is_json {
            self.plans
                .get_or_insert_with(|| Plans::new(&definitions.schema, definitions.types(), &px4::VALUES));
            let num_fields = definitions.schema.message(message_id).fields.len();
            let (checked, all) = match (&shared, open.differences()) {
                (Some(shared), Some(differences)) => {
                    (shared.len(), num_fields - differences.missing.len() + differences.extra.len())
                }
                _ => (num_fields, num_fields),
            };
            open.fields = Some(Share::of(checked as u64, all as u64));
            open.reading = Reading::Json(message_id, shared);
            return self.format(open);
        }
        let is_unknown = lacks_schema && !has_hash(&declared.metadata);
        // At this point, this program may have received messages before it knew the release.
        let has_defined_hash = self.has_defined_hash(declared, message_id);
        let is_outdated = declared.metadata.contains_key(OWN) && !has_defined_hash;
        if is_outdated || is_unknown && definitions.is_undecided(message_id) {
            open.status = CheckStatus::Checked(Basis::Undecided);
            self.run.undecided(&open.identity.channel());
            return;
        }
        // Without a schema, only the hash identifies the fields.
        if lacks_schema && has_hash(&declared.metadata) && !has_defined_hash {
            open.status = CheckStatus::Checked(Basis::OtherHash);
            self.run.undecided(&open.identity.channel());
            return self.hash(open, declared, message_id);
        }
        if let (None, Some(defect)) = (&stated, definitions.types().get(message_id).defect()) {
            open.status = CheckStatus::Checked(Basis::Unusable(defect.to_string()));
            return;
        }
        let source = match stated {
            Some(stated) => TypeSource::Differing(stated, message_id),
            None => TypeSource::Definition(message_id),
        };
        let Some(check) = self.checker(open, source) else { return };
        if let Some(lacks) = check.lacks_timestamp(definitions) {
            let Identity { topic, location, .. } = &open.identity;
            self.run.findings.cover(&px4::FMT_03.rule, 1);
            if lacks {
                let definition = Some(definitions.schema.message(message_id).span);
                self.run.findings.report(&px4::FMT_03.rule, topic, *location, definition, || {
                    Detail::new("the schema has no `uint64 timestamp` field")
                        .expected("uint64 timestamp")
                        .actual("no such field")
                });
            }
        }
        open.reading = Reading::Cdr(Box::new(check));
        self.hash(open, declared, message_id);
        self.format(open);
    }

    /// Chooses the reader for the messages of a channel without a definition. They are checked against the channel's
    /// own schema.
    fn read_own(&mut self, open: &mut Open, declared: &Declared) {
        let stated = match self.schemas.own(declared.schema, self.run.definitions) {
            Ok(stated) => stated,
            Err(problem) => {
                open.remark = problem;
                return;
            }
        };
        if !stated.added.is_empty() {
            let added = names(stated.added.iter().map(String::as_str));
            open.remark =
                Some(format!("the schema lacks {added}, so the built-in definitions of ROS 2 are used"));
        }
        open.subscribers = self.run.opened(&open.identity.channel());
        open.status = CheckStatus::OwnSchema;
        let Some(check) = self.checker(open, TypeSource::Own(Arc::clone(&stated))) else { return };
        open.reading = Reading::Cdr(Box::new(check));
        // For an event of a service, captures contain the hash of the service.
        let is_derived =
            open.schema.as_ref().is_some_and(|(name, _)| derived_from(&plain_name(name)).is_some());
        if let Some(hash) = declared.metadata.get(HASH).filter(|hash| !is_derived && is_comparable(hash)) {
            self.run.findings.cover(&px4::HASH_01.rule, 1);
            if !hash.eq_ignore_ascii_case(&stated.type_hash) {
                self.report_hash(open, None, &stated.type_hash, hash);
            }
        }
    }

    /// Creates the checker for the messages of a channel. Returns `None` if there are too many fields.
    fn checker(&mut self, open: &mut Open, source: TypeSource) -> Option<CdrChecker> {
        let definitions = self.run.definitions;
        // A checker takes time and memory for each field.
        let fields = FieldCounts::default().of(source.message_type(definitions));
        if fields > MAX_BAG_FIELDS - self.fields {
            open.status = CheckStatus::Checked(Basis::TooMany);
            return None;
        }
        self.fields += fields;
        let check = CdrChecker::new(source, definitions);
        open.fields = Some(check.fields(definitions));
        Some(check)
    }

    /// True if a channel has the type hash of its definition.
    fn has_defined_hash(&self, declared: &Declared, message_id: MessageId) -> bool {
        let definitions = self.run.definitions;
        let message = definitions.schema.message(message_id);
        declared.metadata.get(HASH).is_some_and(|stated| definitions.has_type_hash(message, stated))
    }

    /// Compares the hash in a channel's metadata with the hash of its definition.
    fn hash(&mut self, open: &mut Open, declared: &Declared, message_id: MessageId) {
        let Some(stated) = declared.metadata.get(HASH).filter(|hash| is_comparable(hash)) else { return };
        let definitions = self.run.definitions;
        let schema = &definitions.schema;
        let message = schema.message(message_id);
        // The hash includes names. A copy of the type in another package therefore has a different hash.
        let is_of_definition =
            open.schema.as_ref().is_none_or(|(name, _)| is_same_type(name, message, schema));
        if !is_of_definition {
            return;
        }
        let is_other = !definitions.has_type_hash(message, stated);
        if open.differences().is_some() {
            open.has_other_hash = is_other;
            return;
        }
        self.run.findings.cover(&px4::HASH_01.rule, 1);
        if is_other {
            self.report_hash(open, Some(message.span), &message.type_hash, stated);
        }
    }

    /// Reports a hash that has an invalid form, unless it is empty: rosbag2 writes an empty hash if it doesn't know the
    /// hash.
    fn malformed_hash(&mut self, open: &Open, declared: &Declared, definition: Option<MessageId>) {
        let Some(stated) = declared.metadata.get(HASH) else { return };
        if !stated.is_empty() && !is_type_hash(stated) {
            let definition = definition.map(|id| self.run.definitions.schema.message(id).span);
            let expected = format!("{HASH_VERSION} and {HASH_DIGITS} hexadecimal digits");
            self.report_hash(open, definition, &expected, stated);
        }
    }

    fn report_hash(&mut self, open: &Open, definition: Option<Span>, expected: &str, stated: &str) {
        let shortened: String = stated.chars().take(HASH_VERSION.len() + HASH_DIGITS).collect();
        let more = if shortened.len() < stated.len() { "…" } else { "" };
        let Identity { topic, location, .. } = &open.identity;
        self.run.findings.report(&px4::HASH_01.rule, topic, *location, definition, || {
            Detail::differs(expected, format!("{}{more}", shortened.escape_debug()))
        });
    }

    /// Reports the differences between the schema of a channel and the definition.
    fn format(&mut self, open: &Open) {
        let CheckStatus::Checked(Basis::Compared(_)) = &open.status else { return };
        self.run.findings.cover(&px4::FMT_01.rule, 1);
        if let Some(differences) = open.differences() {
            let hash = if open.has_other_hash { "; its hash differs as well" } else { "" };
            let Identity { topic, location, definition, .. } = &open.identity;
            let definition = definition.map(|id| self.run.definitions.schema.message(id).span);
            self.run.findings.report(&px4::FMT_01.rule, topic, *location, definition, || {
                let mut detail = differences.detail();
                detail.message += hash;
                detail
            });
        }
    }

    /// Decides from a message whether a JSON channel has the type that its name suggests.
    fn decide(&mut self, index: usize, message_id: MessageId, payload: &[u8], location: Location) {
        let tree = utf8(payload).and_then(|text| Tree::read(text).map_err(|error| error.to_string()));
        let message = match tree {
            Ok(message) => message,
            Err(problem) => return self.run.gap(location, problem),
        };
        let Some(is_confirmed) = confirms(&message, message_id, self.run.definitions) else {
            return self.open[index].tally.count(false, None);
        };
        // The channel is removed while it is opened, and then put back in its place.
        let mut open = self.open.swap_remove(index);
        if let Reading::Guess(_, declared) = std::mem::replace(&mut open.reading, Reading::Skipped)
            && is_confirmed
        {
            open.identity.definition = Some(message_id);
            self.read(&mut open, &declared, message_id);
        }
        self.open.push(open);
        let last = self.open.len() - 1;
        self.open.swap(index, last);
    }

    /// Checks a message. `time` is the log time in ns.
    fn message(&mut self, index: usize, time: u64, payload: &[u8], location: Location) {
        if let Some(&Open { reading: Reading::Guess(message_id, _), .. }) = self.open.get(index) {
            self.decide(index, message_id, payload, location);
        }
        let Some(open) = self.open.get_mut(index) else { return };
        open.tally.records += 1;
        let logged = Some(time / 1_000).filter(|logged| *logged > 0);
        open.tally.time(logged);
        let channel = open.identity.channel();
        let definitions = self.run.definitions;
        match &mut open.reading {
            Reading::Skipped | Reading::Guess(..) => {}
            Reading::Cdr(check) => {
                let payload = &*match decompressed(payload) {
                    Ok(payload) => payload,
                    Err(problem) => return self.run.gap(location, problem),
                };
                let (memory, findings) = (&mut self.values, &mut self.run.findings);
                let checked = check.check(payload, memory, &channel, location, definitions, findings);
                let Some(seen) = checked else { return self.run.lost(open.subscribers, location) };
                open.tally.count(true, None);
                // The log time counts instead, if it is known.
                self.run.include(seen.timestamp.filter(|_| logged.is_none()));
                let view = || check.view(&self.values, definitions);
                let observed = open.subscribers.want_values().then(view).flatten();
                let values = observed.filter(|values| values.message_type().size().is_some());
                let message = Message { timestamp: seen.timestamp, logged, values, location };
                self.run.message(open.subscribers, &channel, &message, observed);
            }
            Reading::Json(message_id, shared) => {
                let Some(plans) = &self.plans else { return };
                let origin = MessageOrigin {
                    id: *message_id,
                    name: channel.full_topic,
                    location,
                    key: None,
                    is_rosbridge: true,
                    shared: shared.as_deref(),
                };
                let ty = definitions.types().get(*message_id);
                let size = ty.size().filter(|_| open.subscribers.want_values());
                self.values.clear();
                self.values.resize(size.map_or(0, |size| size.padded), 0);
                match check_message(plans, origin, payload, &mut self.values, &mut self.run.findings) {
                    Err(problem) => self.run.gap(location, problem),
                    Ok(Clean { timestamp, dialects }) => {
                        self.dialects.absorb(dialects);
                        open.tally.count(true, None);
                        self.run.include(timestamp.filter(|_| logged.is_none()));
                        let view = || ty.view_uorb(&self.values).ok();
                        let values = (!self.values.is_empty()).then(view).flatten();
                        let is_decoded = values.is_none() && open.subscribers.observe_values();
                        let decoded = is_decoded.then(|| decoded(payload, ty)).flatten();
                        let observed = values.or(decoded.as_ref().map(DynamicMessage::view));
                        let message = Message { timestamp, logged, values, location };
                        self.run.message(open.subscribers, &channel, &message, observed);
                    }
                }
            }
        }
    }

    /// Finishes the check. `summarize` creates the summary.
    fn finish(mut self, bytes: u64, summarize: impl FnOnce(BagContent) -> Summary) -> CaptureResult {
        let topics = self.open.iter().filter(|open| open.identity.definition.is_some());
        let releases = release_matches(self.run.definitions, &topics.map(Open::compared));
        let (mut channels, mut parts) = (Vec::new(), Parts::default());
        for open in std::mem::take(&mut self.open) {
            let definitions = self.run.definitions;
            channels.push(open.close(self.plans.as_ref(), definitions, &mut self.run.findings, &mut parts));
        }
        channels.sort_by(|left, right| left.topic.cmp(&right.topic));
        let bus = self.network.topics(&channels);
        let content = BagContent { channels, dialects: self.dialects, releases, bus };
        self.run.finish(bytes, summarize(content), Unit::Topic, parts)
    }
}

/// Checks a JSON message. Stores the field values in `values`, or clears `values` if there are findings. Fails if the
/// payload isn't JSON.
fn check_message(
    plans: &Plans<'_>,
    origin: MessageOrigin<'_>,
    payload: &[u8],
    values: &mut Vec<u8>,
    findings: &mut Findings,
) -> Result<Clean, String> {
    let text = utf8(payload)?;
    // Foxglove writes bytes as base64, like rosbridge.
    if let Ok(clean) = plans.read_text(origin.id, text, origin.is_rosbridge, values) {
        return Ok(clean);
    }
    values.clear();
    let tree = Tree::read(text).map_err(|error| error.to_string())?;
    let dialects = plans.explain(origin, &tree, findings);
    Ok(Clean { timestamp: plans.timestamp(origin.id, &tree), dialects })
}

/// Decodes a JSON message that may have findings. Returns `None` if a value doesn't fit into its field.
fn decoded<'t>(payload: &[u8], ty: MessageType<'t>) -> Option<DynamicMessage<'t>> {
    let tree = Tree::read(utf8(payload).ok()?).ok()?;
    decode(&tree, ty, true).ok().map(|(message, _)| message)
}

/// True if the text has the form of a ROS type hash. For other versions of the hash, the digits aren't checked.
fn is_type_hash(text: &str) -> bool {
    if let Some(digits) = text.strip_prefix(HASH_VERSION) {
        return digits.len() == HASH_DIGITS && digits.bytes().all(|byte| byte.is_ascii_hexdigit());
    }
    let version = text.strip_prefix("RIHS").and_then(|rest| rest.split_once('_')).map(|(version, _)| version);
    version.is_some_and(|version| version.len() == 2 && version.bytes().all(|byte| byte.is_ascii_hexdigit()))
}

/// True if the text is a type hash of the supported version.
fn is_comparable(text: &str) -> bool {
    text.starts_with(HASH_VERSION) && is_type_hash(text)
}

/// A hash of a declaration, used to distinguish declarations without storing them.
pub fn digest(declaration: &impl std::hash::Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    declaration.hash(&mut hasher);
    hasher.finish()
}
