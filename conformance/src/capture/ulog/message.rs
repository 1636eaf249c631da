//! Messages, and how they are read from their payloads.

use std::str;

use super::kind::SYNC;
use super::problem::{Malformation, Problem};

/// What a log says at one place, or what is wrong there.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Event<'b> {
    /// The start of the file.
    Start {
        /// Version of the format: 0 or 1.
        version: u8,
        /// When logging began, in microseconds of the vehicle's clock.
        timestamp: u64,
    },
    /// `B`: what a reader must understand, and where data was appended.
    FlagBits {
        /// Bits that a reader may ignore. The lowest: there are default parameters.
        compatible: [u8; 8],
        /// Bits that a reader must know. The lowest: data was appended.
        incompatible: [u8; 8],
        /// Offsets in the file at which data was appended; 0 where none was.
        appended: [u64; 3],
    },
    /// `F`: the fields of a type.
    Format {
        /// Name of the type.
        name: &'b str,
        /// Its fields, as `uint64_t timestamp;float[3] xyz;`.
        fields: &'b str,
    },
    /// `I`: something about the system or the log.
    Information {
        /// What.
        key: &'b str,
        /// Type of the value, as `char[8]`.
        ty: &'b str,
        /// Little-endian, as long as the type says unless a problem follows.
        value: &'b [u8],
    },
    /// `M`: one of several values of a key, or a part of one.
    MultiInformation {
        /// Whether the value goes on with the last one of this key.
        is_continued: bool,
        /// What.
        key: &'b str,
        /// Type of the value.
        ty: &'b str,
        /// As in [`Information`](Self::Information).
        value: &'b [u8],
    },
    /// `P`: the value of a parameter, at the start or when it changed.
    Parameter {
        /// Its name.
        key: &'b str,
        /// `int32_t` or `float`.
        ty: &'b str,
        /// As in [`Information`](Self::Information).
        value: &'b [u8],
    },
    /// `Q`: the value that a parameter has by default.
    DefaultParameter {
        /// Bits. The lowest: of the firmware; the next: of the airframe.
        defaults: u8,
        /// Its name.
        key: &'b str,
        /// `int32_t` or `float`.
        ty: &'b str,
        /// As in [`Information`](Self::Information).
        value: &'b [u8],
    },
    /// `A`: data of a topic comes under an id from here on.
    Subscription {
        /// Which instance of the topic.
        multi_id: u8,
        /// The id of its data.
        id: u16,
        /// The topic, which is the name of its format too.
        name: &'b str,
    },
    /// `R`: no more data comes under an id.
    Unsubscription {
        /// The id.
        id: u16,
    },
    /// `D`: a message of a topic.
    Data {
        /// Under which id its topic was subscribed.
        id: u16,
        /// The message as it lies in memory.
        payload: &'b [u8],
    },
    /// `L` and `C`: a line of text.
    Logging {
        /// As in syslog, an ASCII digit: `0` is an emergency, `7` is for debugging.
        level: u8,
        /// Where the text is from (`C` only).
        tag: Option<u16>,
        /// When, in microseconds.
        timestamp: u64,
        /// The text, up to the first byte that isn't UTF-8.
        text: &'b str,
    },
    /// `S`: a mark to find after damage.
    Synchronisation,
    /// `O`: messages were lost, since writing was too slow.
    Dropout {
        /// How long.
        milliseconds: u16,
    },
    /// A message of a kind that isn't known.
    Unknown {
        /// The letter of the kind.
        kind: u8,
        /// All of it.
        payload: &'b [u8],
    },
    /// Something is wrong here.
    Problem(Problem),
}

/// A message, and what is odd about it.
pub(super) type Parsed<'b> = (Event<'b>, Option<Malformation>);

/// Reads the payload of a message of any kind. An error where nothing of it can be used.
pub(super) fn parse(kind: u8, payload: &[u8]) -> Result<Parsed<'_>, Malformation> {
    let mut rest = Payload { rest: payload, size: payload.len() };
    let event = match kind {
        b'B' => Event::FlagBits {
            compatible: rest.take()?,
            incompatible: rest.take()?,
            appended: [rest.u64()?, rest.u64()?, rest.u64()?],
        },
        b'F' => {
            let (name, fields) = rest.text()?.split_once(':').ok_or(Malformation::NoColon)?;
            Event::Format { name: named(name)?, fields }
        }
        b'I' => {
            let ((ty, key), value) = rest.entry()?;
            return Ok((Event::Information { key, ty, value }, odd_value(ty, value)));
        }
        b'M' => {
            let is_continued = rest.u8()? != 0;
            let ((ty, key), value) = rest.entry()?;
            return Ok((Event::MultiInformation { is_continued, key, ty, value }, odd_size(ty, value)));
        }
        b'P' => {
            let ((ty, key), value) = rest.entry()?;
            return Ok((Event::Parameter { key, ty, value }, odd_value(ty, value)));
        }
        b'Q' => {
            let defaults = rest.u8()?;
            let ((ty, key), value) = rest.entry()?;
            return Ok((Event::DefaultParameter { defaults, key, ty, value }, odd_value(ty, value)));
        }
        b'A' => {
            Event::Subscription { multi_id: rest.u8()?, id: rest.u16()?, name: rest.text().and_then(named)? }
        }
        b'R' => Event::Unsubscription { id: rest.u16()? },
        b'D' => Event::Data { id: rest.u16()?, payload: rest.rest },
        b'L' | b'C' => return logging(kind, rest),
        b'S' if rest.take()? == SYNC => Event::Synchronisation,
        b'S' => return Err(Malformation::SyncMagic),
        b'O' => Event::Dropout { milliseconds: rest.u16()? },
        _ => Event::Unknown { kind, payload },
    };
    Ok((event, None))
}

