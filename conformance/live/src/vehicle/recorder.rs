//! Records the events of a bus as a bag.

use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ::mcap::records::MessageHeader;
use uavspec_capture::mcap::{
    self, APPLICATION, CUT_SHORT, ENDPOINT, LOST, NOTE, OWN, Packing, UNREADABLE, Writer, metadata_body,
};
use uavspec_check::{CaptureResult, HASH, LiveBag};
use uavspec_model::ApplicationType;
use uavspec_rules::definitions::EventMetadata;

use crate::bus::{Encoding, Event, Received, Schema, Topic};
use crate::limits::MAX_CHANNELS;

/// A channel: a topic with its schema and encoding, and a flag that is true if this program sends its messages.
type Key = (Topic, Option<Arc<Schema>>, Encoding, bool);

/// Writes a bag. Each record can be checked when it is written.
pub(super) struct Recorder<'d> {
    /// Checks the same records, once the release is known.
    pub(super) live: Option<LiveBag<'d>>,
    /// The file. `None` if further events are only checked.
    writer: Option<Writer<BufWriter<File>>>,
    pub(super) path: PathBuf,
    /// The id and the next sequence number of each channel.
    channels: HashMap<Key, (u16, u32)>,
    /// The ids of the schemas, by type name and schema.
    schemas: HashMap<(Arc<str>, Option<Arc<Schema>>), u16>,
}

