//! Reads an MCAP file of a bag.

use std::collections::{BTreeSet, HashMap};
use std::io::Read;

use uavspec_capture::MCAP_MAGIC;
use uavspec_capture::input::UpToError;
use uavspec_capture::mcap::{
    APPLICATION, AttachmentHead, CUT_SHORT, ENDPOINT, EVENT_METADATA, Event, Item, LOST, NOTE, Packing,
    Reader, UNREADABLE, metadata,
};
use uavspec_model::limits::MAX_NAME;
use uavspec_model::text::{shown, thousands};
use uavspec_model::{ApplicationType, Endpoint, Extent, Findings, Location};
use uavspec_rules::definitions::Definitions;
use uavspec_schema::limits::MAX_EVENTS_LEN;

use super::{BagContent, Channels, Declared, McapSummary, digest};
use crate::{CaptureResult, CheckRun, Kind, Logged, Observer, Summary, has_magic};

pub(crate) const KIND: Kind = Kind {
    name: "MCAP",
    detect: |start| has_magic(start, &MCAP_MAGIC),
    choose: |source, library| library.choose(&super::clues::mcap(source, library.shared())),
    check: |source, _, run| check(source, run),
};

/// Checks the readable part of an MCAP file.
pub fn check_mcap(input: impl Read, definitions: &Definitions) -> CaptureResult {
    check(input, CheckRun::new(definitions))
}

fn check(input: impl Read, run: CheckRun<'_>) -> CaptureResult {
    let mut channels = Channels::new(run);
    let mut file = McapFile::default();
    let bytes = file.read(&mut channels, input);
    finish(channels, file, bytes)
}

/// Finishes the check of a single file.
fn finish(channels: Channels<'_>, file: McapFile<'_>, bytes: u64) -> CaptureResult {
    let McapFile { profile, library, .. } = file;
    channels.finish(bytes, |BagContent { channels, dialects, releases, bus }| {
        Summary::Mcap(McapSummary { profile, library, channels, dialects, releases, bus })
    })
}

/// A bag that is being recorded. Each record is checked when it is written.
pub struct LiveBag<'d> {
    channels: Channels<'d>,
    file: McapFile<'static>,
}

impl<'d> LiveBag<'d> {
    /// A bag without messages.
    pub fn new(definitions: &'d Definitions, observer: Option<&'d mut dyn Observer>) -> Self {
        let channels = Channels::new(CheckRun::observed_by(definitions, observer));
        Self { channels, file: McapFile::default() }
    }

    /// Checks a record. Its location is the number of the message, as for messages in a compressed chunk.
    pub fn record(&mut self, event: Event<'_>) {
        let item = Item { offset: 0, packing: Some(Packing::Lz4), event };
        self.file.item(&mut self.channels, item);
    }

    /// The findings so far.
    pub fn findings(&self) -> &Findings {
        &self.channels.run.findings
    }

    /// Finishes the check. `bytes` is the size of the recording.
    pub fn finish(self, bytes: u64) -> CaptureResult {
        finish(self.channels, self.file, bytes)
    }
}

/// A file that is being read.
#[derive(Default)]
pub(super) struct McapFile<'c> {
    /// The name of the file, if it is one of several files in a bag.
    name: &'c str,
    profile: String,
    library: String,
    /// The indices of the schemas, by id.
    schemas: HashMap<u16, usize>,
    /// The hashes of the channels' declarations, and the indices of the channels, by id.
    channels: Vec<Option<(u64, usize)>>,
    /// The indices in `channels`.
    claimed: BTreeSet<usize>,
    /// The channels that have messages but no declaration. Each is reported only once.
    undeclared: BTreeSet<u16>,
    /// The number of records that announce an endpoint.
    num_endpoints: u64,
    /// The content of the attachment that is being read, if it contains event metadata.
    metadata: Option<Vec<u8>>,
}

impl<'c> McapFile<'c> {
    pub(super) fn named(name: &'c str) -> Self {
        Self { name, ..Self::default() }
    }

