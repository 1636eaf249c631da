//! Converts PX4 logs to MCAP files with the messages that PX4 exchanges with ROS 2 applications.

mod timed;

use std::collections::{HashMap, HashSet};
use std::io::Read;
use std::sync::Arc;

use uavspec_capture::mcap::metadata_body;
use uavspec_capture::ulog::{Event, Item, Log, Record};
use uavspec_dynamic::MessageType;
use uavspec_model::{Location, SubjectName};
use uavspec_px4::event::{EventMetadata, RawEvent};
use uavspec_px4::format::{bag_text, message_name};
use uavspec_rules::definitions::{FROM_PX4, PX4_ROS_PACKAGE, versioned};
use uavspec_runtime::cdr::ByteOrder;

use self::timed::{Place, Timed};
use super::bag::{Origin, PROFILE, Target};
use super::information::Information;
use super::log::{self, Routes, Sink};
use super::plan::{Converted, Converters, Plan};
use super::report::{Action, Problems, TopicReport};
use super::ros::{self, Parameter, Ros, Text};
use super::topic::Topic;
use super::{Error, Settings};
use crate::limits::{MAX_CONVERTED_SCHEMAS, MAX_LOG_TOPICS, MAX_PARAMETERS};
use crate::log::Metadata;
use crate::{HASH, digest};

/// The metadata keys of a channel for the topic in the log, and for its instance.
pub(super) const TOPIC: &str = "ulog:topic";
pub(super) const INSTANCE: &str = "ulog:instance";

/// The topic with PX4's events.
const EVENT: &str = "event";

/// A topic of the log. Its first message declares the channel in the output.
struct Channel<'p> {
    topic: Topic<'p>,
    id: u16,
    /// Known from the first message on.
    opened: Option<Opened>,
}

struct Opened {
    is_event: bool,
    /// The offset of `timestamp` in the payload.
    timestamp: Option<usize>,
    /// The offset of the time of a satellite navigation receiver.
    utc: Option<usize>,
}

/// A message type of the output.
struct Type {
    name: String,
    text: String,
    hash: String,
    version: Option<u32>,
}

struct Stream<'p, 'o> {
    plan: &'p Plan,
    settings: Settings,
    output: Timed<'o>,
    ros: &'p Ros,
    problems: Problems,
    converters: Converters<'p>,
    channels: Vec<Channel<'p>>,
    /// The topics in the output.
    names: HashSet<String>,
    /// The channels by the topic and its instance.
    by_name: HashMap<(String, u8), usize>,
    /// The channels by the id of their subscription.
    routes: Routes,
    /// The total size of the schemas of all topics, in bytes.
    size: usize,
    /// The time of the previous message, in µs of the vehicle's clock.
    time: u64,
    information: Information,
    /// The log's event metadata. `None` after the definitions.
    metadata: Option<Metadata>,
    events: Option<Arc<EventMetadata>>,
    /// The parameters that haven't been written yet.
    parameters: Vec<Parameter>,
    is_in_data: bool,
    /// The memory for the next payload.
    buffer: Vec<u8>,
    /// The numbers of messages with texts and with parameters.
    counts: [u64; 2],
}

/// Converts a log. Returns the topics and the parts that can't be read.
pub(super) fn convert(
    input: impl Read,
    plan: &Plan,
    settings: Settings,
    mut output: Target<'_>,
) -> Result<(Vec<TopicReport>, Problems), Error> {
    output.start(PROFILE)?;
    let ros = Ros::new()?;
    let mut stream = Stream {
        plan,
        settings,
        output: Timed::new(output),
        ros: &ros,
        problems: Problems::default(),
        converters: Converters::default(),
        channels: Vec::new(),
        names: HashSet::new(),
        by_name: HashMap::new(),
        routes: Routes::default(),
        size: 0,
        time: 0,
        information: Information::default(),
        metadata: Some(Metadata::default()),
        events: None,
        parameters: Vec::new(),
        is_in_data: false,
        buffer: Vec::new(),
        counts: [0; 2],
    };
    log::read(input, &mut stream)?;
    stream.finish()
}

