//! CDR decoder.

use std::borrow::Cow;

use uavspec_runtime::cdr::{ByteOrder, HEADER, WIDE_UNIT, is_padding};
use uavspec_runtime::record::Primitive as _;
use uavspec_runtime::{Fault, Scalar};
use uavspec_schema::{Element, Shape};

use crate::bytes::reverse_each;
use crate::error::{Error, Reason};
use crate::message::DynamicMessage;
use crate::plan::{Field, GROWTH, Plan, SLOT, Transfer};
use crate::text::{Bounds, read_narrow, read_wide};
use crate::trail::Trail;
use crate::types::{MessageType, Types};

/// Reads a message. In strict mode each `bool` must be 0 or 1, and each string must be Unicode.
///
/// In a fixed-size message, truncation takes precedence over an invalid `bool`. In all other cases, the first fault is
/// returned.
pub(crate) fn decode<'t>(
    ty: MessageType<'t>,
    payload: &[u8],
    is_strict: bool,
    buffer: Vec<u8>,
) -> Result<DynamicMessage<'t>, Error> {
    let error = match read(ty, payload, is_strict, buffer) {
        Err(error) if is_strict && ty.plan.is_fixed => error,
        result => return result,
    };
    let end = read(ty, payload, false, Vec::new()).err();
    let end = end.filter(|error| matches!(error.reason, Reason::Fault(Fault::Truncated { .. })));
    Err(end.unwrap_or(error))
}

fn read<'t>(
    ty: MessageType<'t>,
    payload: &[u8],
    is_strict: bool,
    mut buffer: Vec<u8>,
) -> Result<DynamicMessage<'t>, Error> {
    buffer.clear();
    let name = &ty.plan.name;
    let error = |fault: Fault, at: usize, trail: &Trail<'_>| Error {
        reason: Reason::Fault(fault),
        path: trail.text(name),
        offset: Some(at),
    };
    let order = ByteOrder::of(payload).map_err(|fault| error(fault, 0, &Trail::default()))?;
    let body = payload.get(HEADER..).unwrap_or_default();
    if order == ByteOrder::LittleEndian && !is_strict && transfer(ty, body, &mut buffer).is_some() {
        return Ok(DynamicMessage { ty, buffer });
    }
    let mut reader = Reader::new(ty, body, order, is_strict, buffer);
    if let Err((fault, at)) = reader.message(ty.plan, 0) {
        return Err(error(fault, at + HEADER, &reader.trail));
    }
    let (end, left) = (reader.at + HEADER, reader.body.len() - reader.at);
    if left > 0 && !is_padding(end, left) {
        return Err(error(Fault::Trailing(left), end, &reader.trail));
    }
    if reader.is_too_large {
        return Err(Error { reason: Reason::TooLarge, path: name.to_string(), offset: None });
    }
    Ok(DynamicMessage { ty, buffer: reader.buffer })
}

/// Copies the parts of a message of fixed size to the empty buffer. `None` if the body has another size, or if the message has
/// too many parts.
fn transfer(ty: MessageType<'_>, body: &[u8], buffer: &mut Vec<u8>) -> Option<()> {
    let Transfer { parts, size, .. } = ty.plan.transfer(ty.types)?;
    let left = body.len().checked_sub(*size)?;
    if left > 0 && !is_padding(size + HEADER, left) {
        return None;
    }
    buffer.resize(ty.plan.size.padded, 0);
    for (from, to, length) in parts {
        buffer[*to..to + length].copy_from_slice(&body[*from..from + length]);
    }
    Some(())
}

struct Reader<'b> {
    types: &'b Types,
    /// The payload after the header.
    body: &'b [u8],
    at: usize,
    buffer: Vec<u8>,
    /// True if the buffer doesn't contain the whole message. Reading continues, because the payload may also contain a
    /// fault.
    is_too_large: bool,
    order: ByteOrder,
    is_strict: bool,
    trail: Trail<'b>,
}