impl Recorder<'_> {
    /// Creates the file. If the user passed event metadata, writes it to the file.
    pub(super) fn create(path: &Path, events: &EventMetadata) -> io::Result<Self> {
        let mut writer = Writer::new(BufWriter::new(File::create(path)?), "ros2")?;
        if let Some(file) = events.file() {
            writer.event_metadata(file)?;
        }
        writer.set_packing(Some(Packing::Lz4))?;
        let (channels, schemas) = (HashMap::new(), HashMap::new());
        Ok(Self { live: None, writer: Some(writer), path: path.to_owned(), channels, schemas })
    }

    /// The size of the file so far, in bytes.
    pub(super) fn size(&self) -> u64 {
        self.writer.as_ref().map_or(0, Writer::size)
    }

    /// Flushes all events so far to the file.
    pub(super) fn flush(&mut self) -> io::Result<()> {
        self.writer.as_mut().map_or(Ok(()), Writer::flush)
    }

    /// Closes the file. Further events are checked but not written, because the index of an open file grows without
    /// limit.
    pub(super) fn discard(&mut self) {
        self.writer = None;
    }

    /// Writes the end of the file. Returns the result of the check, if the records were checked.
    pub(super) fn finish(self) -> io::Result<Option<CaptureResult>> {
        if let Some(writer) = self.writer {
            writer.finish()?.flush()?;
        }
        let size = std::fs::metadata(&self.path)?.len();
        Ok(self.live.map(|live| live.finish(size)))
    }

    /// Writes an event.
    pub(super) fn record(&mut self, event: &Event) -> io::Result<()> {
        match event {
            Event::Endpoint(endpoint) => self.metadata(ENDPOINT, &endpoint.to_values()),
            Event::Ended(id) => self.metadata(ENDPOINT, &[("id".to_owned(), id.clone())].into()),
            Event::Lost { topic, count } => self.lost(topic, *count),
            Event::Unreadable(text) => self.metadata(UNREADABLE, &[("text".to_owned(), text.clone())].into()),
            Event::Message(message) => self.message(message),
            // Only the probe writes notes and the reason for the end.
            Event::Problem(_) | Event::Closed(_) => Ok(()),
        }
    }

    /// Writes a type that the application uses.
    pub(super) fn application(&mut self, ty: &ApplicationType) -> io::Result<()> {
        self.metadata(APPLICATION, &ty.to_values())
    }

    /// Writes a notable event.
    pub(super) fn note(&mut self, text: &str) -> io::Result<()> {
        self.metadata(NOTE, &[("text".to_owned(), text.to_owned())].into())
    }

    /// Writes the reason why the recording was cut short.
    pub(super) fn cut_short(&mut self, reason: &str) -> io::Result<()> {
        self.metadata(CUT_SHORT, &[("reason".to_owned(), reason.to_owned())].into())
    }

    fn lost(&mut self, topic: &str, count: u64) -> io::Result<()> {
        let values = [("count".to_owned(), count.to_string()), ("topic".to_owned(), topic.to_owned())];
        self.metadata(LOST, &values.into())
    }

    fn metadata(&mut self, name: &str, values: &BTreeMap<String, String>) -> io::Result<()> {
        let body = metadata_body(name, values);
        if let Some(writer) = &mut self.writer {
            writer.metadata(&body)?;
        }
        if let Some(live) = &mut self.live {
            live.record(mcap::Event::Metadata { body: &body });
        }
        Ok(())
    }

    fn message(&mut self, message: &Received) -> io::Result<()> {
        let key = (message.topic.clone(), message.schema.clone(), message.encoding, message.is_own);
        let is_full = self.channels.len() >= MAX_CHANNELS;
        let (channel, sequence) = match self.channels.get_mut(&key) {
            Some((id, sequence)) => {
                *sequence = sequence.wrapping_add(1);
                (*id, *sequence)
            }
            None if is_full => return self.lost(&key.0.name, 1),
            None => (self.channel(key)?, 0),
        };
        let (log_time, publish_time) = (message.time, message.time);
        if let Some(writer) = &mut self.writer {
            let header = MessageHeader { channel_id: channel, sequence, log_time, publish_time };
            writer.message(&header, &message.payload)?;
        }
        if let Some(live) = &mut self.live {
            let payload = &message.payload;
            live.record(mcap::Event::Message { channel, time: log_time, publish_time, sequence, payload });
        }
        Ok(())
    }

    /// Declares a channel. Returns its id.
    fn channel(&mut self, key: Key) -> io::Result<u16> {
        let (topic, schema, encoding, is_own) = &key;
        let schema = self.schema(topic, schema.as_ref())?;
        let id = u16::try_from(self.channels.len()).map_err(io::Error::other)?;
        let encoding = match encoding {
            Encoding::Cdr => "cdr",
            Encoding::Json => "json",
        };
        let hash = topic.type_hash.as_ref().map(|hash| (HASH.to_owned(), hash.to_string()));
        let own = is_own.then(|| (OWN.to_owned(), true.to_string()));
        let metadata: BTreeMap<String, String> = hash.into_iter().chain(own).collect();
        if let Some(writer) = &mut self.writer {
            writer.channel((id, schema), (&topic.name, encoding), &metadata)?;
        }
        if let Some(live) = &mut self.live {
            let (topic, encoding) = (topic.name.to_string(), encoding.to_owned());
            live.record(mcap::Event::Channel { id, schema, topic, encoding, metadata });
        }
        self.channels.insert(key, (id, 0));
        Ok(id)
    }

    /// Declares the schema of a topic, and returns its id. If the bus announces only the name of the type, the text is
    /// empty, as in the bags of `ros2 bag record`.
    fn schema(&mut self, topic: &Topic, schema: Option<&Arc<Schema>>) -> io::Result<u16> {
        let key = (Arc::clone(&topic.type_name), schema.cloned());
        if let Some(id) = self.schemas.get(&key) {
            return Ok(*id);
        }
        let id = u16::try_from(self.schemas.len() + 1).map_err(io::Error::other)?;
        let (encoding, text) =
            schema.map_or(("ros2msg", &[][..]), |schema| (&*schema.encoding, &*schema.text));
        if let Some(writer) = &mut self.writer {
            writer.schema(id, (&topic.type_name, encoding), text)?;
        }
        if let Some(live) = &mut self.live {
            let (name, encoding) = (topic.type_name.to_string(), encoding.to_owned());
            live.record(mcap::Event::Schema { id, name, encoding, text });
        }
        self.schemas.insert(key, id);
        Ok(id)
    }
}