impl<'p> Stream<'p, '_> {
    /// Returns the id of a schema in the output. Writes the schema if necessary. `None` if the schemas take too much space.
    fn schema(&mut self, name: String, text: String) -> Result<Option<u16>, Error> {
        // Repeated schemas count, because each is parsed.
        self.size = self.size.saturating_add(name.len() + text.len());
        if self.is_full() {
            return Ok(None);
        }
        let origin = Origin::Input(digest(&(&name, &text)));
        let content = || Some((name.into(), "ros2msg".into(), text.into_bytes().into()));
        Ok(self.output.output.schema(origin, content)?)
    }

    /// True if the schemas take too much space.
    fn is_full(&self) -> bool {
        self.size > MAX_CONVERTED_SCHEMAS
    }

    fn channel<const COUNT: usize>(
        &mut self,
        (id, schema): (u16, u16),
        topic: &str,
        metadata: [(&str, String); COUNT],
    ) -> Result<(), Error> {
        let metadata = metadata.into_iter().map(|(key, value)| (key.to_owned(), value)).collect();
        self.output.output.channel((id, schema), (topic, "cdr"), metadata)?;
        Ok(())
    }

    /// Ends the definitions section: reads the event metadata, and writes the parameters.
    fn start_data(&mut self) -> Result<(), Error> {
        if std::mem::replace(&mut self.is_in_data, true) {
            return Ok(());
        }
        let metadata = self.metadata.take().unwrap_or_default();
        let events = match metadata.bytes() {
            Ok([]) => return self.write_parameters(false),
            Ok(bytes) => {
                self.output.output.event_metadata(bytes)?;
                self.plan.source().read_events(bytes).read.clone()
            }
            Err(error) => Err(error),
        };
        match events {
            Ok((events, _)) => self.events = Some(events),
            Err(error) => self.problems.add(format!("the log's event metadata can't be read: {error}")),
        }
        self.write_parameters(false)
    }

    /// Writes the parameters that haven't been written yet.
    fn write_parameters(&mut self, is_change: bool) -> Result<(), Error> {
        let parameters = std::mem::take(&mut self.parameters);
        if parameters.is_empty() {
            return Ok(());
        }
        let mut payload = self.ros.parameters(&parameters, is_change)?;
        self.ros_message(ros::PARAMETERS, self.time, &mut payload)
    }

    fn text(&mut self, time: u64, text: &Text<'_>) -> Result<(), Error> {
        self.ros_message(ros::TEXTS, time, &mut self.ros.text(text)?)
    }

    /// Writes a message to a channel for texts or parameters.
    fn ros_message(&mut self, channel: u16, time: u64, payload: &mut [u8]) -> Result<(), Error> {
        let at = usize::from(channel);
        if self.counts[at] == 0 {
            let (id, ty, topic) = self.ros.channels()[at];
            let schema = self.schema(ty.name.to_owned(), ty.text.clone())?.unwrap_or_default();
            self.channel((id, schema), topic, [(HASH, ty.hash.clone())])?;
        }
        self.counts[at] += 1;
        Ok(self.output.message(Place { channel, is_stamped: true, time }, payload)?)
    }

    /// Subscribes an id.
    fn subscribe(&mut self, id: u16, (name, multi_id): (&str, u8), log: &Log) {
        self.routes.set(id, None);
        // The subscription may have had no room.
        if log.subscription(id).is_none() {
            return;
        }
        let key = (name.to_owned(), multi_id);
        let at = self.channels.len();
        let known = self.by_name.get(&key).copied();
        if known.is_none() && at < MAX_LOG_TOPICS {
            let subject = SubjectName { name, instance: (multi_id > 0).then_some(multi_id) };
            let reason = "the log has no usable format for it".to_owned();
            let topic = Topic::left_out(&subject.to_string(), reason);
            let id = ros::FIRST_FREE + u16::try_from(at).unwrap_or(u16::MAX);
            self.channels.push(Channel { topic, id, opened: None });
            self.by_name.insert(key, at);
        } else if known.is_none() {
            let name = name.escape_debug();
            return self.problems.add(format!("more than {MAX_LOG_TOPICS} topics: `{name}` is left out"));
        }
        self.routes.set(id, Some(known.unwrap_or(at)));
    }

    /// Opens a channel with its first message.
    fn open(&mut self, at: usize, record: &Record<'_>) -> Result<(), Error> {
        let name = &record.subscription.topic;
        let treatment = log::treatment(self.plan, name, Some(record.message_type), &mut self.converters);
        let mut topic = Topic::new(name, treatment, self.plan, self.settings);
        if self.is_full() {
            topic.leave_out(too_large());
        } else if topic.report.action != Action::LeftOut {
            match self.type_of(&topic, record.message_type) {
                Err(error) => topic.leave_out(format!("its format isn't a ROS 2 message: {error}")),
                Ok(ty) => self.write_channel(at, &mut topic, ty, record)?,
            }
        }
        let plan = self.plan.source().plan(record.message_type, record.compiled);
        let channel = &mut self.channels[at];
        // Earlier messages may have been unreadable.
        let TopicReport { topic: subject, messages, unreadable, error, .. } =
            std::mem::take(&mut channel.topic.report);
        topic.report = TopicReport { topic: subject, messages, unreadable, error, ..topic.report };
        channel.topic = topic;
        channel.opened = Some(Opened { is_event: name == EVENT, timestamp: plan.timestamp, utc: plan.utc });
        Ok(())
    }

    /// Writes the schema and the channel of a topic.
    fn write_channel(
        &mut self,
        at: usize,
        topic: &mut Topic<'p>,
        ty: Type,
        record: &Record<'_>,
    ) -> Result<(), Error> {
        let Some(schema) = self.schema(ty.name, ty.text)? else {
            topic.leave_out(too_large());
            return Ok(());
        };
        // PX4 appends the instance, and then the version of the message.
        let instance = record.subscription.multi_id;
        let shown = Some(instance).filter(|instance| *instance > 0).map(|instance| instance.to_string());
        let base = format!("{FROM_PX4}{}{}", topic.output_name(), shown.unwrap_or_default());
        // Instance 1 of `foo` has the name of the topic `foo1`.
        let names =
            (1_u32..).map(|number| if number == 1 { base.clone() } else { format!("{base}_{number}") });
        let mut names = names.map(|name| versioned(&name, ty.version));
        let Some(renamed) = names.find(|name| !self.names.contains(name)) else { return Ok(()) };
        let metadata =
            [(HASH, ty.hash), (TOPIC, topic.output_name().to_owned()), (INSTANCE, instance.to_string())];
        self.channel((self.channels[at].id, schema), &renamed, metadata)?;
        self.names.insert(renamed.clone());
        topic.report.renamed = Some(renamed);
        Ok(())
    }

    /// The type of a topic in the output. Fails if its format isn't a valid message.
    fn type_of(&self, topic: &Topic<'p>, format: MessageType<'_>) -> Result<Type, String> {
        if let Some(converted) = &topic.converted {
            let (target, id) = (self.plan.target(), converted.conversion.to);
            let (name, hash) = self.plan.target_type(id);
            let version = target.schema.message(id).version;
            return Ok(Type { name, text: target.bag_text(id), hash, version });
        }
        let definitions = self.plan.source();
        let defined = definitions.message_of_logged_topic(format.name());
        let message = defined.map(|id| definitions.schema.message(id).name.clone());
        let message = message.unwrap_or_else(|| message_name(format.name()));
        let name = format!("{PX4_ROS_PACKAGE}/msg/{message}");
        let text = bag_text(format, PX4_ROS_PACKAGE);
        let text = text.ok_or("two of its nested types have the same name")?;
        let hash = definitions.shared.stated(&name, text.as_bytes())?.type_hash.clone();
        Ok(Type { name, text, hash, version: None })
    }

    fn event(&mut self, record: &Record<'_>, time: u64) -> Result<(), Error> {
        let event = record.message_type.view_uorb(record.payload).ok().and_then(RawEvent::read);
        let Some(event) = event else { return Ok(()) };
        let events = self.events.clone();
        let decoded = events.as_ref().and_then(|events| event.decode(events.events()).ok());
        self.text(time, &Text::of_event(&event, decoded.as_ref()))
    }

    fn finish(mut self) -> Result<(Vec<TopicReport>, Problems), Error> {
        self.start_data()?;
        if !self.output.finish()? {
            self.problems
                .note("the log contains no time in UTC: all times count from the start of the vehicle");
        }
        let (records, problem) = self.information.finish();
        for (name, values) in records {
            self.output.output.metadata(&metadata_body(name, &values))?;
        }
        if let Some(problem) = problem {
            self.problems.add(problem);
        }
        self.output.output.finish(&mut self.problems)?;
        let ros =
            self.ros.channels().into_iter().zip(self.counts).map(|((_, _, topic), messages)| TopicReport {
                topic: topic.to_owned(),
                action: Action::Copied,
                messages,
                ..TopicReport::default()
            });
        let topics = self.channels.into_iter().map(|channel| channel.topic.finish()).chain(ros);
        Ok((topics.filter(|topic| topic.messages > 0).collect(), self.problems))
    }
}

