//! Finds the reason why a CDR payload was rejected.
//!
//! This slow pass reads field by field, like the typed codec, and reports the same errors.

use uavspec_runtime::cdr::{ByteOrder, HEADER, WIDE_UNIT, is_padding};
use uavspec_runtime::record::Primitive as _;
use uavspec_runtime::{Fault, Scalar};
use uavspec_schema::{Element, Shape};

use crate::error::{Error, Reason};
use crate::plan::{Field, Plan};
use crate::step::Bounds;
use crate::text::{read_narrow, read_wide};
use crate::trail::Trail;
use crate::types::{MessageType, Types};

/// Finds the fault in a payload, if any. In a fixed-size message, truncation takes precedence over an invalid `bool`.
/// In all other cases, the first fault is returned.
pub(super) fn explain(ty: MessageType<'_>, payload: &[u8], is_strict: bool) -> Option<Error> {
    let end = if ty.plan.is_fixed && is_strict { first_fault(ty, payload, false) } else { None };
    end.filter(|error| matches!(error.reason, Reason::Fault(Fault::Truncated { .. })))
        .or_else(|| first_fault(ty, payload, is_strict))
}

fn first_fault(ty: MessageType<'_>, payload: &[u8], is_strict: bool) -> Option<Error> {
    let order = match ByteOrder::of(payload) {
        Ok(order) => order,
        Err(fault) => return Some(error(ty, fault, 0, &Trail::default())),
    };
    let body = payload.get(HEADER..).unwrap_or_default();
    let mut reader = Reader { types: ty.types, body, at: 0, order, is_strict, trail: Trail::default() };
    if let Err((fault, at)) = reader.message(ty.plan) {
        return Some(error(ty, fault, at + HEADER, &reader.trail));
    }
    let (end, left) = (reader.at + HEADER, body.len() - reader.at);
    let is_whole = left == 0 || is_padding(end, left);
    (!is_whole).then(|| error(ty, Fault::Trailing(left), end, &reader.trail))
}

fn error(ty: MessageType<'_>, fault: Fault, offset: usize, trail: &Trail<'_>) -> Error {
    Error { reason: Reason::Fault(fault), path: trail.text(&ty.plan.name), offset: Some(offset) }
}

struct Reader<'b> {
    types: &'b Types,
    body: &'b [u8],
    at: usize,
    order: ByteOrder,
    is_strict: bool,
    trail: Trail<'b>,
}

/// A fault and its byte offset in the body.
type FaultAt = (Fault, usize);

impl<'b> Reader<'b> {
    fn take(&mut self, size: usize, alignment: usize) -> Result<&'b [u8], FaultAt> {
        let start = self.at.next_multiple_of(alignment);
        let bytes = start.checked_add(size).and_then(|end| self.body.get(start..end));
        let Some(bytes) = bytes else {
            let left = self.body.len().saturating_sub(start);
            return Err((Fault::Truncated { needed: size, left }, start.min(self.body.len())));
        };
        self.at = start + size;
        Ok(bytes)
    }

    fn message(&mut self, plan: &'b Plan) -> Result<(), FaultAt> {
        if plan.fields.is_empty() {
            self.take(1, 1)?;
        }
        for field in &plan.fields {
            self.trail.enter(&field.name);
            self.field(field)?;
            self.trail.leave();
        }
        Ok(())
    }

    fn field(&mut self, field: &'b Field) -> Result<(), FaultAt> {
        let count = if field.is_sequence() { self.sequence(field)? } else { field.count() };
        match field.element {
            Element::Scalar(scalar) => {
                self.numbers(count, scalar.size(), scalar == Scalar::Bool, field.shape == Shape::Single)
            }
            Element::Text(length) => self.numbers(length as usize, 1, false, false),
            Element::String { .. } | Element::Message(_) => (0..count).try_for_each(|index| {
                if field.shape != Shape::Single {
                    self.trail.select(Some(index));
                }
                match field.element {
                    Element::String { wide, bound } => self.string(Bounds { is_wide: wide, bound }),
                    Element::Message(id) => self.message(self.types.get(id).plan),
                    Element::Scalar(_) | Element::Text(_) => Ok(()),
                }
            }),
        }
    }

    fn numbers(&mut self, count: usize, size: usize, is_bool: bool, is_single: bool) -> Result<(), FaultAt> {
        if count == 0 {
            return Ok(());
        }
        let start = self.at.next_multiple_of(size);
        let bytes = self.take(count.saturating_mul(size), size).inspect_err(|_| {
            if !is_single {
                self.trail.select(Some(self.body.len().saturating_sub(start) / size));
            }
        })?;
        let odd = bytes.iter().position(|byte| *byte > 1).filter(|_| is_bool && self.is_strict);
        let Some(index) = odd else { return Ok(()) };
        if !is_single {
            self.trail.select(Some(index));
        }
        Err((Fault::Bool(bytes[index]), start + index))
    }

    fn sequence(&mut self, field: &Field) -> Result<usize, FaultAt> {
        let min = match field.element {
            Element::Scalar(scalar) => scalar.size(),
            Element::String { .. } => 4,
            Element::Text(_) | Element::Message(_) => 1,
        };
        self.length(field.bound(), min)
    }

    /// Reads a length, and checks that enough bytes remain for that many elements of at least `least` bytes each.
    fn length(&mut self, bound: Option<u32>, min: usize) -> Result<usize, FaultAt> {
        let bytes = self.take(4, 4)?;
        let length = match self.order {
            ByteOrder::LittleEndian => u32::read_le(bytes),
            ByteOrder::BigEndian => u32::read_be(bytes),
        };
        let found = usize::try_from(length).unwrap_or(usize::MAX);
        if let Some(bound) = bound.filter(|bound| length > *bound) {
            return Err((Fault::TooLong { bound, found }, self.at - 4));
        }
        let (needed, left) = (found.saturating_mul(min), self.body.len() - self.at);
        if needed > left { Err((Fault::Truncated { needed, left }, self.at)) } else { Ok(found) }
    }

    fn string(&mut self, bounds: Bounds) -> Result<(), FaultAt> {
        let start = self.at.next_multiple_of(4);
        let excess = if bounds.is_wide {
            let length = self.length(None, WIDE_UNIT)?;
            let text = read_wide(self.take(length * WIDE_UNIT, 1)?, self.order, self.is_strict);
            text.map(|text| bounds.exceeded_by(&text))
        } else {
            let length = self.length(None, 1)?;
            let text = read_narrow(self.take(length, 1)?, self.is_strict);
            text.map(|text| bounds.exceeded_by(text))
        };
        match excess.map_err(|fault| (fault, start))? {
            Some((bound, found)) => Err((Fault::TooLong { bound, found }, start)),
            None => Ok(()),
        }
    }
}
