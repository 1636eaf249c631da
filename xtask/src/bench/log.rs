//! Logs derived from other logs: longer or shorter, and some with a violation.

use std::collections::HashMap;
use std::path::PathBuf;
use std::{fs, io};

use uavspec_dynamic::{Field, Types, ULOG_PACKAGE};
use uavspec_runtime::Scalar;
use uavspec_schema::{Element, Shape};

/// The size of the header of a file.
const HEADER: usize = 16;

/// The size of the header of a message: its size and its type.
const MESSAGE: usize = 3;

/// The position of the timestamp in a data message, after the id.
const TIMESTAMP: usize = MESSAGE + 2;

/// The size of a data message that is too short: an id, a timestamp and a byte.
const SHORT: u16 = 11;

/// A log.
pub(super) struct Log {
    /// The header and the definitions.
    definitions: Vec<u8>,
    messages: Vec<Message>,
    topics: HashMap<u16, Topic>,
    /// The time from the first to the last message, plus one period, in µs.
    span: u64,
}

/// A message of the data section.
struct Message {
    bytes: Vec<u8>,
    /// The position of the time in the message. Copies of the message shift this time.
    time: Option<usize>,
    /// The subscription of a data message.
    id: Option<u16>,
}

struct Topic {
    name: String,
    /// The position of the first bool in a payload.
    flag: Option<usize>,
}

/// A violation to insert into a message.
#[derive(Clone, Copy, Debug)]
pub(super) enum Violation {
    /// A bool is neither 0 nor 1.
    Flag,
    /// A data message is shorter than its format.
    Size,
    /// A timestamp is less than the previous timestamp.
    Time,
}

impl Violation {
    pub(super) const ALL: [Self; 3] = [Self::Flag, Self::Size, Self::Time];

    pub(super) const fn rule(self) -> &'static str {
        match self {
            Self::Flag => "PX-BOOL-01",
            Self::Size => "PX-DATA-01",
            Self::Time => "PX-TIME-01",
        }
    }

    /// Changes the last message, which starts at `start`. Returns false if it can't be changed.
    fn apply(self, bytes: &mut Vec<u8>, start: usize, topic: &Topic, earlier: Option<u64>) -> bool {
        let message = &mut bytes[start..];
        match self {
            Self::Flag => {
                let byte = topic.flag.and_then(|flag| message.get_mut(TIMESTAMP + flag));
                byte.map(|byte| *byte = 2).is_some()
            }
            Self::Time => {
                let time = earlier.and_then(|earlier| earlier.checked_sub(1)).filter(|time| *time > 0);
                let bytes = message.get_mut(TIMESTAMP..TIMESTAMP + 8).zip(time);
                bytes.map(|(bytes, time)| bytes.copy_from_slice(&time.to_le_bytes())).is_some()
            }
            // Without padding, payloads may be shorter than their format, so more than the longest padding must be
            // missing.
            Self::Size if message.len() > MESSAGE + usize::from(SHORT) + 8 => {
                message[..2].copy_from_slice(&SHORT.to_le_bytes());
                bytes.truncate(start + MESSAGE + usize::from(SHORT));
                true
            }
            Self::Size => false,
        }
    }
}

impl Log {
    /// Reads the logs of the corpus.
    pub(super) fn of_corpus() -> io::Result<Vec<Self>> {
        let entries = fs::read_dir(super::corpus().join("ulog"))?;
        let mut paths: Vec<PathBuf> = entries.map(|entry| Ok(entry?.path())).collect::<io::Result<_>>()?;
        paths.sort();
        let logs = paths.iter().map(|path| Ok(Self::read(&fs::read(path)?)));
        Ok(logs.collect::<io::Result<Vec<Option<Self>>>>()?.into_iter().flatten().collect())
    }

