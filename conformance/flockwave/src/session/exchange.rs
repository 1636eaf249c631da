//! A record with its context in the session.

use std::borrow::Cow;

use uavspec_model::Rule;
use uavspec_model::json::{Tree, pointer};
use uavspec_model::text::{start_of, without_login};
use uavspec_schema::json_type::Direction;

use super::{ClockMove, Named, SentRequest, parts};
use crate::body_schema::{BodySchemas, Deviation, Fault, Step};
use crate::record::{self, SessionRecord};

/// The maximum length of an excerpt, in characters.
const MAX_EXCERPT: usize = 160;

/// The maximum length of a type name in findings, in characters.
const MAX_NAME: usize = 40;

/// The role of a record in the session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// An event of the connection.
    Event,
    /// Not a Flockwave message: invalid JSON, or not an object.
    Unreadable,
    /// A message that requires an answer.
    Request,
    /// An answer: a message with `refs`.
    Response,
    /// An unsolicited message from the server.
    Notification,
    /// A request that had no answer when its connection or the capture ended. The record has the location of the
    /// request.
    Unanswered,
}

/// The message to which a response's `refs` refers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// Unknown, since records may be missing.
    Unclear,
    /// A request that was waiting for an answer.
    Request,
    /// A request that was already answered.
    Answered,
    /// A notification.
    Notification,
    /// `refs` names no message of this connection.
    Unknown,
}

/// The identity of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ConnectionId {
    /// The index in the capture.
    pub index: usize,
    /// A number that distinguishes the connection from earlier connections with the same name.
    pub serial: u64,
}

/// A record with its context in the session.
#[derive(Clone, Debug)]
#[allow(clippy::struct_excessive_bools)] // the flags are independent
pub struct Exchange<'t> {
    /// The record.
    pub record: &'t SessionRecord<'t>,
    /// The role.
    pub role: Role,
    /// A number that distinguishes the record's connection from all others, including earlier connections with the same
    /// name.
    pub serial: u64,
    /// The time in seconds, if it is reliable.
    pub time: Option<f64>,
    /// The `id`, if it is a string.
    pub id: Option<&'t str>,
    /// The `refs`, if it is a string.
    pub refs: Option<&'t str>,
    /// The `body`, if it is an object.
    pub body: Option<&'t Tree<'t>>,
    /// The type of the body, if it is a string.
    pub type_name: Option<&'t str>,
    /// The message to which the record's `refs` refers.
    pub reference: Reference,
    /// The unanswered request, or the request that the record certainly answers.
    pub request: Option<SentRequest>,
    /// True if the record's id must be unique but isn't.
    pub is_id_in_use: bool,
    /// The receipts that the record issues.
    pub opened: Vec<Named>,
    /// True if a message without `refs` may answer a message of the client that has no readable id.
    pub may_answer_unknown: bool,
    /// True if a message without `refs` answers a message without a readable id, because it isn't a usual notification.
    pub answers_unknown: bool,
    /// True if `refs` is a copy of a client's id that is not a string.
    pub copies_id: bool,
    /// The operations that the record reports on.
    pub operations: Vec<Named>,
    /// The bounds of the server's clock offset that were known before this record, in seconds. A positive offset means
    /// that the server's clock is ahead.
    pub clock: Option<(f64, f64)>,
    /// True if a client may have set the server's clock back. Old timestamps may then be later than the server time.
    pub is_clock_set_back: bool,
    /// The change of the server's clock, if this record and an earlier record both contain the server's time.
    pub clock_move: Option<ClockMove>,
    /// The body schema violations in the message. `None` if there is no schema.
    pub deviations: Option<Vec<Deviation>>,
}

