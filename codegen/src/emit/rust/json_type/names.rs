//! Names of types, modules and fields, and which types hold themselves.

use std::collections::BTreeSet;

use proc_macro2::Ident;

use super::super::context::Context;
use super::super::identifier::{self, Scope, ident};
use crate::prose;
use crate::schema::json_type::{Definition, Expression, Member, TYPE_FIELD};
use crate::schema::{JsonTypeId, Package};

/// The module of a package that has its types and messages.
pub(in crate::emit::rust) const MODULE: &str = "json";

/// The module that has the types.
pub(super) const TYPES: &str = "types";

/// The names of a package's types, and the rings of types that hold themselves.
pub(super) struct Names {
    /// The id of the first type.
    first: u32,
    /// By type.
    types: Vec<String>,
    /// All names that are given in the module of the types.
    pub(super) taken: Vec<String>,
    /// By type, the number of its ring: types that hold each other without a list or map between them.
    rings: Vec<usize>,
}

impl Names {
    pub(super) fn of(context: &Context<'_>, package: &Package) -> Self {
        let mut scope = Scope::default();
        for reserved in ["Request", "Response", "Notification"] {
            scope.unique_type(reserved);
        }
        let found = package.json_types.iter().map(|id| context.schema.json_type(*id));
        let types: Vec<String> =
            found.map(|found| scope.unique_type(&identifier::type_name(&found.name))).collect();
        let first = package.json_types.first().map_or(0, |id| id.0);
        let holds: Vec<BTreeSet<u32>> =
            package.json_types.iter().map(|id| held(&context.schema.json_type(*id).definition)).collect();
        let taken = types.clone();
        Self { first, types, taken, rings: rings(&holds, first) }
    }

    pub(super) fn name(&self, id: JsonTypeId) -> &str {
        &self.types[(id.0 - self.first) as usize]
    }

    /// True if a type and a type within it hold each other, so that neither has a size.
    pub(super) fn is_recursive(&self, outer: JsonTypeId, inner: JsonTypeId) -> bool {
        let ring = |id: JsonTypeId| self.rings[(id.0 - self.first) as usize];
        ring(outer) == ring(inner)
    }
}

/// The types that a type holds without a list or map between them.
fn held(definition: &Definition) -> BTreeSet<u32> {
    fn collect(expression: &Expression, into: &mut BTreeSet<u32>) {
        match expression {
            Expression::Named(id) => drop(into.insert(id.0)),
            Expression::Either(alternatives) => alternatives.iter().for_each(|inner| collect(inner, into)),
            _ => {}
        }
    }
    let mut found = BTreeSet::new();
    match definition {
        Definition::Object(object) => {
            for field in &object.fields {
                collect(&field.typed.ty, &mut found);
            }
        }
        Definition::Tuple(elements) => {
            for element in elements {
                collect(&element.typed.ty, &mut found);
            }
        }
        Definition::Named(typed) => collect(&typed.ty, &mut found),
        Definition::Set(_) => {}
    }
    found
}

/// The number of each type's ring: types of one ring hold each other, directly or not.
///
/// Types are numbered by when the search leaves them; going back from the last, what reaches a type makes up its ring.
fn rings(holds: &[BTreeSet<u32>], first: u32) -> Vec<usize> {
    let index = |id: &u32| (*id - first) as usize;
    let inner: Vec<Vec<usize>> = holds.iter().map(|held| held.iter().map(index).collect()).collect();
    let mut outer: Vec<Vec<usize>> = vec![Vec::new(); holds.len()];
    for (at, held) in inner.iter().enumerate() {
        for held in held {
            outer[*held].push(at);
        }
    }
    let mut left = Vec::with_capacity(holds.len());
    let mut is_seen = vec![false; holds.len()];
    for start in 0..holds.len() {
        visit(&inner, start, &mut is_seen, &mut left);
    }
    let mut rings = vec![0; holds.len()];
    let mut is_seen = vec![false; holds.len()];
    for (ring, start) in left.into_iter().rev().enumerate() {
        let mut members = Vec::new();
        visit(&outer, start, &mut is_seen, &mut members);
        for member in members {
            rings[member] = ring;
        }
    }
    rings
}

/// All that is reached from `start` and hasn't been seen, each after what is reached from it.
fn visit(steps: &[Vec<usize>], start: usize, is_seen: &mut [bool], left: &mut Vec<usize>) {
    let mut path = Vec::new();
    if !std::mem::replace(&mut is_seen[start], true) {
        path.push((start, 0));
    }
    while let Some((at, taken)) = path.last_mut() {
        let next = steps[*at].get(*taken).copied();
        *taken += 1;
        match next {
            Some(next) if !std::mem::replace(&mut is_seen[next], true) => path.push((next, 0)),
            Some(_) => {}
            None => {
                left.push(*at);
                path.pop();
            }
        }
    }
}

/// The identifiers of the fields of a struct.
pub(super) fn field_names(members: &[Member]) -> Vec<Ident> {
    let mut scope = Scope::default();
    let name = |member: &Member| {
        let name = identifier::snake_case(&member.name);
        let name = if name.is_empty() { "field".to_owned() } else { name };
        ident(&scope.unique(&name))
    };
    members.iter().map(name).collect()
}

/// The text of a type: its description, or a sentence that there is none.
pub(super) fn text(docs: &crate::schema::Docs, what: &str, name: &str) -> String {
    let mut text = if docs.summary.is_empty() {
        format!("The {what} {}, which its page says no more of.", prose::code(name))
    } else {
        prose::inline(&docs.summary)
    };
    if !docs.description.is_empty() {
        text += "\n\n";
        text += &prose::block(&docs.description);
    }
    text
}

/// True if a field of a body is a field of its struct: the type of a message is not.
pub(super) fn is_own(member: &Member) -> bool {
    member.name != TYPE_FIELD
}
