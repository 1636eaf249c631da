//! Detects whether messages, including their nested messages, are encoded to the same bytes in two versions.

use std::collections::HashMap;

use uavspec_runtime::Scalar;
use uavspec_schema::{Dialect, Element, Form, Message, MessageId, Schema, Shape};

/// Numbers that identify message layouts. Identical layouts have the same number. Fields are identified by their old
/// names, so renaming a field keeps the number, and swapping two fields changes it.
#[derive(Debug, Default)]
pub(super) struct Signatures<'a> {
    known: HashMap<Vec<Member<'a>>, u32>,
}

/// A part of a layout.
#[derive(Debug, PartialEq, Eq, Hash)]
enum Member<'a> {
    /// The old name of the next member.
    Name(&'a str),
    Scalar(Scalar, Shape),
    String(bool, Option<u32>, Shape),
    /// A nested message, by its signature.
    Message(u32, Shape),
    /// The offset of the next member in memory.
    At(usize),
}

/// The signatures of all messages in one version, by index.
#[derive(Debug)]
pub(super) struct SchemaSignatures {
    cdr: Vec<u32>,
    uorb: Vec<u32>,
}

impl SchemaSignatures {
    pub(super) fn cdr(&self, id: MessageId) -> u32 {
        self.cdr[id.0 as usize]
    }

    pub(super) fn uorb(&self, id: MessageId) -> u32 {
        self.uorb[id.0 as usize]
    }
}

impl<'a> Signatures<'a> {
    /// Computes the signatures of all messages of `schema`. Signatures of different versions can be compared if the
    /// same `Signatures` computed them. For each message that both versions have, `old_names` contains the old names of
    /// its fields.
    pub(super) fn of(
        &mut self,
        schema: &'a Schema,
        old_names: &HashMap<MessageId, Vec<&'a str>>,
    ) -> SchemaSignatures {
        let count = schema.messages.len();
        let mut found = SchemaSignatures { cdr: vec![0; count], uorb: vec![0; count] };
        for id in schema.topological_order.iter().copied() {
            let message = schema.message(id);
            let names = old_names.get(&id);
            let name = |index: usize| {
                Member::Name(names.map_or(message.fields[index].name.as_str(), |names| names[index]))
            };
            let member = |index: usize, nested: &[u32]| {
                let ty = message.fields[index].ty.written();
                match plain(schema, message, ty.element) {
                    Element::Scalar(scalar) => Member::Scalar(scalar, ty.shape),
                    Element::Text(length) => Member::Scalar(Scalar::Char, Shape::Array(length)),
                    Element::String { wide, bound } => Member::String(wide, bound, ty.shape),
                    Element::Message(nested_id) => Member::Message(nested[nested_id.0 as usize], ty.shape),
                }
            };
            let fields = 0..message.fields.len();
            let cdr = fields.flat_map(|index| [name(index), member(index, &found.cdr)]).collect();
            found.cdr[id.0 as usize] = self.number(cdr);
            let slots = message.uorb.iter().flat_map(|layout| &layout.slots);
            let placed = slots.filter_map(|slot| Some((slot.offset, slot.field?)));
            let mut uorb: Vec<Member<'a>> = placed
                .flat_map(|(offset, index)| [name(index), Member::At(offset), member(index, &found.uorb)])
                .collect();
            uorb.push(Member::At(message.uorb.as_ref().map_or(0, |layout| layout.size)));
            found.uorb[id.0 as usize] = self.number(uorb);
        }
        found
    }

    fn number(&mut self, members: Vec<Member<'a>>) -> u32 {
        let next = u32::try_from(self.known.len()).unwrap_or(u32::MAX);
        *self.known.entry(members).or_insert(next)
    }
}

/// The type of an item of `message`, with aliases resolved. In ROS 2, `char` is an alias of `uint8`.
pub(super) fn plain(schema: &Schema, message: &Message, element: Element) -> Element {
    let is_ros2 = schema.package_of(message).form == Form::Msg(Dialect::Ros2);
    match element {
        Element::Scalar(Scalar::Char) if is_ros2 => Element::Scalar(Scalar::UInt8),
        _ => element,
    }
}
