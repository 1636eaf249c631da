//! The core of the server: processes the requests of all connections, and advances the simulation. The hub uses neither
//! sockets nor the system time. The caller passes the elapsed time, so the same calls always produce the same messages.

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use std::time::Duration;

use serde::Serialize;
use serde_json::Value;
use uavspec_rules::flockwave::{
    FlockwaveRule, Outgoing, ack_06, asy_04, asy_04i, asy_14, env_05i, env_19, env_22, env_27, obj_del_02,
};
use uavspec_types::flockwave::json::{
    LogMessage, LogSeverity, Notification, ObjectId, Request, Response, Timestamp, dev_inf, obj_del,
    sys_close, sys_msg, uav_inf,
};

use super::message::{envelope, enveloped, refusal, text, value};
use super::operation::Operation;
use super::request::{Incoming, read};
use super::uav::Uav;
use super::world::World;
use super::{Options, skybrush};

/// The step of the simulation, in seconds.
const STEP: f64 = 0.05;

/// The maximum number of steps per call. If the machine was suspended for longer, the simulation skips the rest of that
/// time.
const STEPS_AT_ONCE: u32 = 10_000;

/// The minimum time between notifications to all clients that are caused by requests. Such a notification may cost more
/// time than a thousand requests.
const ANNOUNCEMENT_INTERVAL: Duration = Duration::from_millis(500);

/// The maximum number of UAVs per notification, so that every notification fits into a UDP datagram.
const UAVS_AT_ONCE: usize = 50;

/// The maximum number of pending operations per connection.
const OPERATION_LIMIT: usize = 1000;

/// The maximum number of pending operations of all connections, each of which causes several notifications. Beyond this
/// number, each connection may still have [`RESERVED_OPERATIONS`].
const TOTAL_OPERATIONS: usize = 5000;

/// The number of pending operations that each connection may have even if [`TOTAL_OPERATIONS`] is reached.
const RESERVED_OPERATIONS: usize = 4;

/// The number of ids to store for the FW-ENV-19 bug.
const ANSWERED_LIMIT: usize = 1000;

/// The sending side of a connection.
pub(super) trait Sink {
    /// Sends a message.
    fn send(&self, text: &str);

    /// Closes the connection after sending the queued messages.
    fn close(&self);
}

/// The kind of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ConnectionKind {
    /// A connection that exists until either side closes it.
    Persistent,
    /// Datagrams: the server can't detect that the client has disconnected.
    Datagrams,
    /// A connection for a single request. It receives only the notifications that the request caused.
    OneShot,
}

/// The id of a connection.
pub(super) type SessionId = u64;

/// The state of a connection.
pub(super) struct Session {
    pub(super) kind: ConnectionKind,
    sink: Rc<dyn Sink>,
    /// The logged-in user.
    pub(super) user: Option<String>,
    /// Subscribed paths of the device tree, with the number of subscriptions.
    pub(super) subscriptions: BTreeMap<String, usize>,
    /// The values last sent to the client, by path.
    pub(super) last_sent: BTreeMap<String, Rc<Value>>,
    operations: Vec<Operation>,
    /// The time from the start of the server to the opening of the connection.
    since: Duration,
    /// The number of sent messages.
    sent: u64,
    /// The ids of answered requests; used only with the FW-ENV-19 bug.
    answered: Vec<String>,
}

/// The body of the response, or the reason for a rejection.
pub(super) type Answer = Result<Response, String>;

/// A function that answers a request.
pub(super) type RequestHandler = fn(&mut Hub, SessionId, Request) -> Answer;

