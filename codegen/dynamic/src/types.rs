//! Message types that are known only at run time.

use uavspec_runtime::layout::Size;
use uavspec_schema::MessageId;
use uavspec_schema::source::Span;

use super::error::{Defect, Error, Reason};
use super::plan::{Field, Plan};

/// All message types in a schema or a log.
#[derive(Debug, Default)]
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

    /// The type of a message in the schema or the log from which these types were created.
    ///
    /// # Panics
    ///
    /// Panics if `id` belongs to another schema or log.
    #[inline]
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

    /// The declaration; empty for a type without a definition.
    pub fn span(self) -> Span {
        self.plan.span
    }

    /// The fields in declaration order. The fields of an unusable type have no positions.
    pub fn fields(self) -> &'t [Field] {
        &self.plan.fields
    }

    /// The field with this name.
    pub fn field(self, name: &str) -> Option<&'t Field> {
        self.plan.fields.iter().find(|field| *field.name == *name)
    }

    /// The type of a nested message.
    ///
    /// # Panics
    ///
    /// Panics if `id` is not the id of a message in the same set of types.
    #[must_use]
    pub fn nested(self, id: MessageId) -> Self {
        self.types.get(id)
    }

    /// Size of a uORB payload, or `None` if it varies.
    pub fn size(self) -> Option<Size> {
        (self.plan.is_fixed && self.plan.defect.is_none()).then_some(self.plan.size)
    }

    /// Size of the fields in memory. Strings and elements of sequences follow them.
    pub(crate) fn fixed_size(self) -> usize {
        self.plan.size.padded
    }

    /// The reason why the type is unusable. If there is one, all operations fail.
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
