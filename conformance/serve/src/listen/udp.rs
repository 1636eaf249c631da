//! UDP: one message per datagram. A client receives notifications for a minute after its last datagram.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::rc::Rc;
use std::time::{Duration, Instant};

use mio::net::UdpSocket;
use serde::de::IgnoredAny;
use serde_json::Value;
use uavspec_rules::flockwave::{udp_01, udp_02, udp_03};

use super::Shared;
use super::limits::{CLIENT_LIMIT, DATAGRAM_BUDGET, REPLACED, STEPS_AT_ONCE};
use crate::hub::{ConnectionKind, SessionId, Sink};
use crate::message::{enveloped, refusal, text};

/// The maximum length of a message in a datagram.
const DATAGRAM_LIMIT: usize = 65_507;

/// The time after which a silent client counts as disconnected, as the specification recommends.
const CLIENT_TIMEOUT: Duration = Duration::from_secs(60);

/// Sends datagrams to a client.
struct DatagramSink {
    socket: Rc<UdpSocket>,
    client: SocketAddr,
    /// True with the FW-UDP-01 bug, which sends each notification twice in one datagram.
    is_doubling: bool,
    /// The number of bytes that may be sent before the client sends another datagram.
    budget: Cell<usize>,
}

impl Sink for DatagramSink {
    fn send(&self, text: &str) {
        let is_doubled =
            self.is_doubling && serde_json::from_str(text).is_ok_and(|m: Value| m.get("refs").is_none());
        let text = if is_doubled { format!("{text}\n{text}") } else { text.to_owned() };
        let text = if text.len() <= DATAGRAM_LIMIT { Some(text) } else { shortened(&text) };
        if let Some(text) = text
            && let Some(left) = self.budget.get().checked_sub(text.len())
        {
            self.budget.set(left);
            // Datagrams may get lost anyway.
            let _ = self.socket.send_to(text.as_bytes(), self.client);
        }
    }

    fn close(&self) {}
}

/// The response to send if the actual response doesn't fit into a datagram.
fn shortened(long: &str) -> Option<String> {
    let message: Value = serde_json::from_str(long).ok()?;
    let (id, refs) = (message["id"].as_str()?, message["refs"].as_str()?);
    let why = "the response doesn't fit into a datagram; request fewer items";
    let answer = enveloped(id, Some(refs), &text(&refusal(why.to_owned())));
    Some(answer).filter(|text| text.len() <= DATAGRAM_LIMIT)
}

struct Client {
    session: SessionId,
    sink: Rc<DatagramSink>,
    /// The time of the last datagram.
    last_active: Instant,
}

/// A socket and its clients.
pub(super) struct Datagrams {
    /// `None` after the socket was closed because of the FW-UDP-03 bug.
    socket: Option<Rc<UdpSocket>>,
    clients: BTreeMap<SocketAddr, Client>,
    /// The datagram that is being received.
    buffer: Vec<u8>,
    /// The first client; used only with the FW-UDP-02 bug.
    first: Option<SocketAddr>,
}

impl Datagrams {
    pub(super) fn new(socket: UdpSocket) -> Self {
        let (clients, buffer) = (BTreeMap::new(), vec![0; DATAGRAM_LIMIT + 1]);
        Self { socket: Some(Rc::new(socket)), clients, buffer, first: None }
    }

    /// Processes some datagrams. Returns true if there were any.
    pub(super) fn receive(&mut self, shared: &mut Shared) -> bool {
        let mut buffer = std::mem::take(&mut self.buffer);
        let mut count = 0;
        while count < STEPS_AT_ONCE {
            let received = self.socket.as_ref().and_then(|socket| socket.recv_from(&mut buffer).ok());
            // Some systems return an error here if an earlier datagram could not be delivered. More datagrams may
            // follow in the next turn.
            let Some((length, address)) = received else { break };
            self.take(shared, address, &buffer[..length]);
            count += 1;
        }
        self.buffer = buffer;
        count > 0
    }

    /// Processes a datagram. Only valid requests register a client.
    fn take(&mut self, shared: &mut Shared, address: SocketAddr, datagram: &[u8]) {
        if shared.has_bug(&udp_03::RULE) && serde_json::from_slice::<IgnoredAny>(datagram).is_err() {
            return self.close(shared);
        }
        let now = shared.now();
        let first = *self.first.get_or_insert(address);
        if let Some(client) = self.clients.get_mut(&address) {
            client.sink.budget.set(DATAGRAM_BUDGET);
            client.last_active = now;
            shared.receive(client.session, datagram);
            return;
        }
        let Some(socket) = &self.socket else { return };
        let sink = Rc::new(DatagramSink {
            socket: Rc::clone(socket),
            client: if shared.has_bug(&udp_02::RULE) { first } else { address },
            is_doubling: shared.has_bug(&udp_01::RULE),
            budget: Cell::new(DATAGRAM_BUDGET),
        });
        let session = shared.hub.open(ConnectionKind::Datagrams, Rc::<DatagramSink>::clone(&sink));
        if !shared.receive(session, datagram) {
            shared.hub.close(session);
            return;
        }
        if self.clients.len() >= CLIENT_LIMIT {
            self.replace_one(shared);
        }
        self.clients.insert(address, Client { session, sink, last_active: now });
    }

    /// Removes a client to make room for a newcomer. Active clients give way as well, because a client over UDP can
    /// always return.
    fn replace_one(&mut self, shared: &mut Shared) {
        let oldest = self.clients.iter().min_by_key(|(_, client)| client.last_active);
        if let Some((address, client)) = oldest.map(|(address, client)| (*address, client.session)) {
            self.clients.remove(&address);
            shared.hub.close(client);
            shared.count(REPLACED);
        }
    }

    /// Removes clients that have been silent for too long.
    pub(super) fn close_expired(&mut self, shared: &mut Shared) {
        let now = shared.now();
        self.clients.retain(|_, client| {
            let is_expired = now.saturating_duration_since(client.last_active) >= CLIENT_TIMEOUT;
            if is_expired {
                shared.hub.close(client.session);
            }
            !is_expired
        });
    }

    /// Closes the socket, which the sinks of all clients share.
    fn close(&mut self, shared: &mut Shared) {
        for client in std::mem::take(&mut self.clients).into_values() {
            shared.hub.close(client.session);
        }
        self.socket = None;
    }
}
