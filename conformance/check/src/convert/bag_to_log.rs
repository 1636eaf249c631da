//! Converts MCAP files with messages of PX4 to PX4 logs.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, BufWriter, Read, Write};
use std::mem;
use std::sync::Arc;

use tempfile::SpooledTempFile;
use uavspec_capture::ULOG_MAGIC;
use uavspec_capture::mcap::{AttachmentHead, EVENT_METADATA, Event, Item, metadata};
use uavspec_dynamic::{Field, MessageType};
use uavspec_model::SubjectName;
use uavspec_model::limits::MAX_NAME;
use uavspec_model::text::start_of;
use uavspec_px4::format::format_name;
use uavspec_px4::memory::FieldCounts;
use uavspec_rules::definitions::{PX4_ROS_PACKAGE, Stated, is_exchanged, plain_name, unversioned};
use uavspec_runtime::Scalar;
use uavspec_schema::limits::MAX_EVENTS_LEN;
use uavspec_schema::{Element, Shape, Type};

use super::bag::{Declarations, Declared, Source, declared_again, names, treatment};
use super::information::{self, LogMessage};
use super::log_to_bag::{INSTANCE, TOPIC};
use super::plan::{Converted, Converters, Plan, Treatment};
use super::report::{Action, Problems, TopicReport};
use super::ros::{Restored, Ros};
use super::topic::Topic;
use super::ulog::formats::Formats;
use super::ulog::{MAX_MESSAGE, log_payload, write};
use super::{Error, Settings, rewound};
use crate::limits::{MAX_IN_MEMORY, MAX_INFORMATION, MAX_LOG_FIELDS};
use crate::log::Metadata;
use crate::{decompressed, definition_of, digest, topic_of};

/// The version of the log format.
const VERSION: u8 = 1;

/// The maximum size of an attachment with event metadata, in bytes: the metadata and the head of the attachment.
const MAX_ATTACHED_EVENTS: u64 = MAX_EVENTS_LEN as u64 + 256;

/// The size of the flag bits, in bytes.
const FLAG_BITS: usize = 40;

/// The content of a channel.
enum Content {
    /// Messages of a topic, with the type that the schema states. `None` if a definition is used.
    Messages(Option<Arc<Stated>>),
    Texts,
    Parameters,
}

struct Channel<'p> {
    topic: Topic<'p>,
    content: Content,
    /// A hash of the declaration.
    digest: u64,
    /// The id of the subscription.
    id: u16,
    /// The offset of the time in a message of the log.
    timestamp: Option<usize>,
}

/// A topic of the log.
struct Opened {
    /// The id of the subscription.
    id: u16,
    /// The name with the instance.
    name: String,
    /// The offset of the time in a message.
    timestamp: Option<usize>,
}

struct Stream<'p> {
    plan: &'p Plan,
    settings: Settings,
    ros: &'p Ros,
    problems: Problems,
    converters: Converters<'p>,
    declarations: Declarations,
    /// The number of fields in the types that schemas state.
    fields: usize,
    /// The channels by id.
    channels: Vec<Option<Channel<'p>>>,
    /// The topics in the log, with their instances.
    topics: BTreeSet<(String, u8)>,
    formats: Formats,
    /// The messages before the formats, and the parameters at the start.
    definitions: Vec<LogMessage>,
    /// The total size of these messages, in bytes.
    size: usize,
    /// The data section.
    data: BufWriter<SpooledTempFile>,
    /// True after the first message.
    is_in_data: bool,
    /// The start of the log, in µs of the vehicle's clock.
    start: Option<u64>,
    /// The difference between the time of the bag and the vehicle's clock, in µs.
    utc_offset: Option<i128>,
    /// The texts that wait for this difference, with their channels, and their size in bytes.
    early: Vec<(u16, Vec<u8>)>,
    early_size: usize,
    /// True if the bag has attachments or metadata records that a log can't contain.
    has_other_parts: bool,
    /// The attachment with event metadata that is being read.
    metadata: Option<Vec<u8>>,
}

