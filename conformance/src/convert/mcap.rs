//! Converts MCAP files.

mod chunk;
mod record;
mod writer;

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::io::{self, Read, Seek as _, SeekFrom, Write};

use mcap::records::MessageHeader;
use tempfile::SpooledTempFile;
use uavspec_codegen::schema::MessageId;
use uavspec_runtime::cdr::ByteOrder;

use self::writer::Writer;
use super::plan::{Converted, Plan, Treatment};
use super::report::{Action, Loss, Problems, TopicReport};
use super::{Error, Settings};
use crate::capture::mcap::{Event, Item, Packing, Reader};
use crate::check::{HASH, decompressed, definition_of, states_other_type};

/// The maximum total length of the schemas in a file, in bytes.
const MAX_SCHEMAS: usize = 64 << 20;

/// The size of the attachments that are kept in memory, in bytes. A larger one is stored in a temporary file, until it
/// is complete.
const MAX_ATTACHMENT: usize = 16 << 20;

/// A schema: its name, encoding and text.
type Schema = (String, String, Vec<u8>);

/// The origin of a schema in the output.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Origin {
    /// The schema of the input with this id.
    Input(u16),
    /// A message of the target.
    Target(MessageId),
}

struct Channel<'p> {
    /// True if the messages are in the output.
    is_kept: bool,
    converted: Option<Box<Converted<'p>>>,
    /// The number of messages that contain the data of each loss.
    losses: Vec<u64>,
    topic: TopicReport,
}

struct Stream<'p, 'o> {
    plan: &'p Plan,
    settings: Settings,
    output: Writer<'o>,
    schemas: HashMap<u16, Schema>,
    schema_size: usize,
    /// The ids of the schemas in the output.
    written: HashMap<Origin, u16>,
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
    Ok((channels.map(|channel| channel.close()).collect(), problems))
}

impl<'p, 'o> Stream<'p, 'o> {
    fn new(plan: &'p Plan, settings: Settings, output: Writer<'o>) -> Self {
        Self {
            plan,
            settings,
            output,
            schemas: HashMap::new(),
            schema_size: 0,
            written: HashMap::new(),
            channels: Vec::new(),
            attachment: None,
        }
    }

