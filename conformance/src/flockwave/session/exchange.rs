//! An record with what it means in its session.

use std::borrow::Cow;

use uavspec_codegen::schema::json_type::Direction;

use super::{Named, SentRequest};
use crate::flockwave::body_schema::{BodySchemas, Deviation};
use crate::flockwave::record::{self, SessionRecord};
use crate::json::Tree;
use crate::model::Rule;

/// How much of a message is shown, in characters.
const MAX_EXCERPT: usize = 160;

/// How much of the name of a type is shown.
const MAX_NAME: usize = 40;

/// What something is in its session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// Something happened to the connection.
    Event,
    /// No Flockwave message at all: no JSON, or no object.
    Unreadable,
    /// It asks for an answer.
    Request,
    /// It answers: it has `refs`.
    Response,
    /// The server says something unasked.
    Notification,
    /// A request that has got no answer until its connection or the recording ended. It stands where that was sent.
    Unanswered,
}

/// What the `refs` of a response name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reference {
    /// Nobody knows.
    Unclear,
    /// A request that waited for an answer.
    Request,
    /// A request that had its answer already.
    Answered,
    /// A notification.
    Notification,
    /// Nothing that was sent on this connection.
    Unknown,
}

/// How the server's clock has moved against that of the recording, from one answer that tells its time to the next.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClockMove {
    /// By how much at least, in seconds; 0 where it needn't have moved at all.
    pub by: f64,
    /// How long after the answer before, in seconds.
    pub since: f64,
    /// Whether the server was asked to adjust its clock by nothing since.
    pub is_after_nothing: bool,
}

/// The id of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ConnectionId {
    /// Its number in its capture.
    pub index: usize,
    /// Tells it from those that had the same name before.
    pub serial: u64,
}

/// A record with what it means in its session.
#[derive(Clone, Debug)]
pub(crate) struct Exchange<'t> {
    /// The record.
    pub record: &'t SessionRecord<'t>,
    /// What it is.
    pub role: Role,
    /// Tells its connection from all others, also from those that had the same name before.
    pub serial: u64,
    /// Its time, where it can be trusted, in seconds.
    pub time: Option<f64>,
    /// Its `id`, where that is a string.
    pub id: Option<&'t str>,
    /// Its `refs`, where that is a string.
    pub refs: Option<&'t str>,
    /// Its `body`, where that is an object.
    pub body: Option<&'t Tree<'t>>,
    /// The type of the body, where that is a string.
    pub type_name: Option<&'t str>,
    /// What its `refs` name.
    pub reference: Reference,
    /// The request that it answers, where that is certain; or the one that got no answer.
    pub request: Option<SentRequest>,
    /// Whether its id is that of another message which it must not be.
    pub is_id_in_use: bool,
    /// Receipts that it gives.
    pub opened: Vec<Named>,
    /// Receipts of which it tells something.
    pub operations: Vec<Named>,
    /// By how much the server's clock is ahead of the recording's, as far as known before: bounds, in seconds.
    pub clock: Option<(f64, f64)>,
    /// How that has changed, where this tells the server's time, and something did before.
    pub clock_move: Option<ClockMove>,
    /// What of its body has another shape than it should; none where nothing says what that is.
    pub deviations: Option<Vec<Deviation>>,
}

