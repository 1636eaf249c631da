//! Converts JSON messages: JSON Lines, an array, or values that span lines.

mod message;

use std::io::{BufWriter, Read, Write};
use std::ops::Range;

use uavspec_capture::input::UpToError;
use uavspec_capture::json::{Event, Item, Reader};
use uavspec_model::Extent;
use uavspec_model::json::Tree;
use uavspec_model::limits::MAX_NAME;
use uavspec_model::text::{plural, utf8};
use uavspec_px4::json::{Dialect, decode};
use uavspec_rules::definitions::Definitions;
use uavspec_schema::MessageId;

use self::message::has_same_names;
use super::plan::{Converted, Converters, Plan};
use super::report::{Action, Problems, TopicReport};
use super::topic::Topic;
use super::{Error, Settings};
use crate::json::{Form, NameKind, Names, ROS, form, starts_like_object};
use crate::limits::MAX_CHANNELS;
use crate::{StatedType, definition_of, definition_of_json, is_flockwave, is_guess, shows_type};

/// A topic or a type of the capture.
struct Channel<'p> {
    definition: Option<MessageId>,
    topic: Topic<'p>,
    /// True if it is decided whether the channel has a definition. A stated type or a non-empty message decides.
    is_decided: bool,
    /// True if a message had a definition or wasn't empty. A type that is stated later is then ignored.
    is_final: bool,
    /// The number of messages that were copied.
    copied: u64,
}

/// The evidence in a value for the definition of a topic.
#[derive(Clone, Copy)]
enum Evidence<'v> {
    /// A non-empty message.
    Message(&'v Tree<'v>),
    /// The type that an operation states.
    Type(&'v str),
    /// Nothing but the name of the topic or type, in an operation without a type or an empty message.
    Name,
}

struct Stream<'p, 'o> {
    plan: &'p Plan,
    settings: Settings,
    output: BufWriter<&'o mut dyn Write>,
    problems: Problems,
    converters: Converters<'p>,
    channels: Vec<Channel<'p>>,
    names: Names,
    /// True once the first object has been read.
    has_objects: bool,
    /// True if a value starts like an object.
    is_json: bool,
    /// True if the capture is an array.
    is_array: bool,
    written: u64,
}

/// Converts JSON messages. Returns the topics and types, and the parts that can't be read.
pub(super) fn convert(
    input: impl Read,
    plan: &Plan,
    settings: Settings,
    output: &mut dyn Write,
) -> Result<(Vec<TopicReport>, Problems), Error> {
    let mut input = UpToError::new(input);
    let mut reader = Reader::new(&mut input);
    let mut stream = Stream::new(plan, settings, output);
    while let Ok(Some(Item { line, event })) = reader.next() {
        match event {
            Event::Value { bytes, is_element, .. } => {
                stream.is_array |= is_element;
                stream.value(bytes, line)?;
            }
            Event::Problem(problem) if problem.extent() != Extent::Whole => stream.problem(line, problem),
            Event::Problem(_) => {}
        }
    }
    let lines = reader.lines();
    if let Some(error) = &input.error {
        stream.problem(lines.max(1), format_args!("the rest is unreadable: {error}"));
    }
    stream.finish()
}

impl<'p, 'o> Stream<'p, 'o> {
    fn new(plan: &'p Plan, settings: Settings, output: &'o mut dyn Write) -> Self {
        Self {
            plan,
            settings,
            output: BufWriter::new(output),
            problems: Problems::default(),
            converters: Converters::default(),
            channels: Vec::new(),
            names: Names::default(),
            has_objects: false,
            is_json: false,
            is_array: false,
            written: 0,
        }
    }

    fn problem(&mut self, line: u64, problem: impl std::fmt::Display) {
        self.problems.add(format!("line {line}: {problem}"));
    }

    fn value(&mut self, bytes: &[u8], line: u64) -> Result<(), Error> {
        self.is_json |= starts_like_object(bytes);
        let text = match utf8(bytes) {
            Ok(text) => text,
            Err(error) => {
                self.problem(line, error);
                return Ok(());
            }
        };
        let (tree, places) = match Tree::read_with_places(text) {
            Ok(read) => read,
            Err(error) => {
                self.problem(line, error);
                return Ok(());
            }
        };
        let value = TextValue { text, tree: &tree, places: &places };
        self.check_kind(&tree)?;
        match form(&tree) {
            Form::Message(kind, name, message) => self.message((kind, name), message, value, line),
            Form::Advertised(topic, ty) => self.operation(topic, Some(ty), value),
            Form::Skipped => match tree.get("topic").and_then(Tree::as_str) {
                Some(topic) => self.operation(topic, None, value),
                None => self.write(text),
            },
            Form::Unknown(problem) => {
                self.problem(line, format_args!("{problem}; copied unchanged"));
                self.write(text)
            }
        }
    }

