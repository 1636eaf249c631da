//! The messages of a log, and the parser of their payloads.

use std::str;

use super::kind::SYNC;
use super::problem::{Malformation, Problem};

/// A message of a log, or a problem.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Event<'b> {
    /// The start of the file.
    Start {
        /// The version of the format: 0 or 1.
        version: u8,
        /// The start of logging, in µs of the vehicle's clock.
        timestamp: u64,
    },
    /// `B`: the features that readers must support, and the offsets of appended data.
    FlagBits {
        /// Bits that readers may ignore. The lowest bit means that the log has default parameters.
        compatible: [u8; 8],
        /// Bits that readers must support. The lowest bit means that data was appended.
        incompatible: [u8; 8],
        /// The offsets of appended data in the file; 0 if unused.
        appended: [u64; 3],
    },
    /// `F`: the fields of a type.
    Format {
        /// The name of the type.
        name: &'b str,
        /// The fields, e.g. `uint64_t timestamp;float[3] xyz;`.
        fields: &'b str,
    },
    /// `I`: information about the system or the log.
    Information {
        /// The key.
        key: &'b str,
        /// The type of the value, e.g. `char[8]`.
        ty: &'b str,
        /// The value, in little-endian order. The size of the value matches the type, unless a problem is returned with
        /// the message.
        value: &'b [u8],
    },
    /// `M`: one of several values of a key, or a part of a value.
    MultiInformation {
        /// True if this continues the previous value of the key.
        is_continued: bool,
        /// The key.
        key: &'b str,
        /// The type of the value.
        ty: &'b str,
        /// The value, as in [`Information`](Self::Information).
        value: &'b [u8],
    },
    /// `P`: the value of a parameter, at the start or after a change.
    Parameter {
        /// The name.
        key: &'b str,
        /// `int32_t` or `float`.
        ty: &'b str,
        /// The value, as in [`Information`](Self::Information).
        value: &'b [u8],
    },
    /// `Q`: the default value of a parameter.
    DefaultParameter {
        /// The kinds of default. The lowest bit denotes a firmware default, and the next bit an airframe default.
        defaults: u8,
        /// The name.
        key: &'b str,
        /// `int32_t` or `float`.
        ty: &'b str,
        /// The value, as in [`Information`](Self::Information).
        value: &'b [u8],
    },
    /// `A`: subscribes an id to a topic, from here on.
    Subscription {
        /// The instance of the topic.
        multi_id: u8,
        /// The id of the topic's data.
        id: u16,
        /// The topic, which is also the name of its format.
        name: &'b str,
    },
    /// `R`: ends the subscription of an id.
    Unsubscription {
        /// The id.
        id: u16,
    },
    /// `D`: a message of a topic.
    Data {
        /// The id of the subscription.
        id: u16,
        /// The message in memory layout.
        payload: &'b [u8],
    },
    /// `L` and `C`: a line of text.
    Logging {
        /// The syslog level as an ASCII digit: `0` is an emergency, `7` is for debugging.
        level: u8,
        /// The source of the text (`C` only).
        tag: Option<u16>,
        /// The time, in µs.
        timestamp: u64,
        /// The text, up to the first invalid UTF-8 byte.
        text: &'b str,
    },
    /// `S`: a mark for recovery from corruption.
    Synchronisation,
    /// `O`: messages were lost because writing was too slow.
    Dropout {
        /// The duration.
        milliseconds: u16,
    },
    /// A message of an unknown kind.
    Unknown {
        /// The letter of the kind.
        kind: u8,
        /// The whole payload.
        payload: &'b [u8],
    },
    /// A problem at this location.
    Problem(Problem),
}

/// A message, and any problem that doesn't prevent its use.
pub(super) type Parsed<'b> = (Event<'b>, Option<Malformation>);

