//! Whether the values of a message are what its definition allows.

use std::fmt;
use std::ops::ControlFlow;

use uavspec_runtime::{Constraint, Number, Rule};

use super::bytes::until_nul;
use super::plan::{Element, Field, Plan};
use super::trail::Trail;
use super::view::{DynamicView, scalar_value};
use super::walk::{Stop, Walk, walk};

/// A value that breaks a rule. Shown as `events[2].id: …`.
#[derive(Clone, Debug, PartialEq)]
pub struct Violation<'t> {
    /// The rule that is broken.
    pub rule: Rule,
    /// Where in the message, as `events[2].id`.
    pub path: String,
    /// The value: of a sequence or string its length, of text how many of its bytes are UTF-8.
    pub found: Number,
    /// What the numbers of the field may be, where its type doesn't say all.
    pub constraint: Option<Constraint<'t>>,
    /// The bound of a sequence or string.
    pub bound: Option<u32>,
}

impl fmt::Display for Violation<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}: ", self.path)?;
        self.rule.explain(self.found, self.constraint.as_ref(), self.bound, formatter)
    }
}

impl std::error::Error for Violation<'_> {}

/// Calls `report` with everything in a message that breaks a rule.
pub(super) fn each<'v>(view: DynamicView<'v>, report: &mut dyn FnMut(Violation<'v>)) {
    // Only what is reported ends a walk, and here nothing does.
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
        let constraint = field.restriction.as_ref().map(crate::schema::Restriction::constraint);
        let broken = match stop {
            Stop::Number(scalar, bytes, _) => scalar_value(scalar, bytes).number().and_then(|found| {
                let rule = constraint.unwrap_or(Constraint::NONE).violated_by(found)?;
                Some((rule, found, None))
            }),
            Stop::Text(bytes) => std::str::from_utf8(until_nul(bytes))
                .err()
                .map(|error| (Rule::Text, length(error.valid_up_to()), None)),
            Stop::String(text) => match field.element {
                Element::String(bounds) => exceeding(text.chars().count(), bounds.bound),
                _ => None,
            },
            Stop::Length(length) => exceeding(length, field.bound()),
        };
        if let Some((rule, found, bound)) = broken {
            (self.report)(Violation { rule, path: trail.text(self.message), found, constraint, bound });
        }
        ControlFlow::Continue(())
    }
}

fn exceeding(found: usize, bound: Option<u32>) -> Option<(Rule, Number, Option<u32>)> {
    let is_over = bound.is_some_and(|bound| found > bound as usize);
    is_over.then(|| (Rule::Bound, length(found), bound))
}

fn length(length: usize) -> Number {
    Number::Int(length as i128)
}
