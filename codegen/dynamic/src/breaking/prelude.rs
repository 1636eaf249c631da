//! The names that most rules need.

pub(super) use uavspec_schema::diagnostic::Level;
pub(super) use uavspec_schema::example::Example;
pub(super) use uavspec_schema::finding::Sides;
pub(super) use uavspec_schema::{Field, glider};

pub(super) use super::message::{Pair, both};
pub(super) use super::rule::{Category, Check, Rule, Sink};
