//! Resolution of references between declarations.

use std::collections::BTreeSet;

use uavspec_schema::{EnumRef, MessageId, Schema};

use super::declaration::Type;
use super::names::Names;

/// The context in which declarations are built.
pub(super) struct Declarer<'s> {
    pub(super) schema: &'s Schema,
    pub(super) names: &'s Names,
    /// Names of the modules referenced so far.
    pub(super) imports: BTreeSet<String>,
}

impl Declarer<'_> {
    /// The type of a message, as referenced from the module of `package`.
    pub(super) fn message(&mut self, package: usize, id: MessageId) -> Type {
        let module = self.module(package, self.schema.message(id).package);
        Type::Named { module, name: self.names.message(id).to_owned() }
    }

    /// The type of an enum, as referenced from the module of `package`.
    pub(super) fn enumeration(&mut self, package: usize, reference: EnumRef) -> Type {
        let owner = reference.message;
        if self.names.message(owner).is_empty() {
            return Type::Integer;
        }
        let module = self.module(package, self.schema.message(owner).package);
        let name = self.names.enums[owner.0 as usize][reference.index].clone();
        Type::Enumeration { module, name }
    }

    fn module(&mut self, from: usize, to: usize) -> Option<String> {
        let name = &self.names.modules[to];
        if from == to {
            return None;
        }
        self.imports.insert(name.clone());
        Some(name.clone())
    }
}
