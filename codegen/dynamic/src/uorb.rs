//! The uORB form. Messages of fixed size are already stored in this form, except for padding and noncanonical `bool`s.

use std::ops::ControlFlow;

use uavspec_runtime::layout::Size;
use uavspec_runtime::{Fault, Scalar};
use uavspec_schema::Element;

use super::bytes::{make_bools, part};
use super::error::{Error, Reason};
use super::plan::{Field, Plan};
use super::trail::Trail;
use super::types::{MessageType, Types};
use super::view::DynamicView;
use super::walk::{Stop, Walk, walk};

/// Rejects a payload unless it has the full size, with or without the padding at its end.
#[inline]
pub(super) fn check_size(ty: MessageType<'_>, payload: &[u8]) -> Result<(), Error> {
    let Size { padded, no_padding } = ty.plan.size;
    let found = payload.len();
    if ty.plan.is_fixed && (found == padded || found == no_padding) {
        return Ok(());
    }
    Err(wrong_size(ty.plan, found))
}

#[cold]
fn wrong_size(plan: &Plan, found: usize) -> Error {
    let Size { padded, no_padding } = plan.size;
    let path = plan.name.to_string();
    if !plan.is_fixed {
        return Error { reason: Reason::SizeVaries, path, offset: None };
    }
    let fault = Fault::Size { padded, no_padding, found };
    Error { reason: Reason::Fault(fault), path, offset: Some(found.min(padded)) }
}

/// Rejects a message with a `bool` that is neither 0 nor 1.
pub(super) fn check_bools(view: DynamicView<'_>) -> Result<(), Error> {
    if !view.plan.has_bools {
        return Ok(());
    }
    let mut search = OddBool { view, found: None };
    // The result is in `found`.
    let _ = walk(view, &mut Trail::default(), &mut search);
    search.found.map_or(Ok(()), Err)
}

struct OddBool<'v> {
    view: DynamicView<'v>,
    found: Option<Error>,
}

impl<'v> Walk<'v> for OddBool<'v> {
    fn enters(&self, plans: &[Plan], field: &Field) -> bool {
        match field.element {
            Element::Message(id) => plans[id.0 as usize].has_bools,
            element => element == Element::Scalar(Scalar::Bool),
        }
    }

    fn stop(&mut self, trail: &Trail<'v>, _: &'v Field, stop: Stop<'v>) -> ControlFlow<()> {
        let Stop::Number(Scalar::Bool, &[byte @ 2..=u8::MAX], at) = stop else {
            return ControlFlow::Continue(());
        };
        let path = trail.text(&self.view.plan.name);
        self.found = Some(Error { reason: Reason::Fault(Fault::Bool(byte)), path, offset: Some(at) });
        ControlFlow::Break(())
    }
}

/// Encodes a message, including the padding at its end.
pub(super) fn encode(view: DynamicView<'_>) -> Result<Vec<u8>, Error> {
    if !view.plan.is_fixed {
        return Err(wrong_size(view.plan, 0));
    }
    let padded = view.plan.size.padded;
    let memory = view.bytes.get(view.base..).unwrap_or_default();
    let mut payload = vec![0; padded];
    write(view.types, view.plan, memory, &mut payload);
    Ok(payload)
}

/// Copies all bytes except padding, and normalizes each `bool` to 0 or 1.
fn write(types: &Types, plan: &Plan, from: &[u8], to: &mut [u8]) {
    for field in &plan.fields {
        if let Element::Message(id) = field.element {
            for start in (0..field.count()).map(|index| field.offset + index * field.stride) {
                let to = to.get_mut(start..start + field.stride).unwrap_or_default();
                write(types, &types.plans[id.0 as usize], from.get(start..).unwrap_or_default(), to);
            }
            continue;
        }
        let size = field.count() * field.stride;
        let Some(to) = to.get_mut(field.offset..field.offset + size) else { continue };
        let from = part(from, field.offset, size);
        if from.len() == size {
            to.copy_from_slice(from);
        }
        if field.element == Element::Scalar(Scalar::Bool) {
            make_bools(to);
        }
    }
}