impl<'p> Sink<'p> for Stream<'p, '_> {
    const COPIES_BYTES: bool = false;

    fn record(&mut self, record: &Record<'_>, _: &[u8]) -> Result<(), Error> {
        let Some(at) = self.routes.get(record.subscription.id) else { return Ok(()) };
        if self.channels[at].opened.is_none() {
            self.open(at, record)?;
        }
        let Channel { topic, id, opened: Some(opened) } = &mut self.channels[at] else { return Ok(()) };
        topic.report.messages += 1;
        let time_at = |offset: Option<usize>| {
            let bytes = record.payload.get(offset?..)?;
            Some(u64::from_le_bytes(*bytes.first_chunk()?))
        };
        let (time, utc, is_event) = (time_at(opened.timestamp), time_at(opened.utc), opened.is_event);
        // The timestamp of a topic that was never published is 0.
        let time = time.filter(|time| *time > 0).unwrap_or(self.time);
        self.time = time;
        if let Some(utc) = utc {
            self.output.set_utc(time, utc)?;
        }
        if topic.report.action != Action::LeftOut {
            let payload = match &topic.converted {
                Some(_) => topic.convert(|converted, losses| {
                    converted.cdr_of_log(record.payload, losses, std::mem::take(&mut self.buffer))
                }),
                None => cdr(record.message_type, record.payload, std::mem::take(&mut self.buffer))
                    .map_err(|error| topic.unreadable(error))
                    .ok(),
            };
            if let Some(mut payload) = payload {
                let place = Place { channel: *id, is_stamped: false, time };
                self.output.message(place, &mut payload)?;
                self.buffer = payload;
            }
        }
        if is_event { self.event(record, time) } else { Ok(()) }
    }

