//! Converts PX4 logs.

pub(super) mod formats;

use std::collections::HashMap;
use std::io::{self, BufWriter, Read, Write};

use uavspec_capture::ulog::{Event, Item, Log, Record};
use uavspec_dynamic::DynamicMessage;

use self::formats::{Formats, LogFormats};
use super::log::{self, Routes, Sink};
use super::plan::{Converted, Converters, Plan, Treatment};
use super::report::{Action, Problems, TopicReport};
use super::topic::Topic;
use super::{Error, Settings};
use crate::limits::MAX_LOG_TOPICS;

/// The maximum size of a message in a log, in bytes. Two bytes are reserved for the id.
pub(super) const MAX_MESSAGE: usize = u16::MAX as usize - 2;

/// The offset of the first message.
const FIRST_MESSAGE: u64 = 16;

/// The size of a message's header, in bytes.
const HEADER: usize = 3;

/// The offsets of two fields in the payload of flag bits: the incompatible bits, and the offsets of appended data.
const INCOMPATIBLE: usize = 8;
const APPENDED: std::ops::Range<usize> = 16..40;

struct Stream<'p, 'o> {
    plan: &'p Plan,
    settings: Settings,
    output: BufWriter<&'o mut dyn Write>,
    problems: Problems,
    converters: Converters<'p>,
    /// The topics: all formats in the definitions section, and other topics with a subscription.
    topics: Vec<Topic<'p>>,
    by_name: HashMap<String, usize>,
    /// True for each topic with a subscription.
    subscribed: Vec<bool>,
    /// The topics by the id of their subscription.
    routes: Routes,
    formats: Formats,
    /// True once the formats have been written.
    is_in_data: bool,
}

/// Converts a log. Returns the topics and the parts that can't be read.
pub(super) fn convert(
    input: impl Read,
    plan: &Plan,
    settings: Settings,
    output: &mut dyn Write,
) -> Result<(Vec<TopicReport>, Problems), Error> {
    let mut stream = Stream::new(plan, settings, output);
    let log = log::read(input, &mut stream)?;
    stream.finish(&log)
}

impl<'p, 'o> Stream<'p, 'o> {
    fn new(plan: &'p Plan, settings: Settings, output: &'o mut dyn Write) -> Self {
        Self {
            plan,
            settings,
            output: BufWriter::new(output),
            problems: Problems::default(),
            converters: Converters::default(),
            topics: Vec::new(),
            by_name: HashMap::new(),
            subscribed: Vec::new(),
            routes: Routes::default(),
            formats: Formats::default(),
            is_in_data: false,
        }
    }

    /// Writes the flag bits. Appended data follows the other data directly in the output.
    fn flag_bits(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let mut bytes = bytes.to_vec();
        if let Some(payload) = bytes.get_mut(HEADER..)
            && payload.len() >= APPENDED.end
        {
            payload[INCOMPATIBLE] &= !1;
            payload[APPENDED].fill(0);
        }
        Ok(self.output.write_all(&bytes)?)
    }

    /// Writes the formats, at the end of the definitions section. The formats of converted topics take precedence over
    /// copied formats.
    fn start_data(&mut self, log: &Log) -> Result<(), Error> {
        if std::mem::replace(&mut self.is_in_data, true) {
            return Ok(());
        }
        let formats: LogFormats<'_> = log.formats().collect();
        for (name, _) in log.formats() {
            let topic = self.planned(name, log);
            self.add(name, topic);
        }
        for wanted in [Action::Converted, Action::Copied] {
            for topic in self.topics.iter_mut().filter(|topic| topic.report.action == wanted) {
                let added = match &topic.converted {
                    Some(converted) => {
                        let name = topic.output_name();
                        let is_taken = topic.report.renamed.is_some() && formats.contains_key(name);
                        if is_taken {
                            Err(format!("the log already has a topic `{name}`"))
                        } else {
                            self.formats.convert(name, converted.converter.target())
                        }
                    }
                    None => self.formats.copy(&topic.report.topic, &formats),
                };
                if let Err(reason) = added {
                    topic.leave_out(reason);
                }
            }
        }
        for (name, fields) in self.formats.take_new() {
            write(&mut self.output, b'F', &[name.as_bytes(), b":", fields.as_bytes()])?;
        }
        Ok(())
    }

