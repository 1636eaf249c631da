//! CDR encoder.

use std::ops::ControlFlow;

use uavspec_runtime::cdr::{ByteOrder, HEADER};
use uavspec_runtime::{Fault, Scalar};
use uavspec_schema::Element;

use crate::bytes::{make_bools, part, reverse_each, slot};
use crate::error::{Error, Reason};
use crate::plan::{Field, Plan, Transfer};
use crate::text::{Bounds, code_units};
use crate::trail::Trail;
use crate::types::Types;
use crate::view::DynamicView;
use crate::walk::{Stop, Walk, walk};

/// Encodes a message as a CDR payload, in the memory of `buffer`.
pub(crate) fn encode(view: DynamicView<'_>, order: ByteOrder, mut buffer: Vec<u8>) -> Result<Vec<u8>, Error> {
    buffer.clear();
    if order == ByteOrder::LittleEndian && transfer(view, &mut buffer).is_some() {
        return Ok(buffer);
    }
    by_field(view, order)
}

/// Encodes a message field by field.
pub(super) fn by_field(view: DynamicView<'_>, order: ByteOrder) -> Result<Vec<u8>, Error> {
    // The CDR form is rarely larger than the memory form plus the header.
    let mut out = Vec::with_capacity(view.bytes.len().saturating_sub(view.base) + HEADER);
    out.extend_from_slice(&order.header());
    let mut writer = Writer { types: view.types, bytes: view.bytes, order, out };
    match writer.message(view.plan, view.base) {
        Some(()) => Ok(writer.out),
        None => Err(refuse(view)),
    }
}

/// Copies the parts of a message of fixed size to the empty buffer. `None` if the message has too many parts.
fn transfer(view: DynamicView<'_>, buffer: &mut Vec<u8>) -> Option<()> {
    let Transfer { parts, bools, size } = view.plan.transfer(view.types)?;
    let memory = view.bytes.get(view.base..)?;
    buffer.extend_from_slice(&ByteOrder::LittleEndian.header());
    buffer.resize(HEADER + size, 0);
    let body = buffer.get_mut(HEADER..)?;
    for (to, from, length) in parts {
        body.get_mut(*to..to + length)?.copy_from_slice(memory.get(*from..from + length)?);
    }
    for place in bools {
        make_bools(body.get_mut(place.clone())?);
    }
    Some(())
}

struct Writer<'b> {
    types: &'b Types,
    bytes: &'b [u8],
    order: ByteOrder,
    /// The four-byte header and the payload. Alignment is relative to the end of the header.
    out: Vec<u8>,
}

impl Writer<'_> {
    /// Pads to a multiple of `size`, a power of two, counted from the end of the header.
    fn align(&mut self, size: usize) {
        let gap = HEADER.wrapping_sub(self.out.len()) & (size - 1);
        self.out.extend_from_slice(&[0; 8][..gap]);
    }

    /// Writes the message at `base`.
    fn message(&mut self, plan: &Plan, base: usize) -> Option<()> {
        if plan.fields.is_empty() {
            self.out.push(0);
        }
        plan.fields.iter().try_for_each(|field| self.field(field, base + field.offset))
    }

    fn field(&mut self, field: &Field, at: usize) -> Option<()> {
        let (start, count) = if field.is_sequence() { slot(self.bytes, at) } else { (at, field.count()) };
        if field.bound().is_some_and(|bound| count > bound as usize) {
            return None;
        }
        if field.is_sequence() {
            self.length(count)?;
        }
        let mut places = (0..count).map(|index| start + index * field.stride);
        match field.element {
            Element::Scalar(_) if count == 0 => {}
            Element::Scalar(scalar) => self.numbers(start, count * scalar.size(), scalar),
            Element::Text(length) => self.numbers(start, length as usize, Scalar::Char),
            Element::String { wide, bound } => {
                places.try_for_each(|place| self.string(place, Bounds { is_wide: wide, bound }))?;
            }
            Element::Message(id) => {
                let plan = &self.types.plans[id.0 as usize];
                places.try_for_each(|place| self.message(plan, place))?;
            }
        }
        Some(())
    }

    fn numbers(&mut self, from: usize, size: usize, scalar: Scalar) {
        self.align(scalar.size());
        let start = self.out.len();
        self.out.extend_from_slice(part(self.bytes, from, size));
        let numbers = &mut self.out[start..];
        match (scalar, self.order) {
            (Scalar::Bool, _) => make_bools(numbers),
            (_, ByteOrder::BigEndian) => reverse_each(numbers, scalar.size()),
            (_, ByteOrder::LittleEndian) => {}
        }
    }

    /// Writes a length or a unit of a `wstring`.
    fn number(&mut self, number: u32) {
        self.out.extend_from_slice(&match self.order {
            ByteOrder::LittleEndian => number.to_le_bytes(),
            ByteOrder::BigEndian => number.to_be_bytes(),
        });
    }

    fn length(&mut self, length: usize) -> Option<()> {
        let length = u32::try_from(length).ok()?;
        self.align(4);
        self.number(length);
        Some(())
    }

    fn string(&mut self, at: usize, bounds: Bounds) -> Option<()> {
        let (start, length) = slot(self.bytes, at);
        let text = part(self.bytes, start, length);
        if bounds.exceeded_by(text).is_some() {
            return None;
        }
        if bounds.is_wide {
            let units = code_units(text)?;
            self.length(units.len())?;
            for unit in units {
                self.number(unit.into());
            }
        } else {
            if text.contains(&0) {
                return None;
            }
            self.length(text.len() + 1)?;
            self.out.extend_from_slice(text);
            self.out.push(0);
        }
        Some(())
    }
}

/// The fault that prevents CDR from representing a string, if any. [`Writer::string`] refuses the same strings.
fn fault(text: &[u8], bounds: Bounds) -> Option<Fault> {
    if let Some((bound, found)) = bounds.exceeded_by(text) {
        return Some(Fault::TooLong { bound, found });
    }
    if bounds.is_wide {
        return code_units(text).is_none().then_some(Fault::NotUnicode);
    }
    text.contains(&0).then_some(Fault::Nul)
}

/// Finds the reason why a message has no CDR form.
#[cold]
fn refuse(view: DynamicView<'_>) -> Error {
    let mut search = Search { message: &view.plan.name, found: None };
    // The walk finds nothing if the cause is a length that exceeds 32 bits.
    let _ = walk(view, &mut Trail::default(), &mut search);
    search.found.unwrap_or_else(|| Error {
        reason: Reason::TooLarge,
        path: view.plan.name.to_string(),
        offset: None,
    })
}

struct Search<'v> {
    message: &'v str,
    found: Option<Error>,
}

impl<'v> Walk<'v> for Search<'v> {
    fn enters(&self, _: &[Plan], _: &Field) -> bool {
        true
    }

    fn stop(&mut self, trail: &Trail<'v>, field: &'v Field, stop: Stop<'v>) -> ControlFlow<()> {
        let fault = match (stop, field.element) {
            (Stop::String(text), Element::String { wide, bound }) => {
                fault(text, Bounds { is_wide: wide, bound })
            }
            (Stop::Length(found), _) => {
                let exceeded = field.bound().filter(|bound| found > *bound as usize);
                exceeded.map(|bound| Fault::TooLong { bound, found })
            }
            _ => None,
        };
        match fault {
            None => ControlFlow::Continue(()),
            Some(fault) => {
                let path = trail.text(self.message);
                self.found = Some(Error { reason: Reason::Fault(fault), path, offset: None });
                ControlFlow::Break(())
            }
        }
    }
}