/// Converts a file. Returns the topics and the parts that can't be read.
pub(super) fn convert(
    source: Source<'_, impl Read>,
    plan: &Plan,
    settings: Settings,
    output: &mut dyn Write,
) -> Result<(Vec<TopicReport>, Problems), Error> {
    let ros = Ros::new()?;
    let mut stream = Stream {
        plan,
        settings,
        ros: &ros,
        problems: Problems::default(),
        converters: Converters::default(),
        declarations: Declarations::default(),
        fields: 0,
        channels: Vec::new(),
        topics: BTreeSet::new(),
        formats: Formats::default(),
        definitions: Vec::new(),
        size: 0,
        data: BufWriter::new(SpooledTempFile::new(MAX_IN_MEMORY)),
        is_in_data: false,
        start: None,
        utc_offset: None,
        early: Vec::new(),
        early_size: 0,
        has_other_parts: false,
        metadata: None,
    };
    let mut problems = Problems::default();
    source.read(&mut problems, |item, problems| {
        mem::swap(&mut stream.problems, problems);
        let result = stream.item(item);
        mem::swap(&mut stream.problems, problems);
        result
    })?;
    stream.problems = problems;
    stream.finish(output)
}

impl<'p> Stream<'p> {
    fn item(&mut self, item: Item<'_>) -> Result<(), Error> {
        let found = match item.event {
            Event::Schema { id, name, encoding, text } => {
                self.declarations.add_schema(id, (name, encoding), text)
            }
            Event::Channel { id, schema, topic, encoding, metadata } => {
                let digest = digest(&(schema, &topic, &encoding, &metadata));
                self.declare(&Declared { id, schema, topic, encoding, metadata, digest })?
            }
            Event::Message { channel, time, payload, .. } => self.message(channel, time / 1_000, payload)?,
            Event::Attachment { length, at, bytes } => {
                self.attachment((length, at), bytes);
                None
            }
            Event::Metadata { body } => {
                let (name, values) = metadata(body).unwrap_or_default();
                let [start, utc_offset] = information::read_times(&name, &values);
                let utc_offset = utc_offset.map(i128::from);
                (self.start, self.utc_offset) = (start.or(self.start), utc_offset.or(self.utc_offset));
                self.has_other_parts |= !name.starts_with("ulog:");
                self.define(information::messages(&name, &values));
                None
            }
            Event::Header { .. } | Event::Private { .. } | Event::Problem(_) => None,
        };
        if let Some(problem) = found {
            self.problems.add(format!("byte {}: {problem}", item.offset));
        }
        Ok(())
    }

    /// Adds messages to the definitions section.
    fn define(&mut self, messages: Vec<LogMessage>) {
        for (kind, payload) in messages {
            if payload.len() > usize::from(u16::MAX) {
                let size = payload.len();
                self.problems.add(format!("information of {size} bytes doesn't fit into a message of a log"));
                continue;
            }
            let is_full = self.size > MAX_INFORMATION;
            self.size = self.size.saturating_add(payload.len());
            if self.size > MAX_INFORMATION {
                if !is_full {
                    let limit = MAX_INFORMATION >> 20;
                    let parts = "the information and the parameters";
                    self.problems.add(format!("{parts} take more than {limit} MiB: the rest is left out"));
                }
                return;
            }
            self.definitions.push((kind, payload));
        }
    }

    /// Declares a channel. Returns the problem if there is one.
    fn declare(&mut self, declared: &Declared) -> Result<Option<String>, Error> {
        let Declared { id, schema, topic, encoding, metadata, digest } = declared;
        let at = usize::from(*id);
        if let Some(Some(known)) = self.channels.get(at) {
            return Ok((known.digest != *digest).then(|| declared_again("channel", *id)));
        }
        self.channels.resize_with(self.channels.len().max(at + 1), || None);
        let refusal = self.declarations.refusal(*schema, topic, encoding, metadata);
        let channel = match &refusal {
            Some(reason) => Err(reason.clone()),
            None => self.channel(declared)?,
        };
        self.channels[at] = Some(channel.unwrap_or_else(|reason| Channel {
            topic: Topic::left_out(&start_of(topic, MAX_NAME), reason),
            content: Content::Messages(None),
            digest: *digest,
            id: 0,
            timestamp: None,
        }));
        Ok(refusal.map(|reason| format!("channel {id}: {reason}")))
    }

