//! The facts in a bag that indicate its release.

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, Read, Seek as _, SeekFrom};
use std::path::Path;

use mcap::records::op;
use uavspec_capture::MCAP_MAGIC;
use uavspec_capture::mcap::{ENDPOINT, Event, Item, LIBRARY, OWN, Reader, metadata};
use uavspec_capture::rosbag::metadata::distribution;
use uavspec_capture::rosbag::sqlite::{Bag, Definition, Facts};
use uavspec_model::Endpoint;
use uavspec_model::limits::MAX_NAME;
use uavspec_rules::definitions::{Clues, Shared, TypeClue, plain_name, version_of_topic};
use uavspec_schema::derived_from;

use super::cdr::decompressed;
use super::{HASH, is_comparable};
use crate::Source;
use crate::json::Found;
use crate::limits::{MAX_METADATA, MAX_SCHEMA, MAX_SCHEMAS, MAX_TYPES};
use crate::release::MAX_AHEAD;
use crate::topic::full_name;

/// The name and the key of the metadata record in which rosbag2 stores the ROS distribution.
pub(crate) const DISTRIBUTION: (&str, &str) = ("rosbag2", "ROS_DISTRO");

/// The length of an MCAP file's footer record with the magic at the end of the file, in bytes.
const FOOTER: usize = 9 + 20 + 8;

/// Reads the declarations in an MCAP file: from its summary, if the summary shows all types; otherwise, from the start
/// of the file.
pub(super) fn mcap(source: &mut Source<'_>, shared: &Shared) -> Clues {
    let summary =
        source.file.and_then(summary).map(|summary| declarations(summary, shared)).unwrap_or_default();
    let summary = Clues { distribution: source.file.and_then(indexed_distribution), ..summary };
    let has_hash = |clue: &TypeClue| clue.type_hash.is_some();
    // The summary of a recording lacks the endpoints.
    if !source.file.is_some_and(is_recording)
        && !summary.types.is_empty()
        && summary.types.values().all(has_hash)
    {
        return summary;
    }
    // The messages at the start indicate the sizes of types without a hash.
    let mut clues = declarations(&mut *source.bytes, shared);
    merge(&mut clues, summary);
    clues
}

/// Adds the facts in another file of a bag. Each file may contain the hash or the size of a type, or neither.
pub(super) fn merge(clues: &mut Clues, others: Clues) {
    for (name, versions) in others.topic_versions {
        clues.topic_versions.entry(name).or_default().extend(versions);
    }
    for (name, other) in others.types {
        let known = clues.types.entry(name).or_default();
        known.type_hash = known.type_hash.take().or(other.type_hash);
        known.size = known.size.or(other.size);
        known.json = known.json.take().or(other.json);
        known.versions.extend(other.versions);
    }
    for (topic, format) in others.formats {
        clues.formats.entry(topic).or_insert(format);
    }
    clues.distribution = clues.distribution.take().or(others.distribution);
}

/// Reads the declarations in an MCAP file that is still being written.
pub(crate) fn recording(path: &Path, shared: &Shared) -> io::Result<Clues> {
    Ok(declarations(File::open(path)?.take(MAX_AHEAD), shared))
}

/// The ROS distribution in the metadata records that the summary of an MCAP file lists.
fn indexed_distribution(path: &Path) -> Option<String> {
    let mut summary = summary(path)?;
    let mut magic = [0; MCAP_MAGIC.len()];
    summary.read_exact(&mut magic).ok()?;
    let mut file = File::open(path).ok()?;
    let mut found = None;
    for _ in 0..MAX_TYPES {
        let Some((opcode, length)) = record_head(&mut summary) else { break };
        if opcode != op::METADATA_INDEX {
            io::copy(&mut (&mut summary).take(length), &mut io::sink()).ok()?;
            continue;
        }
        let mut index = Vec::new();
        (&mut summary).take(length).read_to_end(&mut index).ok()?;
        let offset = u64::from_le_bytes(*index.first_chunk()?);
        file.seek(SeekFrom::Start(offset)).ok()?;
        let (_, length) = record_head(&mut file)
            .filter(|(opcode, length)| *opcode == op::METADATA && *length <= MAX_METADATA)?;
        let mut body = Vec::new();
        (&mut file).take(length).read_to_end(&mut body).ok()?;
        found = stated_distribution(&body).or(found);
    }
    found
}

/// The opcode and the length of a record.
fn record_head(input: &mut impl Read) -> Option<(u8, u64)> {
    let mut head = [0; 9];
    input.read_exact(&mut head).ok()?;
    let [opcode, length @ ..] = head;
    Some((opcode, u64::from_le_bytes(length)))
}

