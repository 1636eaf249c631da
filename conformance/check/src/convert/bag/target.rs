//! The file that a conversion writes.

use std::borrow::Cow;
use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::io::{self, Read, Write};

use mcap::records::MessageHeader;
use uavspec_capture::mcap::{Packing, Writer, metadata, metadata_body};
use uavspec_capture::rosbag::sqlite::{Definition, Topic};
use uavspec_capture::rosbag::{self, FileContent, QOS, portable_qos};
use uavspec_model::text::thousands;
use uavspec_schema::MessageId;
use uavspec_schema::derived_from;
use uavspec_schema::msg::Kind;

use super::super::Output;
use super::super::report::Problems;
use super::declarations::fits;
use crate::{DISTRIBUTION, HASH, digest, stated_distribution};

/// The origin of a schema in the output.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(in crate::convert) enum Origin {
    /// The schema of the input with this digest.
    Input(u64),
    /// The definition of this message of the target.
    Target(MessageId),
    /// A message of the target, in the encoding of the schema of the input with this digest.
    Json(MessageId, u64),
}

/// The name, the encoding and the text of a schema.
pub(in crate::convert) type Content<'s> = (Cow<'s, str>, Cow<'s, str>, Cow<'s, [u8]>);

/// The file that a conversion writes.
pub(in crate::convert) struct Target<'o> {
    file: File<'o>,
    /// The ids of the schemas in the file.
    schemas: HashMap<Origin, u16>,
    /// The schemas by id. The texts are empty, unless a `SQLite` file needs them.
    by_id: HashMap<u16, Definition>,
    /// The total size of the schemas, in bytes.
    size: usize,
    /// The ids of the channels in the file, by the digest of their declaration.
    channels: HashMap<u64, u16>,
    /// The ids that channels of the current input use.
    current: HashSet<u16>,
    /// The next id for a channel whose own id is used.
    next: u16,
    /// The ids of the schemas whose definitions are in a `SQLite` file, by type and hash.
    defined: HashMap<(String, String), u16>,
    /// The topics in the file, with their numbers of messages, by the id of the channel.
    topics: BTreeMap<u16, (Topic, u64)>,
    /// The first and the last log time, in ns.
    times: Option<(u64, u64)>,
    distribution: Distribution,
    left_out: LeftOut,
}

/// The ROS distribution in the output.
pub(in crate::convert) enum Distribution {
    /// The records of the input state it, and are copied.
    InRecords,
    /// The distribution of the input; empty if it is unknown.
    OfInput(String),
    /// The distribution of the target.
    OfTarget(String),
}

/// The numbers of parts that a `SQLite` file can't contain.
#[derive(Default)]
struct LeftOut {
    records: u64,
    metadata: u64,
    schemas: u64,
    /// Publish times that differ from the log time, and sequence numbers.
    headers: u64,
    times: u64,
}

/// The latest time in a `SQLite` file, in ns.
const MAX_TIME: u64 = i64::MAX as u64;

