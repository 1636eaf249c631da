//! Traversal of all values of a message, with the path to each.

use std::ops::ControlFlow;

use uavspec_runtime::Scalar;
use uavspec_schema::{Element, Shape};

use super::bytes::until_nul;
use super::plan::{Field, Plan};
use super::trail::Trail;
use super::view::DynamicView;

/// A value reported by the traversal. An array of scalars, texts or strings is reported element by element.
#[derive(Clone, Copy)]
pub(super) enum Stop<'v> {
    /// A number: its type, its bytes, and their offset in the buffer.
    Number(Scalar, &'v [u8], usize),
    /// The bytes of a `char[N]` before the first NUL.
    Text(&'v [u8]),
    /// The bytes of a string.
    String(&'v [u8]),
    /// The number of elements of a sequence, reported before its elements.
    Length(usize),
}

/// Visits the values of a message.
pub(super) trait Walk<'v> {
    /// True if the field needs to be visited.
    fn enters(&self, plans: &[Plan], field: &Field) -> bool;

    /// Visits a value, and may stop the traversal.
    fn stop(&mut self, trail: &Trail<'v>, field: &'v Field, stop: Stop<'v>) -> ControlFlow<()>;
}

/// Traverses all fields in declaration order.
pub(super) fn walk<'v>(
    view: DynamicView<'v>,
    trail: &mut Trail<'v>,
    walker: &mut impl Walk<'v>,
) -> ControlFlow<()> {
    for field in &view.plan.fields {
        if walker.enters(&view.types.plans, field) {
            trail.enter(&field.name);
            walk_field(view, field, trail, walker)?;
            trail.leave();
        }
    }
    ControlFlow::Continue(())
}

fn walk_field<'v>(
    view: DynamicView<'v>,
    field: &'v Field,
    trail: &mut Trail<'v>,
    walker: &mut impl Walk<'v>,
) -> ControlFlow<()> {
    let elements = view.elements(field);
    if field.is_sequence() {
        walker.stop(trail, field, Stop::Length(elements.len()))?;
    }
    let is_single = field.shape == Shape::Single;
    for index in 0..elements.len() {
        if !is_single {
            trail.select(Some(index));
        }
        let stop = match field.element {
            Element::Scalar(scalar) => {
                Stop::Number(scalar, elements.element_bytes(index), elements.at(index))
            }
            Element::Text(_) => Stop::Text(until_nul(elements.element_bytes(index))),
            Element::String { .. } => Stop::String(elements.string(index)),
            Element::Message(_) => {
                walk(elements.message(index), trail, walker)?;
                continue;
            }
        };
        walker.stop(trail, field, stop)?;
    }
    ControlFlow::Continue(())
}