/// The ROS distribution in the body of a metadata record. rosbag2 writes such records.
pub(crate) fn stated_distribution(body: &[u8]) -> Option<String> {
    let (_, values) = metadata(body).filter(|(name, _)| name == DISTRIBUTION.0)?;
    let in_yaml = || distribution(values.get("serialized_metadata")?);
    values
        .get(DISTRIBUTION.1)
        .cloned()
        .or_else(in_yaml)
        .filter(|name| !name.is_empty() && name.len() <= MAX_NAME)
}

/// True if this program wrote a file.
fn is_recording(path: &Path) -> bool {
    let Ok(file) = File::open(path) else { return false };
    let mut reader = Reader::new(file);
    let first = reader.next();
    matches!(first, Ok(Some(Item { event: Event::Header { library, .. }, .. })) if library.starts_with(LIBRARY))
}

/// The summary of an MCAP file, preceded by the magic.
fn summary(path: &Path) -> Option<impl Read> {
    let mut file = File::open(path).ok()?;
    let footer_start = file.seek(SeekFrom::End(-i64::try_from(FOOTER).ok()?)).ok()?;
    let mut footer = [0; FOOTER];
    file.read_exact(&mut footer).ok()?;
    let [0x02, 20, 0, 0, 0, 0, 0, 0, 0, start @ ..] = footer else { return None };
    let start = u64::from_le_bytes(*start.first_chunk()?);
    let length = footer_start.checked_sub(start).filter(|_| start > 0)?;
    file.seek(SeekFrom::Start(start)).ok()?;
    Some(MCAP_MAGIC.chain(file.take(length)))
}

fn declarations(input: impl Read, shared: &Shared) -> Clues {
    let mut reader = Reader::new(input);
    let mut clues = Clues::default();
    let mut schemas: HashMap<u16, (String, Option<String>)> = HashMap::new();
    let mut room = MAX_SCHEMAS;
    // The types of channels whose schema is empty.
    let mut unknown: HashMap<u16, String> = HashMap::new();
    // The topics and types of JSON channels without a non-empty message.
    let (mut json, mut found) = (HashMap::new(), Found::default());
    while let Ok(Some(item)) = reader.next() {
        match item.event {
            Event::Schema { id, name, encoding, text }
                if name.len() <= MAX_NAME && schemas.len() < MAX_TYPES && !schemas.contains_key(&id) =>
            {
                let is_read = encoding == "ros2msg" && text.len() <= MAX_SCHEMA.min(room);
                let hash = is_read.then(|| schema_hash(&name, text, shared)).flatten();
                room -= if is_read { text.len() } else { 0 };
                schemas.insert(id, (name, hash));
            }
            // Another file may follow, in which the ids have a different meaning.
            Event::Header { .. } => {
                schemas.clear();
                unknown.clear();
                json.clear();
            }
            Event::Channel { metadata, .. } if metadata.contains_key(OWN) => {}
            Event::Channel { id, schema, topic, encoding, metadata } if encoding == "cdr" => {
                let Some((name, hash)) = schemas.get(&schema) else { continue };
                let stated = metadata.get(HASH).filter(|hash| is_comparable(hash));
                if let Some(name) = add(&mut clues, &topic, name, hash.as_ref().or(stated)) {
                    unknown.insert(id, name);
                }
            }
            Event::Channel { id, schema, topic, encoding, .. } if encoding == "json" => {
                let ty = schemas.get(&schema).map(|(name, _)| name.clone()).unwrap_or_default();
                if json.len() < MAX_TYPES && topic.len() <= MAX_NAME {
                    json.insert(id, (topic, ty));
                }
            }
            Event::Message { channel, payload, .. } => {
                if let Some((topic, ty)) = json.get(&channel)
                    && found.add_message(topic, ty, payload)
                {
                    json.remove(&channel);
                }
                if let Some(clue) = unknown.remove(&channel).and_then(|name| clues.types.get_mut(&name)) {
                    clue.size = size_of(payload);
                }
            }
            Event::Metadata { body } => {
                clues.distribution = stated_distribution(body).or(clues.distribution.take());
                let values = metadata(body).filter(|(name, _)| name == ENDPOINT).map(|(_, values)| values);
                let endpoint = values.as_ref().and_then(Endpoint::from_values);
                let is_used =
                    |endpoint: &Endpoint| !endpoint.is_own() && endpoint.type_name.len() <= MAX_NAME;
                if let Some(endpoint) = endpoint.filter(is_used) {
                    add_version(&mut clues, &endpoint.topic, &full_name(&endpoint.type_name));
                }
            }
            _ => {}
        }
    }
    let mut in_json = found.into_clues();
    // The facts from CDR channels take precedence.
    in_json.types.retain(|name, _| !clues.types.contains_key(name));
    merge(&mut clues, in_json);
    clues
}