fn logging(kind: u8, mut rest: Payload<'_>) -> Result<Parsed<'_>, Malformation> {
    let level = rest.u8()?;
    let tag = if kind == b'C' { Some(rest.u16()?) } else { None };
    let timestamp = rest.u64()?;
    let (text, odd) = match str::from_utf8(rest.rest) {
        Ok(text) => (text, None),
        Err(error) => {
            let valid = str::from_utf8(&rest.rest[..error.valid_up_to()]).unwrap_or_default();
            (valid, Some(Malformation::NotUtf8 { at: rest.position() + error.valid_up_to() }))
        }
    };
    Ok((Event::Logging { level, tag, timestamp, text }, odd))
}

fn named(name: &str) -> Result<&str, Malformation> {
    if name.is_empty() { Err(Malformation::NoName) } else { Ok(name) }
}

/// What is odd about the value of an information or a parameter.
fn odd_value(ty: &str, value: &[u8]) -> Option<Malformation> {
    let is_text = ty.starts_with("char[") && str::from_utf8(value).is_err();
    odd_size(ty, value).or_else(|| is_text.then_some(Malformation::ValueNotUtf8))
}

/// Whether a value has another size than its type; other types than basic ones have any. The parts of a
/// value may be cut within a character, so their text isn't looked at.
fn odd_size(ty: &str, value: &[u8]) -> Option<Malformation> {
    let (element, count) = match ty.split_once('[') {
        None => (ty, 1),
        Some((element, count)) => (element, count.strip_suffix(']')?.parse::<u64>().ok()?),
    };
    let size: u64 = match element {
        "int8_t" | "uint8_t" | "bool" | "char" => 1,
        "int16_t" | "uint16_t" => 2,
        "int32_t" | "uint32_t" | "float" => 4,
        "int64_t" | "uint64_t" | "double" => 8,
        _ => return None,
    };
    let expected = size.saturating_mul(count);
    let found = value.len();
    (expected != found as u64).then_some(Malformation::ValueSize { expected, found })
}

/// A payload that is read from its start.
#[derive(Clone, Copy)]
struct Payload<'b> {
    rest: &'b [u8],
    size: usize,
}

impl<'b> Payload<'b> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Malformation> {
        let least = self.position() + N;
        let (taken, rest) =
            self.rest.split_first_chunk().ok_or(Malformation::TooShort { size: self.size, least })?;
        self.rest = rest;
        Ok(*taken)
    }

    fn u8(&mut self) -> Result<u8, Malformation> {
        self.take().map(u8::from_le_bytes)
    }

    fn u16(&mut self) -> Result<u16, Malformation> {
        self.take().map(u16::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, Malformation> {
        self.take().map(u64::from_le_bytes)
    }

    /// All that is left.
    fn text(&self) -> Result<&'b str, Malformation> {
        self.utf8(self.rest)
    }

    fn utf8(&self, bytes: &'b [u8]) -> Result<&'b str, Malformation> {
        str::from_utf8(bytes)
            .map_err(|error| Malformation::NotUtf8 { at: self.position() + error.valid_up_to() })
    }

    /// A key with its type, and all that is left as its value.
    fn entry(&mut self) -> Result<((&'b str, &'b str), &'b [u8]), Malformation> {
        let length = usize::from(self.u8()?);
        let room = self.rest.len();
        let (key, value) =
            self.rest.split_at_checked(length).ok_or(Malformation::KeyLength { length, room })?;
        let key = self.utf8(key)?.split_once(' ').ok_or(Malformation::NoType)?;
        named(key.0).and_then(|_| named(key.1))?;
        Ok((key, value))
    }

    /// Where in the payload the rest starts.
    fn position(&self) -> usize {
        self.size - self.rest.len()
    }
}