/// The core of the server.
pub(super) struct Hub {
    pub(super) options: Options,
    pub(super) world: World,
    /// The adjustment of the clock, in milliseconds.
    pub(super) adjustment: u64,
    /// The time since the start of the server.
    pub(super) elapsed: Duration,
    /// The ports of the transports, by name.
    pub(super) ports: BTreeMap<&'static str, u16>,
    sessions: BTreeMap<SessionId, Session>,
    next_session: SessionId,
    next_receipt: u64,
    /// The number of pending operations of all connections.
    pending: usize,
    /// The number of subscribed paths of all connections.
    pub(super) subscribed: usize,
    simulated: f64,
    notified: Duration,
    /// The time of the first connection.
    first_contact: Option<Duration>,
    /// UAVs that are lost but still listed; used only with the FW-OBJ-DEL-02 bug.
    ghosts: Vec<String>,
    /// UAVs that have ignored UAV-LAND in this flight; used only with the FW-UAV-LAND-01 bug.
    pub(super) deaf: BTreeSet<String>,
    /// Notifications for all connections that wait to be sent, by type.
    announcements: BTreeMap<&'static str, Notification>,
    /// The time of the next notifications of this kind.
    next_announcement: Duration,
    /// True if no request is answered any more; used only with the FW-ENV-27 bug.
    is_stuck: bool,
    handler: RequestHandler,
}

impl Hub {
    /// Creates a hub that answers requests with this function.
    pub(super) fn new(options: Options, answer: RequestHandler) -> Self {
        Self {
            handler: answer,
            world: World::new(&options),
            options,
            adjustment: 0,
            elapsed: Duration::ZERO,
            ports: BTreeMap::new(),
            sessions: BTreeMap::new(),
            next_session: 1,
            next_receipt: 1,
            pending: 0,
            subscribed: 0,
            simulated: 0.0,
            notified: Duration::ZERO,
            first_contact: None,
            ghosts: Vec::new(),
            deaf: BTreeSet::new(),
            announcements: BTreeMap::new(),
            next_announcement: Duration::ZERO,
            is_stuck: false,
        }
    }

    /// True if the server violates this rule.
    pub(super) fn has_bug(&self, rule: &FlockwaveRule) -> bool {
        self.options.bug.is_some_and(|bug| std::ptr::eq(bug, rule))
    }

    /// The time of the server, in milliseconds since 1970.
    pub(super) fn now(&self) -> u64 {
        let passed = u64::try_from(self.elapsed.as_millis()).unwrap_or(u64::MAX);
        self.options.start.saturating_add(passed).saturating_add(self.adjustment)
    }

    /// The time of the server, as used in messages.
    pub(super) fn timestamp(&self) -> Timestamp {
        Timestamp(i64::try_from(self.now()).unwrap_or(i64::MAX))
    }

    /// The state of a connection.
    pub(super) fn session(&mut self, id: SessionId) -> Option<&mut Session> {
        self.sessions.get_mut(&id)
    }

    /// Registers a new connection.
    pub(super) fn open(&mut self, kind: ConnectionKind, sink: Rc<dyn Sink>) -> SessionId {
        let id = self.next_session;
        self.next_session += 1;
        let session = Session {
            kind,
            sink,
            user: None,
            subscriptions: BTreeMap::new(),
            last_sent: BTreeMap::new(),
            operations: Vec::new(),
            since: self.elapsed,
            sent: 0,
            answered: Vec::new(),
        };
        self.sessions.insert(id, session);
        self.first_contact.get_or_insert(self.elapsed);
        if self.may_receive(id) {
            self.greet(id);
        }
        id
    }

    /// Removes a connection.
    pub(super) fn close(&mut self, id: SessionId) {
        if let Some(session) = self.sessions.remove(&id) {
            self.pending = self.pending.saturating_sub(session.operations.len());
        }
    }

    /// Sends a SYS-CLOSE if there is a reason, and removes the connection.
    pub(super) fn end_session(&mut self, id: SessionId, reason: Option<&str>) {
        if let Some(reason) = reason {
            self.dismiss(id, reason);
        }
        self.close(id);
    }

