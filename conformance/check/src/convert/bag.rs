//! Converts the files of bags: MCAP and `SQLite`.

mod declarations;
mod json_schema;
mod source;
mod target;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Read, Seek as _, SeekFrom, Write};

use mcap::records::MessageHeader;
use tempfile::SpooledTempFile;
use uavspec_capture::mcap::{AttachmentHead, Event, Item, Packing, compressed};
use uavspec_model::json::Tree;
use uavspec_model::limits::MAX_NAME;
use uavspec_model::text::{start_of, utf8};
use uavspec_rules::definitions::{Definitions, plain_name};
use uavspec_runtime::cdr::ByteOrder;
use uavspec_schema::{MessageId, derived_from};

use self::declarations::too_large;
pub(super) use self::declarations::{Declarations, Declared, Schema, declared_again, names};
pub(super) use self::source::{PROFILE, Source};
use self::target::Content;
pub(super) use self::target::{Distribution, Origin, Target};
use super::plan::{Converted, Converters, Plan, Treatment};
use super::report::{Action, Problems, TopicReport};
use super::topic::Topic;
use super::{Error, Settings};
use crate::limits::{MAX_ATTACHMENT, MAX_WAITING};
use crate::{HASH, StatedType, confirms, decompressed, definition_of, digest, is_guess, stated_type};

struct Channel<'p> {
    topic: Topic<'p>,
    /// The id in the output.
    id: u16,
    /// A hash of the declaration.
    digest: u64,
    is_json: bool,
    /// True if messages that were compressed separately are decompressed.
    is_unpacked: bool,
    /// The guess about the type of a JSON channel. `None` once it is decided. Until then, the output doesn't contain
    /// the channel.
    guess: Option<Box<Guess>>,
}

/// A JSON channel whose name suggests a type. The first non-empty message decides whether it has this type.
struct Guess {
    message_id: MessageId,
    declared: Declared,
    /// The messages so far.
    waiting: Vec<(MessageHeader, Vec<u8>)>,
    /// The size of these messages, in bytes.
    size: usize,
}

struct Stream<'p, 'c, 'o> {
    plan: &'p Plan,
    settings: Settings,
    output: &'c mut Target<'o>,
    converters: &'c mut Converters<'p>,
    declarations: Declarations,
    unpacked: Unpacked,
    /// The total size of the messages that wait for a decision, in bytes.
    waiting_size: usize,
    /// The channels, by id.
    channels: Vec<Option<Box<Channel<'p>>>>,
    /// The attachment that is being read.
    attachment: Option<SpooledTempFile>,
}

/// The messages that are decompressed, if they were compressed separately. Only the metadata of a bag says whether they
/// were, but CDR can't be confused with compressed data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unpacked {
    None,
    Cdr,
    All,
}

/// Converts a file, and writes it to the output, which may already contain other files of the bag. Returns the topics. Adds
/// the parts that can't be read.
pub(super) fn convert<'p>(
    source: Source<'_, impl Read>,
    (plan, settings, unpacked): (&'p Plan, Settings, Unpacked),
    output: &mut Target<'_>,
    converters: &mut Converters<'p>,
    problems: &mut Problems,
) -> Result<Vec<TopicReport>, Error> {
    if let Some(database) = source.database {
        output.take_distribution(database.bag.distribution());
    }
    output.next_input();
    let mut stream = Stream {
        plan,
        settings,
        output,
        converters,
        declarations: Declarations::default(),
        unpacked,
        waiting_size: 0,
        channels: Vec::new(),
        attachment: None,
    };
    let bytes = source.read(problems, |item, problems| stream.item(item, problems))?;
    // The remaining guesses were wrong.
    for at in 0..stream.channels.len() {
        if let Some(problem) = stream.decide(at, None)? {
            problems.add(format!("byte {bytes}: {problem}"));
        }
    }
    let channels = stream.channels.into_iter().flatten();
    Ok(channels.map(|channel| channel.topic.finish()).collect())
}

