//! Computes the uORB layout and the CDR size of messages.

use uavspec_runtime::layout::{self, Member};

use super::id::MessageId;
use super::model::{CdrSize, Element, Message, Schema, Slot, UorbLayout, shape_text};
use crate::msg::ast::Shape;

/// The number of bytes before the first member of a CDR payload.
const CDR_HEADER: u64 = 4;

/// The member that ROS adds to an empty structure.
pub(crate) const EMPTY_MEMBER: &str = "structure_needs_at_least_one_member";

/// The layout of a message, or `None` if its size varies. The layouts of nested messages must be known.
pub(crate) fn uorb(schema: &Schema, message: &Message) -> Option<UorbLayout> {
    let members: Option<Vec<Member>> = message
        .fields
        .iter()
        .map(|field| {
            let count = match field.ty.shape {
                Shape::Single => 1,
                Shape::Array(length) => length as usize,
                Shape::Bounded(_) | Shape::Sequence => return None,
            };
            match field.ty.element {
                Element::Scalar(scalar) => {
                    Some(Member { element_size: scalar.size(), count, is_nested: false })
                }
                Element::Text(length) => {
                    Some(Member { element_size: 1, count: length as usize, is_nested: false })
                }
                Element::String { .. } => None,
                Element::Message(id) => {
                    let element_size = schema.message(id).uorb.as_ref()?.size;
                    Some(Member { element_size, count, is_nested: true })
                }
            }
        })
        .collect();
    let members = members?;
    let mut offsets = vec![0; members.len()];
    let size = layout::place(&members, &mut offsets);
    let mut order: Vec<usize> = (0..members.len()).collect();
    order.sort_by_key(|index| (offsets[*index], members[*index].is_nested));
    let mut slots = Vec::with_capacity(members.len() + 1);
    let mut end = 0;
    let pad = |slots: &mut Vec<Slot>, from: usize, to: usize| {
        if to > from {
            let type_text =
                format!("uint8{}", shape_text(Shape::Array(u32::try_from(to - from).unwrap_or(u32::MAX))));
            slots.push(Slot {
                field: None,
                // A message has at most one: numbers are sorted by size, and nested messages fill multiples of 8
                // bytes.
                name: "_padding0".to_owned(),
                type_text,
                offset: from,
                size: to - from,
            });
        }
    };
    for index in order {
        pad(&mut slots, end, offsets[index]);
        let field = &message.fields[index];
        slots.push(Slot {
            field: Some(index),
            name: field.name.clone(),
            type_text: schema.type_text(message, field.ty),
            offset: offsets[index],
            size: members[index].size(),
        });
        end = offsets[index].saturating_add(members[index].size());
    }
    pad(&mut slots, end, size.padded);
    Some(UorbLayout { size: size.padded, size_no_padding: size.no_padding, slots })
}

/// The number of bytes that an item adds to a CDR payload, for each start offset modulo 8.
///
/// The padding before a member depends on its offset, and the maximum alignment is 8, so eight numbers are sufficient.
/// The length of an array is computed by repeated doubling, without a loop over its elements.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CdrLength([u64; 8]);

impl CdrLength {
    fn scalar(size: u64) -> Self {
        Self(std::array::from_fn(|start| (start as u64).next_multiple_of(size) - start as u64 + size))
    }

    fn then(self, next: Self) -> Self {
        Self(std::array::from_fn(|start| {
            let end = (start as u64).saturating_add(self.0[start]);
            #[allow(clippy::cast_possible_truncation)] // less than 8
            self.0[start].saturating_add(next.0[(end % 8) as usize])
        }))
    }

    fn repeat(self, mut count: u32) -> Self {
        let mut whole = Self::default();
        let mut power = self;
        while count > 0 {
            if count & 1 == 1 {
                whole = whole.then(power);
            }
            power = power.then(power);
            count >>= 1;
        }
        whole
    }
}

/// The CDR sizes of all messages. `order` lists nested messages first.
pub(crate) fn cdr(schema: &Schema, order: &[MessageId]) -> Vec<CdrSize> {
    let count = CdrLength::scalar(4);
    let mut lengths = vec![CdrLength::default(); schema.messages.len()];
    let mut sizes = vec![CdrSize::default(); schema.messages.len()];
    for id in order {
        let mut length = CdrLength::default();
        let mut is_fixed = true;
        for field in &schema.message(*id).fields {
            let (element, element_is_fixed) = match field.ty.element {
                Element::Scalar(scalar) => (CdrLength::scalar(scalar.size() as u64), true),
                Element::Text(length) => (CdrLength::scalar(1).repeat(length), true),
                // The shortest string consists of a length prefix and, unless it is a wide string, a NUL.
                Element::String { wide: true, .. } => (count, false),
                Element::String { wide: false, .. } => (count.then(CdrLength::scalar(1)), false),
                Element::Message(nested) => (lengths[nested.0 as usize], sizes[nested.0 as usize].is_fixed),
            };
            let (member, shape_is_fixed) = match field.ty.shape {
                Shape::Single => (element, true),
                Shape::Array(length) => (element.repeat(length), true),
                Shape::Bounded(_) | Shape::Sequence => (count, false),
            };
            length = length.then(member);
            is_fixed &= element_is_fixed && shape_is_fixed;
        }
        if schema.message(*id).fields.is_empty() {
            length = CdrLength::scalar(1);
        }
        lengths[id.0 as usize] = length;
        sizes[id.0 as usize] = CdrSize { min: CDR_HEADER.saturating_add(length.0[0]), is_fixed };
    }
    sizes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repetition_by_doubling_equals_repetition_in_a_loop() {
        let element = CdrLength::scalar(8).then(CdrLength::scalar(1)).then(CdrLength::scalar(2));
        for count in 0..40 {
            let looped = (0..count).fold(CdrLength::default(), |whole, _| whole.then(element));
            assert_eq!(element.repeat(count).0, looped.0, "{count}");
        }
    }
}
