//! The names that most rules need.

pub(super) use uavspec_schema::diagnostic::{Diagnostic, Level};
pub(super) use uavspec_schema::example::Example;
pub(super) use uavspec_schema::finding::Edit;
pub(super) use uavspec_schema::glider;
pub(super) use uavspec_schema::source::SourceMap;

pub(super) use super::rule::{Check, Levels, Measured, Rule, Sink, no_fix};
pub(super) use super::subject::Subject;
