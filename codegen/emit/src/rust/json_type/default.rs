//! Decides which types implement `Default`. A type doesn't implement `Default` if the default would have to be chosen
//! from several values.

use uavspec_schema::json_type::{Definition, Expression, Member};
use uavspec_schema::{Package, Schema};

/// The types of a package that implement `Default`.
pub(super) struct Defaults {
    /// The id of the first type.
    first: u32,
    /// True for each type that implements `Default`.
    types: Vec<bool>,
}

impl Defaults {
    pub(super) fn of(schema: &Schema, package: &Package) -> Self {
        let first = package.json_types.first().map_or(0, |id| id.0);
        let mut defaults = Self { first, types: vec![false; package.json_types.len()] };
        // Each round adds the types whose defaults contain only types from earlier rounds.
        let mut is_complete = false;
        while !is_complete {
            is_complete = true;
            // Go backwards, because most pages define a type before the types that it contains.
            for (index, id) in package.json_types.iter().enumerate().rev() {
                if !defaults.types[index] && defaults.of_definition(&schema.json_type(*id).definition) {
                    defaults.types[index] = true;
                    is_complete = false;
                }
            }
        }
        defaults
    }

    /// True if `Default` can be derived for a struct with these members.
    pub(super) fn of_members(&self, members: &[Member]) -> bool {
        members.iter().all(|member| !member.is_required || self.of_expression(&member.typed.ty))
    }

    /// True if `Default` can be derived for a newtype over this expression.
    pub(super) fn of_expression(&self, expression: &Expression) -> bool {
        match expression {
            _ if expression.is_nullable() => true,
            Expression::Named(id) => self.types[(id.0 - self.first) as usize],
            Expression::ErrorCode | Expression::OneOf(_) | Expression::Either(_) => false,
            _ => true,
        }
    }

    fn of_definition(&self, definition: &Definition) -> bool {
        match definition {
            Definition::Object(_) | Definition::Tuple(_) => self.of_members(definition.members()),
            Definition::Named(typed) => self.of_expression(&typed.ty),
            Definition::Set(_) => false,
        }
    }
}
