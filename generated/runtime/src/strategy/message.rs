//! Strategies for the fields of messages according to a descriptor.
//!
//! The `room` of a strategy limits its optional values: the elements of sequences and the characters of strings. All
//! values at one nesting level share the room.

use core::fmt::Debug;
use std::string::String;
use std::vec::Vec;

use proptest::arbitrary::any;
use proptest::char;
use proptest::collection::vec;
use proptest::prop_oneof;
use proptest::sample::{Index, select};
use proptest::strategy::{BoxedStrategy, Strategy as _};

use super::number::Numbers;
use super::replay::Node;
use crate::descriptor::{Element, FieldDescriptor, MessageDescriptor, Shape};
use crate::{Constraint, Scalar};

/// The room of a whole message.
pub(super) const ROOM: usize = 1024;

/// The maximum length of sequences and strings without a bound.
const UNBOUNDED: usize = 40;

/// The largest bound that faults exceed. For larger bounds, generating the elements would take too long.
const GREATEST_BOUND: u32 = 4096;

/// Bytes that make text invalid UTF-8 when appended.
const BAD_BYTES: &[u8] = &[0xff, 0x80, 0xc3, 0xf0];

/// Values that violate no rule.
pub(super) fn valid(message: &'static MessageDescriptor, room: usize) -> BoxedStrategy<Node> {
    valid_fields(message, room).prop_map(Node::Group).boxed()
}

fn valid_fields(message: &'static MessageDescriptor, room: usize) -> Vec<BoxedStrategy<Node>> {
    let room = share(message, room);
    message.fields.iter().map(|field| valid_field(field, room)).collect()
}

/// The share of `room` for each field whose size varies.
fn share(message: &MessageDescriptor, room: usize) -> usize {
    let varies = |field: &&FieldDescriptor| match (field.shape, field.element) {
        (Shape::Bounded(_) | Shape::Sequence, _) | (_, Element::String { .. }) => true,
        (_, Element::Message(nested)) => nested.size.is_none(),
        (_, Element::Scalar(_) | Element::Text) => false,
    };
    room / message.fields.iter().filter(varies).count().max(1)
}

fn valid_field(field: &'static FieldDescriptor, room: usize) -> BoxedStrategy<Node> {
    match field.shape {
        Shape::Array(length) if field.element != Element::Text => {
            let length = length as usize;
            vec(valid_element(field, room / length.max(1)), length).prop_map(Node::Group).boxed()
        }
        Shape::Single | Shape::Array(_) => valid_element(field, room),
        Shape::Bounded(_) | Shape::Sequence => {
            let elements = list(|room| valid_element(field, room), field.shape.bound(), room);
            elements.prop_map(sequence).boxed()
        }
    }
}

fn valid_element(field: &'static FieldDescriptor, room: usize) -> BoxedStrategy<Node> {
    match field.element {
        Element::Scalar(scalar) => numbers(scalar, field).valid().prop_map(Node::Number).boxed(),
        Element::Text => {
            let size = text_size(field);
            characters(size).prop_map(move |characters| text(&characters, None, size)).boxed()
        }
        Element::String { bound, .. } => list(|_| character(), bound, room).prop_map(string).boxed(),
        Element::Message(nested) => valid(nested, room),
    }
}

/// A strategy for each rule that each field can violate. All other values are valid.
pub(super) fn faults(message: &'static MessageDescriptor, room: usize) -> Vec<BoxedStrategy<Node>> {
    let valid = valid_fields(message, room);
    let room = share(message, room);
    let mut faults = Vec::new();
    for (index, field) in message.fields.iter().enumerate() {
        for fault in field_faults(field, room) {
            let mut fields = valid.clone();
            fields[index] = fault;
            faults.push(fields.prop_map(Node::Group).boxed());
        }
    }
    faults
}

/// A strategy for each rule that a field can violate.
fn field_faults(field: &'static FieldDescriptor, room: usize) -> Vec<BoxedStrategy<Node>> {
    let faults = || element_faults(field, room).into_iter();
    match field.shape {
        Shape::Array(0) => Vec::new(),
        Shape::Array(length) if field.element != Element::Text => {
            let length = length as usize;
            let others = vec(valid_element(field, room / length), length - 1).boxed();
            faults().map(|fault| insert(&others, fault).prop_map(Node::Group).boxed()).collect()
        }
        Shape::Single | Shape::Array(_) => faults().collect(),
        Shape::Bounded(_) | Shape::Sequence => {
            let bound = field.shape.bound();
            let element = |room| valid_element(field, room);
            let too_long = too_long(element, bound, room).map(|elements| elements.prop_map(sequence).boxed());
            let others = list(element, bound.map(|bound| bound.saturating_sub(1)), room);
            let faults = faults().filter(|_| bound != Some(0));
            let faults = faults.map(|fault| insert(&others, fault).prop_map(sequence).boxed());
            too_long.into_iter().chain(faults).collect()
        }
    }
}