impl Stream<'_, '_, '_> {
    fn item(&mut self, item: Item<'_>, problems: &mut Problems) -> Result<(), Error> {
        let profile = if let Event::Header { profile, .. } = &item.event { profile } else { "" };
        self.output.start(profile)?;
        if matches!(item.event, Event::Schema { .. } | Event::Channel { .. } | Event::Message { .. }) {
            self.output.set_packing(item.packing)?;
        }
        let found = match item.event {
            Event::Schema { id, name, encoding, text } => {
                self.declarations.add_schema(id, (name, encoding), text)
            }
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
            // A SQLite file has no offsets.
            let place = if item.offset > 0 { format!("byte {}: ", item.offset) } else { String::new() };
            problems.add(place + &problem);
        }
        Ok(())
    }

    /// Declares a channel. Returns the problem if it is left out.
    fn channel(
        &mut self,
        id: u16,
        schema: u16,
        (topic, encoding): (String, String),
        metadata: BTreeMap<String, String>,
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
        if let Some(reason) = self.declarations.refusal(schema, &topic, &encoding, &metadata) {
            let problem = format!("channel {id}: {reason}");
            let topic = Topic::left_out(&start_of(&topic, MAX_NAME), reason);
            let channel = Channel { topic, id, digest, is_json, is_unpacked: false, guess: None };
            self.channels[at] = Some(Box::new(channel));
            return Ok(Some(problem));
        }
        let plan = self.plan;
        let source = plan.source();
        let names = self.declarations.schema(schema).map(names);
        let definition = definition_of(&topic, names, source);
        let is_undecided = |id: &MessageId| {
            is_json && !plan.keeps_types() && plan.concerns(*id) && is_guess(&topic, names, *id, source)
        };
        let guess = definition.filter(is_undecided);
        let declared = Declared { id, schema, topic, encoding, metadata, digest };
        let Some(message_id) = guess else { return self.declare(declared, definition) };
        let topic = Topic::new(&declared.topic, (None, Treatment::Copy), plan, self.settings);
        let guess = Some(Box::new(Guess { message_id, declared, waiting: Vec::new(), size: 0 }));
        self.channels[at] = Some(Box::new(Channel { topic, id, digest, is_json, is_unpacked: false, guess }));
        Ok(None)
    }

    /// Writes the declaration of a channel, and opens the channel. `definition` is the definition of its messages. Returns
    /// the problem if the channel is left out.
    fn declare(
        &mut self,
        declared: Declared,
        definition: Option<MessageId>,
    ) -> Result<Option<String>, Error> {
        let plan = self.plan;
        let stored = self.declarations.schema(declared.schema);
        let treatment = if plan.keeps_types() {
            (None, Treatment::Copy)
        } else {
            treatment(plan, &declared, stored, definition, self.converters)
        };
        let Declared { id, schema, topic, encoding, mut metadata, digest } = declared;
        let is_json = encoding == "json";
        let topic = Topic::new(&topic, treatment, plan, self.settings);
        let stored = self.declarations.digest(schema);
        let origin = match &topic.converted {
            Some(converted) => {
                let target = converted.conversion.to;
                if !is_json || metadata.contains_key(HASH) {
                    metadata.insert(HASH.to_owned(), plan.target_type(target).1);
                }
                if is_json { Origin::Json(target, stored) } else { Origin::Target(target) }
            }
            None => Origin::Input(stored),
        };
        let is_unpacked = match self.unpacked {
            Unpacked::None => false,
            Unpacked::Cdr => encoding == "cdr",
            Unpacked::All => true,
        };
        let mut channel = Channel { id, is_json, is_unpacked, digest, guess: None, topic };
        if channel.topic.report.action != Action::LeftOut {
            let content = || content(plan, self.declarations.schema(schema), origin);
            let Some(content) = self.output.schema(origin, content)? else {
                channel.topic.leave_out(too_large());
                self.channels[usize::from(id)] = Some(Box::new(channel));
                return Ok(Some(format!("channel {id}: {}", too_large())));
            };
            let is_copied = matches!(origin, Origin::Input(_));
            let lacks_hash = metadata.get(HASH).is_none_or(String::is_empty);
            if self.output.is_database() && is_copied && lacks_hash {
                // The hash distinguishes several definitions of a type.
                metadata.extend(self.hash(schema).map(|hash| (HASH.to_owned(), hash)));
            }
            let names = (channel.topic.output_name(), &*encoding);
            match self.output.channel((id, content), names, metadata)? {
                Some(id) => channel.id = id,
                None => channel.topic.leave_out(
                    "another topic has a different definition of this type, and a SQLite file can't distinguish them \
                     without type hashes"
                        .to_owned(),
                ),
            }
        }
        self.channels[usize::from(id)] = Some(Box::new(channel));
        Ok(None)
    }

    /// The type hash of a schema of the input. `None` if it isn't the definition of a message.
    fn hash(&self, schema: u16) -> Option<String> {
        let (name, encoding, text) = self.declarations.schema(schema)?;
        let is_message = encoding == "ros2msg" && derived_from(&plain_name(name)).is_none();
        let stated = is_message.then(|| self.plan.source().shared.stated(name, text))?.ok()?;
        Some(stated.type_hash.clone())
    }

    /// Writes a message. Returns the problem if its channel is unknown, or is left out from now on.
    fn message(&mut self, header: MessageHeader, payload: &[u8]) -> Result<Option<String>, Error> {
        let id = header.channel_id;
        let Some(channel) = self.channels.get_mut(usize::from(id)).and_then(Option::as_deref_mut) else {
            return Ok(Some(format!("a message refers to channel {id}, which hasn't been declared yet")));
        };
        let Some(guess) = &mut channel.guess else {
            channel.write(header, payload, self.output)?;
            return Ok(None);
        };
        let decision = guess.decision(payload, self.plan.source());
        let size = size_of::<(MessageHeader, Vec<u8>)>() + payload.len();
        guess.waiting.push((header, payload.to_vec()));
        guess.size += size;
        self.waiting_size += size;
        if decision.is_none() && self.waiting_size <= MAX_WAITING {
            return Ok(None);
        }
        let definition = Some(guess.message_id).filter(|_| decision == Some(true));
        let problem = self.decide(usize::from(id), definition)?;
        // The limit is exceeded.
        if decision.is_none()
            && let Some(channel) = self.channels.get_mut(usize::from(id)).and_then(Option::as_deref_mut)
        {
            let limit = MAX_WAITING >> 20;
            let reason = format!("more than {limit} MiB of messages precede the first non-empty one");
            channel.topic.report.reason.get_or_insert(reason);
        }
        Ok(problem)
    }

    /// Declares a channel whose guess is decided, and writes its waiting messages. These messages then follow later
    /// messages of other channels. Does nothing if the channel has no guess. Returns the problem if the channel is left
    /// out.
    fn decide(&mut self, at: usize, definition: Option<MessageId>) -> Result<Option<String>, Error> {
        let channel = self.channels.get_mut(at).and_then(Option::as_deref_mut);
        let Some(guess) = channel.and_then(|channel| channel.guess.take()) else { return Ok(None) };
        let Guess { declared, waiting, size, .. } = *guess;
        self.waiting_size -= size;
        let problem = self.declare(declared, definition)?;
        if let Some(channel) = self.channels.get_mut(at).and_then(Option::as_deref_mut) {
            for (header, payload) in waiting {
                channel.write(header, &payload, self.output)?;
            }
        }
        Ok(problem)
    }

    /// Copies a metadata record. Returns the problem if the record is left out, because its name doesn't fit into the
    /// index.
    fn metadata(&mut self, body: &[u8]) -> Result<Option<String>, Error> {
        let length = body.first_chunk().map_or(0, |length| u32::from_le_bytes(*length) as usize);
        if !self.declarations.has_room(length) {
            return Ok(Some(format!("a metadata record is left out: {}", too_large())));
        }
        self.output.metadata(body)?;
        Ok(None)
    }

    /// Copies an attachment when its last part has arrived. Returns the problem if it is left out. A truncated
    /// attachment is left out as well.
    fn attachment(&mut self, (length, at): (u64, u64), bytes: &[u8]) -> Result<Option<String>, Error> {
        if at == 0 {
            // The index contains both texts.
            let head = AttachmentHead::read(bytes);
            let names = head.map_or(0, |head| head.name.len() + head.media_type.len());
            if !self.declarations.has_room(names) {
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

impl Channel<'_> {
    /// Writes a message, unless it is left out.
    fn write(&mut self, header: MessageHeader, payload: &[u8], output: &mut Target<'_>) -> Result<(), Error> {
        self.topic.report.messages += 1;
        if self.topic.report.action == Action::LeftOut {
            return Ok(());
        }
        let payload = if self.is_unpacked { decompressed(payload) } else { Ok(Cow::Borrowed(payload)) };
        let payload = match payload {
            Ok(payload) => payload,
            Err(error) => {
                self.topic.unreadable(error);
                return Ok(());
            }
        };
        let is_json = self.is_json;
        let converted = match self.topic.report.action {
            Action::Converted => self.topic.convert(|converted, losses| {
                if is_json {
                    converted.json_payload(&payload, losses)
                } else {
                    converted.cdr(&payload, losses)
                }
            }),
            _ => Some(Cow::Borrowed(&*payload)),
        };
        let Some(converted) = converted else { return Ok(()) };
        output.message(&MessageHeader { channel_id: self.id, ..header }, &converted)?;
        Ok(())
    }
}

impl Guess {
    /// True if a payload confirms the guess, false if it refutes the guess. `None` if the payload doesn't decide it.
    fn decision(&self, payload: &[u8], definitions: &Definitions) -> Option<bool> {
        let message = Tree::read(utf8(payload).ok()?).ok()?;
        confirms(&message, self.message_id, definitions)
    }
}

/// The content of a schema in the output.
fn content<'s>(plan: &Plan, stored: Option<&'s Schema>, origin: Origin) -> Option<Content<'s>> {
    let definition = |message: MessageId| {
        let text = plan.target().bag_text(message).into_bytes();
        (plan.target_type(message).0.into(), "ros2msg".into(), text.into())
    };
    match origin {
        Origin::Target(message) => Some(definition(message)),
        Origin::Input(_) => {
            let (name, encoding, text) = stored?;
            Some((name.into(), encoding.into(), text.into()))
        }
        Origin::Json(message, _) => {
            let (_, encoding, text) = stored?;
            if encoding == "ros2msg" {
                return Some(definition(message));
            }
            // Other encodings can't be written. An empty text has no meaning.
            let has_text = encoding == "jsonschema" && !text.is_empty();
            let text = if has_text { json_schema::text(&plan.target().schema, message) } else { Vec::new() };
            Some((plan.target_type(message).0.into(), encoding.into(), text.into()))
        }
    }
}

