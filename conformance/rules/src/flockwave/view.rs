//! Views of session records for checks.
//!
//! Each kind of check ([`Check`](super::Check)) gets a view that contains only the inputs that may affect its result.
//! Message checks need not run for a status report that has the same content as an earlier report.

use std::borrow::Cow;

use uavspec_flockwave::body_schema::{Deviation, Mismatch};
use uavspec_flockwave::record::Connection;
use uavspec_flockwave::session::{ConnectionId, Exchange, Role};
use uavspec_model::Detail;
use uavspec_model::json::Tree;

use crate::RuleContext;

/// The type of status reports.
const STATUS: &str = "UAV-INF";

/// The content of a server message, without its time, connection and location, and without earlier messages.
#[derive(Debug)]
pub struct Message<'t> {
    /// The role of the message in its exchange.
    pub role: Role,
    /// The message, which is an object.
    pub value: &'t Tree<'t>,
    /// The `id` of the message, if it is a string.
    pub id: Option<&'t str>,
    /// The `body` of the message, if it is an object.
    pub body: Option<&'t Tree<'t>>,
    /// The type of the body, if it is a string.
    pub type_name: Option<&'t str>,
    /// The body schema violations; `None` if there is no body schema.
    pub deviations: Option<&'t [Deviation]>,
    /// True if the message may answer a message of the client that has no readable id. False for status reports.
    pub may_answer_unknown: bool,
    /// The exchange, for findings only.
    exchange: &'t Exchange<'t>,
}

impl<'t> Message<'t> {
    /// The message of a record, if the server sent it.
    pub fn from_exchange(exchange: &'t Exchange<'t>) -> Option<Self> {
        let value = exchange.message()?;
        let Exchange { role, id, body, type_name, ref deviations, .. } = *exchange;
        let may_answer_unknown = exchange.may_answer_unknown && type_name != Some(STATUS);
        let deviations = deviations.as_deref();
        Some(Self { role, value, id, body, type_name, deviations, may_answer_unknown, exchange })
    }

    /// The body, if it has this type.
    pub(super) fn body_of(&self, type_name: &str) -> Option<&'t Tree<'t>> {
        self.body.filter(|_| self.type_name == Some(type_name))
    }

    /// The body of a response of this type.
    pub(super) fn response(&self, type_name: &str) -> Option<&'t Tree<'t>> {
        self.body_of(type_name).filter(|_| self.role == Role::Response)
    }

    /// The body of a notification of this type.
    pub(super) fn notification(&self, type_name: &str) -> Option<&'t Tree<'t>> {
        self.body_of(type_name).filter(|_| self.role == Role::Notification)
    }

    /// A field of the body.
    pub(super) fn field(&self, name: &str) -> Option<&'t Tree<'t>> {
        self.body.and_then(|body| body.get(name))
    }

    /// Reports that the message violates the rule.
    pub(super) fn violates(&self, context: &mut RuleContext<'_>, detail: impl FnOnce() -> Detail) {
        self.exchange.violates(context, detail);
    }

    /// Reports that a field of the message violates the rule.
    pub(super) fn violates_in(
        &self,
        field: &str,
        context: &mut RuleContext<'_>,
        detail: impl FnOnce() -> Detail,
    ) {
        self.exchange.violates_in(field, context, detail);
    }

    /// Reports that the message violates the rule, with a subject that several types of messages share.
    pub(super) fn violates_as(
        &self,
        subject: &str,
        context: &mut RuleContext<'_>,
        detail: impl FnOnce() -> Detail,
    ) {
        context.violation(subject, self.exchange.record.location, detail);
    }

    /// Reports a body schema violation in a field or in the whole body.
    pub(super) fn deviates(&self, context: &mut RuleContext<'_>, field: &str, deviation: &Deviation) {
        let name = self.exchange.subject();
        let subject = if field.is_empty() { name } else { format!("{name}.{field}").into() };
        context.violation_of(&*subject, self.exchange.record.location, deviation.definition, || {
            let Mismatch { path, expected, actual } = &deviation.mismatch;
            Detail::differs(expected, actual).at(path)
        });
    }
}

