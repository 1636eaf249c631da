//! Converts MCAP files with messages of PX4 to PX4 logs.

use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap};
use std::io::{self, BufWriter, Read, Seek as _, SeekFrom, Write};
use std::sync::Arc;

use tempfile::SpooledTempFile;
use uavspec_capture::ULOG_MAGIC;
use uavspec_capture::input::UpToError;
use uavspec_capture::mcap::{AttachmentHead, EVENT_METADATA, Event, Item, Reader, metadata};
use uavspec_dynamic::MessageType;
use uavspec_model::limits::MAX_NAME;
use uavspec_model::text::start_of;
use uavspec_px4::format::format_name;
use uavspec_rules::definitions::{PX4_ROS_PACKAGE, Stated, is_exchanged, plain_name, unversioned};
use uavspec_schema::limits::MAX_EVENTS_LEN;

use super::information::{self, LogMessage};
use super::mcap::{Declarations, Declared, another_file, names, treatment};
use super::plan::{Converted, Converters, Plan, Treatment};
use super::report::{Action, Problems, TopicReport};
use super::ros::Ros;
use super::topic::Topic;
use super::ulog::formats::Formats;
use super::ulog::{MAX_MESSAGE, log_payload, write};
use super::{Error, Settings};
use crate::limits::{MAX_INFORMATION, MAX_WAITING};
use crate::log::Metadata;
use crate::{decompressed, definition_of, topic_of};

/// The version of the log format.
const VERSION: u8 = 1;

/// The size of the flag bits, in bytes.
const FLAG_BITS: usize = 40;

/// The content of a channel.
enum Content {
    /// Messages of a topic. `None` if they have a defined type.
    Messages(Option<Arc<Stated>>),
    Texts,
    Parameters,
}

struct Channel<'p> {
    topic: Topic<'p>,
    content: Content,
    /// The id of the subscription.
    id: u16,
    /// The offset of the time in a message of the log.
    timestamp: Option<usize>,
}

struct Stream<'p> {
    plan: &'p Plan,
    settings: Settings,
    ros: &'p Ros,
    problems: Problems,
    converters: Converters<'p>,
    declarations: Declarations,
    /// The types that the schemas state, by the id of the schema.
    stated: HashMap<u16, Result<Arc<Stated>, String>>,
    /// The channels by id.
    channels: Vec<Option<Channel<'p>>>,
    /// The topics in the log, with their instances.
    topics: BTreeSet<(String, u8)>,
    formats: Formats,
    /// The messages before the formats, and the parameters at the start.
    definitions: Vec<LogMessage>,
    /// The total size of these messages, in bytes.
    size: usize,
    has_defaults: bool,
    /// The data section.
    data: BufWriter<SpooledTempFile>,
    /// True after the first message.
    is_in_data: bool,
    /// The start of the log, in µs of the vehicle's clock.
    start: Option<u64>,
    /// The difference between UTC and the vehicle's clock, in µs.
    utc_offset: Option<u64>,
    /// The attachment with event metadata that is being read.
    metadata: Option<Vec<u8>>,
}

/// Converts a file. Returns the topics and the parts that can't be read.
pub(super) fn convert(
    input: impl Read,
    plan: &Plan,
    settings: Settings,
    output: &mut dyn Write,
) -> Result<(Vec<TopicReport>, Problems), Error> {
    let mut input = UpToError::new(input);
    let mut reader = Reader::new(&mut input);
    let ros = Ros::new()?;
    let mut stream = Stream {
        plan,
        settings,
        ros: &ros,
        problems: Problems::default(),
        converters: Converters::default(),
        declarations: Declarations::default(),
        stated: HashMap::new(),
        channels: Vec::new(),
        topics: BTreeSet::new(),
        formats: Formats::default(),
        definitions: Vec::new(),
        size: 0,
        has_defaults: false,
        data: BufWriter::new(SpooledTempFile::new(MAX_WAITING)),
        is_in_data: false,
        start: None,
        utc_offset: None,
        metadata: None,
    };
    let mut has_header = false;
    while let Ok(Some(item)) = reader.next() {
        if matches!(item.event, Event::Header { .. }) && std::mem::replace(&mut has_header, true) {
            stream.problems.add(another_file(item.offset));
            break;
        }
        stream.item(item)?;
    }
    let bytes = reader.bytes();
    if let Some(error) = &input.error {
        stream.problems.add(format!("byte {bytes}: the rest is unreadable: {error}"));
    }
    stream.finish(output)
}