/// The treatment of a channel whose messages have this definition. Also returns the release of its messages. A schema that
/// differs from the definition describes the messages.
pub(super) fn treatment<'p>(
    plan: &'p Plan,
    declared: &Declared,
    schema: Option<&Schema>,
    definition: Option<MessageId>,
    converters: &mut Converters<'p>,
) -> (Option<String>, Treatment<'p>) {
    let definitions = plan.source();
    let Declared { topic, encoding, metadata, .. } = declared;
    let stated = schema.map(|(name, encoding, text)| (name.as_str(), encoding.as_str(), &**text));
    let mut of_schema = || match stated {
        Some((name, "ros2msg", text)) if encoding == "cdr" => plan.of_schema((name, text), converters),
        _ => None,
    };
    let Some(id) = definition else {
        let compared = |target: &Definitions| {
            let id = definition_of(topic, schema.map(names), target).filter(|_| encoding == "cdr")?;
            Some(stated_type(stated, metadata, id, target))
        };
        return (None, of_schema().unwrap_or_else(|| plan.undefined(compared)));
    };
    if !plan.concerns(id) {
        return (None, of_schema().unwrap_or(Treatment::Copy));
    }
    let treatment = match encoding.as_str() {
        "cdr" => match stated_type(stated, metadata, id, definitions) {
            StatedType::Other => return (None, of_schema().unwrap_or_else(|| plan.differs(id))),
            // Only the type describes the fields of a CDR message.
            StatedType::Unknown if plan.is_release_unknown(id) => Plan::unknown_release(),
            StatedType::Same | StatedType::Unknown => plan.treatment(id, topic, converters),
        },
        "json" => plan.treatment(id, topic, converters),
        _ => Treatment::Copy,
    };
    (definitions.release_of(id).map(|release| release.label.clone()), treatment)
}

