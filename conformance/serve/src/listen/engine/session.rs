//! An Engine.IO session of a Socket.IO client.

use std::cell::{Cell, RefCell};
use std::hash::{BuildHasher as _, RandomState};
use std::rc::Rc;
use std::time::{Duration, Instant};

use serde_json::json;
use tungstenite::protocol::frame::Frame;
use uavspec_flockwave::transport::engine::{Kind, Packet, Revision};
use uavspec_flockwave::transport::socketio;
use uavspec_rules::flockwave::{sio_01, sio_03};

use crate::hub::{ConnectionKind, SessionId, Sink};
use crate::listen::Shared;
use crate::listen::limits::{DISCONNECTED, REQUEST_LIMIT, Reason};
use crate::listen::outbox::Outbox;
use crate::listen::seats::Seat;

/// The ping interval, as in the Socket.IO libraries.
const PING_INTERVAL: Duration = Duration::from_secs(25);

/// The time limit for the response to a ping.
const PING_TIMEOUT: Duration = Duration::from_secs(20);

/// The time limit for the first request of a client after it opened a session.
const FIRST_USE_TIMEOUT: Duration = Duration::from_secs(5);

/// A session.
pub(in crate::listen) struct Session {
    pub(super) revision: Revision,
    pub(super) sid: String,
    pub(super) seat: Cell<Seat>,
    /// The packets for polls.
    pub(super) queue: Outbox,
    /// Sends the packets after an upgrade, in place of the queue.
    web_socket: RefCell<Option<Rc<Outbox>>>,
    is_polled: Cell<bool>,
    /// True if another request followed the first one, or if the session was opened over a WebSocket.
    pub(super) is_used: Cell<bool>,
    /// The session in the hub, after the client has joined the namespace.
    joined: Cell<Option<SessionId>>,
    /// True after the FW-SIO-03 bug has occurred. The session then ignores further messages.
    has_stopped_reading: Cell<bool>,
    last_received: Cell<Instant>,
    last_ping: Cell<Instant>,
}

/// Sends messages as packets.
struct PacketSink {
    session: Rc<Session>,
    event: &'static str,
}

impl Sink for PacketSink {
    fn send(&self, text: &str) {
        self.session.push(Kind::Message, socketio::message_as(self.event, text));
    }

    fn close(&self) {
        self.session.push(Kind::Message, "1");
        self.session.push(Kind::Close, "");
        self.session.close();
    }
}

impl Session {
    /// Opens a session.
    pub(super) fn open(shared: &mut Shared, revision: Revision) -> Rc<Self> {
        // `RandomState` has random keys.
        let sid = format!("{:016x}{:016x}", RandomState::new().hash_one(0), RandomState::new().hash_one(1));
        let now = shared.now();
        let session = Rc::new(Self {
            revision,
            sid: sid.clone(),
            seat: Cell::new(Seat::new(now)),
            queue: shared.outbox(None),
            web_socket: RefCell::default(),
            is_polled: Cell::new(false),
            is_used: Cell::new(false),
            joined: Cell::new(None),
            has_stopped_reading: Cell::new(false),
            last_received: Cell::new(now),
            last_ping: Cell::new(now),
        });
        let opening = json!({
            "sid": sid,
            "upgrades": ["websocket"],
            "pingInterval": PING_INTERVAL.as_millis(),
            "pingTimeout": PING_TIMEOUT.as_millis(),
            "maxPayload": REQUEST_LIMIT,
        });
        session.push(Kind::Open, opening.to_string());
        if revision == Revision::Three {
            // In this revision, clients join the default namespace automatically.
            session.push(Kind::Message, "0");
            session.join(shared);
        }
        session
    }

    /// Sends a packet.
    pub(super) fn push(&self, kind: Kind, data: impl Into<String>) {
        let text = Packet::new(kind, data).to_text();
        match &*self.web_socket.borrow() {
            Some(outbox) => outbox.push_text(text),
            None => self.queue.push(text),
        }
    }

    /// True if packets are sent over a WebSocket.
    pub(super) fn is_upgraded(&self) -> bool {
        self.web_socket.borrow().is_some()
    }

    /// Sends all further packets over a WebSocket.
    pub(super) fn upgrade(&self, outbox: &Rc<Outbox>) {
        self.is_used.set(true);
        while let Some(text) = self.queue.take() {
            outbox.push_text(text);
        }
        self.web_socket.replace(Some(Rc::clone(outbox)));
        if self.queue.is_closed() {
            self.close();
        }
    }

    /// Registers a poll. Returns false if another poll is pending.
    pub(super) fn start_poll(&self, now: Instant) -> bool {
        self.last_received.set(now);
        !self.is_polled.replace(true)
    }

    /// Allows the next poll.
    pub(super) fn end_poll(&self, now: Instant) {
        self.is_polled.set(false);
        // A client can't send anything else while it waits for a poll.
        self.last_received.set(now);
    }

