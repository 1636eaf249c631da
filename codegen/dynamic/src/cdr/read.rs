//! CDR decoder.

use uavspec_runtime::cdr::{ByteOrder, HEADER, WIDE_UNIT, is_padding};

use super::explain;
use crate::bytes::copy;
use crate::error::{Error, Reason};
use crate::message::DynamicMessage;
use crate::plan::{GROWTH, Plan, SLOT};
use crate::step::{Bounds, Run, Sequence, Step, Width};
use crate::text::{read_narrow, read_wide};
use crate::types::{MessageType, Types};

/// Reads a message. In strict mode each `bool` must be 0 or 1, and each string must be Unicode.
pub(crate) fn decode<'t>(
    ty: MessageType<'t>,
    payload: &[u8],
    is_strict: bool,
) -> Result<DynamicMessage<'t>, Error> {
    let buffer = match ByteOrder::of(payload) {
        Ok(ByteOrder::LittleEndian) => read::<false>(ty, payload, is_strict),
        Ok(ByteOrder::BigEndian) => read::<true>(ty, payload, is_strict),
        Err(_) => None,
    };
    match buffer {
        Some(buffer) => Ok(DynamicMessage { ty, buffer }),
        None => Err(explain::explain(ty, payload, is_strict).unwrap_or_else(|| Error {
            // The only fault that the second pass doesn't detect.
            reason: Reason::TooLarge,
            path: ty.plan.name.to_string(),
            offset: None,
        })),
    }
}

fn read<const BIG: bool>(ty: MessageType<'_>, payload: &[u8], is_strict: bool) -> Option<Vec<u8>> {
    let body = payload.get(HEADER..)?;
    // This check bounds the allocation that follows.
    if body.len() < ty.plan.min {
        return None;
    }
    let buffer = vec![0; ty.plan.size.padded];
    let mut reader = Reader::<BIG> { types: ty.types, body, at: 0, buffer, is_strict };
    reader.message(ty.plan, 0)?;
    let left = body.len() - reader.at;
    (left == 0 || is_padding(reader.at + HEADER, left)).then_some(reader.buffer)
}

struct Reader<'b, const BIG: bool> {
    types: &'b Types,
    /// The payload after the header.
    body: &'b [u8],
    at: usize,
    buffer: Vec<u8>,
    is_strict: bool,
}

impl<'b, const BIG: bool> Reader<'b, BIG> {
    /// Aligns to `width`, then takes `size` bytes.
    #[inline]
    fn take(&mut self, size: usize, width: Width) -> Option<&'b [u8]> {
        let mask = width as usize - 1;
        let start = (self.at + mask) & !mask;
        let end = start.checked_add(size)?;
        let bytes = self.body.get(start..end)?;
        self.at = end;
        Some(bytes)
    }

    /// Reads a message into the buffer at `base`.
    fn message(&mut self, plan: &Plan, base: usize) -> Option<()> {
        for step in &plan.steps {
            match *step {
                Step::Copy(Run { offset, size, width, is_bool }) => {
                    self.numbers(base + offset, size, width, is_bool)?;
                }
                Step::Strings { offset, count, bounds } => self.strings(base + offset, count, bounds)?,
                Step::Messages { offset, count, plan } => self.messages(base + offset, count, plan)?,
                Step::Sequence { offset, bound, element } => self.sequence(base + offset, bound, element)?,
                Step::Empty => {
                    self.take(1, Width::One)?;
                }
            }
        }
        Some(())
    }

    #[inline]
    fn numbers(&mut self, to: usize, size: usize, width: Width, is_bool: bool) -> Option<()> {
        let from = self.take(size, width)?;
        if is_bool && self.is_strict && from.iter().any(|byte| *byte > 1) {
            return None;
        }
        copy::<BIG>(from, self.buffer.get_mut(to..to + size)?, width);
        Some(())
    }

    fn messages(&mut self, to: usize, count: usize, plan: usize) -> Option<()> {
        let plan = &self.types.plans[plan];
        (0..count).try_for_each(|index| self.message(plan, to + index * plan.size.padded))
    }

    fn strings(&mut self, to: usize, count: usize, bounds: Bounds) -> Option<()> {
        (0..count).try_for_each(|index| self.string(to + index * SLOT, bounds))
    }

    fn length(&mut self) -> Option<usize> {
        let bytes = self.take(4, Width::Four)?.first_chunk()?;
        let length = if BIG { u32::from_be_bytes(*bytes) } else { u32::from_le_bytes(*bytes) };
        usize::try_from(length).ok()
    }

    fn sequence(&mut self, slot: usize, bound: Option<u32>, element: Sequence) -> Option<()> {
        let count = self.length()?;
        if bound.is_some_and(|bound| count > bound as usize) {
            return None;
        }
        let (min, stride) = match element {
            Sequence::Numbers { width, .. } => (width as usize, width as usize),
            Sequence::Strings(_) => (4, SLOT),
            Sequence::Messages(plan) => (self.types.plans[plan].min, self.types.plans[plan].size.padded),
        };
        if count.checked_mul(min)? > self.body.len() - self.at {
            return None;
        }
        let start = self.buffer.len();
        let end = start + count * stride;
        // Without this limit, each nesting level could allocate memory for the whole rest of the payload.
        if end > self.body.len() * GROWTH {
            return None;
        }
        self.point(slot, start, count)?;
        self.buffer.resize(end, 0);
        match element {
            Sequence::Numbers { .. } if count == 0 => Some(()),
            Sequence::Numbers { width, is_bool } => self.numbers(start, count * stride, width, is_bool),
            Sequence::Strings(bounds) => self.strings(start, count, bounds),
            Sequence::Messages(plan) => self.messages(start, count, plan),
        }
    }

    fn string(&mut self, slot: usize, bounds: Bounds) -> Option<()> {
        let length = self.length()?;
        let start = self.buffer.len();
        if bounds.is_wide {
            let bytes = self.take(length.checked_mul(WIDE_UNIT)?, Width::One)?;
            let order = if BIG { ByteOrder::BigEndian } else { ByteOrder::LittleEndian };
            self.buffer.extend(read_wide(bytes, order, self.is_strict).ok()?);
        } else {
            let bytes = self.take(length, Width::One)?;
            self.buffer.extend_from_slice(read_narrow(bytes, self.is_strict).ok()?);
        }
        let text = &self.buffer[start..];
        let length = text.len();
        if bounds.exceeded_by(text).is_some() {
            return None;
        }
        self.point(slot, start, length)
    }

    /// Writes a slot: the offset of the bytes or elements, and their number.
    fn point(&mut self, slot: usize, start: usize, count: usize) -> Option<()> {
        let bytes = self.buffer.get_mut(slot..slot + SLOT)?;
        bytes[..4].copy_from_slice(&u32::try_from(start).ok()?.to_le_bytes());
        bytes[4..].copy_from_slice(&u32::try_from(count).ok()?.to_le_bytes());
        Some(())
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
        let buffer = vec![0; ty.plan.size.padded];
        let mut reader = Reader::<false> { types: &types, body: &body, at: 0, buffer, is_strict: false };
        assert!(reader.message(ty.plan, 0).is_none());
        let room = reader.buffer.len();
        assert!((5000..=8000).contains(&room), "{room} bytes allocated for a body of {}", body.len());
    }
}
