//! Rust: one module a message, one type an enum, one type for the error codes of a package, one module for the
//! types and messages of its pages.
//!
//! Tokens are made with `quote`, parsed once more by `syn`, so that what is written is Rust, and laid
//! out by `prettyplease`. Nothing of a definition reaches the output but through identifiers made by
//! `identifier`, literals and documentation.
//!
//! ```
//! # use uavspec_codegen::{PackageInput, SourceMap, msg::Dialect, read, schema::Form};
//! # let mut sources = SourceMap::default();
//! # let id = sources.add("Wind.msg", "uint64 timestamp  # [us] Time\nfloat32 speed  # [m/s] [@range 0, 60] Speed\n".into()).unwrap();
//! # let packages = [PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])];
//! # let (schema, diagnostics) = read(&sources, &packages);
//! use uavspec_codegen::emit::rust::{Options, emit};
//!
//! let files = emit(&schema, &sources, &Options::default());
//! assert!(files.iter().any(|file| file.path == "px4/wind.rs" && file.text.contains("pub struct Wind")));
//! ```

mod enumeration;
mod error_code;
mod identifier;
mod imports;
mod json_type;
mod message;
mod types;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::num::NonZero;
use std::thread;

use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};
use quote::quote;

use self::identifier::{Scope, ident, module_name};
#[cfg(feature = "files")]
use super::emitter::{Input, Output};
use super::origin::Origins;
use super::{GENERATED_BY, OutputFile};
#[cfg(feature = "files")]
use crate::failure::Failure;
use crate::prose;
use crate::schema::{Element, MessageId, Package, Schema};
use crate::source::SourceMap;
use crate::span::Span;

/// Options of the emitter.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "files", derive(serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct Options {
    /// Name of the file at the root of the module tree: `mod.rs`, or `lib.rs` for a whole crate.
    pub root: String,
    /// A Markdown page, relative to that file, that stands in its documentation; code in it is tested.
    pub readme: Option<String>,
}

impl Default for Options {
    fn default() -> Self {
        Self { root: "mod.rs".to_owned(), readme: None }
    }
}

#[cfg(feature = "files")]
impl Output for Options {
    fn emit(&self, input: Input<'_>) -> Result<Vec<OutputFile>, Failure> {
        Ok(emit(input.schema, input.sources, self))
    }
}

/// Modules of a package, in the order in which they are declared.
struct Modules {
    /// Module and type of each message of the package.
    messages: Vec<(MessageId, Place)>,
    /// The modules of services and actions: folder, then module and parts.
    interfaces: Vec<InterfaceModule>,
}

struct InterfaceModule {
    kind: &'static str,
    module: String,
    index: usize,
    parts: Vec<(MessageId, Place)>,
}

/// Where the type of a message is: the path from the root of the module tree, and the type's name.
#[derive(Clone, Debug)]
struct Place {
    modules: Vec<String>,
    type_name: String,
    /// Of a message of fixed size, the name of the type that looks at its bytes.
    view_name: String,
}

impl Place {
    /// The names of its public types but for enums.
    fn names(&self) -> impl Iterator<Item = &String> {
        [&self.type_name, &self.view_name].into_iter().filter(|name| !name.is_empty())
    }
}

/// All that the parts of the emitter look up.
struct Context<'s> {
    schema: &'s Schema,
    origins: Origins<'s>,
    /// By [`MessageId`].
    places: Vec<Option<Place>>,
    /// Names of the types of the enums of each message, by [`MessageId`].
    enum_names: Vec<Vec<String>>,
}

