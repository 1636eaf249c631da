//! Reads an MCAP file of a bag.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::io::Read;

use super::{BagContent, Channels, Declared, MAX_NAME, McapSummary, digest};
use crate::capture::MCAP_MAGIC;
use crate::capture::mcap::{Event, Item, Reader};
use crate::check::{CaptureResult, CheckRun, Kind, Logged, Summary, has_magic};
use crate::model::{Extent, Location};

pub(in crate::check) const KIND: Kind = Kind {
    name: "MCAP",
    detect: |start| has_magic(start, &MCAP_MAGIC),
    clues: super::clues::mcap,
    check: |source, _, run| check(source, run),
};

/// Checks the readable part of an MCAP file.
#[cfg(test)]
pub(crate) fn check_mcap(input: impl Read, definitions: &crate::definitions::Definitions) -> CaptureResult {
    check(input, CheckRun::new(definitions))
}

fn check(input: impl Read, run: CheckRun<'_>) -> CaptureResult {
    let mut channels = Channels::new(run);
    let mut file = McapFile::new(&mut channels, "");
    let bytes = file.read(input);
    let (profile, library) = (file.profile, file.library);
    channels.finish(bytes, |BagContent { channels, dialects, releases }| {
        Summary::Mcap(McapSummary { profile, library, channels, dialects, releases })
    })
}

/// A file that is being read.
pub(super) struct McapFile<'c, 'd> {
    bag: &'c mut Channels<'d>,
    /// The name of the file, if it is one of several files in a bag.
    name: &'c str,
    profile: String,
    library: String,
    /// The indices of the schemas, by id.
    schemas: HashMap<u16, usize>,
    /// The hashes of the channels' declarations, and the indices of the channels, by id.
    channels: BTreeMap<u16, (u64, usize)>,
    /// The indices in `channels`.
    claimed: BTreeSet<usize>,
    /// The undeclared channels with messages, each reported once.
    undeclared: BTreeSet<u16>,
}

impl<'c, 'd> McapFile<'c, 'd> {
    pub(super) fn new(bag: &'c mut Channels<'d>, name: &'c str) -> Self {
        Self {
            bag,
            name,
            profile: String::new(),
            library: String::new(),
            schemas: HashMap::new(),
            channels: BTreeMap::new(),
            claimed: BTreeSet::new(),
            undeclared: BTreeSet::new(),
        }
    }

    /// Checks the readable part of the file. Returns the number of bytes read.
    pub(super) fn read(&mut self, input: impl Read) -> u64 {
        let mut reader = Reader::new(input);
        loop {
            match reader.next() {
                Ok(Some(item)) => self.item(item),
                Ok(None) => break,
                // The findings up to here remain valid.
                Err(error) => {
                    let text = format!("the rest is unreadable: {error}");
                    self.corruption(Location::Byte(reader.bytes()), &text, Extent::Unreadable);
                    break;
                }
            }
        }
        reader.bytes()
    }

    fn item(&mut self, item: Item<'_>) {
        let byte = Location::Byte(item.offset);
        // In a compressed chunk, and in a bag of several files, an offset doesn't identify a record.
        let has_offset = item.packing.is_none() && self.name.is_empty();
        let place = |other: Location| if has_offset { byte } else { other };
        match item.event {
            Event::Header { profile, library } => {
                (self.profile, self.library) = (shortened(&profile), shortened(&library));
            }
            Event::Schema { id, name, encoding, text } => {
                if let Err(problem) = self.schema(id, name, encoding, text) {
                    self.corruption(byte, &problem, Extent::WithGaps);
                }
            }
            Event::Channel { id, schema, topic, encoding, metadata } => {
                let location = place(Location::Channel(id.into()));
                if let Err(problem) = self.channel(id, schema, topic, encoding, metadata, location) {
                    self.corruption(location, &problem, Extent::WithGaps);
                }
            }
            Event::Message { channel, time, sequence, payload, .. } => {
                let number = self.bag.begin(Logged { time, sequence: Some(sequence) });
                let location = place(Location::Message(number));
                if let Some((_, channel)) = self.channels.get(&channel) {
                    self.bag.message(*channel, time, payload, location);
                } else if self.undeclared.insert(channel) {
                    let text =
                        format!("a message refers to channel {channel}, which hasn't been declared yet");
                    self.corruption(location, &text, Extent::WithGaps);
                }
            }
            Event::Attachment { .. } | Event::Metadata { .. } | Event::Private { .. } => {}
            Event::Problem(problem) => self.corruption(byte, &problem.to_string(), problem.extent()),
        }
    }

    /// Adds a schema. An error describes the problem.
    fn schema(&mut self, id: u16, name: String, encoding: String, text: &[u8]) -> Result<(), String> {
        if id == 0 {
            return Err("a schema has the reserved id 0".to_owned());
        }
        let schemas = &mut self.bag.schemas;
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

    /// Declares a channel. An error describes the problem.
    fn channel(
        &mut self,
        id: u16,
        schema_id: u16,
        topic: String,
        encoding: String,
        metadata: BTreeMap<String, String>,
        location: Location,
    ) -> Result<(), String> {
        let digest = digest(&(schema_id, &topic, &encoding, &metadata));
        if let Some((known, _)) = self.channels.get(&id) {
            if *known != digest {
                return Err(format!(
                    "channel {id} is declared again with different content; the first declaration is used"
                ));
            }
            return Ok(());
        }
        let schema = self.schemas.get(&schema_id).copied();
        let declared = Declared { schema, topic, encoding, metadata };
        let channel = self.bag.declare(&declared, location, &mut self.claimed);
        let channel = channel.map_err(|problem| format!("channel {id}: {problem}"))?;
        self.channels.insert(id, (digest, channel));
        if schema_id != 0 && schema.is_none() {
            return Err(format!("channel {id} refers to schema {schema_id}, which hasn't been declared yet"));
        }
        Ok(())
    }

    /// Reports a corrupt part of this file.
    fn corruption(&mut self, location: Location, text: &str, extent: Extent) {
        self.bag.corruption(self.name, location, text, extent);
    }
}

/// Text from the file in printable form, shortened if it is too long.
fn shortened(text: &str) -> String {
    text.chars().take(MAX_NAME).collect::<String>().escape_debug().to_string()
}
