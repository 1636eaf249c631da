//! Message types that are known only at run time.

use uavspec_runtime::Scalar;
use uavspec_runtime::layout::Size;
use uavspec_schema::{MessageId, Shape};

use super::error::{Defect, Error, Reason};
use super::plan::{Element, Plan};

/// All message types in a schema or a log.
#[derive(Debug)]
pub struct Types {
    pub(super) plans: Vec<Plan>,
    /// Indexes of `plans`, sorted by package and name.
    by_name: Vec<usize>,
}

impl Types {
    pub(super) fn of(plans: Vec<Plan>) -> Self {
        let mut by_name: Vec<usize> = (0..plans.len()).collect();
        by_name.sort_by_key(|index| (&plans[*index].package, &plans[*index].name));
        Self { plans, by_name }
    }

    /// The type of a message in the schema from which these types were created.
    ///
    /// # Panics
    ///
    /// Panics if `id` is not an id of that schema.
    pub fn get(&self, id: MessageId) -> MessageType<'_> {
        MessageType { types: self, plan: &self.plans[id.0 as usize] }
    }

    /// The type with this package and name.
    pub fn find(&self, package: &str, name: &str) -> Option<MessageType<'_>> {
        let key = |index: &usize| (&*self.plans[*index].package, &*self.plans[*index].name);
        let found = self.by_name.binary_search_by_key(&(package, name), key).ok()?;
        Some(MessageType { types: self, plan: &self.plans[self.by_name[found]] })
    }

    /// All types, sorted by package and name.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = MessageType<'_>> {
        self.by_name.iter().map(|index| MessageType { types: self, plan: &self.plans[*index] })
    }
}

/// A message type.
#[derive(Clone, Copy, Debug)]
pub struct MessageType<'t> {
    pub(super) types: &'t Types,
    pub(super) plan: &'t Plan,
}

impl<'t> MessageType<'t> {
    /// Name of the package.
    pub fn package(self) -> &'t str {
        &self.plan.package
    }

    /// Name of the type.
    pub fn name(self) -> &'t str {
        &self.plan.name
    }

    /// Field names in declaration order.
    pub fn field_names(self) -> impl ExactSizeIterator<Item = &'t str> {
        self.plan.fields.iter().map(|field| &*field.name)
    }

    /// The uORB layout of the fields, in declaration order.
    pub fn layout(self) -> impl ExactSizeIterator<Item = Placed<'t>> {
        self.plan.fields.iter().map(move |field| Placed {
            name: &field.name,
            element: match field.element {
                Element::Scalar(scalar) => PlacedElement::Scalar(scalar),
                Element::Text(length) => PlacedElement::Text(length),
                Element::String(bounds) => {
                    PlacedElement::String { is_wide: bounds.is_wide, bound: bounds.bound }
                }
                Element::Message(index) => {
                    PlacedElement::Message(MessageType { types: self.types, plan: &self.types.plans[index] })
                }
            },
            shape: field.shape,
            offset: field.offset,
            stride: field.stride,
        })
    }

    /// Size of a uORB payload, or `None` if it varies.
    pub fn size(self) -> Option<Size> {
        (self.plan.is_fixed && self.plan.defect.is_none()).then_some(self.plan.size)
    }

    /// Size of the fields in memory. Strings and elements of sequences follow them.
    pub(crate) fn fixed_size(self) -> usize {
        self.plan.size.padded
    }

    /// The reason why the type is unusable. All operations then fail.
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

/// A field with its position in memory.
#[derive(Clone, Copy, Debug)]
pub struct Placed<'t> {
    /// Name of the field.
    pub name: &'t str,
    /// Type of the field or its elements.
    pub element: PlacedElement<'t>,
    /// Number of elements.
    pub shape: Shape,
    /// Byte offset in the message.
    pub offset: usize,
    /// Distance between elements in bytes.
    pub stride: usize,
}

/// The type of a field or its elements.
#[derive(Clone, Copy, Debug)]
pub enum PlacedElement<'t> {
    /// A number or a `bool`.
    Scalar(Scalar),
    /// PX4's `char[N]`, treated as one text of `N` bytes.
    Text(u32),
    /// A string. The layout contains only its slot.
    String {
        /// True for a `wstring`.
        is_wide: bool,
        /// Maximum number of characters.
        bound: Option<u32>,
    },
    /// A nested message.
    Message(MessageType<'t>),
}