impl Context<'_> {
    fn place(&self, id: MessageId) -> &Place {
        // Every message that is listed, or referred to by one that is, has been given a place.
        self.places[id.0 as usize].as_ref().unwrap_or(&UNPLACED)
    }

    /// The path of a message's type as the module of another message writes it.
    fn path(&self, from: MessageId, to: MessageId) -> TokenStream {
        let place = self.place(to);
        // Types are re-exported by the package's module, so the message's own module is left out.
        let public = &place.modules[..place.modules.len().saturating_sub(1)];
        self.relative(from, public, &place.type_name)
    }

    /// The path of an enum's type as the module of another message writes it.
    fn enum_path(&self, from: MessageId, to: MessageId, type_name: &str) -> TokenStream {
        if self.place(from).modules == self.place(to).modules {
            let name = ident(type_name);
            return quote!(#name);
        }
        self.relative(from, &self.place(to).modules, type_name)
    }

    fn relative(&self, from: MessageId, modules: &[String], type_name: &str) -> TokenStream {
        let own = &self.place(from).modules;
        let shared = own.iter().zip(modules).take_while(|(left, right)| left == right).count();
        let ups = (shared..own.len()).map(|_| quote!(super::));
        let downs = modules[shared..].iter().map(|module| {
            let module = ident(module);
            quote!(#module::)
        });
        let name = ident(type_name);
        quote!(#(#ups)* #(#downs)* #name)
    }
}

static UNPLACED: Place = Place { modules: Vec::new(), type_name: String::new(), view_name: String::new() };

/// Emits the whole schema as a tree of modules below `options.root`.
pub fn emit(schema: &Schema, sources: &SourceMap, options: &Options) -> Vec<OutputFile> {
    let mut context = Context {
        schema,
        origins: Origins::new(schema, sources),
        places: vec![None; schema.messages.len()],
        enum_names: vec![Vec::new(); schema.messages.len()],
    };
    let mut root_scope = Scope::default();
    let mut packages = Vec::new();
    for package in &schema.packages {
        if !package.is_empty() {
            let module = root_scope.unique(&module_name(&package.name));
            let modules = name_modules(&mut context, package, &module);
            packages.push((package, module, modules));
        }
    }
    let mut files = vec![OutputFile { path: options.root.clone(), text: root(&packages, options) }];
    for (package, module, modules) in &packages {
        files.append(&mut package_files(&context, package, module, modules));
    }
    files.append(&mut message_files(&context));
    files.sort_by(|left, right| left.path.cmp(&right.path));
    files
}

fn name_modules(context: &mut Context<'_>, package: &Package, module: &str) -> Modules {
    let mut modules = Modules { messages: Vec::new(), interfaces: Vec::new() };
    let mut scope = Scope::default();
    let mut types = Scope::default();
    for reserved in ["srv", "action", "error_code", json_type::MODULE] {
        scope.unique(reserved);
    }
    types.unique_type("ErrorCode");
    let schema = context.schema;
    let has_view = |id: MessageId| schema.message(id).uorb.is_some();
    for id in &package.messages {
        let name = &schema.message(*id).name;
        let place = Place {
            modules: vec![module.to_owned(), scope.unique(&module_name(name))],
            type_name: types.unique_type(&identifier::type_name(name)),
            view_name: String::new(),
        };
        modules.messages.push((*id, place));
    }
    // Views are called after the types, and give way to them.
    for (id, place) in &mut modules.messages {
        let mut own_types = Scope::default();
        own_types.unique_type(&place.type_name);
        if has_view(*id) {
            place.view_name = types.unique_type(&format!("{}View", place.type_name));
            own_types.unique_type(&place.view_name);
        }
        set_place(context, *id, place.clone(), &mut own_types);
    }
    let mut scopes: BTreeMap<&str, (Scope, Scope)> = BTreeMap::new();
    for (index, interface) in package.interfaces.iter().enumerate() {
        let kind = interface.kind.name();
        let (scope, types) = scopes.entry(kind).or_default();
        let name = scope.unique(&module_name(&interface.name));
        let mut parts = Vec::new();
        let mut own_types = Scope::default();
        for id in &interface.parts {
            let type_name = types.unique_type(&identifier::type_name(&schema.message(*id).name));
            let view_name =
                if has_view(*id) { types.unique_type(&format!("{type_name}View")) } else { String::new() };
            own_types.unique_type(&type_name);
            own_types.unique_type(&view_name);
            let path = vec![module.to_owned(), kind.to_owned(), name.clone()];
            parts.push((*id, Place { modules: path, type_name, view_name }));
        }
        for (id, place) in &parts {
            set_place(context, *id, place.clone(), &mut own_types);
        }
        modules.interfaces.push(InterfaceModule { kind, module: name, index, parts });
    }
    modules
}

/// Gives a message its place, and its enums names in `scope`, that of the module.
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

/// The header line of a generated file.
fn header(from: &str) -> String {
    // A path with a line break would end the comment.
    let from = from.replace(['\n', '\r'], " ");
    format!("// {GENERATED_BY} from {from}. Do not edit.\n\n")
}

/// The header line of a file that comes from the definition that holds `span`.
fn header_of(context: &Context<'_>, package: &Package, span: Span) -> String {
    header(&format!("{} of {}", context.origins.path(span), package.name))
}

/// The header line of a file that comes from all definitions of a package.
fn header_of_package(package: &Package) -> String {
    header(&format!("the definitions of {}", package.name))
}

fn root(packages: &[(&Package, String, Modules)], options: &Options) -> String {
    let modules = packages.iter().map(|(package, module, _)| {
        let module = ident(module);
        let doc = documentation(&format!("Package `{}`.", package.name));
        // The layout of generated code is that of the generator.
        quote!(#doc #[rustfmt::skip] pub mod #module;)
    });
    let no_std = (options.root == "lib.rs").then(|| quote!(#![no_std]));
    let doc = inner_documentation(
        "Types of drone interface definitions, one module a package.\n\n\
         Every message implements [`Message`](::uavspec_runtime::Message), and those of fixed size also\n\
         [`UorbMessage`](::uavspec_runtime::UorbMessage). The features of the runtime decide what more they\n\
         have: `serde` gives all of them JSON in the form that the published JSON Schemas describe.",
    );
    let readme = options.readme.as_ref().map(|path| quote!(#![doc = include_str!(#path)]));
    let tokens = quote! {
        #doc
        #readme
        #no_std
        // Names and texts are those of the definitions.
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
    };
    header("the definitions") + &layout_file(tokens)
}

fn package_files(
    context: &Context<'_>,
    package: &Package,
    module: &str,
    modules: &Modules,
) -> Vec<OutputFile> {
    let mut files = Vec::new();
    let mut lines = vec![format!("Package `{}`, in the {} dialect.", package.name, package.form.name())];
    if let Some(origin) = &package.origin {
        lines.push(format!("Origin: {}.", prose::inline(origin)));
    }
    if let Some(revision) = &package.revision {
        lines.push(format!("Revision: {}.", prose::inline(revision)));
    }
    let doc = inner_documentation(&lines.join("\n\n"));
    let messages = modules.messages.iter().map(|(_, place)| {
        let doc = documentation(&format!(
            "[`{0}`](struct@{0}) and the types of its fields.",
            ident(&place.type_name)
        ));
        re_export(&doc, &place.modules[1], place.names())
    });
    let kinds: Vec<TokenStream> = [("srv", "Services."), ("action", "Actions.")]
        .into_iter()
        .filter(|(kind, _)| modules.interfaces.iter().any(|interface| interface.kind == *kind))
        .map(|(kind, text)| {
            let doc = documentation(text);
            let kind = ident(kind);
            quote!(#doc pub mod #kind;)
        })
        .collect();
    let mut error_codes = None;
    if !package.error_tables.is_empty() {
        let doc = documentation("Error codes.");
        error_codes = Some(re_export(&doc, "error_code", [&"ErrorCode".to_owned()]));
        let text = error_code::emit(context, package);
        files.push(OutputFile { path: format!("{module}/error_code.rs"), text });
    }
    let mut json = None;
    if json_type::has_content(package) {
        json = Some(json_type::declaration());
        files.append(&mut json_type::files(context, package, module));
    }
    let layouts = assert_layouts(context, &modules.messages);
    let tokens = quote!(#doc #error_codes #(#messages)* #(#kinds)* #json #layouts);
    let text = header_of_package(package) + &layout_file(tokens);
    files.push(OutputFile { path: format!("{module}.rs"), text });
    for kind in ["srv", "action"] {
        let of_kind: Vec<&InterfaceModule> =
            modules.interfaces.iter().filter(|interface| interface.kind == kind).collect();
        if !of_kind.is_empty() {
            files.push(OutputFile {
                path: format!("{module}/{kind}.rs"),
                text: kind_module(context, package, &of_kind),
            });
        }
    }
    for interface in &modules.interfaces {
        let path = format!("{module}/{}/{}.rs", interface.kind, interface.module);
        let from = &package.interfaces[interface.index];
        let doc = inner_documentation(&format!("The parts of {}.", prose::code(&from.name)));
        let parts: Vec<TokenStream> =
            interface.parts.iter().map(|(id, _)| message::tokens(context, *id)).collect();
        let text = header_of(context, package, from.span) + &layout_file(quote!(#doc #(#parts)*));
        files.push(OutputFile { path, text });
    }
    files
}

fn kind_module(context: &Context<'_>, package: &Package, interfaces: &[&InterfaceModule]) -> String {
    let what = if interfaces[0].kind == "srv" { "Services" } else { "Actions" };
    let doc = inner_documentation(&format!("{what} of package `{}`.", package.name));
    let modules = interfaces.iter().map(|interface| {
        let doc = documentation(&format!(
            "The parts of {}.",
            prose::code(&package.interfaces[interface.index].name)
        ));
        re_export(&doc, &interface.module, interface.parts.iter().flat_map(|(_, place)| place.names()))
    });
    let layouts = assert_layouts(context, interfaces.iter().flat_map(|interface| &interface.parts));
    header_of_package(package) + &layout_file(quote!(#doc #(#modules)* #layouts))
}

/// Has the compiler check the layouts of those messages of fixed size that nest others: of a layout without them the
/// generator knows everything.
fn assert_layouts<'p>(
    context: &Context<'_>,
    messages: impl IntoIterator<Item = &'p (MessageId, Place)>,
) -> Option<TokenStream> {
    let nests = |id: MessageId| {
        let fields = &context.schema.message(id).fields;
        fields.iter().any(|field| matches!(field.ty.element, Element::Message(_)))
    };
    let has_layout = |(id, place): &&(MessageId, Place)| !place.view_name.is_empty() && nests(*id);
    let names: Vec<_> =
        messages.into_iter().filter(has_layout).map(|(_, place)| ident(&place.type_name)).collect();
    (!names.is_empty()).then(|| quote!(::uavspec_runtime::assert_layouts! { #(#names;)* }))
}

fn re_export<'n>(
    doc: &TokenStream,
    module: &str,
    names: impl IntoIterator<Item = &'n String>,
) -> TokenStream {
    let module = ident(module);
    let names = names.into_iter().map(|name| ident(name));
    quote!(#doc pub mod #module; pub use self::#module::{#(#names),*};)
}

/// The files of all messages. Each is made on its own, so the work is shared out among the processors.
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
    let workers = thread::available_parallelism().map_or(1, NonZero::get);
    let share = ids.len().div_ceil(workers).max(1);
    thread::scope(|scope| {
        let work: Vec<_> = ids
            .chunks(share)
            .map(|ids| scope.spawn(move || ids.iter().map(file).collect::<Vec<_>>()))
            .collect();
        // A panic in a worker is a defect here, and goes on in the caller.
        work.into_iter()
            .flat_map(|worker| worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect()
    })
}

/// Tokens as text: laid out, with a blank line between items.
fn layout_file(tokens: TokenStream) -> String {
    let file: syn::File = match syn::parse2(imports::shorten(tokens)) {
        Ok(file) => file,
        // The tokens come from `quote` and identifiers alone; were they no Rust, the compiler says so.
        Err(error) => return format!("compile_error!({:?});\n", error.to_string()),
    };
    let attributes = file.attrs;
    let mut text = String::new();
    let head = syn::File { shebang: None, frontmatter: None, attrs: attributes, items: Vec::new() };
    for line in prettyplease::unparse(&head).lines() {
        push_line(line, &mut text);
    }
    let mut last_list = List::None;
    for item in file.items {
        let list = List::of(&item);
        if !text.is_empty() && (list == List::None || list != last_list) {
            text.push('\n');
        }
        last_list = list;
        if let syn::Item::Macro(call) = item {
            list_entries(&call, &mut text);
            continue;
        }
        let file = syn::File { shebang: None, frontmatter: None, attrs: Vec::new(), items: vec![item] };
        space_out(&prettyplease::unparse(&file), &mut text);
    }
    text
}

/// A list of items without blank lines in between.
#[derive(Clone, Copy, PartialEq, Eq)]
enum List {
    Imports,
    /// Modules, and what is re-exported from them.
    Modules,
    None,
}

impl List {
    fn of(item: &syn::Item) -> Self {
        match item {
            syn::Item::Use(item) if matches!(item.vis, syn::Visibility::Inherited) => Self::Imports,
            syn::Item::Mod(_) | syn::Item::Use(_) => Self::Modules,
            _ => Self::None,
        }
    }
}

/// Writes a macro call in braces with each entry on a line of its own: `name! { first; second; … }`.
fn list_entries(call: &syn::ItemMacro, text: &mut String) {
    let path = &call.mac.path;
    for (index, segment) in path.segments.iter().enumerate() {
        let separator = if index > 0 || path.leading_colon.is_some() { "::" } else { "" };
        let _ = write!(text, "{separator}{}", segment.ident);
    }
    text.push_str("! {\n");
    let mut line = String::new();
    for token in call.mac.tokens.clone() {
        let is_end = matches!(&token, TokenTree::Punct(punct) if punct.as_char() == ';');
        write_tokens(token.into(), &mut line);
        if is_end {
            push_entry(line.trim_end(), text);
            line.clear();
        }
    }
    text.push_str("}\n");
}

/// Writes an entry of a macro call. A long list of names is wrapped.
fn push_entry(entry: &str, text: &mut String) {
    let mut width = 0;
    for word in entry.split_inclusive(' ') {
        let is_wrapped = !entry.contains('"') && width + word.len() > 100;
        if width == 0 || is_wrapped {
            text.truncate(text.trim_end_matches(' ').len());
            text.push_str(if is_wrapped { "\n    " } else { "    " });
            width = 0;
        }
        text.push_str(word);
        width += word.len();
    }
    text.push('\n');
}

/// Writes tokens with spaces where people put them, and perhaps one after the last.
fn write_tokens(tokens: TokenStream, text: &mut String) {
    for token in tokens {
        match token {
            TokenTree::Group(group) => {
                let (open, close) = match group.delimiter() {
                    Delimiter::Parenthesis => ("(", ")"),
                    Delimiter::Bracket => ("[", "]"),
                    Delimiter::Brace => ("{", "}"),
                    Delimiter::None => ("", ""),
                };
                text.push_str(open);
                write_tokens(group.stream(), text);
                text.truncate(text.trim_end().len());
                text.push_str(close);
            }
            TokenTree::Punct(punct) => {
                let is_path = punct.spacing() == Spacing::Joint || text.ends_with(':');
                match punct.as_char() {
                    ':' if is_path => text.push(':'),
                    '!' => text.push_str(" !"),
                    '=' if text.ends_with('!') => text.push_str("= "),
                    '=' => text.push_str(" = "),
                    separator @ (':' | ',' | ';') => text.extend([separator, ' ']),
                    operator => text.push(operator),
                }
            }
            TokenTree::Ident(_) | TokenTree::Literal(_) => {
                if text.ends_with(|last: char| last.is_alphanumeric() || matches!(last, '_' | '"')) {
                    text.push(' ');
                }
                let _ = write!(text, "{token}");
            }
        }
    }
}

/// Puts a blank line after each function, impl and the like that another item follows.
fn space_out(item: &str, text: &mut String) {
    let mut closed_at = None;
    for line in item.lines() {
        let code = line.trim_start();
        let depth = line.len() - code.len();
        let starts_item = ["fn ", "pub ", "impl ", "impl<", "const ", "///", "#[", "::"]
            .iter()
            .any(|start| code.starts_with(start));
        if closed_at == Some(depth) && depth > 0 && starts_item {
            text.push('\n');
        }
        closed_at = (code == "}").then_some(depth);
        push_line(line, text);
    }
}

/// Stands for a line break in documentation until it is written: one attribute a comment is much
/// less to parse and to lay out than one a line. No text holds it, since [`prose`] replaces controls.
const LINE_BREAK: char = '\u{1}';

/// A documentation comment; the text is Markdown.
fn documentation(text: &str) -> TokenStream {
    let text = comment(text);
    quote!(#[doc = #text])
}

/// A documentation comment of the module that it stands in.
fn inner_documentation(text: &str) -> TokenStream {
    let text = comment(text);
    quote!(#![doc = #text])
}

fn comment(text: &str) -> String {
    let mut comment = String::with_capacity(text.len() + 1);
    for (index, line) in text.lines().enumerate() {
        if index > 0 {
            comment.push(LINE_BREAK);
        }
        if !line.is_empty() {
            comment.push(' ');
            comment.push_str(line);
        }
    }
    comment
}

/// Writes a line that may be a whole documentation comment.
fn push_line(line: &str, text: &mut String) {
    let mut lines = line.split(LINE_BREAK);
    let first = lines.next().unwrap_or_default();
    text.push_str(first);
    text.push('\n');
    // What the first line starts with: white space and `///` or `//!`.
    let start = &first[..first.find("//").map_or(0, |at| at + 3).min(first.len())];
    for line in lines {
        text.push_str(start);
        text.push_str(line);
        text.push('\n');
    }
}