    /// Checks that the first object doesn't belong to a kind of capture that can't be converted.
    fn check_kind(&mut self, tree: &Tree<'_>) -> Result<(), Error> {
        if self.has_objects || !matches!(tree, Tree::Object(_)) {
            return Ok(());
        }
        self.has_objects = true;
        if is_flockwave(tree) { Err(Error::format("Flockwave")) } else { Ok(()) }
    }

    /// Converts a message.
    fn message(
        &mut self,
        name: (NameKind, &str),
        message: &Tree<'_>,
        value: TextValue<'_>,
        line: u64,
    ) -> Result<(), Error> {
        let evidence = if shows_type(message) { Evidence::Message(message) } else { Evidence::Name };
        let at = match self.open(name, evidence) {
            Ok(at) => at,
            Err(problem) => {
                self.problem(line, problem);
                return Ok(());
            }
        };
        let channel = &mut self.channels[at];
        channel.topic.report.messages += 1;
        channel.is_final |= channel.definition.is_some() || matches!(evidence, Evidence::Message(_));
        let (kind, _) = name;
        let text = match channel.topic.report.action {
            Action::LeftOut => return Ok(()),
            Action::Copied => {
                channel.copied += 1;
                return self.write(value.text);
            }
            Action::Converted => {
                let is_rosbridge = kind == NameKind::Topic;
                let converted =
                    channel.topic.convert(|converted, losses| converted.json(message, is_rosbridge, losses));
                let Some(text) = converted else { return Ok(()) };
                text
            }
        };
        let name = channel.topic.report.renamed.as_deref().map(quoted);
        let line = value.with(&[(kind.name_key(), name.as_deref()), (kind.key(), text.as_deref())]);
        self.write(&line)
    }

    /// Copies a rosbridge message other than `publish`. Renames its topic and its type.
    fn operation(&mut self, topic: &str, ty: Option<&str>, value: TextValue<'_>) -> Result<(), Error> {
        let evidence = ty.map_or(Evidence::Name, Evidence::Type);
        let Ok(at) = self.open((NameKind::Topic, topic), evidence) else { return self.write(value.text) };
        let channel = &self.channels[at];
        let name = channel.topic.report.renamed.as_deref().map(quoted);
        // The type may be stated only after the first non-empty message, which may indicate another type.
        let is_same =
            |ty: &&str| definition_of(topic, Some((ty, ROS)), self.plan.source()) == channel.definition;
        let ty = ty.filter(is_same).and_then(|ty| channel.topic.renamed_type(ty, self.plan));
        let ty = ty.as_deref().map(quoted);
        let line = value.with(&[("topic", name.as_deref()), ("type", ty.as_deref())]);
        self.write(&line)
    }

    /// Returns the index of a topic or a type. Its definition is decided by the type that is stated before the first
    /// non-empty message; otherwise, by this message.
    fn open(&mut self, (kind, name): (NameKind, &str), evidence: Evidence<'_>) -> Result<usize, String> {
        if name.len() > MAX_NAME {
            return Err(format!("the name of the topic or type is longer than {MAX_NAME} bytes"));
        }
        let definitions = self.plan.source();
        let Some(at) = self.names[kind as usize].get(name).copied() else {
            let at = self.channels.len();
            if at >= MAX_CHANNELS {
                return Err(format!("more than {MAX_CHANNELS} topics and types"));
            }
            let definition = find((kind, name), evidence, definitions);
            let channel = self.channel((kind, name), evidence, definition);
            self.channels.push(channel);
            self.names[kind as usize].insert(name.to_owned(), at);
            return Ok(at);
        };
        let known = &self.channels[at];
        let decides = match evidence {
            Evidence::Message(_) => !known.is_decided,
            Evidence::Type(_) => !known.is_final,
            Evidence::Name => false,
        };
        let definition = if decides { find((kind, name), evidence, definitions) } else { known.definition };
        if decides && (definition != known.definition || !known.is_decided) {
            let has_old_name = known.definition.is_none();
            let (messages, copied) = (known.topic.report.messages, known.copied);
            let mut channel = self.channel((kind, name), evidence, definition);
            if has_old_name {
                // Lines with the old name have already been copied.
                channel.topic.report.renamed = None;
            }
            channel.topic.report.messages = messages;
            self.channels[at] = Channel { copied, ..channel };
        }
        Ok(at)
    }

