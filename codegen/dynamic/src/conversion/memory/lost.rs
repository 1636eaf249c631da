//! Finds out if a message contains the data that a conversion loses.

use uavspec_runtime::Scalar;
use uavspec_schema::{Element, Shape};

use super::number::{characters, read, text, write};
use super::place::{Place, Room};
use crate::conversion::expression::Computed;
use crate::conversion::plan::{Conversion, Copy, Elements, LossKind, Step};
use crate::{Field, MessageType, part, sequence};

/// Tests if a message contains the data of a loss.
#[derive(Debug)]
pub(super) struct Test {
    place: Place,
    /// The values of the field, with their locations in an element.
    leaves: Vec<(Place, Leaf)>,
    kind: TestKind,
}

#[derive(Debug)]
enum TestKind {
    /// Any value is lost.
    Dropped,
    /// Elements from this index are lost.
    Elements(usize),
    /// Bytes of a text from this index are lost.
    Bytes(usize),
    /// Characters of strings from this index are lost.
    Characters(u32),
    /// The numbers that this type can't represent are lost.
    Narrowed(Scalar, Scalar),
}

/// A value in a field.
#[derive(Clone, Copy, Debug)]
enum Leaf {
    Scalar(Scalar),
    Text(usize),
    String,
    /// A sequence is lost if it has elements.
    Sequence,
}

/// One test for each loss, if the data of the loss can be recognized.
pub(super) fn tests(
    conversion: &Conversion,
    source: MessageType<'_>,
    target: MessageType<'_>,
) -> Vec<Option<Test>> {
    let test = |(kind, at): (LossKind, Option<usize>)| {
        let field = source.fields().get(at?)?;
        let step = conversion.steps.iter().zip(target.fields()).find_map(|(step, target)| match step {
            Step::Copy(copy) if Some(copy.source) == at => Some((copy, target)),
            _ => None,
        });
        Some(Test {
            place: Place::of(field),
            leaves: leaves(source, field),
            kind: kind_of(kind, field, step)?,
        })
    };
    conversion.losses.iter().map(|loss| test((loss.kind, loss.source))).collect()
}

fn kind_of(kind: LossKind, source: &Field, step: Option<(&Copy, &Field)>) -> Option<TestKind> {
    match (kind, step) {
        (LossKind::Dropped, _) => Some(TestKind::Dropped),
        (LossKind::Cut, Some((copy, target))) => {
            match (source.element, target.element, &copy.elements) {
                (Element::Text(_), Element::Text(length), _) => Some(TestKind::Bytes(length as usize)),
                // Two losses may concern the same field: its elements and their characters.
                (Element::String { .. }, _, Elements::String(Some(bound)))
                    if source.shape == target.shape =>
                {
                    Some(TestKind::Characters(*bound))
                }
                (Element::String { .. }, ..) => None,
                _ => match (Place::of(source).room, target.shape) {
                    (Room::Fixed(_), Shape::Array(length)) | (_, Shape::Bounded(length)) => {
                        Some(TestKind::Elements(length as usize))
                    }
                    _ => None,
                },
            }
        }
        (LossKind::Narrowed, Some((_, target))) => match (source.element, target.element) {
            (Element::Scalar(from), Element::Scalar(to)) => Some(TestKind::Narrowed(from, to)),
            _ => None,
        },
        _ => None,
    }
}

/// The values in an element of a field, each with its location.
fn leaves(message_type: MessageType<'_>, field: &Field) -> Vec<(Place, Leaf)> {
    let whole = |leaf| vec![(Place { at: 0, stride: 0, room: Room::Fixed(1) }, leaf)];
    match field.element {
        Element::Scalar(scalar) => whole(Leaf::Scalar(scalar)),
        Element::Text(length) => whole(Leaf::Text(length as usize)),
        Element::String { .. } => whole(Leaf::String),
        Element::Message(id) => {
            let inner = message_type.nested(id);
            inner.fields().iter().flat_map(|field| nested(inner, field)).collect()
        }
    }
}

/// The values of a field in a nested message, each with its location.
fn nested(message_type: MessageType<'_>, field: &Field) -> Vec<(Place, Leaf)> {
    let place = Place::of(field);
    let Room::Fixed(count) = place.room else {
        return vec![(Place { room: Room::Fixed(1), ..place }, Leaf::Sequence)];
    };
    match field.element {
        Element::Message(_) => {
            let inner = leaves(message_type, field);
            let moved = |at: usize| {
                let base = place.at + at * place.stride;
                inner.iter().map(move |(place, leaf)| (Place { at: base + place.at, ..*place }, *leaf))
            };
            (0..count).flat_map(moved).collect()
        }
        _ => leaves(message_type, field).into_iter().map(|(_, leaf)| (place, leaf)).collect(),
    }
}

impl Test {
    /// True if the message contains data that is lost.
    pub(super) fn is_lost(&self, memory: &[u8]) -> bool {
        let (start, count) = match self.place.room {
            Room::Fixed(count) => (self.place.at, count),
            Room::Varying(_) => sequence(memory, self.place.at),
        };
        let at = |index: usize| start + index * self.place.stride;
        match self.kind {
            TestKind::Dropped => (0..count).any(|index| self.is_set(memory, at(index))),
            TestKind::Elements(_) if matches!(self.place.room, Room::Varying(_)) => self.is_longer(count),
            TestKind::Elements(first) => (first..count).any(|index| self.is_set(memory, at(index))),
            TestKind::Bytes(length) => {
                let whole = text(part(memory, start, self.place.stride), usize::MAX);
                text(whole, length).len() < whole.len()
            }
            TestKind::Characters(bound) => (0..count).any(|index| {
                let (start, length) = sequence(memory, at(index));
                characters(part(memory, start, length), Some(bound)).len() < length
            }),
            TestKind::Narrowed(from, to) => (0..count).any(|index| {
                let value = read(from, part(memory, at(index), from.size()));
                !is_same(value, read(to, &write(to, value)))
            }),
        }
    }

    fn is_longer(&self, count: usize) -> bool {
        matches!(self.kind, TestKind::Elements(max) if count > max)
    }

    /// True if an element contains a value other than 0 and NaN.
    fn is_set(&self, memory: &[u8], base: usize) -> bool {
        self.leaves.iter().any(|(place, leaf)| {
            let Room::Fixed(count) = place.room else { return false };
            (0..count).any(|index| leaf.is_set(memory, base + place.at + index * place.stride))
        })
    }
}

impl Leaf {
    fn is_set(self, memory: &[u8], at: usize) -> bool {
        match self {
            Self::Scalar(scalar) => match read(scalar, part(memory, at, scalar.size())) {
                Computed::Bool(value) => value,
                Computed::Int(value) => value != 0,
                Computed::Float(value) => value != 0.0 && !value.is_nan(),
            },
            Self::Text(length) => part(memory, at, length).first().is_some_and(|first| *first != 0),
            Self::String | Self::Sequence => sequence(memory, at).1 > 0,
        }
    }
}

/// True if a number equals its converted value.
fn is_same(value: Computed, converted: Computed) -> bool {
    match (value, converted) {
        (Computed::Float(value), Computed::Float(other)) => value.total_cmp(&other).is_eq() || value.is_nan(),
        #[allow(clippy::cast_possible_truncation)] // the value was an integer
        (Computed::Int(value), Computed::Float(other)) => value == other as i128,
        (value, other) => value == other,
    }
}
