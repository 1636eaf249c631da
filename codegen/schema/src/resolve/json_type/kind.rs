//! The kinds of values of an expression, including the kinds of referenced types.

use std::collections::{HashMap, HashSet};

use crate::json_type::{self, ERROR_LIST};
use crate::table::type_table::{Body, Expression, ExpressionKind, TypeDefinition};

/// Kinds of values that annotations distinguish.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Kinds {
    pub(super) has_number: bool,
    pub(super) has_string: bool,
    pub(super) has_list: bool,
}

/// The types of a package, by name.
pub(super) type ByName<'t, 'p> = HashMap<&'p str, &'t TypeDefinition<'p>>;

/// The kinds of the values of an expression. If `is_within` is true, also includes the elements of lists and maps.
pub(super) fn kinds(expression: &Expression, by_name: &ByName<'_, '_>, is_within: bool) -> Kinds {
    let mut kinds = Kinds::default();
    let mut seen = HashSet::new();
    let mut open = vec![expression];
    while let Some(next) = open.pop() {
        match &next.kind {
            ExpressionKind::BuiltIn(json_type::Expression::Integer | json_type::Expression::Number) => {
                kinds.has_number = true;
            }
            ExpressionKind::BuiltIn(json_type::Expression::String) => kinds.has_string = true,
            ExpressionKind::List(inner) => {
                kinds.has_list = true;
                open.extend(is_within.then_some(&**inner));
            }
            ExpressionKind::Map(inner) => open.extend(is_within.then_some(&**inner)),
            ExpressionKind::Either(alternatives) => open.extend(alternatives),
            ExpressionKind::Named(name) => {
                let found = by_name.get(name.as_str()).filter(|_| seen.insert(name.as_str()));
                if let Some(Body::Named { ty, .. }) = found.map(|definition| &definition.body) {
                    open.push(ty);
                }
                kinds.has_list |= name == ERROR_LIST;
            }
            ExpressionKind::BuiltIn(_) | ExpressionKind::OneOf(_) => {}
        }
    }
    kinds
}
