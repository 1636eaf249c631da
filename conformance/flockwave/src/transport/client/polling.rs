//! Socket.IO over HTTP long polling, and code shared with Socket.IO over WebSocket.

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::{Duration, Instant};
use std::{io, thread};

use serde::Deserialize;
use uavspec_model::clock::Clock;

use super::http::HttpClient;
use super::target::Target;
use super::{Client, Received, invalid, text_of, timed_out};
use crate::limits::EARLY_LIMIT;
use crate::transport::access::Access;
use crate::transport::endpoint::ServerAddress;
use crate::transport::engine::{Kind, Packet, Revision, decode, encode};
use crate::transport::{MESSAGE_LIMIT, SOCKET_IO_PATH, socketio};

/// The maximum duration of a poll. Servers end a poll after their ping interval, usually 25 s.
const POLL_LIMIT: Duration = Duration::from_secs(90);

/// The maximum time to close a session.
const CLOSE_LIMIT: Duration = Duration::from_secs(2);

/// The maximum number of payloads in the queue. Polling pauses when the queue is full. A payload may be as long as two
/// messages.
const WAITING_LIMIT: usize = 1;

/// The maximum total size of the packets that arrive during the handshake, in bytes.
const EARLY_BYTES: usize = MESSAGE_LIMIT;

/// The default interval between pings.
const USUAL_INTERVAL: Duration = Duration::from_secs(25);

/// The content of the packet that opens a session.
#[derive(Deserialize)]
struct Session {
    sid: String,
    #[serde(rename = "pingInterval")]
    ping_interval: Option<u64>,
}

/// Schedules pings. In revision 3, clients send pings; in later revisions, servers do.
pub(super) struct Heartbeat {
    revision: Revision,
    interval: Duration,
    next: Instant,
}

impl Heartbeat {
    pub(super) fn new(revision: Revision) -> Self {
        Self { revision, interval: USUAL_INTERVAL, next: Clock::real().now() + USUAL_INTERVAL }
    }

    /// The time of the next action.
    pub(super) fn next(&self) -> Instant {
        self.next
    }

    /// The ping to send now, if it is due.
    pub(super) fn due(&mut self) -> Option<Packet> {
        if Clock::real().now() < self.next {
            return None;
        }
        self.next = Clock::real().now() + self.interval;
        (self.revision == Revision::Three).then(|| Packet::new(Kind::Ping, ""))
    }

    fn agree(&mut self, interval: Option<u64>) {
        if let Some(interval) = interval {
            // Intervals below one second are implausible, and intervals longer than usual aren't necessary.
            self.interval = Duration::from_millis(interval).clamp(Duration::from_secs(1), USUAL_INTERVAL);
            self.next = Clock::real().now() + self.interval;
        }
    }
}

/// The handshake: opening the session and joining the namespace.
pub(super) struct Opening {
    revision: Revision,
    sid: Option<String>,
    is_done: bool,
    /// Packets that arrived during the handshake, to be returned later.
    pub(super) early: VecDeque<Packet>,
}

impl Opening {
    pub(super) fn new(revision: Revision) -> Self {
        Self { revision, sid: None, is_done: false, early: VecDeque::new() }
    }

    pub(super) fn is_done(&self) -> bool {
        self.is_done
    }

    /// True if a packet may be stored.
    fn has_room(&self, packet: &Packet) -> bool {
        let bytes: usize = self.early.iter().map(|early| early.data.len()).sum();
        self.early.len() < EARLY_LIMIT && bytes + packet.data.len() <= EARLY_BYTES
    }

    /// Handles a packet from the server. Returns the packet to send, if there is one.
    pub(super) fn take(&mut self, packet: &Packet, heartbeat: &mut Heartbeat) -> io::Result<Option<Packet>> {
        match packet.kind {
            Kind::Open => {
                let session: Session = serde_json::from_str(&packet.data).map_err(|error| {
                    invalid(format!("invalid packet at the start of the session: {error}"))
                })?;
                heartbeat.agree(session.ping_interval);
                self.sid = Some(session.sid);
                Ok((self.revision == Revision::Four).then(|| Packet::new(Kind::Message, "0")))
            }
            Kind::Message => match socketio::Packet::parse(&packet.data) {
                Some(socketio::Packet::Connect { namespace }) if namespace == "/" => {
                    self.is_done = true;
                    Ok(None)
                }
                Some(socketio::Packet::Refusal(reason)) => {
                    Err(invalid(format!("the server refused the namespace: {reason}")))
                }
                _ if self.has_room(packet) => {
                    self.early.push_back(packet.clone());
                    Ok(None)
                }
                _ => Err(invalid("too many packets arrived before the namespace was joined")),
            },
            Kind::Ping => Ok(Some(Packet::new(Kind::Pong, packet.data.clone()))),
            Kind::Pong | Kind::Noop => Ok(None),
            Kind::Close | Kind::Upgrade => Err(invalid("the server closed the session during the handshake")),
        }
    }
}

