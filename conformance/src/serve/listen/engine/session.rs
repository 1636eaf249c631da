//! An Engine.IO session of a Socket.IO client.

use std::hash::{BuildHasher as _, RandomState};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde_json::json;

use crate::flockwave::transport::engine::{Kind, Packet, Revision};
use crate::flockwave::transport::{MESSAGE_LIMIT, socketio};
use crate::rules::flockwave::{sio_01, sio_03};
use crate::serve::hub::{ConnectionKind, SessionId, Sink};
use crate::serve::listen::Shared;
use crate::serve::outbox::Outbox;

/// The ping interval, as in the Socket.IO libraries.
const PING_INTERVAL: Duration = Duration::from_secs(25);

/// The time limit for the response to a ping.
const PING_TIMEOUT: Duration = Duration::from_secs(20);

/// A session.
pub(super) struct Session {
    revision: Revision,
    sid: String,
    outbox: Arc<Outbox>,
    is_upgraded: AtomicBool,
    is_polled: AtomicBool,
    state: Mutex<State>,
}

struct State {
    /// The session in the hub, after the client has joined the namespace.
    joined: Option<SessionId>,
    /// True after the FW-SIO-03 bug has occurred. The session then ignores further messages.
    has_stopped_reading: bool,
    last_received: Instant,
    last_ping: Instant,
}

/// Sends messages as packets.
struct PacketSink {
    outbox: Arc<Outbox>,
    event: &'static str,
}

impl Sink for PacketSink {
    fn send(&self, text: &str) {
        push(&self.outbox, Kind::Message, socketio::message_as(self.event, text));
    }

    fn close(&self) {
        push(&self.outbox, Kind::Message, "1".to_owned());
        push(&self.outbox, Kind::Close, String::new());
        self.outbox.close();
    }
}

fn push(outbox: &Outbox, kind: Kind, data: String) {
    outbox.push(Packet::new(kind, data).to_text());
}

/// A pending poll. Dropping it allows the next poll.
pub(super) struct Poll<'s>(&'s Session);

impl Drop for Poll<'_> {
    fn drop(&mut self) {
        self.0.is_polled.store(false, Ordering::Release);
        // A client can't send anything else while it waits for a poll.
        self.0.state().last_received = Instant::now();
    }
}

impl Session {
    /// Opens a session. Returns its id and the session.
    pub(super) fn open(shared: &Shared, revision: Revision) -> (String, Arc<Self>) {
        // `RandomState` has random keys.
        let sid = format!("{:016x}{:016x}", RandomState::new().hash_one(0), RandomState::new().hash_one(1));
        let now = Instant::now();
        let session = Self {
            revision,
            sid: sid.clone(),
            outbox: Arc::default(),
            is_upgraded: AtomicBool::new(false),
            is_polled: AtomicBool::new(false),
            state: Mutex::new(State {
                joined: None,
                has_stopped_reading: false,
                last_received: now,
                last_ping: now,
            }),
        };
        let opening = json!({
            "sid": sid,
            "upgrades": ["websocket"],
            "pingInterval": PING_INTERVAL.as_millis(),
            "pingTimeout": PING_TIMEOUT.as_millis(),
            "maxPayload": MESSAGE_LIMIT,
        });
        push(&session.outbox, Kind::Open, opening.to_string());
        if revision == Revision::Three {
            // In this revision, clients join the default namespace automatically.
            push(&session.outbox, Kind::Message, "0".to_owned());
            session.join(shared);
        }
        (sid, Arc::new(session))
    }

    pub(super) fn revision(&self) -> Revision {
        self.revision
    }

    pub(super) fn outbox(&self) -> &Outbox {
        &self.outbox
    }

    /// True if packets are sent over a WebSocket.
    pub(super) fn is_upgraded(&self) -> bool {
        self.is_upgraded.load(Ordering::Acquire)
    }

    /// Switches to a WebSocket.
    pub(super) fn upgrade(&self) {
        self.is_upgraded.store(true, Ordering::Release);
    }

