//! Types of messages.

use uavspec_runtime::Scalar;
use uavspec_runtime::layout::Size;

use super::error::{Defect, Error, Reason};
use super::plan::{Element, Plan};
use crate::schema::{MessageId, Shape};

/// The types of all messages of a schema, or of a log.
#[derive(Debug)]
pub struct Types {
    pub(super) plans: Vec<Plan>,
    /// Indices of the plans, by package and name.
    by_name: Vec<usize>,
}

impl Types {
    pub(super) fn of(plans: Vec<Plan>) -> Self {
        let mut by_name: Vec<usize> = (0..plans.len()).collect();
        by_name.sort_by_key(|index| (&plans[*index].package, &plans[*index].name));
        Self { plans, by_name }
    }

    /// The type of a message of the schema that these types were made from.
    ///
    /// # Panics
    ///
    /// Where it has no such message.
    pub fn get(&self, id: MessageId) -> MessageType<'_> {
        MessageType { types: self, plan: &self.plans[id.0 as usize] }
    }

    /// The type with this name.
    pub fn find(&self, package: &str, name: &str) -> Option<MessageType<'_>> {
        let key = |index: &usize| (&*self.plans[*index].package, &*self.plans[*index].name);
        let found = self.by_name.binary_search_by_key(&(package, name), key).ok()?;
        Some(MessageType { types: self, plan: &self.plans[self.by_name[found]] })
    }

    /// All of them, by package and name.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = MessageType<'_>> {
        self.by_name.iter().map(|index| MessageType { types: self, plan: &self.plans[*index] })
    }
}

/// A type of messages.
#[derive(Clone, Copy, Debug)]
pub struct MessageType<'t> {
    pub(super) types: &'t Types,
    pub(super) plan: &'t Plan,
}

impl<'t> MessageType<'t> {
    /// Its package.
    pub fn package(self) -> &'t str {
        &self.plan.package
    }

    /// Its name.
    pub fn name(self) -> &'t str {
        &self.plan.name
    }

    /// Names of its fields, in declared order.
    pub fn field_names(self) -> impl ExactSizeIterator<Item = &'t str> {
        self.plan.fields.iter().map(|field| &*field.name)
    }

    /// Where its fields lie in a payload of uORB, in declared order.
    pub fn layout(self) -> impl ExactSizeIterator<Item = Placed<'t>> {
        self.plan.fields.iter().map(move |field| Placed {
            name: &field.name,
            element: match field.element {
                Element::Scalar(scalar) => PlacedElement::Scalar(scalar),
                Element::Text(length) => PlacedElement::Text(length),
                Element::String(_) => PlacedElement::String,
                Element::Message(index) => {
                    PlacedElement::Message(MessageType { types: self.types, plan: &self.types.plans[index] })
                }
            },
            shape: field.shape,
            offset: field.offset,
            stride: field.stride,
        })
    }

    /// Its size in uORB, in bytes; none where it varies.
    pub fn size(self) -> Option<Size> {
        (self.plan.is_fixed && self.plan.defect.is_none()).then_some(self.plan.size)
    }

    /// Why its messages can't be handled, where that is so. All that is asked of it then fails.
    pub fn defect(self) -> Option<&'t Defect> {
        self.plan.defect.as_ref()
    }

    pub(super) fn check(self) -> Result<(), Error> {
        match &self.plan.defect {
            None => Ok(()),
            Some(defect) => Err(self.error(Reason::Defect(defect.clone()))),
        }
    }

    pub(super) fn error(self, reason: Reason) -> Error {
        Error { reason, path: self.plan.name.to_string(), offset: None }
    }
}

/// A field and its place.
#[derive(Clone, Copy, Debug)]
pub struct Placed<'t> {
    /// Its name.
    pub name: &'t str,
    /// What it holds.
    pub element: PlacedElement<'t>,
    /// How many of them.
    pub shape: Shape,
    /// Its first byte, from the start of the message.
    pub offset: usize,
    /// Bytes from one element to the next.
    pub stride: usize,
}

/// What a field holds.
#[derive(Clone, Copy, Debug)]
pub enum PlacedElement<'t> {
    /// A number or a `bool`.
    Scalar(Scalar),
    /// PX4's `char[N]` as a whole, of so many bytes.
    Text(u32),
    /// A string, of which only the slot stands here.
    String,
    /// A message.
    Message(MessageType<'t>),
}