    /// Sends a SYS-CLOSE with the reason, and closes the connection.
    fn dismiss(&mut self, id: SessionId, reason: &str) {
        self.notify(id, &farewell(reason));
        self.disconnect(id);
    }

    /// Sends a SYS-MSG that describes the server.
    pub(super) fn greet(&mut self, id: SessionId) {
        if self.sessions.get(&id).is_some_and(|session| session.kind == ConnectionKind::Persistent) {
            let item = LogMessage {
                message: format!("a simulated fleet of {} UAVs", self.world.uavs.len()),
                severity: Some(LogSeverity::Info),
                sender: None,
                timestamp: Some(self.timestamp()),
            };
            self.notify(id, &sys_msg::Notification { items: vec![item] }.into());
        }
    }

    /// Processes bytes that arrive from a client at the time `elapsed` after the start of the server. Returns true if
    /// the bytes are a valid request.
    pub(super) fn receive(&mut self, id: SessionId, bytes: &[u8], elapsed: Duration) -> bool {
        self.elapsed = self.elapsed.max(elapsed);
        self.is_stuck |= bytes == b"{}" && self.has_bug(&env_27::RULE);
        if self.is_stuck {
            return true;
        }
        if self.has_bug(&env_05i::RULE) {
            self.refuse_odd_id(id, bytes);
        }
        self.take(id, Incoming::parse(bytes))
    }

    /// Refuses a request whose id is not a string, with a copy of the id.
    fn refuse_odd_id(&self, id: SessionId, bytes: &[u8]) -> Option<()> {
        let message: Value = serde_json::from_slice(bytes).ok()?;
        let odd = message.get("id").filter(|id| !id.is_string())?;
        let mut answer = envelope("odd", None, value(&refusal("the id must be a string".to_owned())));
        answer["refs"] = odd.clone();
        self.sessions.get(&id)?.sink.send(&answer.to_string());
        Some(())
    }

    /// Processes a parsed message. Returns true if it is a valid request.
    pub(super) fn take(&mut self, id: SessionId, incoming: Incoming) -> bool {
        let is_request = matches!(incoming, Incoming::Request { .. });
        match incoming {
            Incoming::Request { id: request, kind, body } => {
                if self.options.is_for_skybrush {
                    let answer = self.answer(id, &request, &skybrush::specified(&body));
                    let answer = value(&answer.unwrap_or_else(refusal));
                    self.send(id, Some((&request, &body)), &skybrush::expected(&body, answer));
                } else {
                    let answer = self.answer(id, &request, &body).unwrap_or_else(refusal);
                    self.send(id, Some((&request, &body)), &answer);
                }
                if self.has_bug(&env_19::RULE) {
                    self.remember(id, &request);
                }
                if kind == "AUTH-REQ" && self.is_logged_in(id) {
                    self.greet(id);
                }
            }
            Incoming::Malformed { .. } if self.has_bug(&env_22::RULE) => self.disconnect(id),
            Incoming::Malformed { id: request, reason } => {
                self.send(id, Some((&request, &Value::Null)), &refusal(reason));
            }
            Incoming::Ignored => {}
        }
        is_request
    }

    /// Advances the simulation to the time `elapsed` after the start of the server.
    pub(super) fn advance(&mut self, elapsed: Duration) {
        self.elapsed = self.elapsed.max(elapsed);
        let target = self.elapsed.as_secs_f64() * self.options.speed;
        let now = self.now();
        let before = self.simulated;
        for _ in 0..STEPS_AT_ONCE {
            if self.simulated + STEP > target {
                break;
            }
            self.simulated += STEP;
            for uav in &mut self.world.uavs {
                uav.advance(STEP, now);
            }
        }
        let passed = self.simulated - before;
        if target - self.simulated > STEP {
            self.simulated = target;
        }
        self.advance_operations(passed);
        let remarks = self.world.remarks();
        if !remarks.is_empty() {
            let now = self.timestamp();
            let items = remarks.iter().map(|remark| remark.to_item(now)).collect();
            self.notify_all(&sys_msg::Notification { items }.into());
        }
        self.send_announcements();
        self.apply_appearances();
        self.apply_losses();
        self.disconnect_expired();
        self.notify_if_due();
    }

