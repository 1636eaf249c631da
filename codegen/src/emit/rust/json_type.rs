//! Types and messages of pages: the module `json` of a package.
//!
//! `json/types.rs` has the types, `json/<message>.rs` the bodies of a message for each direction, and `json.rs` an enum
//! of all messages for each direction. All of it hangs on one line of the package's module, which the runtime takes
//! out where its feature `json` is off.

mod default;
mod message;
mod names;
mod types;

use proc_macro2::{Ident, TokenStream};
use quote::quote;

pub(super) use self::names::MODULE;
use self::names::{Names, TYPES};
use self::types::Definitions;
use super::context::Context;
use super::file::{documentation, header_of_package, inner_documentation, layout_file};
use super::identifier::ident;
use crate::emit::file::OutputFile;
use crate::schema::Package;

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
        let doc = documentation("The types.");
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