impl<'t> Exchange<'t> {
    pub(super) fn new(record: &'t SessionRecord<'t>, time: Option<f64>) -> Self {
        let message = record.value.filter(|value| matches!(value, Tree::Object(_)));
        let text = |key| message.and_then(|message| message.get(key)).and_then(Tree::as_str);
        let body = message.and_then(|message| message.get("body"));
        let body = body.filter(|body| matches!(body, Tree::Object(_)));
        let type_name = body.and_then(|body| body.get("type")).and_then(Tree::as_str);
        // The specification's advice for authors allows null for optional members.
        let has_refs =
            message.and_then(|message| message.get("refs")).is_some_and(|refs| *refs != Tree::Null);
        let role = match (record.direction, message) {
            (record::Direction::Event, _) => Role::Event,
            (_, None) => Role::Unreadable,
            _ if has_refs => Role::Response,
            (record::Direction::In, _) if type_name != Some("SYS-PING") => Role::Notification,
            _ => Role::Request,
        };
        Self {
            record,
            role,
            serial: 0,
            time,
            id: text("id"),
            refs: text("refs"),
            body,
            type_name,
            reference: Reference::Unclear,
            request: None,
            is_id_in_use: false,
            may_answer_unknown: false,
            answers_unknown: false,
            copies_id: false,
            opened: Vec::new(),
            operations: Vec::new(),
            clock: None,
            is_clock_set_back: false,
            clock_move: None,
            deviations: None,
        }
    }

    /// Creates the exchange of a notification that has already been checked, and whose record has no value.
    pub fn checked_notification(record: &'t SessionRecord<'t>, type_name: &'t str, id: &'t str) -> Self {
        let exchange = Self::new(record, None);
        Self {
            role: Role::Notification,
            type_name: Some(type_name),
            id: Some(id),
            deviations: Some(Vec::new()),
            ..exchange
        }
    }

    /// Creates the exchange of an unanswered request.
    pub fn unanswered(record: &'t SessionRecord<'t>, serial: u64, request: SentRequest) -> Self {
        let exchange = Self::new(record, None);
        Self { role: Role::Unanswered, serial, request: Some(request), ..exchange }
    }

    /// True if the record is a message from the server, readable or not.
    pub fn is_from_server(&self) -> bool {
        self.record.direction == record::Direction::In && self.role != Role::Unanswered
    }

    /// The identity of the record's connection.
    pub fn connection_id(&self) -> ConnectionId {
        ConnectionId { index: self.record.connection.index, serial: self.serial }
    }

    /// The message, if the server sent it.
    pub fn message(&self) -> Option<&'t Tree<'t>> {
        let is_object = |value: &&Tree<'_>| matches!(value, Tree::Object(_));
        self.record.value.filter(is_object).filter(|_| self.is_from_server())
    }

    /// The body, if this is a message of this type from the server.
    pub fn body_of(&self, type_name: &str) -> Option<&'t Tree<'t>> {
        self.body.filter(|_| self.is_from_server() && self.type_name == Some(type_name))
    }

    /// The body, if this is the server's response of this type.
    pub fn response(&self, type_name: &str) -> Option<&'t Tree<'t>> {
        self.body_of(type_name).filter(|_| self.role == Role::Response)
    }

    /// The body, if this is a notification of this type.
    pub fn notification(&self, type_name: &str) -> Option<&'t Tree<'t>> {
        self.body_of(type_name).filter(|_| self.role == Role::Notification)
    }

    /// True if the message has a version and a type, as every Flockwave message must.
    pub fn is_sound(&self) -> bool {
        let version = self.record.value.and_then(|message| message.get("$fw.version"));
        version.and_then(Tree::as_str).is_some() && self.type_name.is_some()
    }

    /// The description of the rule test to which the record belongs. Answers and unanswered requests belong to the
    /// request's test. Events belong to the connection's test.
    pub fn tried(&self, rule: &Rule) -> Option<&str> {
        let (tested, how) = match &self.request {
            Some(request) => request.trial.as_ref().map(|(rule, how)| (*rule, how.as_str()))?,
            None => {
                self.record.trial.filter(|_| self.role == Role::Event).map(|trial| (trial.rule, trial.how))?
            }
        };
        (tested.id == rule.id).then_some(how)
    }

    /// The direction of a message.
    pub(crate) fn direction(&self) -> Option<Direction> {
        match self.role {
            Role::Request => Some(Direction::Request),
            Role::Response => Some(Direction::Response),
            Role::Notification if self.answers_unknown => Some(Direction::Response),
            Role::Notification => Some(Direction::Notification),
            Role::Event | Role::Unreadable | Role::Unanswered => None,
        }
    }

