//! Validation of the values of a message against its definition.

use std::fmt;
use std::ops::ControlFlow;

use uavspec_runtime::{Constraint, ConstraintKind, Number};

use super::plan::{Element, Field, Plan};
use super::trail::Trail;
use super::view::{DynamicView, scalar_value};
use super::walk::{Stop, Walk, walk};

/// A value that violates a rule, displayed as `events[2].id: …`.
#[derive(Clone, Debug, PartialEq)]
pub struct Violation<'t> {
    /// The violated rule.
    pub rule: ConstraintKind,
    /// Path to the value, such as `events[2].id`.
    pub path: String,
    /// The value of a number, the length of a sequence or string, or the offset of the first invalid UTF-8 byte in
    /// text.
    pub found: Number,
    /// Constraint on the numbers of the field, in addition to the limits of its type.
    pub constraint: Option<Constraint<'t>>,
    /// Maximum length of the sequence or string.
    pub bound: Option<u32>,
}

impl fmt::Display for Violation<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}: ", self.path)?;
        self.rule.explain(self.found, self.constraint.as_ref(), self.bound, formatter)
    }
}

impl std::error::Error for Violation<'_> {}

/// Calls `report` for each violation in a message.
pub(super) fn each<'v>(view: DynamicView<'v>, report: &mut dyn FnMut(Violation<'v>)) {
    // This validator never stops the walk.
    let _ = walk(view, &mut Trail::default(), &mut Validator { message: &view.plan.name, report });
}

struct Validator<'v, 'r> {
    message: &'v str,
    report: &'r mut dyn FnMut(Violation<'v>),
}

impl<'v> Walk<'v> for Validator<'v, '_> {
    fn enters(&self, _: &[Plan], field: &Field) -> bool {
        field.is_restricted
    }

    fn stop(&mut self, trail: &Trail<'v>, field: &'v Field, stop: Stop<'v>) -> ControlFlow<()> {
        let constraint = field.restriction.as_ref().map(uavspec_schema::Restriction::constraint);
        let violation = match stop {
            Stop::Number(scalar, bytes, _) => scalar_value(scalar, bytes).number().and_then(|found| {
                let rule = constraint.unwrap_or(Constraint::NONE).violated_by(found)?;
                Some((rule, found, None))
            }),
            Stop::Text(text) => not_utf8(text),
            Stop::String(text) => {
                let Element::String(bounds) = field.element else { return ControlFlow::Continue(()) };
                let excess = bounds.exceeded_by(text);
                excess
                    .map(|(bound, found)| (ConstraintKind::Bound, length(found), Some(bound)))
                    .or_else(|| not_utf8(text))
            }
            Stop::Length(length) => exceeding(length, field.bound()),
        };
        if let Some((rule, found, bound)) = violation {
            (self.report)(Violation { rule, path: trail.text(self.message), found, constraint, bound });
        }
        ControlFlow::Continue(())
    }
}

fn not_utf8(text: &[u8]) -> Option<(ConstraintKind, Number, Option<u32>)> {
    let error = std::str::from_utf8(text).err()?;
    Some((ConstraintKind::Text, length(error.valid_up_to()), None))
}

fn exceeding(found: usize, bound: Option<u32>) -> Option<(ConstraintKind, Number, Option<u32>)> {
    let is_over = bound.is_some_and(|bound| found > bound as usize);
    is_over.then(|| (ConstraintKind::Bound, length(found), bound))
}

fn length(length: usize) -> Number {
    Number::Int(length as i128)
}
