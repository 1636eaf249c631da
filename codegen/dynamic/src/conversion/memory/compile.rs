//! Compilation of conversions.

use uavspec_runtime::Scalar;
use uavspec_schema::Element;

use super::number::{Number, write};
use super::place::{Place, Room};
use super::{Compute, ElementCopy, Operation, Program, Span, Transfer};
use crate::conversion::expression::{Computed, Expression};
use crate::conversion::plan::{Conversion, Copy, Elements, Neutral, Step};
use crate::{Field, MessageType, sequence};

/// Compiles a conversion.
pub(super) fn program(conversion: &Conversion, source: MessageType<'_>, target: MessageType<'_>) -> Program {
    let sources = source.fields();
    let mut operations = Vec::new();
    for (field, step) in target.fields().iter().zip(&conversion.steps) {
        match step {
            Step::Fill(neutral) => fill(field, *neutral, &mut operations),
            Step::Compute(expression) => operations.extend(compute(expression, sources, field)),
            Step::Copy(copy) => {
                if let Some(origin) = sources.get(copy.source) {
                    transfer(copy, (source, origin), (target, field), &mut operations);
                }
            }
        }
    }
    let initial = target.default();
    let size = target.fixed_size();
    let mut defaults = Vec::new();
    if initial.memory().len() > size {
        slots(target, initial.memory(), 0, &mut defaults);
    }
    Program { initial: initial.memory().to_vec(), size, operations: merged(operations), defaults }
}

/// Lists the strings and sequences of a message.
fn slots(ty: MessageType<'_>, memory: &[u8], base: usize, found: &mut Vec<usize>) {
    for field in ty.fields() {
        let at = base + field.offset;
        let (start, count) = match Place::of(field).room {
            Room::Fixed(count) => (at, count),
            Room::Varying(_) => {
                found.push(at);
                sequence(memory, at)
            }
        };
        for place in (0..count).map(|index| start + index * field.stride) {
            match field.element {
                Element::String { .. } => found.push(place),
                Element::Message(nested) => slots(ty.nested(nested), memory, place, found),
                Element::Scalar(_) | Element::Text(_) => {}
            }
        }
    }
}

/// The bytes of a neutral value; `None` for the initial value.
fn neutral(element: Element, value: Neutral) -> Option<[u8; 8]> {
    let Element::Scalar(scalar) = element else { return None };
    match value {
        Neutral::Default => None,
        Neutral::Int(value) => Some(write(scalar, Computed::Int(value))),
        Neutral::Float(value) => Some(write(scalar, Computed::Float(value))),
    }
}

fn fill(field: &Field, value: Neutral, operations: &mut Vec<Operation>) {
    let Some(bytes) = neutral(field.element, value) else { return };
    match Place::of(field).room {
        Room::Varying(_) => operations.push(Operation::Clear(field.offset)),
        Room::Fixed(_) => {
            let from = Place { at: 0, stride: 0, room: Room::Fixed(0) };
            let (to, element) = (Place::of(field), ElementCopy::Bytes);
            operations.push(Operation::Transfer(Box::new(Transfer { from, to, element, rest: Some(bytes) })));
        }
    }
}

fn compute(expression: &Expression, sources: &[Field], field: &Field) -> Option<Operation> {
    let Element::Scalar(scalar) = field.element else { return None };
    let Room::Fixed(count) = Place::of(field).room else { return Some(Operation::Clear(field.offset)) };
    let place = |source: &Field| match source.element {
        Element::Scalar(scalar) => Some((source.offset, scalar)),
        _ => None,
    };
    let fields = sources.iter().map(place).collect();
    let compute = Compute { to: field.offset, count, scalar, expression: expression.clone(), fields };
    Some(Operation::Compute(Box::new(compute)))
}

