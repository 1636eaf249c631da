//! Makes bags with the data of logs.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::Path;

use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions, Writer};
use uavspec_dynamic::{Field, MessageType, Types, ULOG_PACKAGE};
use uavspec_runtime::cdr::ByteOrder;
use uavspec_schema::msg::Dialect;
use uavspec_schema::{Element, Form, PackageInput, SourceMap, read};

use crate::Result;

const BAGS: [(&str, Option<Compression>); 3] =
    [("plain", None), ("zstd", Some(Compression::Zstd)), ("lz4", Some(Compression::Lz4))];

/// Writes the data of a log as CDR to bags with each compression. Only topics whose formats agree with `definitions` are
/// written. Returns the number of messages.
pub(crate) fn make(folder: &Path, log: &Path, definitions: &Path) -> Result<u64> {
    let log = fs::read(log)?;
    let defined = types(definitions)?;
    let mut total = 0;
    for (name, compression) in BAGS {
        let file = BufWriter::new(File::create(folder.join(format!("{name}.mcap")))?);
        let mut bag = WriteOptions::new().profile("ros2").compression(compression).create(file)?;
        total += copy(&log, definitions, &defined, &mut bag)?;
        bag.finish()?;
    }
    Ok(total)
}

/// The types that a folder defines.
fn types(folder: &Path) -> Result<Types> {
    let mut sources = SourceMap::default();
    let mut package = PackageInput::new("px4_msgs", Form::Msg(Dialect::Px4), Vec::new());
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let source = sources.add(path.to_string_lossy(), fs::read(&path)?);
        package.sources.push(source.map_err(|_| format!("{}: not UTF-8", path.display()))?);
    }
    Ok(Types::new(&read(&sources, &[package]).0))
}

/// Copies the data of a log to a bag. Returns the number of messages.
fn copy(log: &[u8], definitions: &Path, defined: &Types, bag: &mut Writer<BufWriter<File>>) -> Result<u64> {
    let mut formats = Vec::new();
    for (kind, content) in messages(log) {
        if kind == b'F' {
            formats.push(std::str::from_utf8(content)?.split_once(':').ok_or("a format without a name")?);
        }
    }
    let (types, _) = Types::from_ulog_formats(formats);
    // The type, the channel and the number of messages of each subscription.
    let mut topics: BTreeMap<u16, (MessageType<'_>, u16, u32)> = BTreeMap::new();
    let mut count = 0;
    for (kind, content) in messages(log) {
        match (kind, content) {
            (b'A', [instance, low, high, topic @ ..]) => {
                let topic = std::str::from_utf8(topic)?;
                let definition = defined.iter().find(|ty| snake(ty.name()) == topic);
                let Some((ty, definition)) = types.find(ULOG_PACKAGE, topic).zip(definition) else {
                    continue;
                };
                if !is_same(ty, definition) {
                    continue;
                }
                let name = definition.name();
                let text = fs::read(definitions.join(format!("{name}.msg")))?;
                let schema = bag.add_schema(&format!("px4_msgs/msg/{name}"), "ros2msg", &text)?;
                let instance = if *instance > 0 { instance.to_string() } else { String::new() };
                let topic = format!("/fmu/out/{topic}{instance}");
                let channel = bag.add_channel(schema, &topic, "cdr", &BTreeMap::new())?;
                topics.insert(u16::from_le_bytes([*low, *high]), (ty, channel, 0));
            }
            (b'D', [low, high, payload @ ..]) => {
                let topic = topics.get_mut(&u16::from_le_bytes([*low, *high]));
                let time = payload.first_chunk().map(|time| u64::from_le_bytes(*time) * 1_000);
                let Some(((ty, channel_id, sequence), time)) = topic.zip(time) else { continue };
                *sequence += 1;
                let header = MessageHeader {
                    channel_id: *channel_id,
                    sequence: *sequence,
                    log_time: time,
                    publish_time: time,
                };
                let payload = ty.view_uorb(payload)?.to_cdr(ByteOrder::LittleEndian)?;
                bag.write_to_known_channel(&header, &payload)?;
                count += 1;
            }
            _ => {}
        }
    }
    Ok(count)
}

/// The messages of a log: their kinds and contents.
fn messages(bytes: &[u8]) -> impl Iterator<Item = (u8, &[u8])> {
    let mut rest = bytes.get(16..).unwrap_or_default();
    std::iter::from_fn(move || {
        let (header, others) = rest.split_first_chunk::<3>()?;
        let size = u16::from_le_bytes([header[0], header[1]]);
        let (content, others) = others.split_at_checked(size.into())?;
        rest = others;
        Some((header[2], content))
    })
}

/// True if two types have the same fields in memory. Types that contain others are never the same.
fn is_same(left: MessageType<'_>, right: MessageType<'_>) -> bool {
    let place = |field: &Field| (field.name.clone(), field.element, field.shape, field.offset);
    let has_nested = |field: &Field| matches!(field.element, Element::Message(_));
    !left.fields().iter().any(has_nested)
        && left.fields().iter().map(place).eq(right.fields().iter().map(place))
}

/// The name of the topic of a message.
fn snake(name: &str) -> String {
    let mut topic = String::new();
    for letter in name.chars() {
        if letter.is_ascii_uppercase() && !topic.is_empty() {
            topic.push('_');
        }
        topic.push(letter.to_ascii_lowercase());
    }
    topic
}
