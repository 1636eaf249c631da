//! The partitions of endpoints, which rustdds ignores.
//!
//! rustdds keeps the announcements of endpoints in the caches of built-in topics. All subscribers of a topic share its
//! cache, so a subscriber of a built-in topic returns the announcements in the form in which they were received.

use std::collections::HashMap;

use uavspec_model::limits::MAX_NAME;
use uavspec_model::{Durability, History, Qos};

use super::super::Topic;
use super::reader::{RawReader, Readers};
use crate::limits::MAX_ENDPOINTS;

/// The built-in topics for publishers and subscribers.
const TOPICS: [&str; 2] = ["DCPSPublication", "DCPSSubscription"];

/// The number of announcements that may arrive between two calls of [`Partitions::read`].
const DEPTH: u32 = 1_024;

/// The maximum number of attempts to read an announcement. For each endpoint that has ended, an attempt returns none.
const MAX_SKIPPED: u32 = 16;

/// The maximum number of partitions of an endpoint.
const MAX_PARTITIONS: usize = 64;

/// The id of the parameter that contains the GUID of the endpoint.
const GUID: u16 = 0x5a;

/// The id of the parameter that contains the partitions.
const PARTITION: u16 = 0x29;

/// The id of the last parameter.
const END: u16 = 0x01;

/// The partitions of the endpoints that have been announced. Endpoints in the default partition aren't listed.
pub(crate) struct Partitions {
    readers: Vec<RawReader>,
    known: HashMap<[u8; 16], Vec<String>>,
}

impl Partitions {
    pub(crate) fn new(readers: &Readers) -> Result<Self, String> {
        // No publisher offers this durability, so nobody sends messages to these subscribers.
        let qos = Qos {
            durability: Durability::Persistent,
            history: Some(History::KeepLast(DEPTH)),
            ..Qos::WEAKEST
        };
        let create = |name: &str| {
            let topic = Topic { name: name.into(), type_name: "".into(), type_hash: None };
            readers.create(&topic, &qos)
        };
        let readers = TOPICS.into_iter().map(create).collect::<Result<_, _>>()?;
        Ok(Self { readers, known: HashMap::new() })
    }

    /// Reads the announcements that have arrived since the last call. `is_known` returns true for endpoints that exist.
    pub(crate) fn read(&mut self, is_known: impl Fn(&[u8; 16]) -> bool) {
        for reader in &self.readers {
            let mut skipped = 0;
            while skipped < MAX_SKIPPED {
                match reader.try_take_one() {
                    Ok(Some(message)) => {
                        skipped = 0;
                        if let Some((guid, partitions)) = announcement(&message.sample) {
                            self.known.remove(&guid);
                            if !partitions.is_empty() {
                                self.known.insert(guid, partitions);
                            }
                        }
                    }
                    // Either no announcement is left, or an endpoint has ended.
                    _ => skipped += 1,
                }
            }
        }
        if self.known.len() > MAX_ENDPOINTS {
            self.known.retain(|guid, _| is_known(guid));
        }
    }

    /// The partitions of an endpoint; empty if it is in the default partition.
    pub(crate) fn of(&self, guid: &[u8; 16]) -> Vec<String> {
        self.known.get(guid).cloned().unwrap_or_default()
    }
}

/// The GUID and the partitions in an announcement, which is a list of parameters after an encapsulation header.
fn announcement(payload: &[u8]) -> Option<([u8; 16], Vec<String>)> {
    let (header, mut rest) = payload.split_first_chunk::<4>()?;
    let order = if header[1] & 1 == 1 { Order::Little } else { Order::Big };
    let (mut guid, mut partitions) = (None, Vec::new());
    while let Some((id, value, after)) = parameter(order, rest) {
        match id {
            END => break,
            GUID => guid = value.first_chunk().copied(),
            PARTITION => partitions = names(order, value),
            _ => {}
        }
        rest = after;
    }
    Some((guid?, partitions))
}

/// The byte order of numbers.
#[derive(Clone, Copy)]
enum Order {
    Little,
    Big,
}

impl Order {
    fn u16(self, bytes: [u8; 2]) -> u16 {
        if let Self::Little = self { u16::from_le_bytes(bytes) } else { u16::from_be_bytes(bytes) }
    }

