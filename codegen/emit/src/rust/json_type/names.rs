//! Names of types, modules and fields, and detection of recursive types.

use proc_macro2::Ident;
use uavspec_schema::json_type::{Member, TYPE_FIELD};
use uavspec_schema::{JsonTypeId, Package, graph, prose};

use super::super::context::Context;
use super::super::identifier::{self, Scope, ident};
use super::default::Defaults;

/// Name of the module with the types and messages of a package.
pub(in crate::rust) const MODULE: &str = "json";

/// Name of the module with the types.
pub(super) const TYPES: &str = "types";

/// The names of a package's types, the groups of types that contain each other, and the types that implement `Default`.
pub(super) struct Names {
    /// The id of the first type.
    first: u32,
    /// Names by type.
    pub(super) types: Vec<String>,
    /// The group of each type. The types of a group contain each other without a list or map in between.
    groups: Vec<usize>,
    pub(super) defaults: Defaults,
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
        let contained = |id: &JsonTypeId| {
            let parts = context.schema.json_type(*id).definition.typed();
            parts.flat_map(|part| part.ty.alternatives()).map(|id| (id.0 - first) as usize).collect()
        };
        let steps: Vec<Vec<usize>> = package.json_types.iter().map(contained).collect();
        let mut groups = vec![0; steps.len()];
        for (group, members) in graph::groups(&steps).into_iter().enumerate() {
            for member in members {
                groups[member] = group;
            }
        }
        let defaults = Defaults::of(context.schema, package);
        Self { first, types, groups, defaults }
    }

    pub(super) fn name(&self, id: JsonTypeId) -> &str {
        &self.types[(id.0 - self.first) as usize]
    }

    /// True if `outer` and `inner` contain each other without a list or map in between. The inner type must
    /// then be boxed.
    pub(super) fn is_recursive(&self, outer: JsonTypeId, inner: JsonTypeId) -> bool {
        let group = |id: JsonTypeId| self.groups[(id.0 - self.first) as usize];
        group(outer) == group(inner)
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

/// The documentation of a type: its description, or a default.
pub(super) fn text(docs: &uavspec_schema::Docs, what: &str, name: &str) -> String {
    let mut text = if docs.summary.is_empty() {
        format!("{what} {}; the definition has no description.", prose::code(name))
    } else {
        prose::inline(&docs.summary)
    };
    if !docs.description.is_empty() {
        text += "\n\n";
        text += &prose::block(&docs.description);
    }
    text
}

/// True if a body field becomes a field of the struct. Only the `type` field doesn't.
pub(super) fn is_struct_field(member: &Member) -> bool {
    member.name != TYPE_FIELD
}
