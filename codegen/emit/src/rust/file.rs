//! The text of a generated file: a header and formatted tokens.

use std::fmt::Write as _;

use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};
use quote::quote;
use uavspec_schema::span::Span;
use uavspec_schema::{Package, prose};

use super::context::Context;
use super::identifier::ident;
use super::imports;
use crate::file::notice;

/// The header of a generated file.
pub(super) fn header(from: &str) -> String {
    // Replace line breaks in a path, which would end the comment.
    let from: String = from.chars().map(prose::visible).collect();
    format!("// {}\n\n", notice(&from))
}

/// The header of a file generated from the definition that contains `span`.
pub(super) fn header_of(context: &Context<'_>, package: &Package, span: Span) -> String {
    header(&format!("{} of {}", context.origins.path(span), package.name))
}

/// The header of a file generated from all definitions of a package.
pub(super) fn header_of_package(package: &Package) -> String {
    header(&format!("the definitions of {}", package.name))
}

/// The declaration of a public module in the module `parent`. Names come from definitions, so the names of both modules
/// may be equal.
pub(super) fn module_declaration(parent: &str, module: &str) -> TokenStream {
    let allowed = (parent == module).then(|| quote!(#[allow(clippy::module_inception)]));
    let module = ident(module);
    quote!(#allowed pub mod #module;)
}

/// Formats tokens, with blank lines between items.
pub(super) fn layout_file(tokens: TokenStream) -> String {
    let file: syn::File = match syn::parse2(imports::shorten(tokens)) {
        Ok(file) => file,
        // The tokens come from `quote` and identifiers only. If they are invalid, the compiler reports the error.
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
            list_entries(call.mac, &mut text);
            continue;
        }
        let file = syn::File { shebang: None, frontmatter: None, attrs: Vec::new(), items: vec![item] };
        space_out(&prettyplease::unparse(&file), &mut text);
    }
    text
}

/// A kind of item that is listed without blank lines.
#[derive(Clone, Copy, PartialEq, Eq)]
enum List {
    Imports,
    /// Modules and their re-exports.
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

/// Writes a macro call in braces with each entry on a separate line: `name! { first; second; … }`.
fn list_entries(call: syn::Macro, text: &mut String) {
    for (index, segment) in call.path.segments.iter().enumerate() {
        let separator = if index > 0 || call.path.leading_colon.is_some() { "::" } else { "" };
        let _ = write!(text, "{separator}{}", segment.ident);
    }
    text.push_str("! {\n");
    let mut line = String::new();
    for token in call.tokens {
        let is_end = matches!(&token, TokenTree::Punct(punct) if punct.as_char() == ';');
        write_token(token, &mut line);
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

/// Writes a token with conventional spacing, possibly followed by a space.
fn write_token(token: TokenTree, text: &mut String) {
    match token {
        TokenTree::Group(group) => {
            let (open, close) = match group.delimiter() {
                Delimiter::Parenthesis => ("(", ")"),
                Delimiter::Bracket => ("[", "]"),
                Delimiter::Brace => ("{", "}"),
                Delimiter::None => ("", ""),
            };
            text.push_str(open);
            group.stream().into_iter().for_each(|token| write_token(token, text));
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

/// Inserts a blank line between functions, impl blocks and similar items.
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

/// Represents a line break in documentation until the file is written. Each comment is one attribute, which is faster
/// to parse and format than one attribute per line. Texts can't contain this character, because `prose` replaces
/// control characters.
const LINE_BREAK: char = '\u{1}';

/// A documentation comment. The text is Markdown.
pub(super) fn documentation(text: &str) -> TokenStream {
    let text = comment(text);
    quote!(#[doc = #text])
}

/// A documentation comment of the enclosing module.
pub(super) fn inner_documentation(text: &str) -> TokenStream {
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

/// Writes a line that may contain a complete documentation comment.
fn push_line(line: &str, text: &mut String) {
    let mut lines = line.split(LINE_BREAK);
    let first = lines.next().unwrap_or_default();
    text.push_str(first);
    text.push('\n');
    // The prefix of each line: white space and `///` or `//!`. Other lines may contain `//` in a string.
    let indent = first.len() - first.trim_start().len();
    let start = first.get(..indent + "///".len()).filter(|start| start.contains("//")).unwrap_or_default();
    for line in lines {
        text.push_str(start);
        text.push_str(line);
        text.push('\n');
    }
}