impl<'p> Stream<'p> {
    fn item(&mut self, item: Item<'_>) -> Result<(), Error> {
        let found = match item.event {
            Event::Schema { id, name, encoding, text } => {
                self.declarations.add_schema(id, (name, encoding), text)
            }
            Event::Channel { id, schema, topic, encoding, metadata } => {
                let at = usize::from(id);
                if self.channels.get(at).is_none_or(Option::is_none) {
                    self.channels.resize_with(self.channels.len().max(at + 1), || None);
                    let declared = Declared { id, schema, topic, encoding, metadata, digest: 0 };
                    self.channels[at] = Some(self.channel(&declared)?);
                }
                None
            }
            Event::Message { channel, time, payload, .. } => self.message(channel, time / 1_000, payload)?,
            Event::Attachment { length, at, bytes } => {
                self.attachment((length, at), bytes);
                None
            }
            Event::Metadata { body } => {
                if let Some((name, values)) = metadata(body) {
                    let [start, utc_offset] = information::read_times(&name, &values);
                    (self.start, self.utc_offset) = (start.or(self.start), utc_offset.or(self.utc_offset));
                    self.define(information::messages(&name, &values));
                }
                None
            }
            Event::Problem(problem) => Some(problem.to_string()),
            Event::Header { .. } | Event::Private { .. } => None,
        };
        if let Some(problem) = found {
            self.problems.add(format!("byte {}: {problem}", item.offset));
        }
        Ok(())
    }

    /// Adds messages to the definitions section.
    fn define(&mut self, messages: Vec<LogMessage>) {
        for (kind, payload) in messages {
            self.size += payload.len();
            if self.size > MAX_INFORMATION {
                let limit = MAX_INFORMATION >> 20;
                let problem = format!("the information and the parameters take more than {limit} MiB");
                return self.problems.add(problem);
            }
            self.has_defaults |= kind == b'Q';
            self.definitions.push((kind, payload));
        }
    }

