//! Logs that are made from other logs: longer or shorter, and some with a violation.

use std::collections::HashMap;

/// The size of the header of a file.
const HEADER: usize = 16;

/// The size of the header of a message: its size and its type.
const MESSAGE: usize = 3;

/// The position of the timestamp in a data message, behind the id.
const TIMESTAMP: usize = MESSAGE + 2;

/// The size of a data message that is too short: an id, a timestamp and a byte.
const SHORT: u16 = 11;

/// A log.
pub(super) struct Log {
    /// The header and the definitions.
    definitions: Vec<u8>,
    data: Vec<u8>,
    messages: Vec<Message>,
    topics: HashMap<u16, Topic>,
    /// The time from the first to the last message, and a period, in µs.
    span: u64,
}

/// A message of the data section.
struct Message {
    start: usize,
    end: usize,
    /// The time that a copy shifts: its position in the message.
    time: Option<usize>,
    /// The subscription of a data message.
    id: Option<u16>,
}

struct Topic {
    name: String,
    /// The position of the first bool in a payload.
    flag: Option<usize>,
}

/// A change of a message.
#[derive(Clone, Copy, Debug)]
pub(super) enum Violation {
    /// A bool is neither 0 nor 1.
    Flag,
    /// A data message is shorter than its format.
    Size,
    /// A timestamp is less than the one before.
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
            // More than the longest padding is missing.
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
    /// Reads a log. Returns `None` for a file that isn't one.
    pub(super) fn read(bytes: &[u8]) -> Option<Self> {
        let mut formats: HashMap<String, String> = HashMap::new();
        let mut log = Self {
            definitions: bytes.get(..HEADER)?.to_vec(),
            data: Vec::new(),
            messages: Vec::new(),
            topics: HashMap::new(),
            span: 0,
        };
        let (mut at, mut is_data, mut times) = (HEADER, false, Vec::new());
        while let Some(header) = bytes.get(at..at + MESSAGE) {
            let size = usize::from(u16::from_le_bytes([header[0], header[1]]));
            let Some(message) = bytes.get(at..at + MESSAGE + size) else { break };
            let content = &message[MESSAGE..];
            at += message.len();
            is_data |= matches!(header[2], b'A' | b'D' | b'L' | b'C');
            if header[2] == b'F' {
                let text = std::str::from_utf8(content).ok()?;
                let (name, fields) = text.split_once(':')?;
                formats.insert(name.to_owned(), fields.to_owned());
            }
            if !is_data {
                log.definitions.extend(message);
                continue;
            }
            let start = log.data.len();
            log.data.extend(message);
            let mut entry = Message { start, end: log.data.len(), time: None, id: None };
            match (header[2], content) {
                (b'A', [_, low, high, name @ ..]) => {
                    let name = String::from_utf8(name.to_vec()).ok()?;
                    let flag = formats.get(&name).and_then(|fields| flag(fields));
                    log.topics.insert(u16::from_le_bytes([*low, *high]), Topic { name, flag });
                }
                (b'D', [low, high, ..]) => {
                    entry.id = Some(u16::from_le_bytes([*low, *high]));
                    entry.time = Some(TIMESTAMP);
                }
                (b'L', _) => entry.time = Some(MESSAGE + 1),
                (b'C', _) => entry.time = Some(MESSAGE + 3),
                _ => {}
            }
            times.extend(entry.time.and_then(|time| u64_at(message, time)));
            log.messages.push(entry);
        }
        log.span = times.iter().max()? - times.iter().min()? + 1_000;
        Some(log)
    }

    /// A log of about this size: the messages of this one, which repeat with later times. Also returns the topic of the
    /// violation.
    pub(super) fn make(&self, size: usize, mut violation: Option<Violation>) -> (Vec<u8>, Option<&str>) {
        let mut bytes = Vec::with_capacity(size + (1 << 16));
        bytes.extend(&self.definitions);
        let half = usize::midpoint(bytes.len(), size);
        let (mut previous, mut violated) = (HashMap::new(), None);
        for round in 0_u64.. {
            for message in &self.messages {
                if bytes.len() >= size && violation.is_none() {
                    return (bytes, violated);
                }
                // Subscriptions and the rest last for all rounds.
                if round > 0 && message.time.is_none() {
                    continue;
                }
                let start = bytes.len();
                bytes.extend(&self.data[message.start..message.end]);
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
            // No topic has the field to change.
            if bytes.len() > 2 * (size + self.data.len()) {
                break;
            }
        }
        (bytes, violated)
    }
}

fn u64_at(bytes: &[u8], position: usize) -> Option<u64> {
    Some(u64::from_le_bytes(bytes.get(position..position + 8)?.try_into().ok()?))
}

/// The position of the first bool in a format, if only numbers precede it.
fn flag(fields: &str) -> Option<usize> {
    let mut position = 0;
    for field in fields.split(';') {
        let (ty, _) = field.split_once(' ')?;
        let (ty, count) = match ty.split_once('[') {
            Some((ty, count)) => (ty, count.trim_end_matches(']').parse().ok()?),
            None => (ty, 1),
        };
        let size = match ty {
            "bool" if count == 1 => return Some(position),
            "int8_t" | "uint8_t" | "bool" | "char" => 1,
            "int16_t" | "uint16_t" => 2,
            "int32_t" | "uint32_t" | "float" => 4,
            "int64_t" | "uint64_t" | "double" => 8,
            _ => return None,
        };
        position += size * count;
    }
    None
}