    fn channel(
        &mut self,
        (kind, name): (NameKind, &str),
        evidence: Evidence<'_>,
        definition: Option<MessageId>,
    ) -> Channel<'p> {
        let plan = self.plan;
        let source = plan.source();
        // The fields of undefined messages aren't known.
        let stated = |target: &Definitions| find((kind, name), evidence, target).map(|_| StatedType::Other);
        let treated = match definition {
            None => (None, plan.undefined(stated)),
            Some(id) => {
                let first = source.schema.message(id).topics.first().map_or("", String::as_str);
                let topic = if kind == NameKind::Topic { name } else { first };
                let release = source.release_of(id).map(|release| release.label.clone());
                (release, plan.treatment(id, topic, &mut self.converters))
            }
        };
        let mut topic = Topic::new(name, treated, plan, self.settings);
        if kind == NameKind::Type {
            topic.report.renamed = topic.renamed_type(name, plan);
        }
        let is_decided = definition.is_some() || !matches!(evidence, Evidence::Name);
        Channel { definition, topic, is_decided, is_final: false, copied: 0 }
    }

    /// Writes a value.
    fn write(&mut self, value: &str) -> Result<(), Error> {
        let before: &[u8] = match (self.is_array, self.written) {
            (false, _) => b"",
            (true, 0) => b"[\n",
            (true, _) => b",\n",
        };
        self.output.write_all(before)?;
        // In valid JSON, a newline is whitespace. A value that spans lines would change the form of the capture.
        if value.contains('\n') {
            self.output.write_all(value.replace(['\r', '\n'], " ").as_bytes())?;
        } else {
            self.output.write_all(value.as_bytes())?;
        }
        if !self.is_array {
            self.output.write_all(b"\n")?;
        }
        self.written += 1;
        Ok(())
    }

    fn finish(mut self) -> Result<(Vec<TopicReport>, Problems), Error> {
        if !self.is_json {
            return Err(Error::Input("expected objects in JSON, found none".to_owned()));
        }
        if self.is_array {
            self.output.write_all(if self.written > 0 { b"\n]\n" } else { b"[]\n" })?;
        }
        self.output.flush()?;
        Ok((self.channels.into_iter().map(Channel::finish).collect(), self.problems))
    }
}

impl Channel<'_> {
    /// Returns the topic's part of the report.
    fn finish(self) -> TopicReport {
        let mut report = self.topic.finish();
        if self.copied > 0 && report.action != Action::Copied {
            // Non-empty messages are copied only if all later messages are copied, too.
            let copied = format!("copied: {} without keys", plural(self.copied, "message"));
            let reasons = report.reason.into_iter().chain([copied]);
            report.reason = Some(reasons.collect::<Vec<_>>().join("; "));
        }
        report
    }
}

/// Finds the definition of a topic or a type, like `uavspec check`. Returns `None` if only the name matches, and other
/// programs also use this name.
fn find(
    (kind, name): (NameKind, &str),
    evidence: Evidence<'_>,
    definitions: &Definitions,
) -> Option<MessageId> {
    match (kind, evidence) {
        (NameKind::Type, _) => definitions.message_of_type(name),
        (NameKind::Topic, Evidence::Message(message)) => definition_of_json(name, None, message, definitions),
        (NameKind::Topic, Evidence::Type(ty)) => definition_of(name, Some((ty, ROS)), definitions),
        (NameKind::Topic, Evidence::Name) => {
            definition_of(name, None, definitions).filter(|id| !is_guess(name, None, *id, definitions))
        }
    }
}

impl Converted<'_> {
    /// Converts a JSON message, and counts the losses. Returns `None` if the message stays the same: it is valid JSON,
    /// and its type has the same messages in both releases.
    pub(super) fn json(
        &self,
        tree: &Tree<'_>,
        is_rosbridge: bool,
        losses: &mut [u64],
    ) -> Result<Option<String>, String> {
        let (message, dialects) = decode(tree, self.source(), is_rosbridge)?;
        let has_nan = dialects.iter().any(|dialect| dialect == Dialect::BareNan);
        if !has_nan && self.converter.keeps_cdr() && has_same_names(self.source(), self.converter.target()) {
            return Ok(None);
        }
        message::write(&self.message(&message, losses)?, dialects).map(Some)
    }
}

/// A value with its text.
#[derive(Clone, Copy)]
struct TextValue<'t> {
    text: &'t str,
    tree: &'t Tree<'t>,
    /// The positions of the members' values.
    places: &'t [Range<usize>],
}

impl TextValue<'_> {
    /// The text in which the values of some members are replaced.
    fn with(self, replaced: &[(&str, Option<&str>)]) -> String {
        let members = if let Tree::Object(members) = self.tree { members.as_slice() } else { &[] };
        let (mut text, mut end) = (String::with_capacity(self.text.len()), 0);
        for ((key, _), place) in members.iter().zip(self.places) {
            let new = replaced.iter().find_map(|(known, new)| new.filter(|_| known == key));
            let Some(new) = new else { continue };
            text.push_str(self.text.get(end..place.start).unwrap_or_default());
            text.push_str(new);
            end = place.end;
        }
        text.push_str(self.text.get(end..).unwrap_or_default());
        text
    }
}

/// A name as a JSON string.
fn quoted(name: &str) -> String {
    serde_json::Value::from(name).to_string()
}