/// A fault and its byte offset in the body.
type FaultAt = (Fault, usize);

impl<'b> Reader<'b> {
    fn new(
        ty: MessageType<'b>,
        body: &'b [u8],
        order: ByteOrder,
        is_strict: bool,
        mut buffer: Vec<u8>,
    ) -> Self {
        // A payload that is too short for the message must not cause an allocation.
        let is_too_large = body.len() < ty.plan.min;
        if !is_too_large {
            buffer.resize(ty.plan.size.padded, 0);
        }
        Self { types: ty.types, body, at: 0, buffer, is_too_large, order, is_strict, trail: Trail::default() }
    }

    /// Aligns to `alignment`, a power of two, then takes `size` bytes.
    fn take(&mut self, size: usize, alignment: usize) -> Result<&'b [u8], FaultAt> {
        let start = self.aligned(alignment);
        let bytes = start.checked_add(size).and_then(|end| self.body.get(start..end));
        let Some(bytes) = bytes else {
            let left = self.body.len().saturating_sub(start);
            return Err((Fault::Truncated { needed: size, left }, start.min(self.body.len())));
        };
        self.at = start + size;
        Ok(bytes)
    }

    fn aligned(&self, alignment: usize) -> usize {
        (self.at + alignment - 1) & !(alignment - 1)
    }

    /// Reads a message into the buffer at `base`.
    fn message(&mut self, plan: &'b Plan, base: usize) -> Result<(), FaultAt> {
        if plan.fields.is_empty() {
            self.take(1, 1)?;
        }
        for field in &plan.fields {
            self.trail.enter(&field.name);
            self.field(field, base + field.offset)?;
            self.trail.leave();
        }
        Ok(())
    }

    fn field(&mut self, field: &'b Field, at: usize) -> Result<(), FaultAt> {
        let (start, count) =
            if field.is_sequence() { self.sequence(field, at)? } else { (at, field.count()) };
        match field.element {
            Element::Scalar(scalar) => self.numbers(start, count, scalar, field.shape == Shape::Single),
            Element::Text(length) => self.numbers(start, length as usize, Scalar::Char, false),
            Element::String { .. } | Element::Message(_) => (0..count).try_for_each(|index| {
                if field.shape != Shape::Single {
                    self.trail.select(Some(index));
                }
                let at = start + index * field.stride;
                match field.element {
                    Element::String { wide, bound } => self.string(at, Bounds { is_wide: wide, bound }),
                    Element::Message(id) => self.message(self.types.get(id).plan, at),
                    Element::Scalar(_) | Element::Text(_) => Ok(()),
                }
            }),
        }
    }

    fn numbers(&mut self, to: usize, count: usize, scalar: Scalar, is_single: bool) -> Result<(), FaultAt> {
        if count == 0 {
            return Ok(());
        }
        let size = scalar.size();
        let start = self.aligned(size);
        let bytes = self.take(count.saturating_mul(size), size).inspect_err(|_| {
            if !is_single {
                self.trail.select(Some(self.body.len().saturating_sub(start) / size));
            }
        })?;
        if let Some(numbers) = self.buffer.get_mut(to..to + bytes.len()) {
            numbers.copy_from_slice(bytes);
            if self.order == ByteOrder::BigEndian {
                reverse_each(numbers, size);
            }
        }
        if scalar != Scalar::Bool || !self.is_strict {
            return Ok(());
        }
        let Some(index) = bytes.iter().position(|byte| *byte > 1) else { return Ok(()) };
        if !is_single {
            self.trail.select(Some(index));
        }
        Err((Fault::Bool(bytes[index]), start + index))
    }

    /// Reads the length of a sequence whose slot is at `slot`, and appends its elements. Returns the offset and number
    /// of the elements.
    fn sequence(&mut self, field: &Field, slot: usize) -> Result<(usize, usize), FaultAt> {
        let (min, least) = match field.element {
            Element::Scalar(scalar) => (scalar.size(), scalar.size()),
            Element::String { .. } => (4, 4),
            Element::Text(_) => (1, 1),
            Element::Message(id) => (1, self.types.get(id).plan.min),
        };
        let count = self.length(field.bound(), min)?;
        let size = count.saturating_mul(field.stride);
        let has_room = count.saturating_mul(least) <= self.body.len() - self.at;
        // Without this limit, each nesting level could allocate memory for the entire remaining payload.
        if has_room && self.buffer.len().saturating_add(size) <= self.body.len() * GROWTH {
            return Ok((self.append(slot, count, size), count));
        }
        self.is_too_large = true;
        Ok((self.buffer.len(), count))
    }

    /// Reads a length, and checks that enough bytes remain for that many elements of at least `min` bytes each.
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

    fn string(&mut self, slot: usize, bounds: Bounds) -> Result<(), FaultAt> {
        let at = self.aligned(4);
        let text = if bounds.is_wide {
            let length = self.length(None, WIDE_UNIT)?;
            read_wide(self.take(length * WIDE_UNIT, 1)?, self.order, self.is_strict).map(Cow::Owned)
        } else {
            let length = self.length(None, 1)?;
            read_narrow(self.take(length, 1)?, self.is_strict).map(Cow::Borrowed)
        };
        let text = text.map_err(|fault| (fault, at))?;
        if let Some((bound, found)) = bounds.exceeded_by(&text) {
            return Err((Fault::TooLong { bound, found }, at));
        }
        let start = self.append(slot, text.len(), text.len());
        if let Some(to) = self.buffer.get_mut(start..start + text.len()) {
            to.copy_from_slice(&text);
        }
        Ok(())
    }

    /// Appends zeros for the bytes of a string or the elements of a sequence, and writes their offset and number to a slot.
    /// Returns the offset.
    fn append(&mut self, slot: usize, count: usize, size: usize) -> usize {
        let start = self.buffer.len();
        let numbers = (u32::try_from(start), u32::try_from(count));
        let (Ok(first), Ok(count)) = numbers else {
            self.is_too_large = true;
            return start;
        };
        if let Some(bytes) = self.buffer.get_mut(slot..slot + SLOT) {
            bytes[..4].copy_from_slice(&first.to_le_bytes());
            bytes[4..].copy_from_slice(&count.to_le_bytes());
            self.buffer.resize(start + size, 0);
        }
        start
    }
}

