//! UDP: one message per datagram. A client receives notifications for a minute after its last datagram.

use std::collections::BTreeMap;
use std::io;
use std::net::{SocketAddr, UdpSocket};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use serde::de::IgnoredAny;
use serde_json::Value;

use super::{POLL_INTERVAL, Shared};
use crate::flockwave::transport::http::is_silence;
use crate::rules::flockwave::{udp_01, udp_02, udp_03};
use crate::serve::hub::{ConnectionKind, SessionId, Sink};
use crate::serve::message::{enveloped, refusal, text};

/// The maximum length of a message in a datagram.
const DATAGRAM_LIMIT: usize = 65_507;

/// The time after which a silent client counts as disconnected, as the specification recommends.
const CLIENT_TIMEOUT: Duration = Duration::from_secs(60);

/// The maximum number of concurrent clients.
const CLIENT_LIMIT: usize = 1024;

/// Sends datagrams to a client.
struct DatagramSink {
    socket: UdpSocket,
    client: SocketAddr,
    /// True with the FW-UDP-01 bug, which sends each notification twice in one datagram.
    is_doubling: bool,
}

impl Sink for DatagramSink {
    fn send(&self, text: &str) {
        let is_doubled =
            self.is_doubling && serde_json::from_str(text).is_ok_and(|m: Value| m.get("refs").is_none());
        let text = if is_doubled { format!("{text}\n{text}") } else { text.to_owned() };
        let text = if text.len() <= DATAGRAM_LIMIT { Some(text) } else { shortened(&text) };
        if let Some(text) = text {
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

struct Peer {
    session: SessionId,
    last_received: Instant,
}

/// Serves all clients until the server ends.
pub(super) fn serve(shared: &Arc<Shared>, socket: &UdpSocket) {
    let mut peers: BTreeMap<SocketAddr, Peer> = BTreeMap::new();
    let mut first = None;
    let mut datagram = vec![0; DATAGRAM_LIMIT + 1];
    while !shared.is_ending() {
        let received =
            socket.set_read_timeout(Some(POLL_INTERVAL)).and_then(|()| socket.recv_from(&mut datagram));
        close_expired(shared, &mut peers);
        let (length, client) = match received {
            Ok(received) => received,
            // Some systems report here that an earlier datagram was not delivered.
            Err(error) if is_silence(&error) || error.kind() == io::ErrorKind::ConnectionReset => continue,
            Err(_) => {
                thread::sleep(POLL_INTERVAL);
                continue;
            }
        };
        let datagram = &datagram[..length];
        if shared.has_bug(&udp_03::RULE) && serde_json::from_slice::<IgnoredAny>(datagram).is_err() {
            return;
        }
        let first = *first.get_or_insert(client);
        let answered = if shared.has_bug(&udp_02::RULE) { first } else { client };
        if let Some(session) = session(shared, socket, &mut peers, client, answered) {
            shared.receive(session, datagram);
        }
    }
}

/// The session of a client, created if the client is new or its session has expired. Answers go to `answered`.
fn session(
    shared: &Shared,
    socket: &UdpSocket,
    peers: &mut BTreeMap<SocketAddr, Peer>,
    client: SocketAddr,
    answered: SocketAddr,
) -> Option<SessionId> {
    if let Some(peer) = peers.get_mut(&client) {
        peer.last_received = Instant::now();
        return Some(peer.session);
    }
    if peers.len() >= CLIENT_LIMIT {
        return None;
    }
    let is_doubling = shared.has_bug(&udp_01::RULE);
    let sink = DatagramSink { socket: socket.try_clone().ok()?, client: answered, is_doubling };
    let session = shared.open(ConnectionKind::Datagrams, Arc::new(sink));
    peers.insert(client, Peer { session, last_received: Instant::now() });
    Some(session)
}

fn close_expired(shared: &Shared, peers: &mut BTreeMap<SocketAddr, Peer>) {
    peers.retain(|_, peer| {
        let is_active = peer.last_received.elapsed() < CLIENT_TIMEOUT;
        if !is_active {
            shared.close(peer.session);
        }
        is_active
    });
}