/// The action that a packet requires.
pub(super) enum Step {
    Received(Received),
    Answer(Packet),
    Nothing,
}

/// The action for a packet after the handshake.
pub(super) fn step(packet: Packet) -> Step {
    match packet.kind {
        Kind::Ping => Step::Answer(Packet::new(Kind::Pong, packet.data)),
        Kind::Close => Step::Received(Received::End),
        Kind::Message => match socketio::Packet::parse(&packet.data) {
            Some(socketio::Packet::Message { text, .. }) => {
                Step::Received(Received::Message(text.into_bytes()))
            }
            Some(socketio::Packet::OtherEvent { text }) => {
                Step::Received(Received::OtherEvent(text.into_bytes()))
            }
            Some(socketio::Packet::Disconnect) => Step::Received(Received::End),
            _ => Step::Nothing,
        },
        Kind::Open | Kind::Pong | Kind::Upgrade | Kind::Noop => Step::Nothing,
    }
}

pub(super) struct Polling {
    client: HttpClient,
    revision: Revision,
    heartbeat: Heartbeat,
    /// Sends pings and pongs without delaying the caller.
    pings: SyncSender<Packet>,
    polled: Receiver<io::Result<Vec<u8>>>,
    packets: VecDeque<Packet>,
}

impl Polling {
    pub(super) fn connect(
        address: &ServerAddress,
        revision: Revision,
        access: &Access,
        until: Instant,
    ) -> io::Result<Self> {
        let number = revision.engine_io();
        let path = format!("{SOCKET_IO_PATH}?EIO={number}&transport=polling");
        let client = HttpClient::connect(Target::new(address, path), access, until)?;
        let opened = client.get(until)?;
        let (mut heartbeat, mut opening) = (Heartbeat::new(revision), Opening::new(revision));
        let mut packets: VecDeque<Packet> = decode(revision, &opened).map_err(invalid)?.into();
        let mut answers = Vec::new();
        while !opening.is_done()
            && let Some(packet) = packets.pop_front()
        {
            answers.extend(opening.take(&packet, &mut heartbeat)?);
        }
        let sid = opening.sid.as_deref().ok_or_else(|| invalid("the server didn't open a session"))?;
        let client = client.at(format!("{}&sid={sid}", client.path()));
        let (polled, pings) = start_threads(&client, revision);
        let mut client = Self { client, revision, heartbeat, pings, polled, packets };
        client.send_packets(&answers, until)?;
        while !opening.is_done() {
            let packet = client
                .packet(until)?
                .ok_or_else(|| timed_out("timed out: the server didn't accept the namespace"))?;
            let answer = opening.take(&packet, &mut client.heartbeat)?;
            client.send_packets(answer.as_slice(), until)?;
        }
        opening.early.append(&mut client.packets);
        client.packets = opening.early;
        Ok(client)
    }

    fn send_packets(&self, packets: &[Packet], until: Instant) -> io::Result<()> {
        if packets.is_empty() { Ok(()) } else { post(&self.client, self.revision, packets, until) }
    }

    /// The next packet. `None` if none arrives in time. The end of the session is returned as a packet.
    fn packet(&mut self, until: Instant) -> io::Result<Option<Packet>> {
        loop {
            if let Some(packet) = self.packets.pop_front() {
                return Ok(Some(packet));
            }
            match Clock::real().receive(&self.polled, until) {
                Ok(payload) => self.packets = decode(self.revision, &payload?).map_err(invalid)?.into(),
                Err(RecvTimeoutError::Timeout) => return Ok(None),
                Err(RecvTimeoutError::Disconnected) => return Ok(Some(Packet::new(Kind::Close, ""))),
            }
        }
    }

    /// Queues a ping or a pong, or drops it if the queue is full. A server that sends pings so fast doesn't need a pong
    /// for each.
    fn ping(&self, packet: Packet) {
        let _ = self.pings.try_send(packet);
    }
}

impl Client for Polling {
    fn send(&mut self, message: &[u8]) -> io::Result<()> {
        self.send_raw(socketio::message(text_of(message)?).as_bytes())
    }

    fn send_raw(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.send_packets(&[Packet::new(Kind::Message, text_of(bytes)?)], Clock::real().now() + POLL_LIMIT)
    }

    fn receive(&mut self, until: Instant) -> io::Result<Received> {
        loop {
            if let Some(ping) = self.heartbeat.due() {
                self.ping(ping);
            }
            let Some(packet) = self.packet(self.heartbeat.next().min(until))? else {
                if Clock::real().now() >= until {
                    return Ok(Received::Silence);
                }
                continue;
            };
            match step(packet) {
                Step::Received(received) => return Ok(received),
                Step::Answer(answer) => self.ping(answer),
                Step::Nothing => {}
            }
        }
    }
}

