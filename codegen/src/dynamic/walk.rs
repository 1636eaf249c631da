//! Walking through all values of a message, with the way to each.

use std::ops::ControlFlow;

use uavspec_runtime::Scalar;

use super::plan::{Element, Field, Plan};
use super::trail::Trail;
use super::view::DynamicView;

/// What a walk comes by. A field without fields of its own is told as a whole, then each element.
#[derive(Clone, Copy)]
pub(super) enum Stop<'v> {
    /// A number, its bytes, and where they are in the buffer.
    Number(Scalar, &'v [u8], usize),
    /// The bytes of a `char[N]`.
    Text(&'v [u8]),
    /// A string.
    String(&'v str),
    /// The number of elements of a sequence.
    Length(usize),
}

/// What is done on a walk.
pub(super) trait Walk<'v> {
    /// Whether there is anything to do in a field.
    fn enters(&self, plans: &[Plan], field: &Field) -> bool;

    /// Does it, or ends the walk.
    fn stop(&mut self, trail: &Trail<'v>, field: &'v Field, stop: Stop<'v>) -> ControlFlow<()>;
}

/// Walks through all fields in declared order.
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
    let is_single = field.shape == crate::schema::Shape::Single;
    for index in 0..elements.len() {
        if !is_single {
            trail.select(Some(index));
        }
        let stop = match field.element {
            Element::Scalar(scalar) => {
                Stop::Number(scalar, elements.element_bytes(index), elements.at(index))
            }
            Element::Text(_) => Stop::Text(elements.element_bytes(index)),
            Element::String(_) => Stop::String(elements.string(index)),
            Element::Message(_) => {
                walk(elements.message(index), trail, walker)?;
                continue;
            }
        };
        walker.stop(trail, field, stop)?;
    }
    ControlFlow::Continue(())
}