/// Parses the payload of a message of any kind. Fails if no part of the payload is usable.
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
            return Ok((Event::Information { key, ty, value }, value_defect(ty, value)));
        }
        b'M' => {
            let is_continued = rest.u8()? != 0;
            let ((ty, key), value) = rest.entry()?;
            return Ok((Event::MultiInformation { is_continued, key, ty, value }, size_defect(ty, value)));
        }
        b'P' => {
            let ((ty, key), value) = rest.entry()?;
            return Ok((Event::Parameter { key, ty, value }, value_defect(ty, value)));
        }
        b'Q' => {
            let defaults = rest.u8()?;
            let ((ty, key), value) = rest.entry()?;
            return Ok((Event::DefaultParameter { defaults, key, ty, value }, value_defect(ty, value)));
        }
        b'A' => {
            Event::Subscription { multi_id: rest.u8()?, id: rest.u16()?, name: rest.text().and_then(named)? }
        }
        b'R' => Event::Unsubscription { id: rest.only(Payload::u16)? },
        b'D' => Event::Data { id: rest.u16()?, payload: rest.rest },
        b'L' | b'C' => return logging(kind, rest),
        b'S' if rest.only(Payload::take)? == SYNC => Event::Synchronisation,
        b'S' => return Err(Malformation::SyncMagic),
        b'O' => Event::Dropout { milliseconds: rest.only(Payload::u16)? },
        _ => Event::Unknown { kind, payload },
    };
    Ok((event, None))
}

fn logging(kind: u8, mut rest: Payload<'_>) -> Result<Parsed<'_>, Malformation> {
    let level = rest.u8()?;
    if !matches!(level, b'0'..=b'7') {
        return Err(Malformation::Level(level));
    }
    let tag = if kind == b'C' { Some(rest.u16()?) } else { None };
    let timestamp = rest.u64()?;
    let (text, defect) = match str::from_utf8(rest.rest) {
        Ok(text) => (text, None),
        Err(error) => {
            let valid = str::from_utf8(&rest.rest[..error.valid_up_to()]).unwrap_or_default();
            (valid, Some(Malformation::NotUtf8 { at: rest.position() + error.valid_up_to() }))
        }
    };
    Ok((Event::Logging { level, tag, timestamp, text }, defect))
}

fn named(name: &str) -> Result<&str, Malformation> {
    if name.is_empty() { Err(Malformation::NoName) } else { Ok(name) }
}

/// The problem, if any, with the value of an information or parameter message.
fn value_defect(ty: &str, value: &[u8]) -> Option<Malformation> {
    let is_text = ty.starts_with("char[") && str::from_utf8(value).is_err();
    size_defect(ty, value).or_else(|| is_text.then_some(Malformation::ValueNotUtf8))
}

/// Reports a value whose size doesn't match its type. Non-basic types can have any size. The text in a partial value
/// isn't checked, since it may end within a character.
fn size_defect(ty: &str, value: &[u8]) -> Option<Malformation> {
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

/// A cursor over a payload.
#[derive(Clone, Copy)]
struct Payload<'b> {
    rest: &'b [u8],
    size: usize,
}

impl<'b> Payload<'b> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Malformation> {
        let min = self.position() + N;
        let (taken, rest) =
            self.rest.split_first_chunk().ok_or(Malformation::TooShort { size: self.size, min })?;
        self.rest = rest;
        Ok(*taken)
    }

    /// Takes a value that must be the last in the payload. Fails if bytes follow it.
    fn only<T>(
        &mut self,
        take: impl FnOnce(&mut Self) -> Result<T, Malformation>,
    ) -> Result<T, Malformation> {
        let value = take(self)?;
        if self.rest.is_empty() {
            Ok(value)
        } else {
            Err(Malformation::TooLong { size: self.size, max: self.position() })
        }
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

    /// The rest of the payload as text.
    fn text(&self) -> Result<&'b str, Malformation> {
        self.utf8(self.rest)
    }

    fn utf8(&self, bytes: &'b [u8]) -> Result<&'b str, Malformation> {
        str::from_utf8(bytes)
            .map_err(|error| Malformation::NotUtf8 { at: self.position() + error.valid_up_to() })
    }

    /// Parses a key with its type. The rest of the payload is the key's value.
    fn entry(&mut self) -> Result<((&'b str, &'b str), &'b [u8]), Malformation> {
        let length = usize::from(self.u8()?);
        let room = self.rest.len();
        let (key, value) =
            self.rest.split_at_checked(length).ok_or(Malformation::KeyLength { length, room })?;
        let key = self.utf8(key)?.split_once(' ').ok_or(Malformation::NoType)?;
        named(key.0).and_then(|_| named(key.1))?;
        Ok((key, value))
    }

    /// The cursor's offset in the payload.
    fn position(&self) -> usize {
        self.size - self.rest.len()
    }
}