impl Drop for Polling {
    fn drop(&mut self) {
        // The packet makes the server end the open poll. Errors don't matter, since the connection is closed anyway.
        let _ = self.send_packets(&[Packet::new(Kind::Close, "")], Clock::real().now() + CLOSE_LIMIT);
    }
}

/// Starts two threads: one polls, and the other sends pings and pongs. Returns their channels.
fn start_threads(
    client: &HttpClient,
    revision: Revision,
) -> (Receiver<io::Result<Vec<u8>>>, SyncSender<Packet>) {
    let (payloads, polled) = sync_channel(WAITING_LIMIT);
    let thread_client = client.clone();
    thread::spawn(move || poll(&thread_client, &payloads));
    let (pings, waiting) = sync_channel::<Packet>(WAITING_LIMIT);
    let thread_client = client.clone();
    thread::spawn(move || {
        for ping in waiting {
            // If the connection is lost, the poll fails as well.
            let _ = post(&thread_client, revision, &[ping], Clock::real().now() + POLL_LIMIT);
        }
    });
    (polled, pings)
}

/// Sends packets.
fn post(client: &HttpClient, revision: Revision, packets: &[Packet], until: Instant) -> io::Result<()> {
    client.post("text/plain;charset=UTF-8", encode(revision, packets).as_bytes(), until).map(|_| ())
}

/// Polls until the receiver of the payloads is dropped or the session ends.
fn poll(client: &HttpClient, payloads: &SyncSender<io::Result<Vec<u8>>>) {
    loop {
        let payload = client.get(Clock::real().now() + POLL_LIMIT);
        let is_end = payload.is_err();
        if payloads.send(payload).is_err() || is_end {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Performs a handshake in which these packets arrive. Returns the sent packets, the packets to return later, and
    /// true if the handshake is complete.
    fn opened(revision: Revision, packets: &[&str]) -> io::Result<(Vec<String>, Vec<String>, bool)> {
        let (mut opening, mut heartbeat) = (Opening::new(revision), Heartbeat::new(revision));
        let mut sent = Vec::new();
        for text in packets {
            let packet = Packet::parse(text).ok_or_else(|| invalid("not a packet"))?;
            sent.extend(opening.take(&packet, &mut heartbeat)?.map(|packet| packet.to_text()));
        }
        let early = opening.early.iter().map(Packet::to_text).collect();
        Ok((sent, early, opening.is_done))
    }

    #[test]
    fn opens_a_session_in_each_revision() {
        let session = "0{\"sid\":\"a\",\"pingInterval\":25000}";
        let (sent, early, is_done) = opened(Revision::Three, &[session, "40"]).expect("a session");
        assert_eq!((sent.len(), early.len(), is_done), (0, 0, true));
        let (sent, _, is_done) = opened(Revision::Four, &[session]).expect("a session");
        assert_eq!((sent, is_done), (vec!["40".to_owned()], false));
        assert!(opened(Revision::Four, &[session, "40{\"sid\":\"b\"}"]).expect("a session").2);
        for packets in [&["0{}"][..], &[session, "44{\"message\":\"full\"}"], &[session, "1"]] {
            assert!(opened(Revision::Four, packets).is_err(), "{packets:?}");
        }
    }

    #[test]
    fn receives_messages_sent_before_the_handshake_ends() {
        let session = "0{\"sid\":\"a\"}";
        let (_, early, is_done) =
            opened(Revision::Four, &[session, "42[\"fw\",{}]", "40"]).expect("a session");
        assert_eq!((early, is_done), (vec!["42[\"fw\",{}]".to_owned()], true));
        let mut flood = vec![session];
        flood.resize(EARLY_LIMIT + 2, "42[\"fw\",{}]");
        assert!(opened(Revision::Four, &flood).is_err());
        let long = format!("42[\"fw\",\"{}\"]", "x".repeat(EARLY_BYTES / 3));
        assert!(opened(Revision::Four, &[session, &long, &long]).is_ok());
        assert!(opened(Revision::Four, &[session, &long, &long, &long]).is_err());
    }

    #[test]
    fn clients_send_pings_in_revision_3_only() {
        for (revision, pings_server) in [(Revision::Three, true), (Revision::Four, false)] {
            let mut heartbeat = Heartbeat::new(revision);
            assert_eq!(heartbeat.due(), None);
            heartbeat.next = Clock::real().now();
            assert_eq!(heartbeat.due().is_some(), pings_server);
            assert!(heartbeat.next() > Clock::real().now());
        }
    }
}
