//! The `json` module of a package: types and messages defined on pages.
//!
//! `json/types.rs` contains the types. `json/<message>.rs` contains the body of a message for each direction. `json.rs`
//! contains an enum of all messages for each direction. The package module includes these files with one macro call. If
//! the runtime's `json` feature is disabled, the macro expands to nothing.

mod default;
mod message;
mod names;
mod types;

use proc_macro2::{Ident, TokenStream};
use quote::quote;
use uavspec_schema::Package;

pub(super) use self::names::MODULE;
use self::names::{Names, TYPES};
use self::types::Definitions;
use super::context::Context;
use super::file::{documentation, header_of_package, inner_documentation, layout_file, module_declaration};
use super::identifier::ident;
use crate::file::OutputFile;

/// True if a package defines types or messages on pages.
pub(super) fn has_content(package: &Package) -> bool {
    !package.json_types.is_empty() || !package.json_messages.is_empty()
}

/// The declaration of this module in the package module.
pub(super) fn declaration(package_module: &str) -> TokenStream {
    let declaration = module_declaration(package_module, MODULE);
    quote!(::uavspec_runtime::with_json! { #declaration })
}

/// Creates the files of a package. `module` is the name of the package module.
pub(super) fn files(context: &Context<'_>, package: &Package, module: &str) -> Vec<OutputFile> {
    let names = Names::of(context, package);
    let mut definitions = Definitions::new(context, &names);
    let tokens: Vec<TokenStream> = package.json_types.iter().map(|id| definitions.json_type(*id)).collect();
    let mut files = Vec::new();
    let mut re_exported: Vec<Ident> = Vec::new();
    if !package.json_types.is_empty() {
        re_exported = definitions.names().iter().map(|name| ident(name)).collect();
        let doc = inner_documentation(&format!("Types of package `{}`.", package.name));
        let text = header_of_package(package) + &layout_file(quote!(#doc #(#tokens)*));
        files.push(OutputFile { path: format!("{module}/{MODULE}/{TYPES}.rs"), text });
    }
    let (root, mut messages) = message::files(context, package, &names, module);
    let doc = inner_documentation(&format!(
        "JSON types and messages of package `{}`.\n\n\
         Optional fields and nullable values are `Option`s. Undefined fields of an object are ignored unless \
         the object is closed. Reading doesn't check ranges. Types with a range have a method that checks \
         it.",
        package.name
    ));
    let types = (!package.json_types.is_empty()).then(|| {
        let doc = documentation("Types.");
        let types = ident(TYPES);
        quote!(#doc pub mod #types; pub use self::#types::{#(#re_exported),*};)
    });
    // An absent value differs from null, so `Option<Option<T>>` is needed. Few messages exist at the same time, so
    // boxing large variants would only make them harder to use.
    let allowed = quote!(#![allow(clippy::large_enum_variant)] #![allow(clippy::option_option)]);
    let text = header_of_package(package) + &layout_file(quote!(#doc #allowed #types #root));
    files.push(OutputFile { path: format!("{module}/{MODULE}.rs"), text });
    files.append(&mut messages);
    files
}
