//! Validation of the values of a message against its definition.

use core::{fmt, mem};

use crate::descriptor::{Element, FieldDescriptor, MessageDescriptor, Shape};
use crate::record::{FieldSink, Primitive, Record, Sink, Value};
use crate::{Constraint, ConstraintKind, Message, Number, Path};

/// A value that violates a rule, displayed as `events[2].id: …`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Violation {
    /// The violated rule.
    pub rule: ConstraintKind,
    /// The field or element.
    pub path: Path,
    /// The value of a number, the length of a sequence or string, or the offset of the first invalid UTF-8 byte in
    /// text.
    pub found: Number,
    /// The constraint on the numbers of the field.
    pub constraint: Option<&'static Constraint<'static>>,
    /// The bound of a sequence or string.
    pub bound: Option<u32>,
}

impl fmt::Display for Violation {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}: ", self.path)?;
        self.rule.explain(self.found, self.constraint, self.bound, formatter)
    }
}

#[cfg(feature = "std")]
impl std::error::Error for Violation {}

/// Calls `report` with each violation in `message`.
pub(crate) fn each<T: Message>(message: &T, report: &mut dyn FnMut(Violation)) {
    let path = Path::to(T::DESCRIPTOR);
    message.write_fields(&mut Validator { message: T::DESCRIPTOR, path, field: None, report });
}

struct Validator<'r> {
    /// The message whose fields are checked.
    message: &'static MessageDescriptor,
    path: Path,
    /// The field that is being checked.
    field: Option<&'static FieldDescriptor>,
    report: &'r mut dyn FnMut(Violation),
}

impl Validator<'_> {
    fn violation(&mut self, rule: ConstraintKind, found: Number, bound: Option<u32>) {
        let constraint = self.field.and_then(|field| field.constraint);
        (self.report)(Violation { rule, path: self.path, found, constraint, bound });
    }

    fn bound(&mut self, length: usize, bound: Option<u32>) {
        if bound.is_some_and(|bound| length > bound as usize) {
            self.violation(ConstraintKind::Bound, Number::Int(length as i128), bound);
        }
    }
}

impl FieldSink for Validator<'_> {
    #[inline]
    fn field<T: Value>(&mut self, index: usize, value: &T) {
        let field = &self.message.fields[index];
        if !field.is_restricted() {
            return;
        }
        let outer = self.field.replace(field);
        self.path.enter(index);
        value.write(self, field);
        self.path.leave();
        self.field = outer;
    }
}

impl Sink for Validator<'_> {
    #[inline]
    fn scalar<P: Primitive>(&mut self, value: P) {
        let constraint = self.field.and_then(|field| field.constraint).unwrap_or(&Constraint::NONE);
        let found = value.number();
        if let Some(rule) = constraint.violated_by(found) {
            self.violation(rule, found, None);
        }
    }

    fn text(&mut self, bytes: &[u8]) {
        let text = bytes.split(|byte| *byte == 0).next().unwrap_or_default();
        if let Err(error) = core::str::from_utf8(text) {
            self.violation(ConstraintKind::Text, Number::Int(error.valid_up_to() as i128), None);
        }
    }

    fn length(&mut self, length: usize, shape: Shape) {
        self.bound(length, shape.bound());
    }

    fn string(&mut self, text: &str, _: bool, bound: Option<u32>) {
        self.bound(text.chars().count(), bound);
    }

    #[inline]
    fn message<M: Record>(&mut self, message: &M) {
        let outer = mem::replace(&mut self.message, M::DESCRIPTOR);
        message.write_fields(self);
        self.message = outer;
    }

    #[inline]
    fn select(&mut self, element: Option<usize>) {
        self.path.select(element);
    }
}

impl FieldDescriptor {
    /// True if the field's type allows values that violate a rule.
    #[inline]
    const fn is_restricted(&self) -> bool {
        match self.element {
            Element::Scalar(_) => self.constraint.is_some() || matches!(self.shape, Shape::Bounded(_)),
            Element::String { bound, .. } => bound.is_some() || matches!(self.shape, Shape::Bounded(_)),
            Element::Text | Element::Message(_) => true,
        }
    }
}