/// A status report (UAV-INF notification) in its session. Gives access only to the ids and timestamps of the states.
#[derive(Debug)]
pub struct StatusReport<'t> {
    exchange: &'t Exchange<'t>,
    /// The states of the UAVs.
    states: &'t [(Cow<'t, str>, Tree<'t>)],
    /// The timestamps of the UAVs, if the states have already been checked.
    timestamps: &'t [(&'t str, Tree<'t>)],
}

impl<'t> StatusReport<'t> {
    /// The record as a status report, if it is one.
    pub fn from_exchange(exchange: &'t Exchange<'t>) -> Option<Self> {
        let body = exchange.notification(STATUS)?;
        Some(Self { exchange, states: super::body::members(Some(body), "status"), timestamps: &[] })
    }

    /// A report whose states have already been checked. Only their timestamps are available.
    pub fn checked(exchange: &'t Exchange<'t>, timestamps: &'t [(&'t str, Tree<'t>)]) -> Self {
        Self { exchange, states: &[], timestamps }
    }

    /// The connection.
    pub(super) fn connection(&self) -> Connection<'t> {
        self.exchange.record.connection
    }

    /// The id of the connection.
    pub(super) fn connection_id(&self) -> ConnectionId {
        self.exchange.connection_id()
    }

    /// The time of the report in seconds, if the time is reliable.
    pub(super) fn time(&self) -> Option<f64> {
        self.exchange.time
    }

    /// The `id` of the report, if it is a string.
    pub(super) fn id(&self) -> Option<&'t str> {
        self.exchange.id
    }

    /// True if another message has this id.
    pub(super) fn is_id_in_use(&self) -> bool {
        self.exchange.is_id_in_use
    }

    /// The bounds of the server's clock offset, in seconds.
    pub(super) fn clock(&self) -> Option<(f64, f64)> {
        self.exchange.clock
    }

    /// True if a client may have set the server's clock back.
    pub(super) fn is_clock_set_back(&self) -> bool {
        self.exchange.is_clock_set_back
    }

    /// The ids of the UAVs and their timestamps.
    pub(super) fn timestamps(&self) -> impl Iterator<Item = (&'t str, Option<&'t Tree<'t>>)> + use<'t> {
        let of_states = self.states.iter().map(|(uav, state)| (uav.as_ref(), state.get("timestamp")));
        of_states.chain(self.timestamps.iter().map(|(uav, timestamp)| (*uav, Some(timestamp))))
    }

    /// Reports that the message violates the rule.
    pub(super) fn violates(&self, context: &mut RuleContext<'_>, detail: impl FnOnce() -> Detail) {
        self.exchange.violates(context, detail);
    }

    /// Reports that a field of the message violates the rule.
    pub(super) fn violates_in(
        &self,
        field: &str,
        context: &mut RuleContext<'_>,
        detail: impl FnOnce() -> Detail,
    ) {
        self.exchange.violates_in(field, context, detail);
    }
}

/// Reports violations by the message of an exchange.
pub(super) trait Violates {
    /// Reports that the message violates the rule.
    fn violates(&self, context: &mut RuleContext<'_>, detail: impl FnOnce() -> Detail);

    /// Reports that a field of the message violates the rule.
    fn violates_in(&self, field: &str, context: &mut RuleContext<'_>, detail: impl FnOnce() -> Detail);
}

impl Violates for Exchange<'_> {
    fn violates(&self, context: &mut RuleContext<'_>, detail: impl FnOnce() -> Detail) {
        context.violation(&self.subject(), self.record.location, detail);
    }

    fn violates_in(&self, field: &str, context: &mut RuleContext<'_>, detail: impl FnOnce() -> Detail) {
        context.violation(&format!("{}.{field}", self.subject()), self.record.location, detail);
    }
}