    /// Sends fleet notifications if they are due.
    fn notify_if_due(&mut self) {
        if self.options.rate <= 0.0 {
            return;
        }
        // A period that is too long for a duration never ends.
        let Ok(period) = Duration::try_from_secs_f64(1.0 / self.options.rate) else { return };
        let late = self.elapsed.saturating_sub(self.notified);
        if late >= period {
            // A short delay doesn't reduce the rate. After a longer delay, missed notifications are skipped.
            let is_short = late < period.saturating_mul(2);
            self.notified = if is_short { self.notified + period } else { self.elapsed };
            self.notify_of_uavs();
            self.notify_of_devices();
        }
    }

    /// Sends SYS-CLOSE to all clients, and closes their connections.
    pub(super) fn end(&mut self) {
        self.notify_all(&farewell("the server is shutting down"));
        for session in self.sessions.values() {
            session.sink.close();
        }
    }

    /// Removes UAVs, and notifies all clients.
    pub(super) fn lose(&mut self, ids: &[String]) {
        if ids.is_empty() {
            return;
        }
        if self.has_bug(&obj_del_02::RULE) {
            self.ghosts.extend_from_slice(ids);
        } else {
            self.world.uavs.retain(|uav| !ids.contains(&uav.id));
        }
        let ids = ids.iter().map(|id| ObjectId::from(id.as_str())).collect();
        self.notify_all(&obj_del::Notification { ids }.into());
    }

    /// Adds the UAVs that are due to appear.
    fn apply_appearances(&mut self) {
        for id in due(&mut self.options.appearances, self.first_contact, self.elapsed) {
            self.world.appear(&id);
        }
    }

    /// Removes the UAVs that are due to get lost.
    fn apply_losses(&mut self) {
        let ids = due(&mut self.options.losses, self.first_contact, self.elapsed);
        self.lose(&ids);
    }

    /// Closes connections that have reached the maximum duration.
    fn disconnect_expired(&mut self) {
        let Some(limit) = self.options.stay else { return };
        for id in self.listeners() {
            let Some(session) = self.sessions.get_mut(&id) else { continue };
            if self.elapsed.saturating_sub(session.since) < limit {
                continue;
            }
            // Prevents a second notification. The connection closes after all queued messages have been sent.
            session.since = Duration::MAX;
            self.dismiss(id, "the maximum connection time was reached");
        }
    }

    /// Starts an operation, and returns its receipt.
    pub(super) fn start(
        &mut self,
        session: SessionId,
        operation: impl FnOnce(String) -> Operation,
    ) -> Result<String, String> {
        let mut receipt = format!("r{}", self.next_receipt);
        if self.has_bug(&asy_04::RULE) {
            receipt = format!("{receipt:0>70}");
        } else if self.has_bug(&asy_04i::RULE) {
            "r1".clone_into(&mut receipt);
        }
        let session = self.sessions.get_mut(&session).ok_or("the connection has ended")?;
        let is_full = self.pending >= TOTAL_OPERATIONS;
        let limit = if is_full { RESERVED_OPERATIONS } else { OPERATION_LIMIT };
        if session.operations.len() >= limit {
            return Err("too many pending operations".to_owned());
        }
        session.operations.push(operation(receipt.clone()));
        self.pending += 1;
        self.next_receipt += 1;
        Ok(receipt)
    }

    /// A pending operation of a connection.
    pub(super) fn operation(&mut self, session: SessionId, receipt: &str) -> Option<&mut Operation> {
        let operations = &mut self.sessions.get_mut(&session)?.operations;
        operations.iter_mut().find(|operation| operation.receipt == receipt)
    }