    fn part(&mut self, item: &Item<'_>, log: &Log) -> Result<(), Error> {
        match &item.event {
            Event::Start { timestamp, .. } => {
                self.time = *timestamp;
                self.output.start(*timestamp);
            }
            Event::Information { key, ty, value } => self.information.add(key, ty, value),
            Event::MultiInformation { key: Metadata::KEY, value, .. } if !self.is_in_data => {
                if let Some(metadata) = &mut self.metadata {
                    metadata.add(value, Location::Byte(item.offset));
                }
            }
            Event::MultiInformation { key, ty, value, is_continued } => {
                self.information.add_piece(key, ty, value, *is_continued);
            }
            Event::Parameter { key, ty, value } => {
                if let Some(parameter) = Parameter::read(key, ty, value) {
                    self.parameters.push(parameter);
                } else {
                    let (at, size) = (item.offset, value.len());
                    let (key, ty) = (key.escape_debug(), ty.escape_debug());
                    self.problems.add(format!(
                        "byte {at}: parameter `{key}`: expected an int32_t or a float of 4 bytes, found `{ty}` of {size}"
                    ));
                }
                if self.is_in_data || self.parameters.len() >= MAX_PARAMETERS {
                    self.write_parameters(self.is_in_data)?;
                }
            }
            Event::DefaultParameter { defaults, key, ty, value } => {
                self.information.add_default(*defaults, key, ty, value);
            }
            Event::Subscription { id, name, multi_id } => {
                self.start_data()?;
                self.subscribe(*id, (name, *multi_id), log);
            }
            Event::Logging { level, tag, timestamp, text } => {
                self.start_data()?;
                self.text(*timestamp, &Text::of_log(*level, *tag, text))?;
            }
            Event::Dropout { milliseconds } => {
                self.start_data()?;
                self.text(self.time, &Text::of_dropout(*milliseconds))?;
            }
            _ => {}
        }
        Ok(())
    }

    fn topic(&mut self, id: u16) -> Option<&mut Topic<'p>> {
        let at = self.routes.get(id)?;
        self.channels.get_mut(at).map(|channel| &mut channel.topic)
    }

    fn problems(&mut self) -> &mut Problems {
        &mut self.problems
    }
}

/// The reason to leave out a topic.
fn too_large() -> String {
    format!("the schemas take more than {} MiB", MAX_CONVERTED_SCHEMAS >> 20)
}

impl Converted<'_> {
    /// Converts a payload of a log to CDR, and counts the losses.
    fn cdr_of_log(&self, payload: &[u8], losses: &mut [u64], buffer: Vec<u8>) -> Result<Vec<u8>, String> {
        if self.converter.keeps_cdr() {
            return cdr(self.source(), payload, buffer);
        }
        let message = self.source().decode_uorb(payload).map_err(|error| error.to_string())?;
        let message = self.message(&message, losses)?;
        message.view().to_cdr_in(ByteOrder::LittleEndian, buffer).map_err(|error| error.to_string())
    }
}

/// Converts a payload of a log to CDR, in the memory of `buffer`.
fn cdr(ty: MessageType<'_>, payload: &[u8], buffer: Vec<u8>) -> Result<Vec<u8>, String> {
    let view = ty.view_uorb(payload);
    let cdr = view.and_then(|view| view.to_cdr_in(ByteOrder::LittleEndian, buffer));
    cdr.map_err(|error| error.to_string())
}
