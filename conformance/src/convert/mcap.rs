//! Converts MCAP files.

use std::collections::{BTreeMap, HashMap};
use std::io::{self, Read, Write};

use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{McapError, WriteOptions, Writer};
use uavspec_runtime::cdr::ByteOrder;

use super::plan::{Converted, Plan, Treatment};
use super::report::{Action, Problems, TopicReport};
use super::topic::Topic;
use super::{Error, Settings};
use crate::capture::mcap::{Event, Item, Reader};
use crate::check::{HASH, decompressed, definition_of, states_other_type};
use crate::definitions::Definitions;

/// The maximum total length of the schemas in a file, in bytes.
const MAX_SCHEMAS: usize = 64 << 20;

type Output<'o> = Writer<NoSeek<&'o mut dyn Write>>;

/// A schema: its name, encoding and text.
type Schema = (String, String, Vec<u8>);

struct Channel<'p> {
    /// The id in the output; `None` if the messages are left out.
    id: Option<u16>,
    topic: Topic<'p>,
}

struct Stream<'p, 'o> {
    plan: &'p Plan,
    settings: Settings,
    output: Output<'o>,
    schemas: HashMap<u16, Schema>,
    schema_size: usize,
    channels: HashMap<u16, Channel<'p>>,
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
            stream = Some(Stream::new(plan, settings, output, profile)?);
        }
        if let Some(stream) = &mut stream {
            stream.item(item, &mut problems)?;
        }
    }
    let Some(mut stream) = stream else { return Ok((Vec::new(), problems)) };
    stream.output.finish().map_err(failed)?;
    let channels = std::mem::take(&mut stream.channels);
    Ok((channels.into_values().map(|channel| channel.topic.finish()).collect(), problems))
}

/// An error of the writer.
fn failed(error: McapError) -> Error {
    Error::Write(match error {
        McapError::Io(error) => error,
        other => io::Error::other(other.to_string()),
    })
}

impl<'p, 'o> Stream<'p, 'o> {
    fn new(
        plan: &'p Plan,
        settings: Settings,
        output: &'o mut dyn Write,
        profile: String,
    ) -> Result<Self, Error> {
        let options = WriteOptions::new()
            .profile(profile)
            .library(format!("uavspec {}", env!("CARGO_PKG_VERSION")))
            .compression(None)
            .disable_seeking(true);
        let output = options.create(NoSeek::new(output)).map_err(failed)?;
        Ok(Self { plan, settings, output, schemas: HashMap::new(), schema_size: 0, channels: HashMap::new() })
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
                self.message(header, payload)?
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
        if self.channels.contains_key(&id) {
            return Ok(());
        }
        let plan = self.plan;
        let stored = self.schemas.get(&schema);
        let treatment = treatment(plan, (&topic, &encoding), stored, &metadata);
        let topic = Topic::new(&topic, treatment, plan, self.settings);
        let schema = match (&topic.converted, stored) {
            _ if topic.report.action == Action::LeftOut => None,
            (Some(converted), _) => {
                let (ty, hash) = plan.target_type(converted.conversion.to);
                let text = plan.target_text(converted.conversion.to);
                metadata.insert(HASH.to_owned(), hash.to_owned());
                Some(self.output.add_schema(&ty, "ros2msg", text.as_bytes()).map_err(failed)?)
            }
            (None, Some((name, encoding, text))) => {
                Some(self.output.add_schema(name, encoding, text).map_err(failed)?)
            }
            (None, None) => Some(0),
        };
        let mut add = |schema| {
            self.output.add_channel(schema, topic.output_name(), &encoding, &metadata).map_err(failed)
        };
        let channel = Channel { id: schema.map(&mut add).transpose()?, topic };
        self.channels.insert(id, channel);
        Ok(())
    }

    /// Writes a message. Returns the problem if its channel is unknown.
    fn message(&mut self, header: MessageHeader, payload: &[u8]) -> Result<Option<String>, Error> {
        let Some(channel) = self.channels.get_mut(&header.channel_id) else {
            return Ok(Some(format!(
                "a message refers to channel {}, which hasn't been declared yet",
                header.channel_id
            )));
        };
        channel.topic.report.messages += 1;
        let Some(id) = channel.id else { return Ok(None) };
        let header = MessageHeader { channel_id: id, ..header };
        let keeps_payload = |converted: &Converted<'_>| converted.converter.keeps_cdr();
        let written = if channel.topic.converted.as_deref().is_none_or(keeps_payload) {
            self.output.write_to_known_channel(&header, payload)
        } else {
            match channel.topic.convert(|converted, losses| converted.cdr(payload, losses)) {
                Some(payload) => self.output.write_to_known_channel(&header, &payload),
                None => return Ok(None),
            }
        };
        written.map_err(failed)?;
        Ok(None)
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
    let stated = schema.map(|(name, encoding, text)| (name.as_str(), encoding.as_str(), &**text));
    let Some(id) = definition_of(topic, names, definitions) else {
        let is_other = |target: &Definitions| {
            let id = definition_of(topic, names, target).filter(|_| encoding == "cdr");
            id.is_some_and(|id| states_other_type(stated, metadata, id, target))
        };
        return (None, plan.undefined(is_other));
    };
    if !plan.concerns(id) {
        return (None, Treatment::Copy);
    }
    let treatment = match encoding {
        "cdr" if states_other_type(stated, metadata, id, definitions) => plan.differs(id),
        "cdr" => plan.treatment(id, topic),
        "json" => Treatment::LeaveOut("JSON messages of bags can't be converted".to_owned()),
        _ => Treatment::Copy,
    };
    (definitions.release_of(id).map(|release| release.label.clone()), treatment)
}

impl Converted<'_> {
    /// Converts a CDR payload. Counts the losses.
    fn cdr(&self, payload: &[u8], losses: &mut [u64]) -> Result<Vec<u8>, String> {
        let payload = decompressed(payload)?;
        let order = ByteOrder::of(&payload).map_err(|fault| fault.to_string())?;
        let message = self.source.decode_cdr(&payload).map_err(|error| error.to_string())?;
        self.message(&message, losses)?.to_cdr(order).map_err(|error| error.to_string())
    }
}