    /// Registers a poll. Returns `None` if another poll is pending.
    pub(super) fn start_poll(&self) -> Option<Poll<'_>> {
        self.state().last_received = Instant::now();
        (!self.is_polled.swap(true, Ordering::AcqRel)).then(|| Poll(self))
    }

    /// Ends the pending poll, so that the client can switch to a WebSocket.
    pub(super) fn release_poll(&self) {
        push(&self.outbox, Kind::Noop, String::new());
    }

    /// Sends a ping if it is due. Returns true if the client has responded in time.
    pub(super) fn tend(&self) -> bool {
        let mut state = self.state();
        if self.revision == Revision::Four && state.last_ping.elapsed() >= PING_INTERVAL {
            state.last_ping = Instant::now();
            push(&self.outbox, Kind::Ping, String::new());
        }
        state.last_received.elapsed() < PING_INTERVAL + PING_TIMEOUT
    }

    /// Processes a packet from the client.
    pub(super) fn take(&self, shared: &Shared, packet: Packet) {
        self.state().last_received = Instant::now();
        match packet.kind {
            Kind::Ping => push(&self.outbox, Kind::Pong, packet.data),
            Kind::Close => self.end(shared),
            Kind::Message => self.take_message(shared, &packet.data),
            Kind::Open | Kind::Pong | Kind::Upgrade | Kind::Noop => {}
        }
    }

    /// Ends the session.
    pub(super) fn end(&self, shared: &Shared) {
        let joined = self.state().joined.take();
        if let Some(joined) = joined {
            shared.close(joined);
        }
        shared.sessions.all().remove(&self.sid);
        push(&self.outbox, Kind::Close, String::new());
        self.outbox.close();
    }

    fn take_message(&self, shared: &Shared, text: &str) {
        let packet = socketio::Packet::parse(text);
        if shared.has_bug(&sio_03::RULE)
            && matches!(packet, None | Some(socketio::Packet::Other | socketio::Packet::OtherEvent { .. }))
        {
            self.state().has_stopped_reading = true;
        }
        match packet {
            Some(socketio::Packet::Connect { namespace }) if namespace == "/" => {
                let answer = match self.revision {
                    Revision::Three => "0".to_owned(),
                    // Send a new id, since the session id must stay secret.
                    Revision::Four => {
                        format!("0{}", json!({ "sid": format!("{:016x}", RandomState::new().hash_one(2)) }))
                    }
                };
                push(&self.outbox, Kind::Message, answer);
                self.join(shared);
            }
            Some(socketio::Packet::Connect { namespace }) => {
                let reason = match self.revision {
                    Revision::Three => json!("Invalid namespace"),
                    Revision::Four => json!({ "message": "Invalid namespace" }),
                };
                push(&self.outbox, Kind::Message, format!("4{namespace},{reason}"));
            }
            Some(socketio::Packet::Message { text, receipt }) => {
                if let Some(number) = receipt {
                    push(&self.outbox, Kind::Message, socketio::receipt(number));
                }
                let State { joined, has_stopped_reading, .. } = *self.state();
                if let Some(joined) = joined.filter(|_| !has_stopped_reading) {
                    shared.receive(joined, text.as_bytes());
                }
            }
            Some(socketio::Packet::Disconnect) => self.end(shared),
            Some(
                socketio::Packet::Refusal(_) | socketio::Packet::Other | socketio::Packet::OtherEvent { .. },
            )
            | None => {}
        }
    }

    /// Opens a session in the hub, if there is none.
    fn join(&self, shared: &Shared) {
        let mut state = self.state();
        if state.joined.is_none() {
            let event = if shared.has_bug(&sio_01::RULE) { "flockwave" } else { socketio::EVENT };
            let sink = PacketSink { outbox: Arc::clone(&self.outbox), event };
            state.joined = Some(shared.open(ConnectionKind::Persistent, Arc::new(sink)));
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