    /// Opens a channel. The inner error is the reason why it is left out.
    fn channel(&mut self, declared: &Declared) -> Result<Result<Channel<'p>, String>, Error> {
        let Declared { schema, topic: name, encoding, digest, .. } = declared;
        if encoding != "cdr" {
            return Ok(Err(format!("expected CDR messages, found `{}`", encoding.escape_debug())));
        }
        let stored = self.declarations.schema(*schema);
        let Some(ty) = stored.map(|(name, _, _)| plain_name(name)) else {
            return Ok(Err("it has no schema".to_owned()));
        };
        let mut channel = Channel {
            topic: Topic::new(name, (None, Treatment::Copy), self.plan, self.settings),
            content: Content::Messages(None),
            digest: *digest,
            id: 0,
            timestamp: None,
        };
        let mut of_ros = [Content::Texts, Content::Parameters].into_iter().zip(self.ros.channels());
        if let Some((content, (_, known, _))) = of_ros.find(|(_, (_, known, _))| known.name == ty) {
            if self.stated(*schema, &ty).is_ok_and(|stated| stated.type_hash != known.hash) {
                return Ok(Err(format!("its fields differ from {ty}")));
            }
            channel.content = content;
            return Ok(Ok(channel));
        }
        let definition = definition_of(name, stored.map(names), self.plan.source());
        let treatment = treatment(self.plan, declared, stored, definition, &mut self.converters);
        channel.topic = Topic::new(name, treatment, self.plan, self.settings);
        if channel.topic.report.action == Action::LeftOut {
            return Ok(Ok(channel));
        }
        let converted = channel.topic.converted.clone();
        let opened = if let Some(converted) = converted {
            self.subscribe(&channel.topic, declared, converted.converter.target())?
        } else if ty.starts_with(&format!("{PX4_ROS_PACKAGE}/msg/")) {
            match self.stated(*schema, &ty) {
                Ok(stated) => {
                    let opened = self.subscribe(&channel.topic, declared, stated.root())?;
                    channel.content = Content::Messages(Some(stated));
                    opened
                }
                Err(reason) => Err(format!("its schema can't be used: {reason}")),
            }
        } else {
            Err("its type isn't in px4_msgs".to_owned())
        };
        Ok(opened.map(|opened| {
            (channel.id, channel.timestamp) = (opened.id, opened.timestamp);
            channel.topic.report.renamed = Some(opened.name);
            channel
        }))
    }

    /// The type that a schema states. Fails if the types of all channels have too many fields.
    fn stated(&mut self, schema: u16, ty: &str) -> Result<Arc<Stated>, String> {
        let text = self.declarations.schema(schema).map_or(&[][..], |(_, _, text)| text);
        let too_many = || format!("the types of the bag have more than {MAX_LOG_FIELDS} fields");
        if self.fields > MAX_LOG_FIELDS {
            return Err(too_many());
        }
        let stated = self.plan.source().shared.stated(ty, text)?;
        self.fields = self.fields.saturating_add(FieldCounts::default().of(stated.root()).max(1));
        if self.fields > MAX_LOG_FIELDS { Err(too_many()) } else { Ok(stated) }
    }

    /// Subscribes a topic. The inner error is the reason why the log can't contain it.
    fn subscribe(
        &mut self,
        topic: &Topic<'_>,
        declared: &Declared,
        ty: MessageType<'_>,
    ) -> Result<Result<Opened, String>, Error> {
        let Some(size) = ty.size() else {
            return Ok(Err("the size of its messages varies".to_owned()));
        };
        if size.padded > MAX_MESSAGE {
            return Ok(Err("its messages don't fit into a log".to_owned()));
        }
        let (name, first) = stated_topic(topic.output_name(), &declared.metadata)
            .unwrap_or_else(|| logged_topic(topic.output_name(), &self.topics_of(ty)));
        let is_valid = |letter: char| letter.is_ascii_alphanumeric() || letter == '_' || letter == '-';
        if name.is_empty() || !name.chars().all(is_valid) {
            return Ok(Err(format!("a log can't have a topic `{}`", name.escape_debug())));
        }
        let mut instances = first..=u8::MAX;
        let free = instances.find(|instance| !self.topics.contains(&(name.clone(), *instance)));
        let (Some(instance), Ok(id)) = (free, u16::try_from(self.topics.len())) else {
            return Ok(Err(format!("the log has no room for another instance of `{name}`")));
        };
        if let Err(reason) = self.formats.convert(&name, ty) {
            return Ok(Err(reason));
        }
        write(&mut self.data, b'A', &[&[instance], &id.to_le_bytes(), name.as_bytes()])?;
        self.topics.insert((name.clone(), instance));
        let is_time = |field: &&Field| {
            field.ty() == Type { element: Element::Scalar(Scalar::UInt64), shape: Shape::Single }
        };
        let timestamp = ty.field("timestamp").filter(is_time).map(|field| field.offset);
        let subject = SubjectName { name: &name, instance: (instance > 0).then_some(instance) };
        Ok(Ok(Opened { id, name: subject.to_string(), timestamp }))
    }

    /// The topics of a type. A type without a definition has its default topic.
    fn topics_of(&self, ty: MessageType<'_>) -> Vec<String> {
        let target = self.plan.target();
        let defined = target.message_of_type(&format!("{PX4_ROS_PACKAGE}/msg/{}", ty.name()));
        let topics = defined.map(|id| target.schema.message(id).topics.clone());
        topics.unwrap_or_else(|| vec![format_name(ty.name())])
    }

    /// Writes a message. `time` is the log time in µs. Returns the problem if the channel is unknown.
    fn message(&mut self, id: u16, time: u64, payload: &[u8]) -> Result<Option<String>, Error> {
        let Some(Some(channel)) = self.channels.get_mut(usize::from(id)) else {
            return Ok(Some(format!("a message refers to channel {id}, which hasn't been declared yet")));
        };
        if self.utc_offset.is_none()
            && matches!(channel.content, Content::Texts)
            && self.early_size + payload.len() <= MAX_IN_MEMORY
        {
            self.early_size += payload.len();
            self.early.push((id, payload.to_vec()));
            return Ok(None);
        }
        channel.topic.report.messages += 1;
        if channel.topic.report.action == Action::LeftOut {
            return Ok(None);
        }
        let restored = match channel.content {
            Content::Messages(_) => {
                if let Some(payload) = channel.record(payload) {
                    let (id, timestamp) = (channel.id, channel.timestamp);
                    let bytes = timestamp.and_then(|at| payload.get(at..)?.first_chunk());
                    let own = bytes.map(|bytes| u64::from_le_bytes(*bytes)).filter(|own| *own > 0);
                    if let Some(own) = own {
                        self.start.get_or_insert(own);
                        self.utc_offset.get_or_insert(i128::from(time) - i128::from(own));
                        self.write_early()?;
                    }
                    write(&mut self.data, b'D', &[&id.to_le_bytes(), &payload])?;
                    self.is_in_data = true;
                }
                return Ok(None);
            }
            Content::Texts => self.ros.log_of_text(payload, self.utc_offset.unwrap_or(0)),
            Content::Parameters => self.ros.log_of_parameters(payload),
        };
        match restored {
            Ok(Restored { mut initial, mut later, left_out }) => {
                if let Some(parts) = left_out {
                    channel.topic.report.reason.get_or_insert_with(|| format!("{parts} are left out"));
                }
                if self.is_in_data {
                    later.splice(0..0, std::mem::take(&mut initial));
                }
                self.define(initial);
                for (kind, payload) in later {
                    write(&mut self.data, kind, &[&payload])?;
                }
            }
            Err(error) => channel.topic.unreadable(error),
        }
        Ok(None)
    }

    /// Writes the texts that precede the first message with a time.
    fn write_early(&mut self) -> Result<(), Error> {
        for (id, payload) in std::mem::take(&mut self.early) {
            self.message(id, 0, &payload)?;
        }
        Ok(())
    }

    /// Reads an attachment with event metadata.
    fn attachment(&mut self, (length, at): (u64, u64), bytes: &[u8]) {
        if at == 0 {
            let head = AttachmentHead::read(bytes);
            let is_metadata = head.is_some_and(|head| EVENT_METADATA.iter().any(|name| head.is_named(name)));
            let is_used = is_metadata && length <= MAX_ATTACHED_EVENTS;
            self.has_other_parts |= !is_used;
            self.metadata = is_used.then(Vec::new);
        }
        let Some(body) = &mut self.metadata else { return };
        body.extend_from_slice(bytes);
        if at + (bytes.len() as u64) < length {
            return;
        }
        let body = self.metadata.take().unwrap_or_default();
        if let Some(data) = AttachmentHead::read(&body).and_then(|head| head.data(&body)) {
            self.define(information::pieces("uint8_t", Metadata::KEY, data));
        }
    }

    /// Writes the log.
    fn finish(mut self, output: &mut dyn Write) -> Result<(Vec<TopicReport>, Problems), Error> {
        self.utc_offset.get_or_insert(0);
        self.write_early()?;
        if self.has_other_parts {
            self.problems.note("other attachments and metadata records are left out");
        }
        let mut output = BufWriter::new(output);
        output.write_all(&ULOG_MAGIC)?;
        output.write_all(&[VERSION])?;
        output.write_all(&self.start.unwrap_or(0).to_le_bytes())?;
        let mut flags = [0; FLAG_BITS];
        flags[0] = u8::from(self.definitions.iter().any(|(kind, _)| *kind == b'Q'));
        write(&mut output, b'B', &[&flags])?;
        for (name, fields) in self.formats.take_new() {
            write(&mut output, b'F', &[name.as_bytes(), b":", fields.as_bytes()])?;
        }
        for (kind, payload) in &self.definitions {
            write(&mut output, *kind, &[payload])?;
        }
        io::copy(&mut rewound(self.data)?, &mut output)?;
        output.flush()?;
        let topics = self.channels.into_iter().flatten().map(|channel| channel.topic.finish());
        Ok((topics.collect(), self.problems))
    }
}

