//! Rust modules: one module per message, and one type per enum. For each package, there is one type for error codes,
//! and one module for types and messages defined on pages.
//!
//! `quote` creates tokens, `syn` parses them again to ensure valid syntax, and `prettyplease` formats them. Definition
//! text appears in the output only as identifiers made by `identifier`, as literals, or as documentation.
//!
//! ```
//! # use uavspec_schema::{Form, PackageInput, SourceMap, msg::Dialect, read};
//! # let mut sources = SourceMap::default();
//! # let id = sources.add("Wind.msg", "uint64 timestamp  # [us] Time\nfloat32 speed  # [m/s] [@range 0, 60] Speed\n".into()).unwrap();
//! # let packages = [PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])];
//! # let (schema, diagnostics) = read(&sources, &packages);
//! use uavspec_emit::rust::{Options, emit};
//!
//! let files = emit(&schema, &sources, &Options::default());
//! assert!(files.iter().any(|file| file.path == "px4/wind.rs" && file.text.contains("pub struct Wind")));
//! ```

mod context;
mod conversion;
mod enumeration;
mod error_code;
mod event;
mod file;
mod identifier;
mod imports;
mod json_type;
mod message;
mod text;
mod types;

use std::collections::BTreeMap;

use proc_macro2::TokenStream;
use quote::quote;
use uavspec_dynamic::conversion::Conversions;
use uavspec_lint::release::Releases;
use uavspec_schema::failure::Failure;
use uavspec_schema::parallel::in_parts;
use uavspec_schema::source::SourceMap;
use uavspec_schema::translation::Translations;
use uavspec_schema::{Interface, MessageId, Package, Schema, prose};

use self::context::{Context, Place};
use self::file::{
    documentation, header, header_of, header_of_package, inner_documentation, layout_file, module_declaration,
};
use self::identifier::{Scope, ident, module_name};
use super::emitter::{Input, Output};
use super::file::OutputFile;
use super::origin::Origins;

/// Options of the emitter.
#[derive(Clone, Debug, schemars::JsonSchema, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// Name of the root file: `mod.rs`, or `lib.rs` for a whole crate.
    pub root: String,
    /// A Markdown file to include in the documentation of the root module, relative to the root file. Its code examples
    /// are doctests.
    pub readme: Option<String>,
}

impl Default for Options {
    fn default() -> Self {
        Self { root: "mod.rs".to_owned(), readme: None }
    }
}

impl Output for Options {
    fn emit(&self, input: Input<'_>) -> Result<Vec<OutputFile>, Failure> {
        Ok(emit_all(input, self))
    }
}

/// Creates the module tree of the whole schema, with `options.root` as the root file.
pub fn emit(schema: &Schema, sources: &SourceMap, options: &Options) -> Vec<OutputFile> {
    emit_with_conversions(schema, sources, &[], options)
}

/// Like [`emit`], with conversions between packages of the schema in the module `conversions`.
pub fn emit_with_conversions(
    schema: &Schema,
    sources: &SourceMap,
    conversions: &[Conversions],
    options: &Options,
) -> Vec<OutputFile> {
    let (translations, releases) = (Translations::default(), Releases::default());
    let input = Input { schema, sources, conversions, translations: &translations, releases: &releases };
    emit_all(input, options)
}

fn emit_all(input: Input<'_>, options: &Options) -> Vec<OutputFile> {
    let Input { schema, sources, conversions, translations, .. } = input;
    let mut context = Context {
        schema,
        translations,
        origins: Origins::new(schema, sources),
        places: vec![None; schema.messages.len()],
        enum_names: vec![Vec::new(); schema.messages.len()],
    };
    let mut root_scope = Scope::default();
    root_scope.unique(options.root.trim_end_matches(".rs"));
    if !conversions.is_empty() {
        root_scope.unique(conversion::MODULE);
    }
    let mut packages = Vec::new();
    for package in &schema.packages {
        if !package.is_empty() {
            let module = root_scope.unique(&module_name(&package.name));
            name_modules(&mut context, package, &module);
            packages.push((package, module));
        }
    }
    let mut files = vec![OutputFile {
        path: options.root.clone(),
        text: root(&packages, !conversions.is_empty(), options),
    }];
    for (package, module) in &packages {
        files.append(&mut package_files(&context, package, module));
    }
    files.append(&mut message_files(&context));
    if !conversions.is_empty() {
        let module = |package: usize| {
            let name = &schema.packages[package].name;
            let found = packages.iter().find(|(found, _)| found.name == *name);
            // Packages without messages have neither a module nor conversions.
            found.map_or("", |(_, module)| module.as_str())
        };
        files.append(&mut conversion::files(&context, conversions, &module));
    }
    OutputFile::sort(&mut files);
    files
}