    /// The body schema violations in a message from the server.
    pub(super) fn deviations_from(&self, schemas: BodySchemas<'_>) -> Option<Vec<Deviation>> {
        let body = self.body.filter(|_| self.is_from_server())?;
        schemas.deviations(self.type_name?, self.direction()?, body)
    }

    /// Marks the undefined fields that hold requested objects: the answer should name these objects in another field.
    pub(super) fn note_misplaced(&mut self) {
        let Some(objects) = self.same_type_request().and_then(|request| request.objects.clone()) else {
            return;
        };
        let Some(parts) = self.type_name.and_then(parts) else { return };
        let body = self.body;
        for deviation in self.deviations.iter_mut().flatten() {
            let [Step::Other] = &deviation.steps[..] else { continue };
            let Some(Tree::Object(fields)) = body.filter(|_| deviation.fault == Some(Fault::Additional))
            else {
                continue;
            };
            let is_reported =
                |object: &str| parts.reply_fields.iter().any(|part| has_key(body, part, object));
            let is_misplaced =
                |name: &str| keys(body, name).any(|object| objects.contains(object) && !is_reported(object));
            let path = &deviation.mismatch.path;
            let found = fields.iter().find(|(name, _)| pointer(&["body", name]) == *path);
            if found.is_some_and(|(name, _)| is_misplaced(name)) {
                deviation.fault = Some(Fault::Misplaced);
            }
        }
    }

    /// A field of the body.
    pub fn field(&self, name: &str) -> Option<&'t Tree<'t>> {
        self.body.and_then(|body| body.get(name))
    }

    /// The request that the record answers, if the record and the request have the same type.
    pub fn same_type_request(&self) -> Option<&SentRequest> {
        self.request
            .as_ref()
            .filter(|request| self.type_name.is_some() && request.type_name.as_deref() == self.type_name)
    }

    /// The bounds of the server's clock offset in seconds, according to an answer to a time request.
    pub(crate) fn clock_reading(&self) -> Option<(f64, f64)> {
        let server_time = self.response("SYS-TIME")?.get("timestamp")?;
        // A fraction suggests that the unit isn't milliseconds.
        let server_time = seconds(server_time).filter(|_| matches!(server_time, Tree::Int(_)))?;
        let request = self.same_type_request()?;
        Some((server_time - self.time?, server_time - request.time?))
    }

    /// The subject of findings: the message type.
    pub fn subject(&self) -> Cow<'t, str> {
        match self.type_name {
            Some(name) if name.chars().count() <= MAX_NAME => Cow::Borrowed(name),
            Some(name) => Cow::Owned(name.chars().take(MAX_NAME).chain(['…']).collect()),
            None => Cow::Borrowed("message"),
        }
    }

    /// The start of the message text. The password of a login is not shown.
    pub fn excerpt(&self) -> String {
        start_of(&without_login(self.record.text), MAX_EXCERPT).into_owned()
    }
}

/// The keys of the object in a field of a body.
fn keys<'t>(body: Option<&'t Tree<'t>>, name: &str) -> impl Iterator<Item = &'t str> {
    let members = match body.and_then(|body| body.get(name)) {
        Some(Tree::Object(members)) => &members[..],
        _ => &[],
    };
    members.iter().map(|(key, _)| key.as_ref())
}

fn has_key(body: Option<&Tree<'_>>, name: &str, wanted: &str) -> bool {
    keys(body, name).any(|key| key == wanted)
}

/// The text of a message, reduced to the field at a JSON pointer. The password of a login is not shown.
pub fn message_excerpt(message: &Tree<'_>, pointer: &str) -> String {
    let is_login = message.get("body").and_then(|body| body.get("type")?.as_str()) == Some("AUTH-REQ");
    message.excerpt_at(if is_login { "/body/method" } else { pointer })
}

/// Converts milliseconds to seconds.
pub fn seconds(value: &Tree<'_>) -> Option<f64> {
    match value {
        #[allow(clippy::cast_precision_loss)] // times are small enough, and other values needn't be exact
        Tree::Int(value) => Some(*value as f64 / 1000.0),
        Tree::Float(value, _) => Some(*value / 1000.0),
        _ => None,
    }
}