    /// The UAV with this id.
    pub(super) fn uav(&mut self, id: &str) -> Option<&mut Uav> {
        self.world.uavs.iter_mut().find(|uav| uav.id == id)
    }

    /// Sends a notification to a connection.
    pub(super) fn notify(&mut self, id: SessionId, body: &Notification) {
        self.send(id, None, body);
    }

    /// Sends a notification to all connections at the next step, or [`ANNOUNCEMENT_INTERVAL`] after the previous one.
    /// Only the last notification of a type is sent, so a client that causes many can't delay others.
    pub(super) fn announce(&mut self, message_type: &'static str, body: Notification) {
        self.announcements.insert(message_type, body);
    }

    fn send_announcements(&mut self) {
        if self.announcements.is_empty() || self.elapsed < self.next_announcement {
            return;
        }
        self.next_announcement = self.elapsed + ANNOUNCEMENT_INTERVAL;
        for body in std::mem::take(&mut self.announcements).into_values() {
            self.notify_all(&body);
        }
    }

    /// Sends a notification to all connections that receive them.
    pub(super) fn notify_all(&mut self, body: &Notification) {
        let listeners = self.listeners();
        if self.options.bug.is_some() {
            for id in listeners {
                self.notify(id, body);
            }
            return;
        }
        // Without a bug, all connections receive the same body, so it is serialized only once.
        let written = text(body);
        for id in listeners {
            if let Some(session) = self.sessions.get_mut(&id) {
                session.sent += 1;
                session.sink.send(&enveloped(&format!("s{}", session.sent), None, &written));
            }
        }
    }

    /// The connections that receive notifications.
    fn listeners(&self) -> Vec<SessionId> {
        let is_persistent =
            |id: &SessionId| self.sessions.get(id).is_some_and(|s| s.kind != ConnectionKind::OneShot);
        self.sessions.keys().copied().filter(|id| is_persistent(id) && self.may_receive(*id)).collect()
    }

    /// True if the server requires no login or the client has logged in.
    fn may_receive(&self, id: SessionId) -> bool {
        self.options.login.is_none() || self.is_logged_in(id)
    }

    fn is_logged_in(&self, id: SessionId) -> bool {
        self.sessions.get(&id).is_some_and(|session| session.user.is_some())
    }

    fn answer(&mut self, id: SessionId, name: &str, body: &Value) -> Answer {
        let request = read(body)?;
        if !is_open(&request) && !self.may_receive(id) && !self.has_bug(&ack_06::RULE) {
            return Err("log in first".to_owned());
        }
        let is_known = |session: &Session| session.answered.iter().any(|known| known == name);
        if self.has_bug(&env_19::RULE) && self.sessions.get(&id).is_some_and(is_known) {
            return Err("this id was used before".to_owned());
        }
        (self.handler)(self, id, request)
    }

    /// Stores the id of an answered request.
    fn remember(&mut self, id: SessionId, request: &str) {
        if let Some(session) = self.sessions.get_mut(&id) {
            session.answered.push(request.to_owned());
            session.answered.truncate(ANSWERED_LIMIT);
        }
    }

    fn advance_operations(&mut self, seconds: f64) {
        let is_overrunning = self.has_bug(&asy_14::RULE);
        let mut reports = Vec::new();
        (self.pending, self.subscribed) = (0, 0);
        for (id, session) in &mut self.sessions {
            session.operations.retain_mut(|operation| {
                if is_overrunning && operation.is_suspended() {
                    operation.overrun();
                }
                let Some(report) = operation.advance(seconds) else { return true };
                let is_last = report.is_last();
                reports.push((*id, operation.receipt.clone(), report));
                !is_last
            });
            self.pending += session.operations.len();
            self.subscribed += session.subscriptions.len();
        }
        for (id, receipt, report) in reports {
            self.notify(id, &report.into_notification(&receipt));
        }
    }