enum File<'o> {
    /// A file without content.
    New(Option<Output<'o>>),
    Mcap(Box<Writer<&'o mut dyn Write>>),
    Sqlite(rosbag::Writer),
}

impl<'o> Target<'o> {
    /// Creates a file.
    pub(in crate::convert) fn new(output: Output<'o>, distribution: Distribution) -> Self {
        Self {
            file: File::New(Some(output)),
            schemas: HashMap::new(),
            by_id: HashMap::new(),
            size: 0,
            channels: HashMap::new(),
            current: HashSet::new(),
            next: 0,
            defined: HashMap::new(),
            topics: BTreeMap::new(),
            times: None,
            distribution,
            left_out: LeftOut::default(),
        }
    }

    /// Writes the start of the file, unless it is already written. `profile` is the profile of an MCAP file.
    pub(in crate::convert) fn start(&mut self, profile: &str) -> io::Result<()> {
        let File::New(output) = &mut self.file else { return Ok(()) };
        match output.take() {
            Some(Output::Stream(output)) => self.file = File::Mcap(Box::new(Writer::new(output, profile)?)),
            Some(Output::Sqlite(path)) => self.file = File::Sqlite(rosbag::Writer::new(path)?),
            Some(Output::Folder(_)) => return Err(io::Error::other("expected a file, found a folder")),
            None => {}
        }
        Ok(())
    }

    /// Begins with the channels of another file.
    pub(in crate::convert) fn next_input(&mut self) {
        self.current.clear();
    }

    /// True for a `SQLite` file.
    pub(in crate::convert) fn is_database(&self) -> bool {
        matches!(self.file, File::Sqlite(_))
    }

    /// Takes over the ROS distribution that an input states.
    pub(in crate::convert) fn take_distribution(&mut self, found: String) {
        if let Distribution::OfInput(distribution) = &mut self.distribution
            && !found.is_empty()
        {
            *distribution = found;
        }
    }

    /// Sets the compression of the following records.
    pub(in crate::convert) fn set_packing(&mut self, packing: Option<Packing>) -> io::Result<()> {
        match &mut self.file {
            File::Mcap(writer) => writer.set_packing(packing),
            File::New(_) | File::Sqlite(_) => Ok(()),
        }
    }

    /// Returns the id of a schema, and writes the schema if necessary. Returns `None` if the schemas take too much space.
    pub(in crate::convert) fn schema<'s>(
        &mut self,
        origin: Origin,
        content: impl FnOnce() -> Option<Content<'s>>,
    ) -> io::Result<Option<u16>> {
        if let Some(id) = self.schemas.get(&origin) {
            return Ok(Some(*id));
        }
        let Some((name, encoding, text)) = content() else { return Ok(Some(0)) };
        if !fits(&mut self.size, text.len()) {
            return Ok(None);
        }
        let id = u16::try_from(self.schemas.len() + 1);
        let id = id.map_err(|_| io::Error::other("the output needs more than 65,535 schemas"))?;
        let mut stored =
            Definition { ty: name.into_owned(), encoding: encoding.into_owned(), ..Definition::default() };
        if let File::Mcap(writer) = &mut self.file {
            writer.schema(id, (&stored.ty, &stored.encoding), &text)?;
        } else if let Ok(text) = String::from_utf8(text.into_owned()) {
            stored.text = text;
        } else {
            // Like a type whose definition is unknown.
            stored.encoding.clear();
            self.left_out.schemas += 1;
        }
        self.schemas.insert(origin, id);
        self.by_id.insert(id, stored);
        Ok(Some(id))
    }

    /// Writes a channel, unless an earlier file declared the same channel. Returns its id, which is `id` if possible. Returns
    /// `None` if another channel of a `SQLite` file has another definition of the same type.
    pub(in crate::convert) fn channel(
        &mut self,
        (id, schema): (u16, u16),
        (name, encoding): (&str, &str),
        mut metadata: BTreeMap<String, String>,
    ) -> io::Result<Option<u16>> {
        if let Some(qos) = metadata.get_mut(QOS) {
            *qos = portable_qos(qos);
        }
        let digest = digest(&(schema, name, encoding, &metadata));
        // Channels of the same input stay separate, even if they are equal.
        if let Some(known) = self.channels.get(&digest).filter(|known| !self.current.contains(known)) {
            self.current.insert(*known);
            return Ok(Some(*known));
        }
        let mut free = id;
        while self.topics.contains_key(&free) {
            let next = self.next.checked_add(1);
            free = self.next;
            self.next = next.ok_or_else(|| io::Error::other("the output needs more than 65,535 channels"))?;
        }
        let id = free;
        let value = |key: &str| metadata.get(key).cloned().unwrap_or_default();
        let stored = self.by_id.get(&schema);
        let ty = stored.map_or_else(String::new, |stored| stored.ty.clone());
        let (hash, qos) = (value(HASH), value(QOS));
        let topic =
            Topic { id: id.into(), name: name.to_owned(), ty, encoding: encoding.to_owned(), hash, qos };
        match &mut self.file {
            File::Mcap(writer) => writer.channel((id, schema), (name, encoding), &metadata)?,
            File::Sqlite(writer) => {
                let is_kept = |key: &String| [HASH, QOS].contains(&key.as_str());
                self.left_out.metadata += u64::from(!metadata.keys().all(is_kept));
                if let Some(stored) = stored.filter(|stored| !stored.encoding.is_empty()) {
                    // For an event of a service, rosbag2 stores the definition under the name of the service.
                    let service = derived_from(&stored.ty).filter(|(kind, _)| *kind == Kind::Service);
                    let ty = service.map_or(&*stored.ty, |(_, service)| service).to_owned();
                    match self.defined.entry((ty.clone(), topic.hash.clone())) {
                        Entry::Vacant(entry) => {
                            entry.insert(schema);
                            writer.definition(&Definition {
                                ty,
                                hash: topic.hash.clone(),
                                ..stored.clone()
                            })?;
                        }
                        // Equal hashes mean equal types.
                        Entry::Occupied(known) => {
                            let text = self.by_id.get(known.get()).map(|known| &known.text);
                            if topic.hash.is_empty() && text != Some(&stored.text) {
                                return Ok(None);
                            }
                        }
                    }
                }
                writer.topic(&topic)?;
            }
            File::New(_) => {}
        }
        self.topics.insert(id, (topic, 0));
        self.current.insert(id);
        self.channels.insert(digest, id);
        Ok(Some(id))
    }

    /// Writes a message.
    pub(in crate::convert) fn message(&mut self, header: &MessageHeader, payload: &[u8]) -> io::Result<()> {
        let (id, mut time) = (header.channel_id, header.log_time);
        if self.is_database() {
            self.left_out.times += u64::from(time > MAX_TIME);
            self.left_out.headers += u64::from(header.sequence != 0 || header.publish_time != time);
            time = time.min(MAX_TIME);
        }
        let (first, last) = self.times.unwrap_or((time, time));
        self.times = Some((first.min(time), last.max(time)));
        if let Some((_, count)) = self.topics.get_mut(&id) {
            *count += 1;
        }
        match &mut self.file {
            File::Mcap(writer) => writer.message(header, payload),
            File::Sqlite(writer) => writer.message(id.into(), time, payload),
            File::New(_) => Ok(()),
        }
    }

    /// Writes a metadata record.
    pub(in crate::convert) fn metadata(&mut self, body: &[u8]) -> io::Result<()> {
        let is_replaced = !matches!(self.distribution, Distribution::InRecords);
        if is_replaced && metadata(body).is_some_and(|(name, _)| name == DISTRIBUTION.0) {
            self.take_distribution(stated_distribution(body).unwrap_or_default());
            return Ok(());
        }
        let Some(writer) = self.mcap() else { return Ok(()) };
        writer.metadata(body)
    }

    /// Writes an attachment of `length` bytes.
    pub(in crate::convert) fn attachment(&mut self, length: u64, body: &mut dyn Read) -> io::Result<()> {
        let Some(writer) = self.mcap() else { return Ok(()) };
        writer.attachment(length, body)
    }

    /// Writes the event metadata of a vehicle as an attachment.
    pub(in crate::convert) fn event_metadata(&mut self, file: &[u8]) -> io::Result<()> {
        let Some(writer) = self.mcap() else { return Ok(()) };
        writer.event_metadata(file)
    }

    /// Writes a record of an application.
    pub(in crate::convert) fn private(
        &mut self,
        opcode: u8,
        body: &[u8],
        is_in_chunk: bool,
    ) -> io::Result<()> {
        let Some(writer) = self.mcap() else { return Ok(()) };
        writer.private(opcode, body, is_in_chunk)
    }

    /// The writer of an MCAP file. In a `SQLite` file, counts a record that is left out.
    fn mcap(&mut self) -> Option<&mut Writer<&'o mut dyn Write>> {
        match &mut self.file {
            File::Mcap(writer) => Some(writer),
            File::New(_) | File::Sqlite(_) => {
                self.left_out.records += 1;
                None
            }
        }
    }

    /// The ROS distribution of the messages; empty if it is unknown, or if a copied record states it.
    pub(in crate::convert) fn distribution(&self) -> String {
        match &self.distribution {
            Distribution::InRecords => String::new(),
            Distribution::OfInput(name) | Distribution::OfTarget(name) => name.clone(),
        }
    }

    /// Writes the end of the file. Returns its content; the name is empty.
    pub(in crate::convert) fn finish(mut self, problems: &mut Problems) -> io::Result<FileContent> {
        // Even without records, the output is a valid file.
        self.start("")?;
        let distribution = self.distribution();
        match self.file {
            File::New(_) => {}
            File::Mcap(mut writer) => {
                if !distribution.is_empty() {
                    let (name, key) = DISTRIBUTION;
                    let values = [(key.to_owned(), distribution)].into();
                    writer.metadata(&metadata_body(name, &values))?;
                }
                writer.finish()?;
            }
            File::Sqlite(writer) => writer.finish(&distribution)?,
        }
        let LeftOut { records, metadata, schemas, headers, times } = self.left_out;
        let left_out = "they are left out";
        for (count, what, result) in [
            (records, "attachments, metadata records and private records", left_out),
            (metadata, "most metadata of channels", left_out),
            (schemas, "schemas that aren't text in UTF-8", left_out),
            (headers, "publish times and sequence numbers", left_out),
            (times, "times after 2262", "these messages get the latest possible time"),
        ] {
            if count > 0 {
                let count = thousands(count);
                problems.note(&format!("a SQLite file can't contain {what} ({count}): {result}"));
            }
        }
        Ok(FileContent {
            name: String::new(),
            times: self.times,
            topics: self.topics.into_values().collect(),
        })
    }
}
