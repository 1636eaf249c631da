//! Converts MCAP files.

mod json_schema;

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::io::{self, Read, Seek as _, SeekFrom, Write};

use mcap::records::MessageHeader;
use tempfile::SpooledTempFile;
use uavspec_codegen::schema::MessageId;
use uavspec_runtime::cdr::ByteOrder;

use super::plan::{Converted, Converters, Plan, Treatment};
use super::report::{Action, Problems, TopicReport};
use super::topic::Topic;
use super::{Error, Settings};
use crate::capture::mcap::{AttachmentHead, Event, Item, Packing, Reader, Writer, compressed};
use crate::check::json::MAX_NAME;
use crate::check::{HASH, StatedType, decompressed, definition_of, digest, stated_type};
use crate::definitions::Definitions;
use crate::json::Tree;
use crate::text::{start_of, utf8};

/// The maximum total size of the schemas and channels in a file, in bytes. It includes the names of attachments and
/// metadata records, which the index of the output contains. The limit also applies to the schemas in the output.
const MAX_SIZE: usize = 64 << 20;

/// The size of the attachments that are kept in memory, in bytes. A larger one is stored in a temporary file, until it
/// is complete.
const MAX_ATTACHMENT: usize = 16 << 20;

/// A schema: its name, encoding and text.
type Schema = (String, String, Vec<u8>);

/// The name, the encoding and the text of a schema in the output.
type Content<'s> = (Cow<'s, str>, Cow<'s, str>, Cow<'s, [u8]>);

/// The origin of a schema in the output.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Origin {
    /// The schema of the input with this id.
    Input(u16),
    /// A message of the target, as its definition.
    Target(MessageId),
    /// A message of the target, in the encoding of this schema of the input.
    Json(MessageId, u16),
}

struct Channel<'p> {
    topic: Topic<'p>,
    /// A hash of the declaration.
    digest: u64,
    is_json: bool,
    /// True if the output contains the payloads of the input.
    keeps_payloads: bool,
}

struct Stream<'p, 'o> {
    plan: &'p Plan,
    settings: Settings,
    output: Writer<&'o mut dyn Write>,
    schemas: HashMap<u16, Schema>,
    /// The ids of the schemas that exceed a limit.
    left_out: BTreeSet<u16>,
    /// The total size of the schemas and channels, in bytes, with the names of attachments and metadata records.
    size: usize,
    /// The ids of the schemas in the output.
    written: HashMap<Origin, u16>,
    /// The total size of the schemas in the output, in bytes.
    written_size: usize,
    converters: Converters<'p>,
    /// The channels, by id. The output has the same ids.
    channels: Vec<Option<Box<Channel<'p>>>>,
    /// The attachment that is being read.
    attachment: Option<SpooledTempFile>,
}

/// Converts a file. Returns the topics and the parts that can't be read.
pub(super) fn convert(
    input: impl Read,
    plan: &Plan,
    settings: Settings,
    output: &mut dyn Write,
) -> Result<(Vec<TopicReport>, Problems), Error> {
    let (mut reader, mut problems) = (Reader::new(input), Problems::default());
    let (mut output, mut stream) = (Some(output), None);
    loop {
        let item = match reader.next() {
            Ok(Some(item)) => item,
            Ok(None) => break,
            Err(error) => {
                problems.add(format!("byte {}: the rest is unreadable: {error}", reader.bytes()));
                break;
            }
        };
        let profile = match &item.event {
            Event::Problem(problem) => {
                problems.add(format!("byte {}: {problem}", item.offset));
                continue;
            }
            Event::Header { profile, .. } => profile.clone(),
            _ => String::new(),
        };
        // The writer needs the profile of the header, which is the first record.
        if let Some(output) = output.take() {
            stream = Some(Stream::new(plan, settings, Writer::new(output, &profile)?));
        }
        if let Some(stream) = &mut stream {
            stream.item(item, &mut problems)?;
        }
    }
    // Even without records, the output is a valid file.
    if let Some(output) = output {
        Writer::new(output, "")?.finish()?;
    }
    let Some(stream) = stream else { return Ok((Vec::new(), problems)) };
    stream.output.finish()?;
    let channels = stream.channels.into_iter().flatten();
    Ok((channels.map(|channel| channel.topic.finish()).collect(), problems))
}

