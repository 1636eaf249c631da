//! The parts of a message that have the same bytes in memory and in CDR.

use uavspec_runtime::Scalar;
use uavspec_schema::Element;

use crate::limits::{MAX_PARTS, MAX_TRANSFERRED};
use crate::plan::{Plan, Transfer};
use crate::types::Types;

impl Plan {
    /// The parts of a message of this type, if it has a fixed size and not too many parts. `types` contains the type.
    pub(super) fn transfer(&self, types: &Types) -> Option<&Transfer> {
        self.transfer.get_or_init(|| Transfer::default().of(types, self, 0)).as_ref()
    }
}

impl Transfer {
    /// Adds the parts of the message at offset `base` in memory. `None` if its size varies, or if there are too many parts.
    fn of(mut self, types: &Types, plan: &Plan, base: usize) -> Option<Self> {
        if !plan.is_fixed || self.parts.len() > MAX_PARTS || self.size > MAX_TRANSFERRED {
            return None;
        }
        if plan.fields.is_empty() {
            self.size += 1;
        }
        for field in &plan.fields {
            let at = base + field.offset;
            match field.element {
                // A message of fixed size has no strings.
                Element::String { .. } => return None,
                Element::Scalar(scalar) => self.add(at, field.count() * scalar.size(), scalar),
                Element::Text(length) => self.add(at, length as usize, Scalar::Char),
                Element::Message(id) => {
                    for index in 0..field.count() {
                        self = self.of(types, types.get(id).plan, at + index * field.stride)?;
                    }
                }
            }
        }
        Some(self)
    }

    /// Adds a part, or extends the previous one.
    fn add(&mut self, memory: usize, length: usize, scalar: Scalar) {
        if length == 0 {
            return;
        }
        let body = self.size.next_multiple_of(scalar.size());
        self.size = body + length;
        if scalar == Scalar::Bool {
            self.bools.push(body..self.size);
        }
        match self.parts.last_mut() {
            Some((from, to, before)) if *from + *before == body && *to + *before == memory => {
                *before += length;
            }
            _ => self.parts.push((body, memory, length)),
        }
    }
}

#[cfg(test)]
mod tests {
    use uavspec_runtime::cdr::{ByteOrder, HEADER};
    use uavspec_schema::msg::Dialect;
    use uavspec_schema::{Form, PackageInput, SourceMap};

    use super::*;
    use crate::cdr::write::by_field;
    use crate::cdr::{decode, encode};
    use crate::{DynamicMessage, Error};

    /// The strict mode reads field by field.
    #[test]
    fn transferred_messages_are_the_same_as_those_copied_by_field() {
        let mut sources = SourceMap::default();
        let mut package = PackageInput::new("demo", Form::Msg(Dialect::Px4), Vec::new());
        for (name, text) in [
            ("Mark", "uint8 kind\nuint64 time\nbool[3] flags\nfloat32 height\n"),
            (
                "Glider",
                "uint8 id\nuint64 timestamp\nMark[2] marks\nchar[5] sign\nint16[3] turns\nfloat64 lift\n",
            ),
        ] {
            package.sources.push(sources.add(format!("{name}.msg"), text.into()).expect("a text"));
        }
        let types = Types::new(&uavspec_schema::read(&sources, &[package]).0);
        let ty = types.find("demo", "Glider").expect("the type");
        let size = ty.plan.transfer(&types).expect("a message of fixed size").size;
        let mut payload = ByteOrder::LittleEndian.header().to_vec();
        payload.extend((0..size).map(|at| u8::from(at % 3 > 0)));
        for padding in 0..=4 {
            payload.resize(HEADER + size + padding, 0);
            let [fast, slow] = [false, true].map(|is_strict| decode(ty, &payload, is_strict, Vec::new()));
            let memory = |read: Result<DynamicMessage<'_>, Error>| read.map(DynamicMessage::into_memory).ok();
            assert_eq!(memory(fast), memory(slow), "{padding} bytes of padding");
        }
        payload.truncate(HEADER + size);
        let mut memory = decode(ty, &payload, false, Vec::new()).expect("a message").into_memory();
        memory.iter_mut().filter(|byte| **byte == 1).for_each(|byte| *byte = 7);
        let view = ty.view_memory(&memory).expect("a view");
        let order = ByteOrder::LittleEndian;
        assert_eq!(
            encode(view, order, vec![9; 3]).expect("a payload"),
            by_field(view, order).expect("a payload")
        );
        payload.truncate(HEADER + size - 1);
        assert!(decode(ty, &payload, false, vec![7; 1000]).is_err());
    }
}