    /// True if the client has used the session and responded to pings in time, and reads fast enough.
    pub(super) fn is_alive(&self, now: Instant) -> bool {
        let limit = if self.is_used.get() { PING_INTERVAL + PING_TIMEOUT } else { FIRST_USE_TIMEOUT };
        !self.queue.has_failed() && now < self.last_received.get() + limit
    }

    /// Sends a ping if it is due.
    pub(super) fn ping_if_due(&self, now: Instant) {
        if self.revision == Revision::Four && now >= self.last_ping.get() + PING_INTERVAL {
            self.last_ping.set(now);
            self.push(Kind::Ping, "");
        }
    }

    /// Ends the session after the waiting packets have been sent.
    pub(super) fn close(&self) {
        self.queue.close();
        if let Some(outbox) = &*self.web_socket.borrow() {
            outbox.push_frame(Frame::close(None));
            outbox.close();
        }
    }

    /// Processes a packet from the client. Returns true if it is a valid request.
    pub(super) fn take(self: &Rc<Self>, shared: &mut Shared, packet: Packet) -> bool {
        // A request may contain further packets. A session that has ended must not join a namespace again.
        if self.queue.is_closed() {
            return false;
        }
        self.last_received.set(shared.now());
        match packet.kind {
            Kind::Message => return self.take_message(shared, &packet.data),
            Kind::Ping => self.push(Kind::Pong, packet.data),
            Kind::Close => self.end(shared, DISCONNECTED),
            Kind::Open | Kind::Pong | Kind::Upgrade | Kind::Noop => {}
        }
        false
    }

    /// Tells the client the reason, if there is one, and ends the session.
    pub(super) fn end(&self, shared: &mut Shared, reason: Reason) {
        if let Some(joined) = self.joined.take() {
            shared.hub.end_session(joined, reason);
        }
        shared.sessions.remove(&self.sid);
        self.push(Kind::Close, "");
        self.close();
    }

    fn take_message(self: &Rc<Self>, shared: &mut Shared, text: &str) -> bool {
        let packet = socketio::Packet::parse(text);
        if shared.has_bug(&sio_03::RULE)
            && matches!(packet, None | Some(socketio::Packet::Other | socketio::Packet::OtherEvent { .. }))
        {
            self.has_stopped_reading.set(true);
        }
        match packet {
            Some(socketio::Packet::Connect { namespace }) => self.connect(shared, &namespace),
            Some(socketio::Packet::Message { text, receipt }) => {
                if let Some(number) = receipt {
                    self.push(Kind::Message, socketio::receipt(number));
                }
                if let Some(joined) = self.joined.get().filter(|_| !self.has_stopped_reading.get()) {
                    let is_request = shared.receive(joined, text.as_bytes());
                    if is_request {
                        self.seat.set(Seat::of_active(shared.now()));
                    }
                    return is_request;
                }
            }
            Some(socketio::Packet::Disconnect) => self.end(shared, DISCONNECTED),
            Some(
                socketio::Packet::Refusal(_) | socketio::Packet::Other | socketio::Packet::OtherEvent { .. },
            )
            | None => {}
        }
        false
    }

    /// Answers the request to join a namespace. Only the default namespace exists.
    fn connect(self: &Rc<Self>, shared: &mut Shared, namespace: &str) {
        let is_known = namespace == "/";
        let answer = match self.revision {
            Revision::Three if is_known => "0".to_owned(),
            // Send a new id, since the session id must stay secret.
            Revision::Four if is_known => {
                format!("0{}", json!({ "sid": format!("{:016x}", RandomState::new().hash_one(2)) }))
            }
            Revision::Three => format!("4{namespace},{}", json!("Invalid namespace")),
            Revision::Four => format!("4{namespace},{}", json!({ "message": "Invalid namespace" })),
        };
        self.push(Kind::Message, answer);
        if is_known {
            self.join(shared);
        }
    }

    /// Opens a session in the hub, if there is none.
    fn join(self: &Rc<Self>, shared: &mut Shared) {
        if self.joined.get().is_none() {
            let event = if shared.has_bug(&sio_01::RULE) { "flockwave" } else { socketio::EVENT };
            let sink = PacketSink { session: Rc::clone(self), event };
            self.joined.set(Some(shared.hub.open(ConnectionKind::Persistent, Rc::new(sink))));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Options;
    use crate::family::answer;
    use crate::hub::Hub;

    #[test]
    fn a_session_that_has_ended_joins_no_namespace() {
        for end in ["41", "1"] {
            let mut shared = Shared::new(Hub::new(Options::default(), answer));
            let session = Session::open(&mut shared, Revision::Four);
            let mut take = |text: &str| session.take(&mut shared, Packet::parse(text).expect("a packet"));
            take("40");
            assert!(session.joined.get().is_some());
            take(end);
            take("40");
            assert_eq!(session.joined.get(), None, "after {end}");
        }
    }
}