#[cfg(test)]
mod tests {
    use uavspec_schema::msg::Dialect;
    use uavspec_schema::{Form, PackageInput, SourceMap};

    use super::*;

    /// Each nested sequence claims a length that would take up nearly all of the remaining payload. The payload ends
    /// after these lengths.
    #[test]
    fn bounds_the_allocation_for_nested_sequences_with_false_lengths() {
        let mut sources = SourceMap::default();
        let mut package = PackageInput::new("demo", Form::Msg(Dialect::Ros2), Vec::new());
        for level in 0..=20 {
            let next = if level == 0 { "uint8".to_owned() } else { format!("L{}", level - 1) };
            let text = format!("{next}[] nested\nuint64[100] rest\n");
            package.sources.push(sources.add(format!("L{level}.msg"), text.into_bytes()).expect("a text"));
        }
        let types = Types::new(&uavspec_schema::read(&sources, &[package]).0);
        let ty = types.find("demo", "L20").expect("the type");
        let mut body = [1, 0, 0, 0].repeat(10);
        body.resize(1000, 0);
        let mut reader = Reader::new(ty, &body, ByteOrder::LittleEndian, false, Vec::new());
        assert!(reader.message(ty.plan, 0).is_err());
        let room = reader.buffer.len();
        assert!((5000..=8000).contains(&room), "{room} bytes allocated for a body of {}", body.len());
    }
}
