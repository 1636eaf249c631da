//! Converts PX4 logs.

mod formats;

use std::collections::HashMap;
use std::io::{self, BufWriter, Read, Write};

use uavspec_capture::input::UpToError;
use uavspec_capture::ulog::{Event, Item, Log, LogProblem, Problem, Reader, Record};
use uavspec_dynamic::ULOG_PACKAGE;
use uavspec_model::Extent;
use uavspec_px4::comparison::{Comparison, compare};
use uavspec_rules::definitions::Definitions;

use self::formats::{Formats, LogFormats};
use super::plan::{Converted, Converters, Plan, Treatment};
use super::report::{Action, Problems, TopicReport};
use super::topic::Topic;
use super::{Error, Settings};
use crate::limits::MAX_LOG_TOPICS;

/// The maximum size of a message in a log, in bytes. Two bytes are reserved for the id.
const MAX_MESSAGE: usize = u16::MAX as usize - 2;

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
    routes: Vec<Option<usize>>,
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
    let mut input = UpToError::new(input);
    let (mut reader, mut log) = (Reader::new(&mut input), Log::default());
    let mut stream = Stream::new(plan, settings, output);
    while let Ok(Some(item)) = reader.next() {
        stream.item(&item, &mut log)?;
    }
    let position = reader.position();
    if let Some(error) = &input.error {
        stream.problems.add(format!("byte {position}: the rest is unreadable: {error}"));
    }
    stream.finish(&mut log)
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
            routes: Vec::new(),
            formats: Formats::default(),
            is_in_data: false,
        }
    }

    fn item(&mut self, item: &Item<'_>, log: &mut Log) -> Result<(), Error> {
        let mut found = Vec::new();
        let record = log.take(item, &mut |offset, problem| found.push((offset, problem)));
        if let Some(record) = record {
            return self.record(&record, item.bytes);
        }
        for (offset, problem) in found {
            self.log_problem(offset, &problem);
        }
        match &item.event {
            Event::Problem(problem) => {
                if loses_data(problem) {
                    self.problems.add(format!("byte {}: {problem}", item.offset));
                }
            }
            Event::FlagBits { .. } if item.offset == FIRST_MESSAGE => self.flag_bits(item.bytes)?,
            // Misplaced flag bits are ignored, and the formats follow at the end of the definitions section. Data that can't
            // be read was reported above.
            Event::FlagBits { .. } | Event::Format { .. } | Event::Data { .. } => {}
            Event::Subscription { id, name, multi_id } => {
                self.start_data(log)?;
                self.subscribe(*id, *multi_id, (name, item.bytes), log)?;
            }
            Event::Unsubscription { id } => {
                self.start_data(log)?;
                let topic = self.routes.get(usize::from(*id)).copied().flatten();
                if topic.is_some_and(|at| self.topics[at].report.action != Action::LeftOut) {
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
        let plan = self.plan;
        let definitions = plan.source();
        let format = log.types().find(ULOG_PACKAGE, name).filter(|format| format.size().is_some());
        let id = definitions.message_of_logged_topic(name).filter(|id| plan.concerns(*id));
        let release = id.and_then(|id| definitions.release_of(id)).map(|release| release.label.clone());
        let is_other = |target: &Definitions| {
            let id = target.message_of_logged_topic(name);
            id.zip(format)
                .is_some_and(|(id, format)| compare(format, target.types().get(id)) != Comparison::Equal)
        };
        let treatment = match (format, id) {
            (_, None) => plan.undefined(is_other),
            (Some(format), Some(id)) if compare(format, definitions.types().get(id)) != Comparison::Equal => {
                plan.differs(id)
            }
            (_, Some(id)) => plan.treatment(id, name, &mut self.converters),
        };
        let mut topic = Topic::new(name, (release, treatment), plan, self.settings);
        let fits = |converted: &Converted<'_>| {
            converted.converter.target().size().is_some_and(|size| size.padded <= MAX_MESSAGE)
        };
        if format.is_none() {
            topic.leave_out("its format is invalid".to_owned());
        } else if !topic.converted.as_deref().is_none_or(fits) {
            topic.leave_out(format!("its messages in {} don't fit into a log", plan.target_label()));
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
        let slot = usize::from(id);
        if slot >= self.routes.len() {
            self.routes.resize(slot + 1, None);
        }
        // The subscription may have had no room.
        self.routes[slot] = log.subscription(id).and_then(|_| self.topic(name));
        let Some(at) = self.routes[slot] else { return Ok(()) };
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
    fn topic(&mut self, name: &str) -> Option<usize> {
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

    /// Converts or copies a message.
    fn record(&mut self, record: &Record<'_>, bytes: &[u8]) -> Result<(), Error> {
        let id = record.subscription.id;
        let Some(at) = self.routes.get(usize::from(id)).copied().flatten() else { return Ok(()) };
        let topic = &mut self.topics[at];
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

    /// Counts data that can't be read, and reports formats that can't be used.
    fn log_problem(&mut self, offset: u64, problem: &LogProblem) {
        match problem {
            LogProblem::DataSize { id, .. }
            | LogProblem::MissingFormat { id }
            | LogProblem::UnusableFormat { id } => {
                let topic = self.routes.get(usize::from(*id)).copied().flatten();
                if let Some(topic) = topic.and_then(|at| self.topics.get_mut(at)) {
                    topic.report.messages += 1;
                    topic.unreadable(problem.to_string());
                }
            }
            LogProblem::Resubscribed { .. }
            | LogProblem::Redefined { .. }
            | LogProblem::LateSubscription { .. }
            | LogProblem::LateFormat { .. }
            | LogProblem::NotSubscribed { .. } => {}
            _ => self.problems.add(format!("byte {offset}: {problem}")),
        }
    }

    fn finish(mut self, log: &mut Log) -> Result<(Vec<TopicReport>, Problems), Error> {
        let mut found = Vec::new();
        log.finish(&mut |offset, problem| found.push((offset, problem)));
        for (offset, problem) in found {
            self.log_problem(offset, &problem);
        }
        self.start_data(log)?;
        self.output.flush()?;
        let topics = self.topics.into_iter().zip(self.subscribed);
        let topics = topics.filter_map(|(topic, is_subscribed)| is_subscribed.then(|| topic.finish()));
        Ok((topics.collect(), self.problems))
    }
}

impl Converted<'_> {
    /// Converts a payload, and counts the losses. Like PX4, writes no padding at the end.
    fn uorb(&self, payload: &[u8], losses: &mut [u64]) -> Result<Vec<u8>, String> {
        let message = self.source.decode_uorb(payload).map_err(|error| error.to_string())?;
        let converted = self.message(&message, losses)?;
        let mut payload = converted.to_uorb().map_err(|error| error.to_string())?;
        if let Some(size) = converted.message_type().size() {
            payload.truncate(size.no_padding);
        }
        Ok(payload)
    }
}

/// True if a problem means that data is missing in the output, or may be misread.
fn loses_data(problem: &Problem) -> bool {
    let is_other = matches!(problem, Problem::NewerVersion(_) | Problem::FlagBitsNotFirst);
    // Messages of unknown kinds are copied.
    is_other || problem.extent() != Extent::Whole && !matches!(problem, Problem::UnknownKind(_))
}

/// Writes a message.
fn write(output: &mut impl Write, kind: u8, parts: &[&[u8]]) -> Result<(), Error> {
    let size: usize = parts.iter().map(|part| part.len()).sum();
    let size = u16::try_from(size).map_err(|_| io::Error::other("a message is longer than 65,535 bytes"))?;
    output.write_all(&size.to_le_bytes())?;
    output.write_all(&[kind])?;
    for part in parts {
        output.write_all(part)?;
    }
    Ok(())
}