    fn item(&mut self, item: Item<'_>, problems: &mut Problems) -> Result<(), Error> {
        let found = match item.event {
            Event::Schema { id, name, encoding, text } => self.schema(id, (name, encoding), text),
            Event::Channel { id, schema, topic, encoding, metadata } => {
                self.channel(id, schema, (topic, encoding), metadata)?;
                None
            }
            Event::Message { channel, time, publish_time, sequence, payload } => {
                let header = MessageHeader { channel_id: channel, sequence, log_time: time, publish_time };
                self.message(header, payload, item.packing)?
            }
            Event::Attachment { length, at, bytes } => {
                self.attachment((length, at), bytes)?;
                None
            }
            Event::Metadata { body } => {
                self.output.metadata(body)?;
                None
            }
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

    /// Chunks and the summary repeat schemas. The first declaration of an id is used.
    fn schema(&mut self, id: u16, (name, encoding): (String, String), text: &[u8]) -> Option<String> {
        if self.schemas.contains_key(&id) {
            return None;
        }
        if self.schema_size + text.len() > MAX_SCHEMAS {
            let limit = MAX_SCHEMAS >> 20;
            return Some(format!("schema {id}: the schemas take more than {limit} MiB"));
        }
        self.schema_size += text.len();
        self.schemas.insert(id, (name, encoding, text.to_vec()));
        None
    }

    fn channel(
        &mut self,
        id: u16,
        schema: u16,
        (topic, encoding): (String, String),
        mut metadata: BTreeMap<String, String>,
    ) -> Result<(), Error> {
        let at = usize::from(id);
        if self.channels.len() <= at {
            self.channels.resize_with(at + 1, || None);
        }
        if self.channels[at].is_some() {
            return Ok(());
        }
        let plan = self.plan;
        let stored = self.schemas.get(&schema);
        let treatment = treatment(plan, (&topic, &encoding), stored, &metadata);
        let mut channel =
            Channel { is_kept: true, converted: None, losses: Vec::new(), topic: new_topic(topic) };
        let name = &channel.topic.topic;
        match treatment {
            (_, Treatment::LeaveOut(reason)) if !self.settings.keeps_unconverted => {
                channel.topic.reason = Some(reason);
                channel.is_kept = false;
            }
            (from, Treatment::Convert(converted)) => {
                let target = converted.conversion.to;
                metadata.insert(HASH.to_owned(), plan.target_type(target).1.to_owned());
                channel.topic.renamed = plan.renamed(name, converted.conversion);
                let schema = self.written(Origin::Target(target))?;
                let name = channel.topic.renamed.as_ref().unwrap_or(name);
                self.output.channel((id, schema), (name, &encoding), &metadata);
                channel.topic.action = Action::Converted;
                channel.topic.from = from;
                channel.losses = vec![0; converted.conversion.losses.len()];
                channel.converted = Some(converted);
            }
            (_, treatment) => {
                if let Treatment::LeaveOut(reason) = treatment {
                    channel.topic.reason = Some(reason);
                }
                let schema = if stored.is_some() { self.written(Origin::Input(schema))? } else { 0 };
                self.output.channel((id, schema), (name, &encoding), &metadata);
                channel.topic.action = Action::Copied;
            }
        }
        self.channels[at] = Some(Box::new(channel));
        Ok(())
    }

    /// The id of a schema in the output. Writes the schema if necessary.
    fn written(&mut self, origin: Origin) -> Result<u16, Error> {
        if let Some(id) = self.written.get(&origin) {
            return Ok(*id);
        }
        let id = u16::try_from(self.written.len() + 1);
        let id =
            id.map_err(|_| Error::Write(io::Error::other("the output needs more than 65,535 schemas")))?;
        match origin {
            Origin::Input(schema) => {
                if let Some((name, encoding, text)) = self.schemas.get(&schema) {
                    self.output.schema(id, (name, encoding), text);
                }
            }
            Origin::Target(message) => {
                let text = self.plan.target_text(message);
                self.output.schema(id, (&self.plan.target_type(message).0, "ros2msg"), text.as_bytes());
            }
        }
        self.written.insert(origin, id);
        Ok(id)
    }

    /// Writes a message. Returns the problem if its channel is unknown.
    fn message(
        &mut self,
        header: MessageHeader,
        payload: &[u8],
        packing: Option<Packing>,
    ) -> Result<Option<String>, Error> {
        let id = header.channel_id;
        let Some(channel) = self.channels.get_mut(usize::from(id)).and_then(Option::as_deref_mut) else {
            return Ok(Some(format!("a message refers to channel {id}, which hasn't been declared yet")));
        };
        channel.topic.messages += 1;
        if !channel.is_kept {
            return Ok(None);
        }
        let converted = channel.converted.as_ref().filter(|converted| !converted.converter.keeps_cdr());
        let payload = match converted.map(|converted| converted.cdr(payload, &mut channel.losses)) {
            None => Cow::Borrowed(payload),
            Some(Ok(payload)) => Cow::Owned(payload),
            Some(Err(error)) => {
                channel.topic.unreadable += 1;
                channel.topic.error.get_or_insert(error);
                return Ok(None);
            }
        };
        self.output.set_packing(packing)?;
        self.output.message(&header, &payload)?;
        Ok(None)
    }

    /// Copies an attachment after its last part. A truncated attachment is left out.
    fn attachment(&mut self, (length, at): (u64, u64), bytes: &[u8]) -> Result<(), Error> {
        if at == 0 {
            self.attachment = Some(SpooledTempFile::new(MAX_ATTACHMENT));
        }
        let Some(body) = &mut self.attachment else { return Ok(()) };
        body.write_all(bytes)?;
        if at + bytes.len() as u64 == length {
            body.seek(SeekFrom::Start(0))?;
            self.output.attachment(length, body)?;
            self.attachment = None;
        }
        Ok(())
    }
}

/// The treatment of a channel, and the release of its messages.
fn treatment<'p>(
    plan: &'p Plan,
    (topic, encoding): (&str, &str),
    schema: Option<&Schema>,
    metadata: &BTreeMap<String, String>,
) -> (Option<String>, Treatment<'p>) {
    let definitions = plan.source();
    let names = schema.map(|(name, encoding, _)| (name.as_str(), encoding.as_str()));
    let Some(id) = definition_of(topic, names, definitions) else { return (None, Treatment::Copy) };
    if !plan.concerns(id) {
        return (None, Treatment::Copy);
    }
    let stated = schema.map(|(name, encoding, text)| (name.as_str(), encoding.as_str(), &**text));
    let treatment = match encoding {
        "cdr" if states_other_type(stated, metadata, id, definitions) => {
            let release = definitions.release_of(id).map_or("", |release| &release.title);
            Treatment::LeaveOut(format!("its fields differ from {release}"))
        }
        "cdr" => plan.treatment(id, topic),
        "json" => Treatment::LeaveOut("JSON messages of bags can't be converted".to_owned()),
        _ => Treatment::Copy,
    };
    (definitions.release_of(id).map(|release| release.label.clone()), treatment)
}

fn new_topic(topic: String) -> TopicReport {
    TopicReport {
        topic,
        renamed: None,
        action: Action::LeftOut,
        from: None,
        reason: None,
        messages: 0,
        unreadable: 0,
        error: None,
        losses: Vec::new(),
    }
}

impl Converted<'_> {
    /// Converts a CDR payload. Counts the losses.
    fn cdr(&self, payload: &[u8], losses: &mut [u64]) -> Result<Vec<u8>, String> {
        let payload = decompressed(payload)?;
        let order = ByteOrder::of(&payload).map_err(|fault| fault.to_string())?;
        let message = self.source.decode_cdr(&payload).map_err(|error| error.to_string())?;
        if self.converter.counts_losses() {
            self.converter.count_losses(&message, losses);
        }
        let converted = self.converter.convert(&message).map_err(|error| error.to_string())?;
        converted.to_cdr(order).map_err(|error| error.to_string())
    }
}

impl Channel<'_> {
    fn close(self) -> TopicReport {
        let Self { converted, losses, mut topic, .. } = self;
        if let Some(converted) = converted {
            let counted = converted.conversion.losses.iter().zip(losses).enumerate();
            let losses = counted.map(|(at, (loss, count))| Loss {
                text: loss.text.clone(),
                messages: converted.converter.is_counted(at).then_some(count),
            });
            topic.losses = losses.collect();
        }
        topic
    }
}