fn transfer(
    copy: &Copy,
    (source_type, source): (MessageType<'_>, &Field),
    (target_type, target): (MessageType<'_>, &Field),
    operations: &mut Vec<Operation>,
) {
    let copied = element(copy, (source_type, source.element), (target_type, target.element));
    let Some(element) = copied else { return };
    let rest = neutral(target.element, copy.rest);
    let (from, to) = (Place::of(source), Place::of(target));
    if let (ElementCopy::Bytes, Room::Fixed(count), Room::Fixed(length)) = (&element, from.room, to.room)
        && (count >= length || rest.is_none())
    {
        let size = count.min(length) * to.stride;
        return operations.push(Operation::Copy(Span { from: from.at, to: to.at, size }));
    }
    operations.push(Operation::Transfer(Box::new(Transfer { from, to, element, rest })));
}

fn element(
    copy: &Copy,
    (source_type, source): (MessageType<'_>, Element),
    (target_type, target): (MessageType<'_>, Element),
) -> Option<ElementCopy> {
    Some(match (source, target) {
        (Element::Message(source), Element::Message(target)) => {
            let Elements::Message(nested) = &copy.elements else { return None };
            ElementCopy::Message(program(nested, source_type.nested(source), target_type.nested(target)))
        }
        (Element::Text(length), Element::Text(other)) if length == other => ElementCopy::Bytes,
        (Element::Text(_), Element::Text(_)) => ElementCopy::Text,
        (Element::String { .. }, Element::String { .. }) => ElementCopy::String(match copy.elements {
            Elements::String(bound) => bound,
            _ => None,
        }),
        (Element::Scalar(from), Element::Scalar(to)) => scalar(copy, from, to),
        _ => return None,
    })
}

fn scalar(copy: &Copy, from: Scalar, to: Scalar) -> ElementCopy {
    match (&copy.elements, &copy.limit) {
        (Elements::Same, None) => ElementCopy::Bytes,
        (elements, limit) => {
            ElementCopy::Number(Number { from, to, elements: elements.clone(), limit: limit.clone() })
        }
    }
}

/// Merges adjacent copies.
fn merged(operations: Vec<Operation>) -> Vec<Operation> {
    let (mut spans, mut others) = (Vec::new(), Vec::new());
    for operation in operations {
        match operation {
            Operation::Copy(span) => spans.push(span),
            other => others.push(other),
        }
    }
    // Each byte of the target has one origin, so the order doesn't matter.
    spans.sort_by_key(|span| span.to);
    let mut merged: Vec<Span> = Vec::new();
    for next in spans.into_iter().filter(|span| span.size > 0) {
        match merged.last_mut() {
            Some(last) if last.from + last.size == next.from && last.to + last.size == next.to => {
                last.size += next.size;
            }
            _ => merged.push(next),
        }
    }
    merged.into_iter().map(Operation::Copy).chain(others).collect()
}

/// True if a message has the same CDR payload in both types.
pub(super) fn keeps_cdr(conversion: &Conversion, source: MessageType<'_>, target: MessageType<'_>) -> bool {
    let sources = source.fields();
    let keeps = |(at, (step, field)): (usize, (&Step, &Field))| {
        let Step::Copy(Copy { source: from, elements, limit: None, .. }) = step else { return false };
        let Some(origin) = sources.get(at).filter(|_| *from == at) else { return false };
        let is_same_length = match (Place::of(origin).room, Place::of(field).room) {
            (Room::Varying(_), Room::Varying(_)) => true,
            (one, other) => one == other,
        };
        is_same_length
            && match (elements, origin.element, field.element) {
                (Elements::Message(nested), Element::Message(from), Element::Message(to)) => {
                    keeps_cdr(nested, source.nested(from), target.nested(to))
                }
                (Elements::Text, Element::Text(from), Element::Text(to)) => from == to,
                (Elements::Same | Elements::String(_), ..) => true,
                _ => false,
            }
    };
    conversion.losses.is_empty()
        && sources.len() == conversion.steps.len()
        && conversion.steps.iter().zip(target.fields()).enumerate().all(keeps)
}
