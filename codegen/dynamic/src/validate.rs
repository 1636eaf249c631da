//! Validation of the values of a message against its definition.

use std::fmt;
use std::ops::ControlFlow;

use uavspec_runtime::{ConstraintKind, Number};

use super::check::Violation;
use super::plan::{Field, Plan};
use super::trail::Trail;
use super::view::DynamicView;
use super::walk::{Stop, Walk, walk};

/// A violation with its location, displayed as `events[2].id: …`.
#[derive(Clone, Debug, PartialEq)]
pub struct ViolationAt<'t> {
    /// The kind of the violated constraint.
    pub kind: ConstraintKind,
    /// Path to the value, such as `events[2].id`.
    pub path: String,
    /// The value and the problem.
    pub violation: Violation<'t>,
}

impl fmt::Display for ViolationAt<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}: ", self.path)?;
        let (found, constraint, bound) = match self.violation {
            Violation::Number(_, found, restriction) => (found, Some(restriction.constraint()), None),
            Violation::Length { found, shape, .. } => (Number::Int(found as i128), None, shape.bound()),
            Violation::NotUtf8(at) => (Number::Int(at as i128), None, None),
            Violation::NotUtf16(at) => {
                return write!(formatter, "unpaired surrogate at code unit {at} ({})", self.kind);
            }
            Violation::Bool(_) | Violation::Type | Violation::TooLarge(_) | Violation::Nul(_) => {
                return self.kind.fmt(formatter);
            }
        };
        self.kind.explain(found, constraint.as_ref(), bound, formatter)
    }
}

impl std::error::Error for ViolationAt<'_> {}

/// Calls `report` for each violation in a message.
pub(super) fn each<'v>(view: DynamicView<'v>, report: &mut dyn FnMut(ViolationAt<'v>)) {
    // This validator never stops the walk.
    let _ = walk(view, &mut Trail::default(), &mut Validator { message: &view.plan.name, report });
}

struct Validator<'v, 'r> {
    message: &'v str,
    report: &'r mut dyn FnMut(ViolationAt<'v>),
}

impl<'v> Walk<'v> for Validator<'v, '_> {
    fn enters(&self, _: &[Plan], field: &Field) -> bool {
        field.is_restricted
    }

    fn stop(&mut self, trail: &Trail<'v>, field: &'v Field, stop: Stop<'v>) -> ControlFlow<()> {
        let value_type = field.value_type();
        let checked = match stop {
            Stop::Number(_, bytes, _) | Stop::Text(bytes) | Stop::String(bytes) => {
                value_type.check_bytes(bytes)
            }
            Stop::Length(length) => value_type.check_length(length),
        };
        if let Err(violation) = checked
            && let Some(kind) = violation.kind()
        {
            (self.report)(ViolationAt { kind, path: trail.text(self.message), violation });
        }
        ControlFlow::Continue(())
    }
}