    /// Reads a log. Returns `None` for a file that isn't a log.
    fn read(bytes: &[u8]) -> Option<Self> {
        let (header, mut rest) = bytes.split_at_checked(HEADER)?;
        let mut log =
            Self { definitions: header.to_vec(), messages: Vec::new(), topics: HashMap::new(), span: 0 };
        let (mut formats, mut is_data, mut times) = (Vec::new(), false, Vec::new());
        while let Some([low, high, kind, ..]) = rest.first_chunk::<MESSAGE>() {
            let size = MESSAGE + usize::from(u16::from_le_bytes([*low, *high]));
            let Some((message, others)) = rest.split_at_checked(size) else { break };
            rest = others;
            let content = &message[MESSAGE..];
            is_data |= matches!(kind, b'A' | b'D' | b'L' | b'C');
            if *kind == b'F' {
                formats.push(str::from_utf8(content).ok()?.split_once(':')?);
            }
            if !is_data {
                log.definitions.extend(message);
                continue;
            }
            let (time, id) = match (kind, content) {
                (b'D', [low, high, ..]) => (Some(TIMESTAMP), Some(u16::from_le_bytes([*low, *high]))),
                (b'L', _) => (Some(MESSAGE + 1), None),
                (b'C', _) => (Some(MESSAGE + 3), None),
                _ => (None, None),
            };
            if let (b'A', [_, low, high, name @ ..]) = (kind, content) {
                let name = str::from_utf8(name).ok()?.to_owned();
                log.topics.insert(u16::from_le_bytes([*low, *high]), Topic { name, flag: None });
            }
            times.extend(time.and_then(|time| u64_at(message, time)));
            log.messages.push(Message { bytes: message.to_vec(), time, id });
        }
        let (types, _) = Types::from_ulog_formats(formats);
        let is_flag =
            |field: &&Field| field.element == Element::Scalar(Scalar::Bool) && field.shape == Shape::Single;
        for topic in log.topics.values_mut() {
            let ty = types.find(ULOG_PACKAGE, &topic.name);
            topic.flag = ty.and_then(|ty| Some(ty.fields().iter().find(is_flag)?.offset));
        }
        log.span = times.iter().max()? - times.iter().min()? + 1_000;
        Some(log)
    }

    /// Creates a log of about this size by repeating the messages of this log with later times. Also returns the topic
    /// of the violation.
    pub(super) fn make(&self, size: usize, mut violation: Option<Violation>) -> (Vec<u8>, Option<&str>) {
        let mut bytes = Vec::with_capacity(size + (1 << 16));
        bytes.extend(&self.definitions);
        let half = usize::midpoint(bytes.len(), size);
        let (mut previous, mut violated) = (HashMap::new(), None);
        for round in 0_u64.. {
            // Stop if no topic has the field to change.
            if round > 1 && bytes.len() > 2 * size {
                break;
            }
            for message in &self.messages {
                if bytes.len() >= size && violation.is_none() {
                    return (bytes, violated);
                }
                // Repeat only messages with a time. Other messages, such as subscriptions, apply to all rounds.
                if round > 0 && message.time.is_none() {
                    continue;
                }
                let start = bytes.len();
                bytes.extend(&message.bytes);
                let added = &mut bytes[start..];
                let time = message.time.and_then(|time| Some((time, u64_at(added, time)?)));
                if let Some((position, time)) = time {
                    let time = time + round * self.span;
                    added[position..position + 8].copy_from_slice(&time.to_le_bytes());
                }
                let Some((id, (_, time))) = message.id.zip(time) else { continue };
                let earlier = previous.insert(id, time + round * self.span);
                if let (Some(kind), Some(topic)) = (violation.filter(|_| start >= half), self.topics.get(&id))
                    && kind.apply(&mut bytes, start, topic, earlier)
                {
                    (violation, violated) = (None, Some(topic.name.as_str()));
                }
            }
        }
        (bytes, violated)
    }
}

fn u64_at(bytes: &[u8], position: usize) -> Option<u64> {
    Some(u64::from_le_bytes(bytes.get(position..position + 8)?.try_into().ok()?))
}