/// Names the modules, types and views of a package.
fn name_modules(context: &mut Context<'_>, package: &Package, module: &str) {
    let mut scope = Scope::default();
    let mut types = Scope::default();
    for reserved in ["srv", "action", "error_code", json_type::MODULE] {
        scope.unique(reserved);
    }
    if !package.error_tables.is_empty() {
        types.unique_type("ErrorCode");
    }
    let schema = context.schema;
    let has_view = |id: MessageId| schema.message(id).uorb.is_some();
    let mut places = Vec::with_capacity(package.messages.len());
    for id in &package.messages {
        let name = &schema.message(*id).name;
        places.push(Place {
            modules: vec![module.to_owned(), scope.unique(&module_name(name))],
            type_name: types.unique_type(&identifier::type_name(name)),
            view_name: String::new(),
        });
    }
    // Views are named after their types, and type names take precedence.
    for (id, mut place) in package.messages.iter().zip(places) {
        let mut module_types = Scope::default();
        module_types.unique_type(&place.type_name);
        if has_view(*id) {
            place.view_name = types.unique_type(&format!("{}View", place.type_name));
            module_types.unique_type(&place.view_name);
        }
        set_place(context, *id, place, &mut module_types);
    }
    let mut scopes: BTreeMap<&str, (Scope, Scope)> = BTreeMap::new();
    for interface in &package.interfaces {
        let kind = interface.kind.name();
        let (scope, types) = scopes.entry(kind).or_default();
        let name = scope.unique(&module_name(&interface.name));
        let mut places = Vec::new();
        let mut module_types = Scope::default();
        for id in &interface.parts {
            let type_name = types.unique_type(&identifier::type_name(&schema.message(*id).name));
            let view_name =
                if has_view(*id) { types.unique_type(&format!("{type_name}View")) } else { String::new() };
            module_types.unique_type(&type_name);
            module_types.unique_type(&view_name);
            let modules = vec![module.to_owned(), kind.to_owned(), name.clone()];
            places.push(Place { modules, type_name, view_name });
        }
        for (id, place) in interface.parts.iter().zip(places) {
            set_place(context, *id, place, &mut module_types);
        }
    }
}

/// Stores where the type of a message is generated, and names the message's enums. `scope` is the scope of the module.
fn set_place(context: &mut Context<'_>, id: MessageId, place: Place, scope: &mut Scope) {
    let message = context.schema.message(id);
    let names: Vec<String> = message
        .enums
        .iter()
        .map(|found| {
            let prefix = found.prefixes.first().map_or("Value", String::as_str);
            let user = message.fields.iter().find(|field| {
                field.enumeration.is_some_and(|reference| {
                    reference.message == id && message.enums[reference.index] == *found
                })
            });
            let fallback = user.map_or_else(|| format!("{prefix}_value"), |field| field.name.clone());
            scope.first_free_type(&[identifier::pascal_case(prefix), identifier::pascal_case(&fallback)])
        })
        .collect();
    context.enum_names[id.0 as usize] = names;
    context.places[id.0 as usize] = Some(place);
}

