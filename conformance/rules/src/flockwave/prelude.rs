//! The names that most files of Flockwave rules use.

pub(super) use serde_json::{Value, json};
pub(super) use uavspec_flockwave::body_schema::{ExpectedValue, Fault, Mismatch};
pub(super) use uavspec_flockwave::session::{Exchange, Reference, Role, Stage};
pub(super) use uavspec_flockwave::transport::endpoint::Endpoint;
pub(super) use uavspec_model::json::{Tree, pointer};
pub(super) use uavspec_model::{Detail, Level, Location, Rule, Status};

pub(super) use super::attribution::Attribution;
pub(super) use super::bug::{Bug, Needs};
pub(super) use super::per_connection::PerConnection;
pub(super) use super::sample::Session;
pub(super) use super::trial::{Attempt, Request, Sent, Step, Strain, Trial};
pub(super) use super::view::{Message, StatusReport, Violates};
pub(super) use super::{
    Check, FlockwaveRule, Mutant, SessionCheck, attribution, body, bug, lines, mutant, reply, served, source,
    trial, udp, ust,
};
pub(super) use crate::RuleContext;
