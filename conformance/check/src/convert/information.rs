//! The information and the default parameters of a log, as metadata of an MCAP file.

use std::collections::BTreeMap;

use serde_json::json;

use crate::limits::MAX_INFORMATION;

/// The name of the metadata record with the information of a log. A key is a type and a key of the log. If the type ends with
/// `[]`, the value is a JSON array with several values.
const INFORMATION: &str = "ulog:information";

/// The names of the metadata records with the default parameters of the firmware and of the airframe.
const DEFAULTS: [&str; 2] = ["ulog:firmware_defaults", "ulog:airframe_defaults"];

/// The name of the metadata record with two times, in µs: the start of the log on the vehicle's clock, and the difference between
/// UTC and this clock.
const TIME: &str = "ulog:time";
const START: &str = "start_us";
const UTC_OFFSET: &str = "utc_offset_us";

/// The maximum length of a piece of a long value, in bytes.
const PIECE: usize = 60_000;

/// A message of a log: its kind and its payload.
pub(super) type LogMessage = (u8, Vec<u8>);

/// A metadata record: its name and its values.
pub(super) type Metadata = (&'static str, BTreeMap<String, String>);

/// The record with the start of a log, and the difference between UTC and the vehicle's clock; 0 if it is unknown.
pub(super) fn times(start: Option<u64>, utc_offset: u64) -> Metadata {
    let times = [(START, start), (UTC_OFFSET, Some(utc_offset))];
    let times = times.into_iter().filter_map(|(key, time)| Some((key.to_owned(), time?.to_string())));
    (TIME, times.collect())
}

/// The times in a record; see [`times`].
pub(super) fn read_times(name: &str, values: &BTreeMap<String, String>) -> [Option<u64>; 2] {
    [START, UTC_OFFSET].map(|key| values.get(key).filter(|_| name == TIME)?.parse().ok())
}

/// Restores the messages of a log from a record. Leaves out invalid values.
pub(super) fn messages(name: &str, values: &BTreeMap<String, String>) -> Vec<LogMessage> {
    if let Some(bit) = DEFAULTS.iter().position(|known| *known == name) {
        return values.iter().filter_map(|(name, value)| default(bit, name, value)).collect();
    }
    let values = values.iter().filter(|_| name == INFORMATION);
    values.filter_map(|(key, value)| Some((key.split_once(' ')?, value))).flat_map(one).collect()
}

/// The message for the default of a parameter.
fn default(bit: usize, name: &str, value: &str) -> Option<LogMessage> {
    let ty = if value.parse::<i32>().is_ok() { "int32_t" } else { "float" };
    let mut payload = vec![1 << bit];
    payload.extend(keyed(ty, name, &bytes(ty, value)?)?);
    Some((b'Q', payload))
}

/// The messages for a value.
fn one(((ty, key), value): ((&str, &str), &String)) -> Vec<LogMessage> {
    let Some(element) = ty.strip_suffix("[]") else {
        let value = bytes(ty, value);
        let message = value.and_then(|value| keyed(&sized(ty, value.len()), key, &value));
        return message.map(|payload| (b'I', payload)).into_iter().collect();
    };
    let values: Vec<String> = serde_json::from_str(value).unwrap_or_default();
    let values = values.iter().filter_map(|value| bytes(ty, value));
    values.flat_map(|value| pieces(element, key, &value)).collect()
}

/// The messages for one of several values of a key. `element` is the type of its elements.
pub(super) fn pieces(element: &str, key: &str, value: &[u8]) -> Vec<LogMessage> {
    let size = size_of(element).unwrap_or(1);
    let piece = |(at, piece): (usize, &[u8])| {
        let mut payload = vec![u8::from(at > 0)];
        payload.extend(keyed(&format!("{element}[{}]", piece.len() / size), key, piece)?);
        Some((b'M', payload))
    };
    value.chunks(PIECE).enumerate().filter_map(piece).collect()
}

/// The size of a number, in bytes.
fn size_of(ty: &str) -> Option<usize> {
    Some(match ty {
        "uint8_t" | "int8_t" => 1,
        "uint16_t" | "int16_t" => 2,
        "uint32_t" | "int32_t" | "float" => 4,
        "uint64_t" | "int64_t" | "double" => 8,
        _ => return None,
    })
}

/// The type of a value of `size` bytes. The length of a text may have changed.
fn sized(ty: &str, size: usize) -> String {
    if ty.starts_with("char[") { format!("char[{size}]") } else { ty.to_owned() }
}

/// A key with its type, and its value. `None` if the key is too long.
pub(super) fn keyed(ty: &str, key: &str, value: &[u8]) -> Option<Vec<u8>> {
    let key = format!("{ty} {key}");
    let mut payload = vec![u8::try_from(key.len()).ok()?];
    payload.extend_from_slice(key.as_bytes());
    payload.extend_from_slice(value);
    Some(payload)
}

/// Parses a value. `None` if it is invalid or empty.
fn bytes(ty: &str, text: &str) -> Option<Vec<u8>> {
    if ty.starts_with("char[") {
        return Some(text.as_bytes().to_vec()).filter(|text| !text.is_empty());
    }
    match (ty, size_of(ty)) {
        ("float", _) => Some(text.parse::<f32>().ok()?.to_le_bytes().to_vec()),
        ("double", _) => Some(text.parse::<f64>().ok()?.to_le_bytes().to_vec()),
        (_, Some(size)) => {
            let value = text.parse::<i128>().ok()?.to_le_bytes();
            let bytes = value[..size].to_vec();
            // A number that is too large has another text.
            (number(ty, &bytes)? == text).then_some(bytes)
        }
        _ => {
            let digits = |pair| u8::from_str_radix(str::from_utf8(pair).ok()?, 16).ok();
            let bytes: Option<Vec<u8>> = text.as_bytes().chunks(2).map(digits).collect();
            bytes.filter(|bytes| !bytes.is_empty())
        }
    }
}

/// The information and the default parameters of a log.
#[derive(Default)]
pub(super) struct Information {
    /// The values by their type and key.
    values: BTreeMap<(String, String), Vec<u8>>,
    /// The values of keys with several values, by the type of their elements and the key.
    several: BTreeMap<(String, String), Vec<Vec<u8>>>,
    /// The default values of the firmware and of the airframe, by parameter.
    defaults: [BTreeMap<String, String>; 2],
    /// The size of all keys and values, in bytes.
    size: usize,
}

impl Information {
    /// Reserves space. Returns false if the limit is reached.
    fn has_room(&mut self, size: usize) -> bool {
        self.size = self.size.saturating_add(size);
        self.size <= MAX_INFORMATION
    }

    /// Adds the value of a key.
    pub(super) fn add(&mut self, key: &str, ty: &str, value: &[u8]) {
        if self.has_room(key.len() + ty.len() + value.len()) {
            self.values.insert((ty.to_owned(), key.to_owned()), value.to_vec());
        }
    }

    /// Adds one of several values of a key, or a part of a value.
    pub(super) fn add_piece(&mut self, key: &str, ty: &str, piece: &[u8], is_continued: bool) {
        if !self.has_room(key.len() + ty.len() + piece.len()) {
            return;
        }
        let element = ty.split('[').next().unwrap_or_default();
        let values = self.several.entry((element.to_owned(), key.to_owned())).or_default();
        match values.last_mut().filter(|_| is_continued) {
            Some(value) => value.extend_from_slice(piece),
            None => values.push(piece.to_vec()),
        }
    }

    /// Adds the default of a parameter. The bits of `kinds` denote the firmware and the airframe.
    pub(super) fn add_default(&mut self, kinds: u8, name: &str, ty: &str, value: &[u8]) {
        if !self.has_room(2 * (name.len() + value.len())) {
            return;
        }
        for (bit, defaults) in self.defaults.iter_mut().enumerate() {
            if kinds & (1 << bit) != 0 {
                defaults.insert(name.to_owned(), text(ty, value));
            }
        }
    }

    /// The metadata records. Also returns the reason if a part is left out.
    pub(super) fn finish(&mut self) -> (Vec<Metadata>, Option<String>) {
        let values = std::mem::take(&mut self.values).into_iter();
        let values = values.map(|((ty, key), value)| (format!("{ty} {key}"), text(&ty, &value)));
        let several = std::mem::take(&mut self.several).into_iter().map(|((element, key), values)| {
            let ty = format!("{element}[]");
            let texts: Vec<String> = values.iter().map(|value| text(&ty, value)).collect();
            (format!("{ty} {key}"), json!(texts).to_string())
        });
        let values = values.chain(several).collect();
        let defaults = DEFAULTS.into_iter().zip(std::mem::take(&mut self.defaults));
        let records = std::iter::once((INFORMATION, values)).chain(defaults);
        let limit = MAX_INFORMATION >> 20;
        let problem = (self.size > MAX_INFORMATION).then(|| {
            format!(
                "the information and the default parameters take more than {limit} MiB: the rest is left out"
            )
        });
        (records.filter(|(_, values)| !values.is_empty()).collect(), problem)
    }
}

/// A value as text. Bytes are in hexadecimal digits, unless they are text.
fn text(ty: &str, value: &[u8]) -> String {
    if ty.starts_with("char[") {
        return String::from_utf8_lossy(value).trim_end_matches('\0').to_owned();
    }
    number(ty, value).unwrap_or_else(|| value.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// A number as text. `None` if the value has another size.
fn number(ty: &str, value: &[u8]) -> Option<String> {
    if size_of(ty)? != value.len() {
        return None;
    }
    let mut bytes = [0; 16];
    bytes[..value.len()].copy_from_slice(value);
    let bits = i128::from_le_bytes(bytes);
    let shift = 128 - 8 * value.len();
    Some(match ty {
        "float" => format!("{:?}", f32::from_le_bytes(value.try_into().ok()?)),
        "double" => format!("{:?}", f64::from_le_bytes(value.try_into().ok()?)),
        _ if ty.starts_with('u') => bits.to_string(),
        _ => ((bits << shift) >> shift).to_string(),
    })
}