impl Converted<'_> {
    /// Converts a CDR payload, and counts the losses. A readable payload stays the same if its type has the same
    /// payloads in both releases.
    fn cdr<'m>(&self, payload: &'m [u8], losses: &mut [u64]) -> Result<Cow<'m, [u8]>, String> {
        let plain = decompressed(payload)?;
        let order = ByteOrder::of(&plain).map_err(|fault| fault.to_string())?;
        let message = self.source().decode_cdr(&plain).map_err(|error| error.to_string())?;
        if self.converter.keeps_cdr() {
            return Ok(Cow::Borrowed(payload));
        }
        let converted = self.message(&message, losses)?.to_cdr(order).map_err(|error| error.to_string())?;
        // A message that was compressed separately stays compressed.
        match plain {
            Cow::Borrowed(_) => Ok(Cow::Owned(converted)),
            Cow::Owned(_) => {
                compressed(Packing::Zstd, &converted).map(Cow::Owned).map_err(|error| error.to_string())
            }
        }
    }

    /// Converts a JSON payload, and counts the losses.
    fn json_payload<'m>(&self, payload: &'m [u8], losses: &mut [u64]) -> Result<Cow<'m, [u8]>, String> {
        let tree = Tree::read(utf8(payload)?).map_err(|error| error.to_string())?;
        // Foxglove writes bytes as base64, like rosbridge.
        let text = self.json(&tree, true, losses)?;
        Ok(text.map_or(Cow::Borrowed(payload), |text| Cow::Owned(text.into_bytes())))
    }
}