impl<'p, 'o> Stream<'p, 'o> {
    fn new(plan: &'p Plan, settings: Settings, output: Writer<&'o mut dyn Write>) -> Self {
        Self {
            plan,
            settings,
            output,
            schemas: HashMap::new(),
            left_out: BTreeSet::new(),
            size: 0,
            written: HashMap::new(),
            written_size: 0,
            converters: Converters::default(),
            channels: Vec::new(),
            attachment: None,
        }
    }

    fn item(&mut self, item: Item<'_>, problems: &mut Problems) -> Result<(), Error> {
        if matches!(item.event, Event::Schema { .. } | Event::Channel { .. } | Event::Message { .. }) {
            self.output.set_packing(item.packing)?;
        }
        let found = match item.event {
            Event::Schema { id, name, encoding, text } => self.schema(id, (name, encoding), text),
            Event::Channel { id, schema, topic, encoding, metadata } => {
                self.channel(id, schema, (topic, encoding), metadata)?
            }
            Event::Message { channel, time, publish_time, sequence, payload } => {
                let header = MessageHeader { channel_id: channel, sequence, log_time: time, publish_time };
                self.message(header, payload)?
            }
            Event::Attachment { length, at, bytes } => self.attachment((length, at), bytes)?,
            Event::Metadata { body } => self.metadata(body)?,
            Event::Private { opcode, body, is_in_chunk } => {
                self.output.private(opcode, body, is_in_chunk)?;
                None
            }
            Event::Header { .. } | Event::Problem(_) => None,
        };
        if let Some(problem) = found {
            problems.add(format!("byte {}: {problem}", item.offset));
        }
        Ok(())
    }

    /// Stores a schema. Returns the problem if it is left out. Chunks and the summary repeat schemas; the first declaration
    /// of an id is used.
    fn schema(&mut self, id: u16, (name, encoding): (String, String), text: &[u8]) -> Option<String> {
        if id == 0 {
            return Some("a schema has the reserved id 0".to_owned());
        }
        if let Some((known_name, known_encoding, known)) = self.schemas.get(&id) {
            let is_same = *known_name == name && *known_encoding == encoding && *known == text;
            return (!is_same).then(|| declared_again("schema", id));
        }
        if self.left_out.contains(&id) {
            return None;
        }
        let problem = if name.len() > MAX_NAME || encoding.len() > MAX_NAME {
            format!("the name or the encoding is longer than {MAX_NAME} bytes")
        } else if fits(&mut self.size, name.len() + encoding.len() + text.len()) {
            self.schemas.insert(id, (name, encoding, text.to_vec()));
            return None;
        } else {
            too_large()
        };
        self.left_out.insert(id);
        Some(format!("schema {id}: {problem}"))
    }

    /// Declares a channel. Returns the problem if it is left out.
    fn channel(
        &mut self,
        id: u16,
        schema: u16,
        (topic, encoding): (String, String),
        mut metadata: BTreeMap<String, String>,
    ) -> Result<Option<String>, Error> {
        let digest = digest(&(schema, &topic, &encoding, &metadata));
        let at = usize::from(id);
        if let Some(Some(known)) = self.channels.get(at) {
            return Ok((known.digest != digest).then(|| declared_again("channel", id)));
        }
        if self.channels.len() <= at {
            self.channels.resize_with(at + 1, || None);
        }
        let is_json = encoding == "json";
        if let Some(reason) = self.refusal(schema, &topic, &encoding, &metadata) {
            let problem = format!("channel {id}: {reason}");
            let topic = Topic::left_out(&start_of(&topic, MAX_NAME), reason);
            self.channels[at] = Some(Box::new(Channel { topic, digest, is_json, keeps_payloads: false }));
            return Ok(Some(problem));
        }
        let plan = self.plan;
        let stored = self.schemas.get(&schema);
        let treatment = treatment(plan, (&topic, &encoding), stored, &metadata, &mut self.converters);
        let mut topic = Topic::new(&topic, treatment, plan, self.settings);
        let mut keeps_payloads = true;
        let origin = match &topic.converted {
            Some(converted) => {
                let target = converted.conversion.to;
                if !is_json || metadata.contains_key(HASH) {
                    metadata.insert(HASH.to_owned(), plan.target_type(target).1.to_owned());
                }
                keeps_payloads =
                    if is_json { converted.keeps_json() } else { converted.converter.keeps_cdr() };
                if is_json { Origin::Json(target, schema) } else { Origin::Target(target) }
            }
            None => Origin::Input(schema),
        };
        let mut problem = None;
        if topic.report.action != Action::LeftOut {
            if let Some(schema) = self.written(origin)? {
                self.output.channel((id, schema), (topic.output_name(), &encoding), &metadata)?;
            } else {
                topic.leave_out(too_large());
                problem = Some(format!("channel {id}: {}", too_large()));
            }
        }
        self.channels[at] = Some(Box::new(Channel { topic, digest, is_json, keeps_payloads }));
        Ok(problem)
    }