/// The topic in a log and its instance, as the metadata of a channel states them. `None` if the channel was renamed.
fn stated_topic(topic: &str, metadata: &BTreeMap<String, String>) -> Option<(String, u8)> {
    let (name, instance) = (metadata.get(TOPIC)?, metadata.get(INSTANCE)?.parse().ok()?);
    is_exchanged(topic).then_some(())?;
    topic_of(topic).starts_with(name.as_str()).then(|| (name.clone(), instance))
}

/// The topic in a log for a topic of ROS 2, and its instance. A topic outside of PX4's folders gets the first topic of its type.
/// `known` contains the topics of its type. PX4 appends the
/// instance to the name, and then the version of the message.
fn logged_topic(topic: &str, known: &[String]) -> (String, u8) {
    let last = topic_of(topic);
    let name = unversioned(last).unwrap_or(last);
    let is_known = |name: &str| known.iter().any(|known| known == name);
    let base = name.trim_end_matches(|letter: char| letter.is_ascii_digit());
    let instance = name[base.len()..].parse().ok().filter(|_| !is_known(name));
    let base = [base, base.trim_end_matches('_')].into_iter().find(|base| is_known(base));
    match (base.zip(instance), known.first()) {
        (Some((base, instance)), _) => (base.to_owned(), instance),
        (None, Some(first)) if !is_known(name) && !is_exchanged(topic) => (first.clone(), 0),
        _ => (name.to_owned(), 0),
    }
}