fn root(packages: &[(&Package, String)], has_conversions: bool, options: &Options) -> String {
    let modules = packages.iter().map(|(package, module)| {
        let module = ident(module);
        let doc = documentation(&format!("Package `{}`.", package.name));
        // The generator formats the code, so rustfmt skips it.
        quote!(#doc #[rustfmt::skip] pub mod #module;)
    });
    let conversions = has_conversions.then(conversion::declaration);
    let no_std = (options.root == "lib.rs").then(|| quote!(#![no_std]));
    let doc = inner_documentation(
        "Types of drone interface definitions. Each package is a module.\n\n\
         Every message implements [`Message`](::uavspec_runtime::Message), and messages of fixed size also \
         implement [`UorbMessage`](::uavspec_runtime::UorbMessage). The runtime feature `serde` adds the \
         JSON form described by the published JSON Schemas.",
    );
    let readme = options.readme.as_ref().map(|path| quote!(#![doc = include_str!(#path)]));
    let tokens = quote! {
        #doc
        #readme
        #no_std
        // Allow these lints, because names and texts are copied from the definitions and may violate them.
        #![allow(clippy::approx_constant)]
        #![allow(clippy::default_trait_access)]
        #![allow(clippy::doc_lazy_continuation)]
        #![allow(clippy::doc_markdown)]
        #![allow(clippy::excessive_precision)]
        #![allow(clippy::must_use_candidate)]
        #![allow(clippy::struct_excessive_bools)]
        #![allow(clippy::struct_field_names)]
        #![allow(clippy::too_long_first_doc_paragraph)]
        #![allow(clippy::unreadable_literal)]
        #(#modules)*
        #conversions
    };
    header("the definitions") + &layout_file(tokens)
}

fn package_files(context: &Context<'_>, package: &Package, module: &str) -> Vec<OutputFile> {
    let mut files = Vec::new();
    let mut lines = vec![format!("Package `{}`, in the {} dialect.", package.name, package.form.name())];
    if let Some(origin) = &package.origin {
        lines.push(format!("Origin: {}.", prose::inline(origin)));
    }
    if let Some(revision) = &package.revision {
        lines.push(format!("Revision: {}.", prose::inline(revision)));
    }
    let doc = inner_documentation(&lines.join("\n\n"));
    let messages = package.messages.iter().map(|id| {
        let place = context.place(*id);
        let doc = documentation(&format!(
            "[`{0}`](struct@{0}) and the types of its fields.",
            ident(&place.type_name)
        ));
        re_export(&doc, module, place.module(), [&place.type_name])
    });
    let kinds: Vec<TokenStream> = [("srv", "Services."), ("action", "Actions.")]
        .into_iter()
        .filter(|(kind, _)| package.interfaces.iter().any(|interface| interface.kind.name() == *kind))
        .map(|(kind, text)| {
            let doc = documentation(text);
            let declaration = module_declaration(module, kind);
            quote!(#doc #declaration)
        })
        .collect();
    let mut error_codes = None;
    if !package.error_tables.is_empty() {
        let doc = documentation("Error codes.");
        error_codes = Some(re_export(&doc, module, "error_code", [&"ErrorCode".to_owned()]));
        let text = error_code::emit(context, package);
        files.push(OutputFile { path: format!("{module}/error_code.rs"), text });
    }
    let mut json = None;
    if json_type::has_content(package) {
        json = Some(json_type::declaration(module));
        files.append(&mut json_type::files(context, package, module));
    }
    let (events, mut event_files) = event::files(context, package, module);
    files.append(&mut event_files);
    let views = re_export_views(context, &package.messages);
    let layouts = assert_layouts(context, &package.messages);
    let tokens = quote!(#doc #error_codes #(#messages)* #(#kinds)* #json #events #views #layouts);
    let text = header_of_package(package) + &layout_file(tokens);
    files.push(OutputFile { path: format!("{module}.rs"), text });
    for kind in ["srv", "action"] {
        let interfaces: Vec<&Interface> =
            package.interfaces.iter().filter(|interface| interface.kind.name() == kind).collect();
        if !interfaces.is_empty() {
            files.push(OutputFile {
                path: format!("{module}/{kind}.rs"),
                text: kind_module(context, package, &interfaces),
            });
        }
    }
    for interface in &package.interfaces {
        let Some(first) = interface.parts.first() else { continue };
        let path = format!("{}.rs", context.place(*first).modules.join("/"));
        let doc = inner_documentation(&format!("Parts of {}.", prose::code(&interface.name)));
        let parts = interface.parts.iter().map(|id| message::tokens(context, *id));
        let text = header_of(context, package, interface.span) + &layout_file(quote!(#doc #(#parts)*));
        files.push(OutputFile { path, text });
    }
    files
}

fn kind_module(context: &Context<'_>, package: &Package, interfaces: &[&Interface]) -> String {
    let kind = interfaces[0].kind.name();
    let what = if kind == "srv" { "Services" } else { "Actions" };
    let doc = inner_documentation(&format!("{what} of package `{}`.", package.name));
    let modules = interfaces.iter().map(|interface| {
        let doc = documentation(&format!("Parts of {}.", prose::code(&interface.name)));
        let places = || interface.parts.iter().map(|id| context.place(*id));
        let module = places().next().map_or("", Place::module);
        re_export(&doc, kind, module, places().map(|place| &place.type_name))
    });
    let parts = || interfaces.iter().flat_map(|interface| &interface.parts);
    let views = re_export_views(context, parts());
    let layouts = assert_layouts(context, parts());
    header_of_package(package) + &layout_file(quote!(#doc #(#modules)* #views #layouts))
}

/// Creates compile-time assertions for the layout of fixed-size messages that contain other messages. The layout of
/// other messages needs no assertions, because the generator knows it completely.
fn assert_layouts<'p>(
    context: &Context<'_>,
    messages: impl IntoIterator<Item = &'p MessageId>,
) -> Option<TokenStream> {
    let nests = |id: &&MessageId| context.schema.message(**id).nested().next().is_some();
    let places = messages.into_iter().filter(nests).map(|id| context.place(*id));
    let names: Vec<_> =
        places.filter(|place| !place.view_name.is_empty()).map(|place| ident(&place.type_name)).collect();
    (!names.is_empty()).then(|| quote!(::uavspec_runtime::assert_layouts! { #(#names;)* }))
}

fn re_export<'n>(
    doc: &TokenStream,
    parent: &str,
    module: &str,
    names: impl IntoIterator<Item = &'n String>,
) -> TokenStream {
    let declaration = module_declaration(parent, module);
    let module = ident(module);
    let names = names.into_iter().map(|name| ident(name));
    quote!(#doc #declaration pub use self::#module::{#(#names),*};)
}

/// Re-exports the views of messages if the runtime's `views` feature is enabled.
fn re_export_views<'p>(
    context: &Context<'_>,
    messages: impl IntoIterator<Item = &'p MessageId>,
) -> Option<TokenStream> {
    let lines: Vec<TokenStream> = messages
        .into_iter()
        .map(|id| context.place(*id))
        .filter(|place| !place.view_name.is_empty())
        .map(|place| {
            let (module, name) = (ident(place.module()), ident(&place.view_name));
            quote!(pub use self::#module::#name;)
        })
        .collect();
    (!lines.is_empty()).then(|| quote!(::uavspec_runtime::with_views! { #(#lines)* }))
}

/// Creates the files of all messages. The files are independent, so the work is distributed among the processors.
fn message_files(context: &Context<'_>) -> Vec<OutputFile> {
    let ids: Vec<MessageId> =
        context.schema.packages.iter().flat_map(|package| package.messages.iter().copied()).collect();
    let file = |id: &MessageId| {
        let place = context.place(*id);
        let message = context.schema.message(*id);
        let doc = inner_documentation(&format!(
            "[`{0}`](struct@{0}) and the types of its fields.",
            ident(&place.type_name)
        ));
        let tokens = message::tokens(context, *id);
        let path = format!("{}.rs", place.modules.join("/"));
        let header = header_of(context, context.schema.package_of(message), message.span);
        OutputFile { path, text: header + &layout_file(quote!(#doc #tokens)) }
    };
    let files = in_parts(&ids, |ids| ids.iter().map(file).collect::<Vec<_>>());
    files.into_iter().flatten().collect()
}