    fn notify_of_uavs(&mut self) {
        let is_reachable = |uav: &&Uav| !uav.is_sleeping() && !self.ghosts.contains(&uav.id);
        let received: Vec<&Uav> = self.world.uavs.iter().filter(is_reachable).collect();
        let of_some = |uavs: &[&Uav]| {
            let status = uavs.iter().map(|uav| (uav.id.clone(), uav.status())).collect();
            uav_inf::Notification { status: Some(status) }.into()
        };
        let bodies: Vec<Notification> = received.chunks(UAVS_AT_ONCE).map(of_some).collect();
        for body in &bodies {
            self.notify_all(body);
        }
    }

    fn notify_of_devices(&mut self) {
        // Clients usually subscribe to the same paths, so each value is determined only once.
        let mut values: BTreeMap<String, Option<Rc<Value>>> = BTreeMap::new();
        for id in self.listeners() {
            let Some(session) = self.sessions.get_mut(&id) else { continue };
            let mut changed = BTreeMap::new();
            for path in session.subscriptions.keys() {
                if !values.contains_key(path) {
                    values.insert(path.clone(), self.world.values_at(path).ok().map(Rc::new));
                }
                let Some(Some(value)) = values.get(path) else { continue };
                if session.last_sent.get(path) != Some(value) {
                    session.last_sent.insert(path.clone(), Rc::clone(value));
                    changed.insert(path.clone(), Value::clone(value));
                }
            }
            if !changed.is_empty() {
                self.notify(id, &dev_inf::Notification { values: Some(changed) }.into());
            }
        }
    }

    /// Sends a body as a response or as a notification.
    fn send(&mut self, id: SessionId, request: Option<(&str, &Value)>, body: &impl Serialize) {
        let Some(session) = self.sessions.get_mut(&id) else { return };
        session.sent += 1;
        let name = format!("s{}", session.sent);
        let refs = request.map(|(refs, _)| refs);
        let is_null = request
            .is_some_and(|(_, body)| self.options.null_results.iter().any(|kind| body["type"] == **kind));
        if self.options.bug.is_none() && !is_null {
            return session.sink.send(&enveloped(&name, refs, &text(body)));
        }
        let mut message = envelope(&name, refs, value(body));
        if is_null {
            make_null(&mut message);
        }
        let mut outgoing = Outgoing::new(message, request.map(|(_, body)| body), session.sent);
        if let Some(rule) = self.options.bug {
            rule.bug.apply(&mut outgoing);
        }
        for text in outgoing.into_texts() {
            session.sink.send(&text);
        }
    }

    /// Closes a connection without a notification.
    fn disconnect(&mut self, id: SessionId) {
        if let Some(session) = self.sessions.get(&id) {
            session.sink.close();
        }
    }
}

/// Removes and returns the UAVs that are due to appear or to get lost.
fn due(list: &mut Vec<(String, Duration)>, first: Option<Duration>, elapsed: Duration) -> Vec<String> {
    let passed = first.map(|first| elapsed.saturating_sub(first));
    let due = list.extract_if(.., |(_, time)| passed.is_some_and(|passed| *time <= passed));
    due.map(|(id, _)| id).collect()
}

/// Replaces the results of a command with null.
fn make_null(message: &mut Value) {
    for result in message["body"]["result"].as_object_mut().into_iter().flat_map(serde_json::Map::values_mut)
    {
        *result = Value::Null;
    }
}

/// True if a request requires no login.
fn is_open(request: &Request) -> bool {
    matches!(
        request,
        Request::AuthInf(_)
            | Request::AuthReq(_)
            | Request::AuthWhoami(_)
            | Request::SysPing(_)
            | Request::SysVer(_)
    )
}

/// A notification that the server is closing the connection.
pub(super) fn farewell(reason: &str) -> Notification {
    sys_close::Notification { reason: Some(reason.to_owned()) }.into()
}
