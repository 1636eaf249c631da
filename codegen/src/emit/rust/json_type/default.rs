//! Decides which types implement `Default`. A type doesn't implement `Default` if the default would have to be chosen
//! from several values.

use crate::schema::json_type::{Definition, Expression, Member};
use crate::schema::{JsonTypeId, Schema};

/// Defaults are resolved only to this depth.
const MAX_DEPTH: usize = 32;

/// True if `Default` can be derived for a struct with these members.
pub(super) fn of_members(schema: &Schema, members: &[Member]) -> bool {
    members_have(schema, members, 0)
}

/// True if `Default` can be derived for a newtype over this expression.
pub(super) fn of_expression(schema: &Schema, expression: &Expression) -> bool {
    has(schema, expression, 0)
}

fn members_have(schema: &Schema, members: &[Member], depth: usize) -> bool {
    members.iter().all(|member| !member.is_required || has(schema, &member.typed.ty, depth))
}

fn has(schema: &Schema, expression: &Expression, depth: usize) -> bool {
    match expression {
        _ if depth > MAX_DEPTH => false,
        _ if expression.is_nullable() => true,
        Expression::Named(id) => type_has(schema, *id, depth + 1),
        Expression::ErrorCode | Expression::OneOf(_) | Expression::Either(_) => false,
        _ => true,
    }
}

fn type_has(schema: &Schema, id: JsonTypeId, depth: usize) -> bool {
    match &schema.json_type(id).definition {
        Definition::Object(object) => members_have(schema, &object.fields, depth),
        Definition::Tuple(elements) => members_have(schema, elements, depth),
        Definition::Named(typed) => has(schema, &typed.ty, depth),
        Definition::Set(_) => false,
    }
}
