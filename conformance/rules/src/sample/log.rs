//! Flights as `ULog` files.

use std::collections::BTreeSet;

use sha2::{Digest as _, Sha256};
use uavspec_capture::ULOG_MAGIC;
use uavspec_definitions::PX4_EVENTS;
use uavspec_dynamic::MessageType;
use uavspec_px4::format::{fields, format_name, nested};

use super::{Flight, START};

/// The entries of a `ULog`.
#[derive(Clone, Debug)]
pub struct Log {
    /// The entries after the header.
    pub entries: Vec<Entry>,
}

/// An entry of a log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Entry {
    /// Flag bits, none of which is set.
    FlagBits,
    /// A key with its type, and a value.
    Information(&'static str, Vec<u8>),
    /// Event metadata, in one piece.
    Metadata(Vec<u8>),
    /// A format: its name and its fields.
    Format(String, String),
    /// A subscription: id, instance and topic.
    Subscription(u16, u8, String),
    /// A data message: id and payload.
    Data(u16, Vec<u8>),
    /// A dropout: its duration in ms.
    Dropout(u16),
}

impl Log {
    /// Creates the log for a flight. The id of a topic is its index.
    pub(super) fn from_flight(flight: &Flight<'_>) -> Self {
        let digest: String = Sha256::digest(PX4_EVENTS).iter().map(|byte| format!("{byte:02x}")).collect();
        let mut log = Self {
            entries: vec![
                Entry::FlagBits,
                Entry::Information("char[3] sys_name", b"PX4".to_vec()),
                Entry::Information("char[64] metadata_events_sha256", digest.into_bytes()),
                Entry::Metadata(PX4_EVENTS.to_vec()),
            ],
        };
        let mut named = BTreeSet::new();
        for (index, topic) in flight.topics.iter().enumerate() {
            log.format(&topic.name, flight.type_of(index), &mut named);
        }
        for (id, topic) in (0..).zip(&flight.topics) {
            log.entries.push(Entry::Subscription(id, 0, topic.name.clone()));
        }
        for sent in &flight.messages {
            let payload = flight.message(sent).and_then(|message| message.to_uorb().ok());
            let id = u16::try_from(sent.topic).ok();
            log.entries.extend(id.zip(payload).map(|(id, payload)| Entry::Data(id, payload)));
        }
        log
    }

    /// Adds the formats of a type and its nested types.
    fn format(&mut self, name: &str, ty: MessageType<'_>, named: &mut BTreeSet<String>) {
        if !named.insert(name.to_owned()) {
            return;
        }
        self.entries.push(Entry::Format(name.to_owned(), fields(ty)));
        for nested in nested(ty) {
            self.format(&format_name(nested.name()), nested, named);
        }
    }

    /// The number of data messages.
    pub(super) fn messages(&self) -> usize {
        self.entries.iter().filter(|entry| matches!(entry, Entry::Data(..))).count()
    }

    /// Changes the last payload of a topic.
    #[must_use]
    pub(crate) fn with_payload(mut self, topic: usize, change: impl FnOnce(&mut Vec<u8>)) -> Option<Self> {
        let payload = self.entries.iter_mut().rev().find_map(|entry| match entry {
            Entry::Data(id, payload) if usize::from(*id) == topic => Some(payload),
            _ => None,
        })?;
        change(payload);
        Some(self)
    }

    /// The fields of the format with this name.
    pub fn format_mut(&mut self, name: &str) -> Option<&mut String> {
        self.entries.iter_mut().find_map(|entry| match entry {
            Entry::Format(known, fields) if known == name => Some(fields),
            _ => None,
        })
    }

    /// The bytes of the file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = [&ULOG_MAGIC[..], &[1], &START.to_le_bytes()].concat();
        for entry in &self.entries {
            let (kind, payload) = entry.to_bytes();
            // No definition leads to an entry that is longer than the format allows.
            bytes.extend(u16::try_from(payload.len()).unwrap_or(u16::MAX).to_le_bytes());
            bytes.push(kind);
            bytes.extend(payload);
        }
        bytes
    }
}

impl Entry {
    fn to_bytes(&self) -> (u8, Vec<u8>) {
        match self {
            Self::FlagBits => (b'B', vec![0; 40]),
            Self::Information(key, value) => {
                let length = u8::try_from(key.len()).unwrap_or(u8::MAX);
                (b'I', [&[length], key.as_bytes(), value].concat())
            }
            Self::Metadata(json) => {
                let key = format!("uint8_t[{}] metadata_events", json.len());
                let length = u8::try_from(key.len()).unwrap_or(u8::MAX);
                // The first piece doesn't continue another one.
                (b'M', [&[0, length], key.as_bytes(), json].concat())
            }
            Self::Format(name, fields) => (b'F', format!("{name}:{fields}").into_bytes()),
            Self::Subscription(id, multi_id, topic) => {
                (b'A', [&[*multi_id], &id.to_le_bytes()[..], topic.as_bytes()].concat())
            }
            Self::Data(id, payload) => (b'D', [&id.to_le_bytes()[..], payload].concat()),
            Self::Dropout(milliseconds) => (b'O', milliseconds.to_le_bytes().to_vec()),
        }
    }
}
