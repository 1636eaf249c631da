//! Draws the values of a message according to its descriptor.

use std::format;
use std::vec::Vec;

use proptest::test_runner::Reason;

use super::fault;
use super::number::Leaf;
use super::random::Random;
use super::tree::{ListKind, Node};
use crate::ConstraintKind;
use crate::descriptor::{Element, FieldDescriptor, MessageDescriptor, Shape};

/// The maximum number of optional elements and characters in a case.
const ROOM: usize = 1024;

/// Characters that programs often mishandle: multi-byte characters, control characters and similar.
const UNUSUAL: [char; 14] = [
    'é',
    'µ',
    'ß',
    '漢',
    '\u{1f681}',
    '\u{10ffff}',
    '\u{ffff}',
    '\u{feff}',
    '\u{202e}',
    '\u{7f}',
    '\u{1}',
    '\n',
    '"',
    '\\',
];

/// Bytes that make text invalid UTF-8 when appended.
const BAD_BYTES: [u8; 4] = [0xff, 0x80, 0xc3, 0xf0];

pub(super) struct Draw {
    random: Random,
    room: usize,
}

impl Draw {
    pub(super) fn new(random: Random) -> Self {
        Self { random, room: ROOM }
    }

    /// Draws a message. `fault` is an index into the faults that [`fault::count`] counts.
    pub(super) fn message(
        &mut self,
        message: &'static MessageDescriptor,
        mut fault: Option<usize>,
    ) -> Result<Node, Reason> {
        let mut parts = Vec::with_capacity(message.fields.len());
        for field in message.fields {
            let (in_field, later) = split(fault, || fault::in_field(field));
            fault = later;
            parts.push(self.field(field, in_field)?);
        }
        Ok(Node::group(parts))
    }

    fn field(&mut self, field: &'static FieldDescriptor, fault: Option<usize>) -> Result<Node, Reason> {
        let (too_long, fault) = split(fault, || fault::in_length(field.shape));
        match field.shape {
            Shape::Array(length) if field.element == Element::Text => {
                Ok(self.text(length as usize, fault.is_some()))
            }
            Shape::Single => self.element(field, fault),
            Shape::Array(length) => Ok(Node::group(self.elements(field, length as usize, fault)?)),
            Shape::Bounded(_) | Shape::Sequence => {
                let bound = field.shape.bound();
                let min = usize::from(fault.is_some());
                let (length, min) = self.length(bound, min, too_long.is_some());
                let list = Node::list(self.elements(field, length, fault)?, ListKind::Sequence, min);
                Ok(if too_long.is_some() { list.violating(ConstraintKind::Bound) } else { list })
            }
        }
    }

    fn elements(
        &mut self,
        field: &'static FieldDescriptor,
        length: usize,
        fault: Option<usize>,
    ) -> Result<Vec<Node>, Reason> {
        let invalid = fault.map(|_| self.random.below(length));
        let element = |index| self.element(field, fault.filter(|_| Some(index) == invalid));
        (0..length).map(element).collect()
    }

    fn element(&mut self, field: &'static FieldDescriptor, fault: Option<usize>) -> Result<Node, Reason> {
        match field.element {
            Element::Scalar(scalar) => {
                let constraint = fault::restriction(field);
                let rule = fault.and_then(|fault| fault::rules(scalar, constraint).nth(fault));
                let leaf = match rule {
                    Some(rule) => Leaf::invalid(scalar, constraint, rule, &mut self.random),
                    None => Leaf::valid(scalar, constraint, &mut self.random),
                };
                let leaf = leaf.ok_or_else(|| {
                    Reason::from(format!("no value of {} conforms to its definition", field.name))
                })?;
                Ok(Node { fault: rule, ..Node::from(leaf) })
            }
            Element::Text => Ok(self.text(1, fault.is_some())),
            Element::String { bound, .. } => {
                let (length, min) = self.length(bound, 0, fault.is_some());
                let characters = (0..length).map(|_| Leaf::character(self.character()).into()).collect();
                let string = Node::list(characters, ListKind::String, min);
                Ok(if fault.is_some() { string.violating(ConstraintKind::Bound) } else { string })
            }
            Element::Message(nested) => self.message(nested, fault),
        }
    }

    /// Draws the length of a sequence or string. Also returns the minimum length for simplification.
    fn length(&mut self, bound: Option<u32>, min: usize, is_too_long: bool) -> (usize, usize) {
        let bound = bound.map_or(usize::MAX, |bound| bound as usize);
        if is_too_long {
            return (bound + 1 + self.random.below(3), bound + 1);
        }
        let max = bound.min(self.room);
        let length = match self.random.below(8) {
            0 => 0,
            1 if bound <= self.room => bound,
            2 => self.random.below(max.min(40) + 1),
            _ => self.random.below(max.min(4) + 1),
        };
        let length = length.max(min);
        self.room = self.room.saturating_sub(length);
        (length, min)
    }

    /// Draws text of at most `room` bytes. Bad text ends with a byte that makes it invalid UTF-8.
    fn text(&mut self, room: usize, is_bad: bool) -> Node {
        let bad_byte = is_bad.then(|| self.random.pick(&BAD_BYTES).copied().unwrap_or(0xff));
        let max = room.saturating_sub(usize::from(is_bad));
        let mut left = match self.random.below(4) {
            0 => 0,
            1 => max,
            _ => self.random.below(max + 1),
        };
        let mut characters = Vec::new();
        while left > 0 {
            let character = self.character();
            let character = if character.len_utf8() > left { 'z' } else { character };
            left -= character.len_utf8();
            characters.push(Leaf::character(character).into());
        }
        let text = Node::list(characters, ListKind::Text { room, bad_byte }, 0);
        if is_bad { text.violating(ConstraintKind::Text) } else { text }
    }

    /// Draws any character except NUL, which would end the text.
    fn character(&mut self) -> char {
        match self.random.below(16) {
            0 | 1 => self.random.pick(&UNUSUAL).copied().unwrap_or('é'),
            // Surrogates, 0xd800 to 0xdfff, are not characters.
            #[allow(clippy::cast_possible_truncation)] // 20 bits
            2 => char::from_u32((self.random.bits() >> 44) as u32 | 1).unwrap_or('~'),
            #[allow(clippy::cast_possible_truncation)] // under 95
            _ => char::from(b' ' + self.random.below(95) as u8),
        }
    }
}

/// Splits a fault index. If the fault is one of the next `count` faults, the first value is its index among them.
/// Otherwise, the second value is its index among the later faults.
fn split(fault: Option<usize>, count: impl FnOnce() -> usize) -> (Option<usize>, Option<usize>) {
    let Some(fault) = fault else { return (None, None) };
    match fault.checked_sub(count()) {
        None => (Some(fault), None),
        Some(later) => (None, Some(later)),
    }
}