    /// Checks the readable part of the file. Returns the number of bytes read.
    pub(super) fn read(&mut self, bag: &mut Channels<'_>, input: impl Read) -> u64 {
        let mut input = UpToError::new(input);
        let mut reader = Reader::new(&mut input);
        while let Ok(Some(item)) = reader.next() {
            self.item(bag, item);
        }
        let bytes = reader.bytes();
        if let Some(error) = &input.error {
            // The findings up to here remain valid.
            let text = format!("the rest is unreadable: {error}");
            self.corruption(bag, Location::Byte(bytes), &text, Extent::Unreadable);
        }
        bytes
    }

    fn item(&mut self, bag: &mut Channels<'_>, item: Item<'_>) {
        let byte = Location::Byte(item.offset);
        // In a compressed chunk, and in a bag of several files, an offset doesn't identify a record.
        let has_offset = item.packing.is_none() && self.name.is_empty();
        let place = |other: Location| if has_offset { byte } else { other };
        match item.event {
            Event::Header { profile, library } => {
                // Another file with its own ids may follow the end of a file.
                *self = Self { num_endpoints: self.num_endpoints, ..Self::named(self.name) };
                (self.profile, self.library) = (shortened(&profile), shortened(&library));
            }
            Event::Schema { id, name, encoding, text } => {
                if let Err(problem) = self.schema(bag, id, name, encoding, text) {
                    self.corruption(bag, byte, &problem, Extent::WithGaps);
                }
            }
            Event::Channel { id, schema, topic, encoding, metadata } => {
                let location = place(Location::Channel(id.into()));
                let declared = Declared { schema: None, topic, encoding, metadata };
                if let Err(problem) = self.channel(bag, id, schema, declared, location) {
                    self.corruption(bag, location, &problem, Extent::WithGaps);
                }
            }
            Event::Message { channel, time, sequence, payload, .. } => {
                let number = bag.begin(Logged { time, sequence: Some(sequence) });
                let location = place(Location::Message(number));
                if let Some(Some((_, channel))) = self.channels.get(usize::from(channel)) {
                    bag.message(*channel, time, payload, location);
                } else if self.undeclared.insert(channel) {
                    let text =
                        format!("a message refers to channel {channel}, which hasn't been declared yet");
                    self.corruption(bag, location, &text, Extent::WithGaps);
                }
            }
            Event::Metadata { body } => self.metadata(bag, body, byte),
            Event::Attachment { length, at, bytes } => self.attachment(bag, (length, at), bytes),
            Event::Private { .. } => {}
            Event::Problem(problem) => self.corruption(bag, byte, &problem.to_string(), problem.extent()),
        }
    }

    /// Adds a schema. The error describes the problem.
    fn schema(
        &mut self,
        bag: &mut Channels<'_>,
        id: u16,
        name: String,
        encoding: String,
        text: &[u8],
    ) -> Result<(), String> {
        if id == 0 {
            return Err("a schema has the reserved id 0".to_owned());
        }
        let schemas = &mut bag.schemas;
        match self.schemas.get(&id) {
            // Summaries and chunks repeat schemas.
            Some(known) if schemas.is(*known, &name, &encoding, text) => return Ok(()),
            Some(_) => {
                return Err(format!(
                    "schema {id} is declared again with different content; the first declaration is used"
                ));
            }
            None => {}
        }
        let index = schemas.add(name, encoding, text).map_err(|problem| format!("schema {id}: {problem}"))?;
        self.schemas.insert(id, index);
        schemas.problem(index).map_or(Ok(()), |problem| Err(format!("schema {id} {problem}")))
    }

