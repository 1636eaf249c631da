//! Types and messages of pages: the module `json` of a package.
//!
//! `json/types.rs` has the types, `json/<message>.rs` the bodies of a message for each direction, and `json.rs` an enum
//! of all messages for each direction. All of it hangs on one line of the package's module, which the runtime takes
//! out where its feature `json` is off.

mod default;
mod message;
mod types;

use std::collections::BTreeSet;

use proc_macro2::{Ident, TokenStream};
use quote::quote;

use self::types::Definitions;
use super::identifier::{self, Scope, ident};
use super::{Context, header_of_package, inner_documentation, layout_file};
use crate::emit::OutputFile;
use crate::prose;
use crate::schema::json_type::{Definition, Expression, Member, TYPE_FIELD};
use crate::schema::{JsonTypeId, Package};

/// The module of a package that has its types and messages.
pub(super) const MODULE: &str = "json";

/// The module that has the types.
const TYPES: &str = "types";

/// Whether a package has anything to emit here.
pub(super) fn has_content(package: &Package) -> bool {
    !package.json_types.is_empty() || !package.json_messages.is_empty()
}

/// The line of the package's module that brings in all others.
pub(super) fn declaration() -> TokenStream {
    let module = ident(MODULE);
    quote!(::uavspec_runtime::with_json! { pub mod #module; })
}

/// All files of the package in the module `module`.
pub(super) fn files(context: &Context<'_>, package: &Package, module: &str) -> Vec<OutputFile> {
    let names = Names::of(context, package);
    let mut definitions = Definitions::new(context, &names);
    let tokens: Vec<TokenStream> = package.json_types.iter().map(|id| definitions.json_type(*id)).collect();
    let mut files = Vec::new();
    let mut re_exported: Vec<Ident> = Vec::new();
    if !package.json_types.is_empty() {
        re_exported = definitions.names().iter().map(|name| ident(name)).collect();
        let doc = inner_documentation(&format!("The types of package `{}`.", package.name));
        let text = header_of_package(package) + &layout_file(quote!(#doc #(#tokens)*));
        files.push(OutputFile { path: format!("{module}/{MODULE}/{TYPES}.rs"), text });
    }
    let (root, mut messages) = message::files(context, package, &names, module);
    let doc = inner_documentation(&format!(
        "Types and messages of package `{}`: JSON, as its pages define it.\n\n\
         A field that may be left out is an `Option`; what may be `null` is one, too. Further fields of an object are\n\
         passed over unless the page closes it. Ranges are documented and can be asked for, but reading doesn't look\n\
         at them.",
        package.name
    ));
    let types = (!package.json_types.is_empty()).then(|| {
        let doc = super::documentation("The types.");
        let types = ident(TYPES);
        quote!(#doc pub mod #types; pub use self::#types::{#(#re_exported),*};)
    });
    // What is absent and what is null are two things. Messages are few at a time, and an indirection would be in
    // everybody's way.
    let allowed = quote!(#![allow(clippy::large_enum_variant)] #![allow(clippy::option_option)]);
    let text = header_of_package(package) + &layout_file(quote!(#doc #allowed #types #root));
    files.push(OutputFile { path: format!("{module}/{MODULE}.rs"), text });
    files.append(&mut messages);
    files
}

/// What the types of a package are called, and which hold themselves.
struct Names {
    /// The id of the first type.
    first: u32,
    /// By type.
    types: Vec<String>,
    /// All names that are given in the module of the types.
    taken: Vec<String>,
    /// By type, the number of its ring: types that hold each other without a list or map between them.
    rings: Vec<usize>,
}

impl Names {
    fn of(context: &Context<'_>, package: &Package) -> Self {
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

    fn name(&self, id: JsonTypeId) -> &str {
        &self.types[(id.0 - self.first) as usize]
    }

    /// Whether a type and one that it holds may hold each other, so that there is no saying how large either is.
    fn is_recursive(&self, outer: JsonTypeId, inner: JsonTypeId) -> bool {
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

/// For each type the number of the ring it stands in: types of the same ring hold each other, directly or not.
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
fn field_names(members: &[Member]) -> Vec<Ident> {
    let mut scope = Scope::default();
    let name = |member: &Member| {
        let name = identifier::snake_case(&member.name);
        let name = if name.is_empty() { "field".to_owned() } else { name };
        ident(&scope.unique(&name))
    };
    members.iter().map(name).collect()
}

/// The text of a type: what the page says of it, or that it says nothing.
fn text(docs: &crate::schema::Docs, what: &str, name: &str) -> String {
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

/// The fields of a body that are fields of its struct: its type is told by where it stands.
fn is_own(member: &Member) -> bool {
    member.name != TYPE_FIELD
}
