//! Drives the server without sockets and without real time, for fuzz targets.

use std::rc::Rc;
use std::time::Duration;

use super::hub::{ConnectionKind, Hub};
use super::memory::Queue;
use super::{Options, family};

/// The start of the server, in milliseconds since 1970.
const START: u64 = 1_790_000_000_000;

/// The time between two messages from the client.
const STEP: Duration = Duration::from_millis(300);

/// The side that sent a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Client,
    Server,
}

/// A sent message.
#[derive(Clone, Debug)]
pub struct Record {
    /// The time, in seconds since 1970.
    pub time: f64,
    /// The sender.
    pub side: Side,
    /// The message.
    pub bytes: Vec<u8>,
}

/// Sends messages to a new server. Returns all messages of both sides in order.
pub fn transcript<'m>(messages: impl Iterator<Item = &'m [u8]>, is_datagram: bool) -> Vec<Record> {
    let mut hub = Hub::new(Options { uavs: 2, start: START, ..Options::default() }, family::answer);
    let queue = Rc::new(Queue::default());
    let kind = if is_datagram { ConnectionKind::Datagrams } else { ConnectionKind::Persistent };
    let id = hub.open(kind, Rc::<Queue>::clone(&queue));
    let (mut elapsed, mut records) = (Duration::ZERO, Vec::new());
    let take = |elapsed: Duration, records: &mut Vec<Record>| {
        let time = Duration::from_millis(START) + elapsed;
        records.extend(queue.texts.take().into_iter().map(|text| Record {
            time: time.as_secs_f64(),
            side: Side::Server,
            bytes: text.into_bytes(),
        }));
        time.as_secs_f64()
    };
    for message in messages {
        let time = take(elapsed, &mut records);
        records.push(Record { time, side: Side::Client, bytes: message.to_vec() });
        hub.receive(id, message, elapsed);
        take(elapsed, &mut records);
        elapsed += STEP;
        hub.advance(elapsed);
    }
    take(elapsed, &mut records);
    records
}