/// A strategy for each rule that a single value can violate. Text is not empty.
fn element_faults(field: &'static FieldDescriptor, room: usize) -> Vec<BoxedStrategy<Node>> {
    match field.element {
        Element::Scalar(scalar) => {
            let numbers = numbers(scalar, field);
            let faults = numbers.constraint.rules().filter_map(|rule| numbers.violating(rule));
            faults.map(|bits| bits.prop_map(Node::Number).boxed()).collect()
        }
        Element::Text => {
            let size = text_size(field);
            let parts = (characters(size - 1), select(BAD_BYTES));
            std::vec![parts.prop_map(move |(valid, bad_byte)| text(&valid, Some(bad_byte), size)).boxed()]
        }
        Element::String { bound, .. } => {
            let too_long = too_long(|_| character(), bound, room);
            too_long.into_iter().map(|characters| characters.prop_map(string).boxed()).collect()
        }
        Element::Message(nested) => faults(nested, room),
    }
}

fn numbers(scalar: Scalar, field: &FieldDescriptor) -> Numbers {
    Numbers { scalar, constraint: *field.constraint.unwrap_or(&Constraint::NONE) }
}

/// Lists of valid elements. Most have few elements, and many are empty or full.
fn list<T: Debug + 'static>(
    element: impl Fn(usize) -> BoxedStrategy<T>,
    bound: Option<u32>,
    room: usize,
) -> BoxedStrategy<Vec<T>> {
    let max = bound.map_or(UNBOUNDED, |bound| bound as usize).min(room);
    let few = max.min(3);
    let element = |max: usize| element(room / max.max(1));
    // Half of these lists are cut, and thus full. Proptest can remove all of their elements to simplify them.
    let many = vec(element(max), 0..=2 * max).prop_map(move |mut elements| {
        elements.truncate(max);
        elements
    });
    prop_oneof![3 => vec(element(few), 0..=few), 1 => many].boxed()
}

/// Lists that exceed a bound, or `None` if there is no bound or the bound is very large.
fn too_long<T: Debug + 'static>(
    element: impl Fn(usize) -> BoxedStrategy<T>,
    bound: Option<u32>,
    room: usize,
) -> Option<BoxedStrategy<Vec<T>>> {
    let bound = bound.filter(|bound| *bound <= GREATEST_BOUND)? as usize;
    Some(vec(element(room / (bound + 1)), bound + 1..=bound + 3).boxed())
}

/// Inserts an invalid element anywhere into a list.
fn insert(others: &BoxedStrategy<Vec<Node>>, fault: BoxedStrategy<Node>) -> BoxedStrategy<Vec<Node>> {
    let parts = (others.clone(), fault, any::<Index>());
    let list = parts.prop_map(|(mut elements, fault, index)| {
        elements.insert(index.index(elements.len() + 1), fault);
        elements
    });
    list.boxed()
}

fn sequence(elements: Vec<Node>) -> Node {
    let length = Node::Number(elements.len() as u64);
    Node::Group(std::vec![length, Node::Group(elements)])
}

fn string(characters: Vec<char>) -> Node {
    Node::String(characters.into_iter().collect())
}

/// Any character except NUL, which would end the text.
fn character() -> BoxedStrategy<char> {
    char::range('\u{1}', char::MAX).boxed()
}

/// At most `max` characters.
fn characters(max: usize) -> BoxedStrategy<Vec<char>> {
    list(|_| character(), u32::try_from(max).ok(), max)
}

/// The size of a text in bytes.
fn text_size(field: &FieldDescriptor) -> usize {
    field.shape.bound().unwrap_or(1) as usize
}

/// Text of `size` bytes: the characters that fit, and a byte that is not valid UTF-8, if any.
fn text(characters: &[char], bad_byte: Option<u8>, size: usize) -> Node {
    let room = size - usize::from(bad_byte.is_some());
    let mut text = String::new();
    for character in characters {
        if text.len() + character.len_utf8() <= room {
            text.push(*character);
        }
    }
    let mut bytes = text.into_bytes();
    bytes.extend(bad_byte);
    bytes.resize(size, 0);
    Node::Group(bytes.into_iter().map(|byte| Node::Number(byte.into())).collect())
}