/// Reads the declarations in a `SQLite` file.
pub(super) fn sqlite(source: &mut Source<'_>, shared: &Shared) -> Clues {
    let Some((bag, _)) = source.file.and_then(|path| Bag::open(path).ok()) else {
        return Clues::default();
    };
    let mut hashes: Facts<Option<String>> = Facts::default();
    let _ = bag.definitions(|definition| {
        if definition.ty.len() <= MAX_NAME {
            let hash = definition_hash(&definition, shared);
            let is_verified = hash.as_ref().is_some_and(|hash| hash.eq_ignore_ascii_case(&definition.hash));
            hashes.add(&definition.ty, &definition.hash, is_verified, hash);
        }
    });
    let distribution = Some(bag.distribution()).filter(|name| !name.is_empty());
    let (mut clues, mut unknown) = (Clues { distribution, ..Clues::default() }, HashMap::new());
    let _ = bag.topics(|topic| {
        let stated = Some(&topic.hash).filter(|hash| is_comparable(hash));
        let hash = hashes.of(&topic).and_then(Option::as_ref).or(stated);
        if topic.encoding == "cdr"
            && topic.ty.len() <= MAX_NAME
            && unknown.len() < MAX_TYPES
            && let Some(name) = add(&mut clues, &topic.name, &topic.ty, hash)
        {
            unknown.insert(topic.id, name);
        }
    });
    // The check reports messages that can't be read.
    let _ = bag.first_messages(unknown.keys().copied().collect(), |topic, payload| {
        if let Some(clue) = unknown.get(&topic).and_then(|name| clues.types.get_mut(name)) {
            clue.size = size_of(payload);
        }
    });
    clues
}

/// The size of a message in CDR. `None` if the message can't be decompressed.
fn size_of(payload: &[u8]) -> Option<u64> {
    Some(decompressed(payload).ok()?.len() as u64)
}

/// Adds the type of a topic. If the hash of the type isn't known, returns the name of the type.
fn add(clues: &mut Clues, topic: &str, name: &str, hash: Option<&String>) -> Option<String> {
    let name = full_name(name);
    if clues.types.len() >= MAX_TYPES {
        return None;
    }
    let clue = clues.types.entry(name.clone()).or_default();
    if clue.type_hash.is_none() {
        clue.type_hash = hash.cloned();
    }
    clue.versions.extend(version_of_topic(topic));
    let is_unknown = clue.type_hash.is_none();
    add_version(clues, topic, &name);
    is_unknown.then_some(name)
}

/// Adds the version in the name of a topic.
fn add_version(clues: &mut Clues, topic: &str, name: &str) {
    let is_known = clues.topic_versions.contains_key(name);
    if let Some(version) = version_of_topic(topic)
        && (is_known || clues.topic_versions.len() < MAX_TYPES)
    {
        clues.topic_versions.entry(name.to_owned()).or_default().insert(version);
    }
}

/// True if the text of a definition in a `SQLite` file matches the type hash in the file.
pub(super) fn has_its_hash(definition: &Definition, shared: &Shared) -> bool {
    let is_stated = |hash: String| hash.eq_ignore_ascii_case(&definition.hash);
    !definition.hash.is_empty() && definition_hash(definition, shared).is_some_and(is_stated)
}

/// The type hash of a definition in a `SQLite` file, calculated from its text.
fn definition_hash(definition: &Definition, shared: &Shared) -> Option<String> {
    let is_read = definition.encoding == "ros2msg";
    is_read.then(|| schema_hash(&definition.ty, definition.text.as_bytes(), shared)).flatten()
}

/// The type hash of a schema, calculated from its text. Returns `None` for a type that ROS 2 derives from a service or
/// an action, because its hash isn't the hash of a definition. Also returns `None` for an empty schema, which rosbag2
/// writes if it can't find the definition.
fn schema_hash(name: &str, text: &[u8], shared: &Shared) -> Option<String> {
    if text.is_empty() || derived_from(&plain_name(name)).is_some() {
        return None;
    }
    Some(shared.stated(name, text).ok()?.type_hash.clone())
}