    fn channel(&mut self, declared: &Declared) -> Result<Channel<'p>, Error> {
        let Declared { schema, topic: name, encoding, metadata, .. } = declared;
        let left_out = |reason: String| Channel {
            topic: Topic::left_out(&start_of(name, MAX_NAME), reason),
            content: Content::Messages(None),
            id: 0,
            timestamp: None,
        };
        if let Some(reason) = self.declarations.refusal(*schema, name, encoding, metadata) {
            return Ok(left_out(reason));
        }
        if encoding != "cdr" {
            return Ok(left_out("its messages aren't CDR".to_owned()));
        }
        let stored = self.declarations.schema(*schema);
        let ty = stored.map(|(name, _, _)| plain_name(name)).unwrap_or_default();
        let of_ros = [Content::Texts, Content::Parameters].into_iter().zip(self.ros.channels());
        if let Some((content, (_, known, _))) = of_ros.into_iter().find(|(_, (_, known, _))| known.name == ty)
        {
            if self.stated(*schema, &ty).is_ok_and(|stated| stated.type_hash != known.hash) {
                return Ok(left_out("its type differs from the definition of ROS 2".to_owned()));
            }
            let mut topic = Topic::new(name, (None, Treatment::Copy), self.plan, self.settings);
            topic.report.action = Action::Converted;
            return Ok(Channel { topic, content, id: 0, timestamp: None });
        }
        let definition = definition_of(name, stored.map(names), self.plan.source());
        let treatment = treatment(self.plan, declared, stored, definition, &mut self.converters);
        let mut topic = Topic::new(name, treatment, self.plan, self.settings);
        let mut stated = None;
        if topic.report.action == Action::Copied {
            if !ty.starts_with(&format!("{PX4_ROS_PACKAGE}/msg/")) {
                return Ok(left_out("it isn't a topic of PX4".to_owned()));
            }
            match self.stated(*schema, &ty) {
                Ok(found) => stated = Some(found),
                Err(reason) => return Ok(left_out(format!("its schema can't be used: {reason}"))),
            }
        }
        let target = topic.converted.as_deref().map(|converted| converted.converter.target());
        let target = target.or_else(|| stated.as_deref().map(Stated::root));
        let opened = target.map(|target| self.subscribe(topic.output_name(), target)).transpose()?;
        let (mut id, mut timestamp) = (0, None);
        match opened {
            Some(Ok(opened)) => {
                timestamp = target.and_then(|target| target.field("timestamp")).map(|field| field.offset);
                topic.report.renamed = Some(opened.1);
                id = opened.0;
            }
            Some(Err(reason)) => topic.leave_out(reason),
            None => {}
        }
        Ok(Channel { topic, content: Content::Messages(stated), id, timestamp })
    }

    /// The type that a schema states.
    fn stated(&mut self, schema: u16, ty: &str) -> Result<Arc<Stated>, String> {
        let text = self.declarations.schema(schema).map_or(&[][..], |(_, _, text)| text);
        let read = || self.plan.source().shared.stated(ty, text);
        self.stated.entry(schema).or_insert_with(read).clone()
    }

    /// Subscribes a topic. Returns the id and the name of the topic in the log, or the reason why the log can't contain it.
    fn subscribe(
        &mut self,
        topic: &str,
        ty: MessageType<'_>,
    ) -> Result<Result<(u16, String), String>, Error> {
        if ty.size().is_none_or(|size| size.padded > MAX_MESSAGE) {
            return Ok(Err("its messages don't fit into a log".to_owned()));
        }
        let (name, first) = logged_topic(topic, &self.topics_of(ty));
        let mut instances = first..=u8::MAX;
        let free = instances.find(|instance| !self.topics.contains(&(name.clone(), *instance)));
        let Some(instance) = free else {
            return Ok(Err(format!("the log has 256 instances of `{name}`")));
        };
        let Ok(id) = u16::try_from(self.topics.len()) else {
            return Ok(Err("the log has 65,536 topics".to_owned()));
        };
        if let Err(reason) = self.formats.convert(&name, ty) {
            return Ok(Err(reason));
        }
        write(&mut self.data, b'A', &[&[instance], &id.to_le_bytes(), name.as_bytes()])?;
        self.topics.insert((name.clone(), instance));
        let shown = if instance == 0 { name } else { format!("{name} (instance {instance})") };
        Ok(Ok((id, shown)))
    }

    /// The topics of a type, or the default topic of a type without a definition.
    fn topics_of(&self, ty: MessageType<'_>) -> Vec<String> {
        let target = self.plan.target();
        let defined = target.message_of_type(&format!("{PX4_ROS_PACKAGE}/msg/{}", ty.name()));
        let topics = defined.map(|id| target.schema.message(id).topics.clone());
        topics.unwrap_or_else(|| vec![format_name(ty.name())])
    }

    /// Writes a message. `time` is the log time in µs. Returns the problem if the channel is unknown.
    fn message(&mut self, channel: u16, time: u64, payload: &[u8]) -> Result<Option<String>, Error> {
        let Some(Some(Channel { topic, content, id, timestamp })) =
            self.channels.get_mut(usize::from(channel))
        else {
            return Ok(Some(format!(
                "a message refers to channel {channel}, which hasn't been declared yet"
            )));
        };
        topic.report.messages += 1;
        if topic.report.action == Action::LeftOut {
            return Ok(None);
        }
        let is_in_data = self.is_in_data;
        let read = match content {
            Content::Messages(stated) => {
                let converted = match stated {
                    None => topic.convert(|converted, losses| converted.log_of_cdr(payload, losses)),
                    Some(stated) => {
                        let converted = log_of_stated(stated, payload);
                        converted.map_err(|error| topic.unreadable(error)).ok()
                    }
                };
                if let Some(payload) = converted {
                    let bytes = timestamp.and_then(|at| payload.get(at..)?.first_chunk());
                    let own = bytes.map_or(time, |bytes| u64::from_le_bytes(*bytes));
                    self.is_in_data = true;
                    self.start.get_or_insert(own);
                    self.utc_offset.get_or_insert(time.saturating_sub(own));
                    write(&mut self.data, b'D', &[&id.to_le_bytes(), &payload])?;
                }
                return Ok(None);
            }
            Content::Texts => self.ros.log_of_text(payload, self.utc_offset.unwrap_or(0)),
            Content::Parameters => self.ros.log_of_parameters(payload),
        };
        match read {
            Ok(messages) if matches!(content, Content::Parameters) && !is_in_data => self.define(messages),
            Ok(messages) => {
                for (kind, payload) in messages {
                    write(&mut self.data, kind, &[&payload])?;
                }
            }
            Err(error) => topic.unreadable(error),
        }
        Ok(None)
    }

    /// Reads an attachment with event metadata.
    fn attachment(&mut self, (length, at): (u64, u64), bytes: &[u8]) {
        if at == 0 {
            let head = AttachmentHead::read(bytes);
            let is_metadata = head.is_some_and(|head| EVENT_METADATA.iter().any(|name| head.is_named(name)));
            self.metadata = (is_metadata && length <= MAX_EVENTS_LEN as u64).then(Vec::new);
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
        let mut output = BufWriter::new(output);
        output.write_all(&ULOG_MAGIC)?;
        output.write_all(&[VERSION])?;
        output.write_all(&self.start.unwrap_or(0).to_le_bytes())?;
        let mut flags = [0; FLAG_BITS];
        flags[0] = u8::from(self.has_defaults);
        write(&mut output, b'B', &[&flags])?;
        for (name, fields) in self.formats.take_new() {
            write(&mut output, b'F', &[name.as_bytes(), b":", fields.as_bytes()])?;
        }
        for (kind, payload) in &self.definitions {
            write(&mut output, *kind, &[payload])?;
        }
        let mut data = self.data.into_inner().map_err(io::IntoInnerError::into_error)?;
        let end = data.stream_position()?;
        data.seek(SeekFrom::Start(0))?;
        io::copy(&mut data.take(end), &mut output)?;
        output.flush()?;
        let topics = self.channels.into_iter().flatten().map(|channel| channel.topic.finish());
        Ok((topics.collect(), self.problems))
    }
}

/// The topic in a log for a topic of ROS 2, and its instance. `known` contains the topics of its type. PX4 appends the
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

impl Converted<'_> {
    /// Converts a CDR payload to the payload of a log, and counts the losses.
    fn log_of_cdr(&self, payload: &[u8], losses: &mut [u64]) -> Result<Vec<u8>, String> {
        let message = self.source.decode_cdr(&decompressed(payload)?).map_err(|error| error.to_string())?;
        log_payload(&self.message(&message, losses)?)
    }
}

/// Converts a CDR payload with the type that its schema states.
fn log_of_stated(stated: &Stated, payload: &[u8]) -> Result<Vec<u8>, String> {
    let payload: Cow<'_, [u8]> = decompressed(payload)?;
    log_payload(&stated.root().decode_cdr(&payload).map_err(|error| error.to_string())?)
}