    /// A topic with a format.
    fn planned(&mut self, name: &str, log: &Log) -> Topic<'p> {
        let format = log::format(name, log);
        let treatment = log::treatment(self.plan, name, format, &mut self.converters);
        let mut topic = Topic::new(name, treatment, self.plan, self.settings);
        let fits = |converted: &Converted<'_>| {
            converted.converter.target().size().is_some_and(|size| size.padded <= MAX_MESSAGE)
        };
        if format.is_none() {
            topic.leave_out("its format is invalid".to_owned());
        } else if !topic.converted.as_deref().is_none_or(fits) {
            topic.leave_out(format!(
                "its messages in {} don't fit into a log",
                self.plan.target_label().unwrap_or_default()
            ));
        }
        topic
    }

    /// Adds a topic, and returns its index.
    fn add(&mut self, name: &str, topic: Topic<'p>) -> usize {
        let at = self.topics.len();
        self.by_name.insert(name.to_owned(), at);
        self.topics.push(topic);
        self.subscribed.push(false);
        at
    }

    /// Subscribes an id.
    fn subscribe(
        &mut self,
        id: u16,
        multi_id: u8,
        (name, bytes): (&str, &[u8]),
        log: &Log,
    ) -> Result<(), Error> {
        // The subscription may have had no room.
        let topic = log.subscription(id).and_then(|_| self.topic_of(name));
        self.routes.set(id, topic);
        let Some(at) = topic else { return Ok(()) };
        self.subscribed[at] = true;
        let topic = &self.topics[at];
        if topic.report.action == Action::LeftOut {
            return Ok(());
        }
        match &topic.report.renamed {
            Some(renamed) => {
                write(&mut self.output, b'A', &[&[multi_id], &id.to_le_bytes(), renamed.as_bytes()])
            }
            None => Ok(self.output.write_all(bytes)?),
        }
    }

    /// The index of a topic; `None` if there are too many topics.
    fn topic_of(&mut self, name: &str) -> Option<usize> {
        if let Some(at) = self.by_name.get(name) {
            return Some(*at);
        }
        if self.topics.len() >= MAX_LOG_TOPICS {
            self.problems
                .add(format!("more than {MAX_LOG_TOPICS} topics: `{}` is left out", name.escape_debug()));
            return None;
        }
        let mut topic = Topic::new(name, (None, Treatment::Copy), self.plan, self.settings);
        topic.leave_out("the definitions section has no format for it".to_owned());
        Some(self.add(name, topic))
    }

    fn finish(mut self, log: &Log) -> Result<(Vec<TopicReport>, Problems), Error> {
        self.start_data(log)?;
        self.output.flush()?;
        let topics = self.topics.into_iter().zip(self.subscribed);
        let topics = topics.filter_map(|(topic, is_subscribed)| is_subscribed.then(|| topic.finish()));
        Ok((topics.collect(), self.problems))
    }
}

impl<'p> Sink<'p> for Stream<'p, '_> {
    const COPIES_BYTES: bool = true;

    /// Converts or copies a message.
    fn record(&mut self, record: &Record<'_>, bytes: &[u8]) -> Result<(), Error> {
        let id = record.subscription.id;
        let Some(topic) = self.topic(id) else { return Ok(()) };
        topic.report.messages += 1;
        match (topic.report.action, &topic.converted) {
            (Action::LeftOut, _) => Ok(()),
            (_, Some(converted)) if !converted.converter.keeps_cdr() => {
                let converted = topic.convert(|converted, losses| converted.uorb(record.payload, losses));
                match converted {
                    Some(payload) => write(&mut self.output, b'D', &[&id.to_le_bytes(), &payload]),
                    None => Ok(()),
                }
            }
            _ => Ok(self.output.write_all(bytes)?),
        }
    }

    fn part(&mut self, item: &Item<'_>, log: &Log) -> Result<(), Error> {
        match &item.event {
            Event::FlagBits { .. } if item.offset == FIRST_MESSAGE => self.flag_bits(item.bytes)?,
            // Misplaced flag bits are ignored, and the formats follow at the end of the definitions section.
            Event::FlagBits { .. } | Event::Format { .. } => {}
            Event::Subscription { id, name, multi_id } => {
                self.start_data(log)?;
                self.subscribe(*id, *multi_id, (name, item.bytes), log)?;
            }
            Event::Unsubscription { id } => {
                self.start_data(log)?;
                if self.topic(*id).is_some_and(|topic| topic.report.action != Action::LeftOut) {
                    self.output.write_all(item.bytes)?;
                }
            }
            Event::Logging { .. } | Event::Dropout { .. } | Event::Synchronisation => {
                self.start_data(log)?;
                self.output.write_all(item.bytes)?;
            }
            _ => self.output.write_all(item.bytes)?,
        }
        Ok(())
    }

    fn topic(&mut self, id: u16) -> Option<&mut Topic<'p>> {
        let at = self.routes.get(id)?;
        self.topics.get_mut(at)
    }

    fn problems(&mut self) -> &mut Problems {
        &mut self.problems
    }
}

impl Converted<'_> {
    /// Converts a payload, and counts the losses.
    fn uorb(&self, payload: &[u8], losses: &mut [u64]) -> Result<Vec<u8>, String> {
        let message = self.source().decode_uorb(payload).map_err(|error| error.to_string())?;
        log_payload(&self.message(&message, losses)?)
    }
}

/// The payload of a message in a log. Like PX4, writes no padding at the end.
pub(super) fn log_payload(message: &DynamicMessage<'_>) -> Result<Vec<u8>, String> {
    let mut payload = message.to_uorb().map_err(|error| error.to_string())?;
    if let Some(size) = message.message_type().size() {
        payload.truncate(size.no_padding);
    }
    Ok(payload)
}

/// Writes a message.
pub(super) fn write(output: &mut impl Write, kind: u8, parts: &[&[u8]]) -> Result<(), Error> {
    let size: usize = parts.iter().map(|part| part.len()).sum();
    let size = u16::try_from(size).map_err(|_| io::Error::other("a message is longer than 65,535 bytes"))?;
    output.write_all(&size.to_le_bytes())?;
    output.write_all(&[kind])?;
    for part in parts {
        output.write_all(part)?;
    }
    Ok(())
}