    /// The reason why a new channel is left out: it exceeds a limit, or its schema is unknown. Without the schema, its
    /// topic could be mistaken for a topic of PX4.
    fn refusal(
        &mut self,
        schema: u16,
        topic: &str,
        encoding: &str,
        metadata: &BTreeMap<String, String>,
    ) -> Option<String> {
        if topic.len() > MAX_NAME || encoding.len() > MAX_NAME {
            return Some(format!("the topic or the encoding is longer than {MAX_NAME} bytes"));
        }
        if self.left_out.contains(&schema) {
            return Some(format!("its schema {schema} is left out"));
        }
        if schema != 0 && !self.schemas.contains_key(&schema) {
            return Some(format!("its schema {schema} hasn't been declared yet"));
        }
        let pairs: usize = metadata.iter().map(|(key, value)| key.len() + value.len()).sum();
        (!fits(&mut self.size, topic.len() + encoding.len() + pairs)).then(too_large)
    }

    /// The id of a schema in the output; 0 if there is none. Writes the schema if necessary. `None` if the schemas in the
    /// output take too much space.
    fn written(&mut self, origin: Origin) -> Result<Option<u16>, Error> {
        if let Some(id) = self.written.get(&origin) {
            return Ok(Some(*id));
        }
        let Some((name, encoding, text)) = content(self.plan, &self.schemas, origin) else {
            return Ok(Some(0));
        };
        if !fits(&mut self.written_size, text.len()) {
            return Ok(None);
        }
        let id = u16::try_from(self.written.len() + 1);
        let id = id.map_err(|_| io::Error::other("the output needs more than 65,535 schemas"))?;
        self.output.schema(id, (&name, &encoding), &text)?;
        self.written.insert(origin, id);
        Ok(Some(id))
    }

    /// Writes a message. Returns the problem if its channel is unknown.
    fn message(&mut self, header: MessageHeader, payload: &[u8]) -> Result<Option<String>, Error> {
        let id = header.channel_id;
        let Some(channel) = self.channels.get_mut(usize::from(id)).and_then(Option::as_deref_mut) else {
            return Ok(Some(format!("a message refers to channel {id}, which hasn't been declared yet")));
        };
        channel.topic.report.messages += 1;
        if channel.topic.report.action == Action::LeftOut {
            return Ok(None);
        }
        let payload = if channel.keeps_payloads {
            Cow::Borrowed(payload)
        } else {
            let is_json = channel.is_json;
            let converted = channel.topic.convert(|converted, losses| {
                if is_json { converted.json_payload(payload, losses) } else { converted.cdr(payload, losses) }
            });
            let Some(converted) = converted else { return Ok(None) };
            Cow::Owned(converted)
        };
        self.output.message(&header, &payload)?;
        Ok(None)
    }

    /// Copies a metadata record. Returns the problem if it is left out. The index contains the name.
    fn metadata(&mut self, body: &[u8]) -> Result<Option<String>, Error> {
        let length = body.first_chunk().map_or(0, |length| u32::from_le_bytes(*length) as usize);
        if !fits(&mut self.size, length) {
            return Ok(Some(format!("a metadata record is left out: {}", too_large())));
        }
        self.output.metadata(body)?;
        Ok(None)
    }

    /// Copies an attachment after its last part. Returns the problem if it is left out. A truncated attachment is left out
    /// as well.
    fn attachment(&mut self, (length, at): (u64, u64), bytes: &[u8]) -> Result<Option<String>, Error> {
        if at == 0 {
            // The index contains both texts.
            let head = AttachmentHead::read(bytes);
            let names = head.map_or(0, |head| head.name.len() + head.media_type.len());
            if !fits(&mut self.size, names) {
                self.attachment = None;
                return Ok(Some(format!("an attachment is left out: {}", too_large())));
            }
            self.attachment = Some(SpooledTempFile::new(MAX_ATTACHMENT));
        }
        let Some(body) = &mut self.attachment else { return Ok(None) };
        body.write_all(bytes)?;
        if at + bytes.len() as u64 == length {
            body.seek(SeekFrom::Start(0))?;
            self.output.attachment(length, body)?;
            self.attachment = None;
        }
        Ok(None)
    }
}

