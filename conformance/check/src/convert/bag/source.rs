//! The records of the file that a conversion reads.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::io::{self, Read};
use std::mem;
use std::ops::ControlFlow;
use std::rc::Rc;

use uavspec_capture::input::UpToError;
use uavspec_capture::mcap::{Event, Item, Reader};
use uavspec_capture::rosbag::QOS;
use uavspec_capture::rosbag::sqlite::{self, Definition, Facts, Message, Topic};
use uavspec_rules::definitions::Shared;

use super::super::Error;
use super::super::report::Problems;
use super::declarations::{fits, too_large};
use crate::{HASH, definitions_of};

/// The profile of MCAP files that rosbag2 writes.
pub(in crate::convert) const PROFILE: &str = "ros2";

/// A file of a bag.
pub(in crate::convert) struct Source<'s, R> {
    /// All bytes, decompressed.
    pub(in crate::convert) bytes: R,
    /// The `SQLite` file that contains these bytes; `None` for an MCAP file.
    pub(in crate::convert) database: Option<&'s crate::Database>,
    pub(in crate::convert) shared: &'s Shared,
    /// The encodings of the topics' messages in the metadata of the bag. rosbag2 prefers them to the encodings in
    /// `SQLite` files.
    pub(in crate::convert) encodings: Option<&'s BTreeMap<String, String>>,
}

impl<R: Read> Source<'_, R> {
    /// Passes the records to `take`, until it fails. Adds the reasons why parts can't be read. Returns the number of bytes
    /// read.
    pub(in crate::convert) fn read(
        self,
        problems: &mut Problems,
        mut take: impl FnMut(Item<'_>, &mut Problems) -> Result<(), Error>,
    ) -> Result<u64, Error> {
        let mut input = UpToError::new(self.bytes);
        if let Some(database) = self.database {
            let Self { shared, encodings, .. } = self;
            database.problems.iter().for_each(|problem| problems.add(problem.clone()));
            let mut file = Database { input: &mut input, shared, encodings, take: &mut take, problems };
            file.read(&database.bag)?;
            return Ok(0);
        }
        let mut reader = Reader::new(&mut input);
        let mut has_header = false;
        while let Ok(Some(item)) = reader.next() {
            match &item.event {
                Event::Problem(problem) => problems.add(format!("byte {}: {problem}", item.offset)),
                Event::Header { .. } if mem::replace(&mut has_header, true) => {
                    let place = format!("byte {}", item.offset);
                    problems
                        .add(format!("{place}: another MCAP file starts here: split the file to convert it"));
                    break;
                }
                _ => take(item, problems)?,
            }
        }
        let bytes = reader.bytes();
        problems.add_unreadable_rest(bytes, input.error.as_ref());
        Ok(bytes)
    }
}

/// A `SQLite` file, which is passed on as the records of an MCAP file.
struct Database<'s, R, T> {
    input: &'s mut UpToError<R>,
    shared: &'s Shared,
    encodings: Option<&'s BTreeMap<String, String>>,
    take: T,
    problems: &'s mut Problems,
}

impl<R: Read, T: FnMut(Item<'_>, &mut Problems) -> Result<(), Error>> Database<'_, R, T> {
    fn read(&mut self, database: &sqlite::Bag) -> Result<(), Error> {
        self.record(Event::Header { profile: PROFILE.to_owned(), library: String::new() })?;
        let (mut topics, mut size, mut has_room) = (Vec::new(), 0, true);
        let result = database.topics(|topic| {
            let Topic { name, ty, encoding, hash, qos, .. } = &topic;
            let length = name.len() + ty.len() + encoding.len() + hash.len() + qos.len();
            has_room &= fits(&mut size, length + size_of::<Topic>());
            if has_room {
                topics.push(topic);
            }
        });
        let mut is_whole = self.report(result);
        let mut definitions: Facts<Rc<Definition>> = Facts::default();
        is_whole &=
            self.report(definitions_of(database, &topics, self.shared, |ty, definition, is_verified| {
                if fits(&mut size, definition.text.len()) {
                    definitions.add(ty, &definition.hash, is_verified, Rc::new(definition.clone()));
                } else {
                    has_room = false;
                }
            }));
        if !has_room {
            self.problems.add(too_large());
        }
        let mut known = BTreeSet::new();
        topics.retain(|Topic { id, .. }| {
            let is_new = known.insert(*id);
            if !is_new {
                self.problems.add(format!("topic {id} is declared again; the first declaration is used"));
            }
            is_new
        });
        let (mut schemas, mut channels) = (HashMap::new(), HashMap::new());
        // The reader limits the number of topics, so each gets an id.
        for (id, topic) in (1..=u16::MAX).zip(topics) {
            let definition = definitions.of(&topic).cloned();
            let at = definition.as_ref().map(Rc::as_ptr);
            // The first topic with a schema gives it its id.
            let schema = *schemas.entry((topic.ty.clone(), at)).or_insert(id);
            if schema == id {
                let name = topic.ty.clone();
                let definition = definition.as_deref();
                // Without a definition, rosbag2 writes neither a text nor an encoding into MCAP files.
                let encoding = definition.map_or("", |definition| &definition.encoding).to_owned();
                let text = definition.map_or(&b""[..], |definition| definition.text.as_bytes());
                self.record(Event::Schema { id, name, encoding, text })?;
            }
            let Topic { id: number, name, encoding, hash, qos, .. } = topic;
            channels.insert(number, id);
            // In a truncated file, a part of the text may be missing.
            let qos = if qos.contains('\0') { String::new() } else { qos };
            let stated = self.encodings.and_then(|encodings| encodings.get(&name));
            let encoding = stated.cloned().unwrap_or(encoding);
            let metadata = [(HASH.to_owned(), hash), (QOS.to_owned(), qos)].into();
            self.record(Event::Channel { id, schema, topic: name, encoding, metadata })?;
        }
        let (mut result, mut undeclared) = (Ok(()), BTreeSet::new());
        let read = database.messages(|Message { topic, time, payload }| {
            result = match (channels.get(&topic), payload) {
                (Some(channel), Ok(payload)) => self.message(*channel, time, payload),
                (_, Err(problem)) => {
                    is_whole = false;
                    self.problems.add(problem);
                    Ok(())
                }
                (None, _) => {
                    if undeclared.insert(topic) {
                        let problem = "which the bag doesn't declare";
                        self.problems.add(format!("a message refers to topic {topic}, {problem}"));
                    }
                    Ok(())
                }
            };
            if result.is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        result?;
        if self.report(read) && is_whole {
            self.report(database.check_structure());
        }
        Ok(())
    }

    fn record(&mut self, event: Event<'_>) -> Result<(), Error> {
        (self.take)(Item { offset: 0, packing: None, event }, self.problems)
    }

    fn message(&mut self, channel: u16, time: u64, payload: &[u8]) -> Result<(), Error> {
        // SQLite reads the file. Reading as many bytes shows the progress, and notices an interruption.
        io::copy(&mut self.input.take(payload.len() as u64), &mut io::sink())?;
        if let Some(error) = self.input.error.take() {
            return Err(Error::Input(error.to_string()));
        }
        self.record(Event::Message { channel, time, publish_time: time, sequence: 0, payload })
    }

    /// Adds the problem if there is one. Returns true if there is none.
    fn report(&mut self, result: Result<(), sqlite::Problem>) -> bool {
        let Err(problem) = result else { return true };
        self.problems.add(problem.text);
        false
    }
}