impl<'t> Exchange<'t> {
    pub(super) fn new(record: &'t SessionRecord<'t>, time: Option<f64>) -> Self {
        let message = record.value.filter(|value| matches!(value, Tree::Object(_)));
        let text = |key| message.and_then(|message| message.get(key)).and_then(Tree::as_str);
        let body = message.and_then(|message| message.get("body"));
        let body = body.filter(|body| matches!(body, Tree::Object(_)));
        let type_name = body.and_then(|body| body.get("type")).and_then(Tree::as_str);
        // Optional members may be null, says the advice to authors of the specification.
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
            opened: Vec::new(),
            operations: Vec::new(),
            clock: None,
            clock_move: None,
            deviations: None,
        }
    }

    /// That a request has got no answer.
    pub(crate) fn unanswered(record: &'t SessionRecord<'t>, serial: u64, request: SentRequest) -> Self {
        let exchange = Self::new(record, None);
        Self { role: Role::Unanswered, serial, request: Some(request), ..exchange }
    }

    /// Whether it is a message of the server, readable or not.
    pub(crate) fn is_from_server(&self) -> bool {
        self.record.direction == record::Direction::In && self.role != Role::Unanswered
    }

    /// The id of its connection.
    pub(crate) fn connection_id(&self) -> ConnectionId {
        ConnectionId { index: self.record.connection.index, serial: self.serial }
    }

    /// The message, where it is one of the server.
    pub(crate) fn message(&self) -> Option<&'t Tree<'t>> {
        let is_object = |value: &&Tree<'_>| matches!(value, Tree::Object(_));
        self.record.value.filter(is_object).filter(|_| self.is_from_server())
    }

    /// The body of a message of the server that is of this type.
    pub(crate) fn body_of(&self, type_name: &str) -> Option<&'t Tree<'t>> {
        self.body.filter(|_| self.is_from_server() && self.type_name == Some(type_name))
    }

    /// The body of a response of the server that is of this type.
    pub(crate) fn response(&self, type_name: &str) -> Option<&'t Tree<'t>> {
        self.body_of(type_name).filter(|_| self.role == Role::Response)
    }

    /// The body of a notification that is of this type.
    pub(crate) fn notification(&self, type_name: &str) -> Option<&'t Tree<'t>> {
        self.body_of(type_name).filter(|_| self.role == Role::Notification)
    }

    /// Whether it has what makes it a message of Flockwave: a version, and a type.
    pub(crate) fn is_sound(&self) -> bool {
        let version = self.record.value.and_then(|message| message.get("$fw.version"));
        version.and_then(Tree::as_str).is_some() && self.type_name.is_some()
    }

    /// How a rule is tried with the request that it answers, or that has got no answer, or with the connection that it
    /// tells of.
    pub(crate) fn tried(&self, rule: &Rule) -> Option<&str> {
        let (of, how) = match &self.request {
            Some(request) => request.trial.as_ref().map(|(rule, how)| (*rule, how.as_str()))?,
            None => self.record.trial.filter(|_| self.role == Role::Event).map(|of| (of.rule, of.how))?,
        };
        (of.id == rule.id).then_some(how)
    }

    /// Which way it goes, where it is a message.
    pub(crate) fn direction(&self) -> Option<Direction> {
        match self.role {
            Role::Request => Some(Direction::Request),
            Role::Response => Some(Direction::Response),
            Role::Notification => Some(Direction::Notification),
            Role::Event | Role::Unreadable | Role::Unanswered => None,
        }
    }

    /// What of a body that the server sends has another shape than its type has for its direction.
    pub(super) fn deviations_from(&self, schemas: BodySchemas<'_>) -> Option<Vec<Deviation>> {
        let body = self.body.filter(|_| self.is_from_server())?;
        schemas.deviations(self.type_name?, self.direction()?, body)
    }

    /// A field of the body.
    pub(crate) fn field(&self, name: &str) -> Option<&'t Tree<'t>> {
        self.body.and_then(|body| body.get(name))
    }

    /// The request that it answers, where it is of this type as well.
    pub(crate) fn same_type_request(&self) -> Option<&SentRequest> {
        self.request
            .as_ref()
            .filter(|request| self.type_name.is_some() && request.type_name.as_deref() == self.type_name)
    }

    /// By how much the server's clock is ahead, going by this answer to a request for the time: bounds, in seconds.
    pub(crate) fn clock_reading(&self) -> Option<(f64, f64)> {
        let server_time = self.response("SYS-TIME")?.get("timestamp")?;
        // What has a fraction counts seconds, or whatever else.
        let server_time = seconds(server_time).filter(|_| matches!(server_time, Tree::Int(_)))?;
        let request = self.same_type_request()?;
        Some((server_time - self.time?, server_time - request.time?))
    }

    /// What findings on it are about: its type.
    pub(crate) fn subject(&self) -> Cow<'t, str> {
        match self.type_name {
            Some(name) if name.chars().count() <= MAX_NAME => Cow::Borrowed(name),
            Some(name) => Cow::Owned(name.chars().take(MAX_NAME).chain(['…']).collect()),
            None => Cow::Borrowed("message"),
        }
    }

    /// The beginning of it, as it is written.
    pub(crate) fn excerpt(&self) -> String {
        let mut text: String = self.record.text.chars().take(MAX_EXCERPT).collect();
        if text.len() < self.record.text.len() {
            text.push('…');
        }
        text
    }
}

/// Milliseconds as seconds.
pub(crate) fn seconds(value: &Tree<'_>) -> Option<f64> {
    match value {
        #[allow(clippy::cast_precision_loss)] // times fit well, and others needn't be exact
        Tree::Int(value) => Some(*value as f64 / 1000.0),
        Tree::Float(value, _) => Some(*value / 1000.0),
        _ => None,
    }
}