    fn length(self, bytes: [u8; 4]) -> Option<usize> {
        let length =
            if let Self::Little = self { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) };
        usize::try_from(length).ok()
    }
}

/// The id and the value of the first parameter, and the bytes after it.
fn parameter(order: Order, bytes: &[u8]) -> Option<(u16, &[u8], &[u8])> {
    let (id, rest) = bytes.split_first_chunk()?;
    let (length, rest) = rest.split_first_chunk()?;
    let (value, rest) = rest.split_at_checked(order.u16(*length).into())?;
    Some((order.u16(*id), value, rest))
}

/// The strings in a list. An empty name denotes the default partition. Without a list, the endpoint is also in the
/// default partition.
fn names(order: Order, value: &[u8]) -> Vec<String> {
    let Some((count, mut rest)) = value.split_first_chunk() else { return Vec::new() };
    let count = order.length(*count).unwrap_or(usize::MAX).min(MAX_PARTITIONS);
    let mut names = Vec::new();
    while names.len() < count
        && let Some((name, after)) = name(order, rest)
    {
        names.push(name);
        rest = after;
    }
    if names.iter().all(String::is_empty) { Vec::new() } else { names }
}

/// The first string, and the bytes after the string and its padding.
fn name(order: Order, bytes: &[u8]) -> Option<(String, &[u8])> {
    let (length, rest) = bytes.split_first_chunk()?;
    let length = order.length(*length)?;
    let text = rest.get(..length)?;
    let text = text.strip_suffix(b"\0").unwrap_or(text);
    let text = String::from_utf8_lossy(text.get(..MAX_NAME).unwrap_or(text)).into_owned();
    Some((text, rest.get(length.next_multiple_of(4)..).unwrap_or_default()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An announcement with a topic, partitions and a GUID.
    fn bytes(order: Order, list: &[&str]) -> Vec<u8> {
        let swapped = |mut bytes: Vec<u8>| {
            if let Order::Big = order {
                bytes.reverse();
            }
            bytes
        };
        let u16 = |value: u16| swapped(value.to_le_bytes().to_vec());
        let u32 = |value: u32| swapped(value.to_le_bytes().to_vec());
        let length = |bytes: usize| u32::try_from(bytes).expect("a length");
        let mut value = u32(length(list.len()));
        for name in list {
            value.extend(u32(length(name.len() + 1)));
            value.extend(name.bytes().chain([0]));
            value.resize(value.len().next_multiple_of(4), 0);
        }
        let mut bytes = vec![0, if let Order::Little = order { 3 } else { 2 }, 0, 0];
        for (id, value) in [(5, &[9; 8][..]), (PARTITION, &value), (GUID, &[7; 16]), (END, &[])] {
            bytes.extend(u16(id));
            bytes.extend(u16(u16::try_from(value.len()).expect("a length")));
            bytes.extend(value);
        }
        bytes
    }

    #[test]
    fn reads_partitions_in_both_byte_orders() {
        for order in [Order::Little, Order::Big] {
            for list in [&["a"][..], &["wing", "fleet*", ""]] {
                let (guid, found) = announcement(&bytes(order, list)).expect("an announcement");
                assert_eq!(
                    (guid, &found[..]),
                    ([7; 16], list.iter().map(ToString::to_string).collect::<Vec<_>>().as_slice())
                );
            }
        }
    }

    #[test]
    fn the_default_partition_is_not_listed() {
        for list in [&[][..], &[""]] {
            assert_eq!(announcement(&bytes(Order::Little, list)), Some(([7; 16], Vec::new())));
        }
    }

    #[test]
    fn limits_names() {
        let (long, many) = ("x".repeat(MAX_NAME + 9), vec!["y"; MAX_PARTITIONS + 9]);
        let read = |list: &[&str]| announcement(&bytes(Order::Little, list)).expect("an announcement").1;
        assert_eq!(read(&[&long]), ["x".repeat(MAX_NAME)]);
        assert_eq!(read(&many).len(), MAX_PARTITIONS);
    }

    #[test]
    fn truncated_announcements_cause_no_panic() {
        let whole = bytes(Order::Little, &["a", "b"]);
        for length in 0..whole.len() {
            let _ = announcement(&whole[..length]);
            let mut changed = whole.clone();
            changed[length] = 0xff;
            let _ = announcement(&changed);
        }
    }
}