impl Channel<'_> {
    /// Converts a message of a topic. `None` if it is unreadable.
    fn record(&mut self, payload: &[u8]) -> Option<Vec<u8>> {
        match &self.content {
            Content::Messages(Some(stated)) => {
                let converted = log_of_stated(stated, payload);
                converted.map_err(|error| self.topic.unreadable(error)).ok()
            }
            _ => self.topic.convert(|converted, losses| converted.log_of_cdr(payload, losses)),
        }
    }
}

impl Converted<'_> {
    /// Converts a CDR payload to the payload of a log, and counts the losses.
    fn log_of_cdr(&self, payload: &[u8], losses: &mut [u64]) -> Result<Vec<u8>, String> {
        let message = self.source().decode_cdr(&decompressed(payload)?).map_err(|error| error.to_string())?;
        if self.converter.keeps_cdr() {
            return log_payload(&message);
        }
        log_payload(&self.message(&message, losses)?)
    }
}

/// Converts a CDR payload with the type that its schema states.
fn log_of_stated(stated: &Stated, payload: &[u8]) -> Result<Vec<u8>, String> {
    let payload: Cow<'_, [u8]> = decompressed(payload)?;
    log_payload(&stated.root().decode_cdr(&payload).map_err(|error| error.to_string())?)
}