/// The problem of a declaration that differs from an earlier one.
fn declared_again(kind: &str, id: u16) -> String {
    format!("{kind} {id} is declared again with different content; the first declaration is used")
}

/// The problem of declarations that take too much space.
fn too_large() -> String {
    format!("the schemas, channels and names take more than {} MiB", MAX_SIZE >> 20)
}

/// Adds a size to a total, unless this would exceed the limit. Returns true if it was added.
fn fits(total: &mut usize, size: usize) -> bool {
    let sum = total.saturating_add(size);
    if sum > MAX_SIZE {
        return false;
    }
    *total = sum;
    true
}

/// The content of a schema in the output.
fn content<'s>(plan: &Plan, schemas: &'s HashMap<u16, Schema>, origin: Origin) -> Option<Content<'s>> {
    let of_input = |id: u16| schemas.get(&id);
    let definition = |message: MessageId| {
        let text = plan.target_text(message).into_bytes();
        (plan.target_type(message).0.into(), "ros2msg".into(), text.into())
    };
    match origin {
        Origin::Target(message) => Some(definition(message)),
        Origin::Input(id) => {
            let (name, encoding, text) = of_input(id)?;
            Some((name.into(), encoding.into(), text.into()))
        }
        Origin::Json(message, id) => {
            let (_, encoding, text) = of_input(id)?;
            if encoding == "ros2msg" {
                return Some(definition(message));
            }
            // Other encodings can't be written. An empty text states nothing.
            let has_text = encoding == "jsonschema" && !text.is_empty();
            let text = if has_text { json_schema::text(plan.target_schema(), message) } else { Vec::new() };
            Some((plan.target_type(message).0.into(), encoding.into(), text.into()))
        }
    }
}

/// The treatment of a channel, and the release of its messages.
fn treatment<'p>(
    plan: &'p Plan,
    (topic, encoding): (&str, &str),
    schema: Option<&Schema>,
    metadata: &BTreeMap<String, String>,
    converters: &mut Converters<'p>,
) -> (Option<String>, Treatment<'p>) {
    let definitions = plan.source();
    let names = schema.map(|(name, encoding, _)| (name.as_str(), encoding.as_str()));
    let stated = schema.map(|(name, encoding, text)| (name.as_str(), encoding.as_str(), &**text));
    let Some(id) = definition_of(topic, names, definitions) else {
        let is_other = |target: &Definitions| {
            let id = definition_of(topic, names, target).filter(|_| encoding == "cdr");
            id.is_some_and(|id| stated_type(stated, metadata, id, target) == StatedType::Other)
        };
        return (None, plan.undefined(is_other));
    };
    if !plan.concerns(id) {
        return (None, Treatment::Copy);
    }
    let treatment = match encoding {
        "cdr" => match stated_type(stated, metadata, id, definitions) {
            StatedType::Other => plan.differs(id),
            // Only the type shows the fields of a CDR message.
            StatedType::Unknown if plan.is_release_unknown(id) => Plan::unknown_release(),
            StatedType::Same | StatedType::Unknown => plan.treatment(id, topic, converters),
        },
        "json" => plan.treatment(id, topic, converters),
        _ => Treatment::Copy,
    };
    (definitions.release_of(id).map(|release| release.label.clone()), treatment)
}

impl Converted<'_> {
    /// Converts a CDR payload. Counts the losses.
    fn cdr(&self, payload: &[u8], losses: &mut [u64]) -> Result<Vec<u8>, String> {
        let plain = decompressed(payload)?;
        let order = ByteOrder::of(&plain).map_err(|fault| fault.to_string())?;
        let message = self.source.decode_cdr(&plain).map_err(|error| error.to_string())?;
        let converted = self.message(&message, losses)?.to_cdr(order).map_err(|error| error.to_string())?;
        // A message that was compressed separately stays compressed.
        match plain {
            Cow::Borrowed(_) => Ok(converted),
            Cow::Owned(_) => compressed(Packing::Zstd, &converted).map_err(|error| error.to_string()),
        }
    }

    /// Converts a JSON payload. Counts the losses.
    fn json_payload(&self, payload: &[u8], losses: &mut [u64]) -> Result<Vec<u8>, String> {
        let tree = Tree::read(utf8(payload)?).map_err(|error| error.to_string())?;
        // Foxglove writes bytes as base64, as rosbridge does.
        self.json(&tree, true, losses).map(String::into_bytes)
    }
}