    /// Declares a channel. The error describes the problem.
    fn channel(
        &mut self,
        bag: &mut Channels<'_>,
        id: u16,
        schema_id: u16,
        declared: Declared,
        location: Location,
    ) -> Result<(), String> {
        let digest = digest(&(schema_id, &declared));
        let at = usize::from(id);
        if let Some(Some((known, _))) = self.channels.get(at) {
            if *known != digest {
                return Err(format!(
                    "channel {id} is declared again with different content; the first declaration is used"
                ));
            }
            return Ok(());
        }
        let schema = self.schemas.get(&schema_id).copied();
        let declared = Declared { schema, ..declared };
        let channel = bag.declare(&declared, location, &mut self.claimed);
        let channel = channel.map_err(|problem| format!("channel {id}: {problem}"))?;
        if at >= self.channels.len() {
            self.channels.resize(at + 1, None);
        }
        self.channels[at] = Some((digest, channel));
        if schema_id != 0 && schema.is_none() {
            return Err(format!("channel {id} refers to schema {schema_id}, which hasn't been declared yet"));
        }
        Ok(())
    }

    /// Reads a metadata record about a live vehicle. Ignores the metadata of other programs.
    fn metadata(&mut self, bag: &mut Channels<'_>, body: &[u8], byte: Location) {
        let Some((name, values)) = metadata(body) else { return };
        let value = |key: &str| values.get(key).map(|value| value.escape_debug().to_string());
        match name.as_str() {
            ENDPOINT if values.len() == 1 => {
                bag.run.endpoint_ended(values.get("id").map_or("", String::as_str));
            }
            ENDPOINT => {
                self.num_endpoints += 1;
                match Endpoint::from_values(&values) {
                    Some(endpoint) => {
                        bag.network.add(&endpoint);
                        bag.run.endpoint(&endpoint, Location::Endpoint(self.num_endpoints));
                    }
                    None => self.corruption(bag, byte, "invalid values of an endpoint", Extent::WithGaps),
                }
            }
            APPLICATION => match ApplicationType::from_values(&values) {
                Some(ty) => bag.run.application(&ty),
                None => self.corruption(bag, byte, "invalid values of an application", Extent::WithGaps),
            },
            LOST => {
                let (count, topic) = (value("count").unwrap_or_default(), value("topic").unwrap_or_default());
                let text = format!("{count} messages of {topic} were lost before they were recorded");
                self.corruption(bag, Location::Message(bag.run.records), &text, Extent::WithGaps);
            }
            UNREADABLE => {
                let text = shown(values.get("text").map_or("", String::as_str));
                self.corruption(bag, Location::Message(bag.run.records), &text, Extent::WithGaps);
            }
            NOTE => bag.run.note(values.get("text").map_or("", String::as_str)),
            CUT_SHORT => bag.run.cut_short(values.get("reason").map_or("", String::as_str)),
            _ => {}
        }
    }

    /// Reads an attachment with event metadata, which explains the messages that follow.
    fn attachment(&mut self, bag: &mut Channels<'_>, (length, at): (u64, u64), bytes: &[u8]) {
        if at == 0 {
            let head = AttachmentHead::read(bytes);
            let is_metadata = head.is_some_and(|head| EVENT_METADATA.iter().any(|name| head.is_named(name)));
            self.metadata = is_metadata.then(Vec::new);
        }
        let Some(body) = &mut self.metadata else { return };
        let is_too_late = bag.run.records > 0;
        if length <= MAX_EVENTS_LEN as u64 && !is_too_late {
            body.extend_from_slice(bytes);
            if at + (bytes.len() as u64) < length {
                return;
            }
        }
        let read = if is_too_late {
            Err("it follows the first message; specify the file with `--events`".to_owned())
        } else {
            let data = AttachmentHead::read(body).and_then(|head| head.data(body));
            data.ok_or_else(|| {
                let (length, most) = (thousands(length), thousands(MAX_EVENTS_LEN));
                format!("the attachment is truncated, or longer than {most} bytes: {length} bytes")
            })
        };
        let problem = bag.run.read_metadata(read, None);
        self.metadata = None;
        if let Some(problem) = problem {
            bag.run.note(&problem);
        }
    }

    /// Reports a corrupt part of this file.
    fn corruption(&self, bag: &mut Channels<'_>, location: Location, text: &str, extent: Extent) {
        bag.corruption(self.name, location, text, extent);
    }
}

/// Text from the file in printable form, shortened if it is too long.
fn shortened(text: &str) -> String {
    text.chars().take(MAX_NAME).collect::<String>().escape_debug().to_string()
}
