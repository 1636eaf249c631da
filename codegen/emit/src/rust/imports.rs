//! `use` declarations. Emitters write full paths; this module shortens them and adds the imports.
//!
//! Names that the file declares are not imported, so a message may have a name such as `Option` or `String`.

use std::collections::{BTreeMap, BTreeSet};

use proc_macro2::{Group, Spacing, TokenStream, TokenTree};
use quote::quote;

use super::identifier::ident;

/// The crates whose paths are shortened.
const CRATES: [&str; 2] = ["core", "uavspec_runtime"];

/// The runtime module that is enabled by a feature. Without the feature, its imports would be unused.
const VIEWS: [&str; 2] = ["uavspec_runtime", "view"];

/// Names of `core` that are in the prelude.
const PRELUDE: [&str; 9] = [
    "Default",
    "DoubleEndedIterator",
    "ExactSizeIterator",
    "From",
    "Iterator",
    "None",
    "Option",
    "Some",
    "write",
];

/// Keywords that may precede a path. Any other identifier before `::` is part of the path.
const BEFORE_PATH: [&str; 8] = ["as", "const", "dyn", "for", "impl", "in", "mut", "return"];

/// Shortens the paths in a file, and declares its imports after the inner attributes.
pub(super) fn shorten(file: TokenStream) -> TokenStream {
    let mut tokens: Vec<TokenTree> = file.into_iter().collect();
    let mut imports = Imports { declared: declared(&tokens), used: BTreeMap::new() };
    // An attribute consists of `#`, `!` and a bracketed group.
    let is_attribute = |part: &&[TokenTree]| is_punct(part.first(), '#') && is_punct(part.get(1), '!');
    let attributes = tokens.chunks(3).take_while(is_attribute).count() * 3;
    let items = tokens.split_off(attributes.min(tokens.len()));
    let items = imports.shorten(items);
    let uses = imports.declarations();
    let attributes: TokenStream = tokens.into_iter().collect();
    quote!(#attributes #uses #items)
}

struct Imports {
    /// Names that the file declares.
    declared: BTreeSet<String>,
    /// The module from which each short name is imported, or `None` for a name in the prelude.
    used: BTreeMap<String, Option<Vec<String>>>,
}

impl Imports {
    /// Shortens paths in tokens and nested groups.
    fn shorten(&mut self, tokens: Vec<TokenTree>) -> TokenStream {
        let mut short = Vec::with_capacity(tokens.len());
        let mut tokens = tokens.into_iter();
        loop {
            let rest = tokens.as_slice();
            let path = if may_precede_path(&short) { segments(rest) } else { Vec::new() };
            let is_macro = is_punct(rest.get(3 * path.len()), '!');
            if let Some(remaining) = self.import(&path, is_macro) {
                // A segment consists of two colons and a name. The first remaining segment loses its colons.
                let removed = 3 * (path.len() - remaining) + 2;
                short.extend(tokens.by_ref().take(3 * path.len()).skip(removed));
                continue;
            }
            short.push(match tokens.next() {
                None => break,
                Some(TokenTree::Group(group)) => {
                    let (delimiter, content) = (group.delimiter(), group.stream());
                    // Drop the group first; otherwise, its tokens would be copied.
                    drop(group);
                    let content = self.shorten(content.into_iter().collect());
                    Group::new(delimiter, content).into()
                }
                Some(other) => other,
            });
        }
        short.into_iter().collect()
    }

    /// Imports the name that shortens a path. Returns the number of remaining segments, or `None` if the path can't be
    /// shortened.
    fn import(&mut self, path: &[String], is_macro: bool) -> Option<usize> {
        let root = path.first().filter(|root| CRATES.contains(&root.as_str()))?;
        let (name, rest) = imported(path, is_macro)?;
        let is_prelude = root == "core" && PRELUDE.contains(&path[name].as_str());
        let module = (!is_prelude).then(|| path[..name].to_vec());
        let short = &path[name];
        if self.declared.contains(short) || self.declared.contains(root) {
            return None;
        }
        let known = self.used.entry(short.clone()).or_insert_with(|| module.clone());
        (*known == module).then_some(rest)
    }

    /// Creates one declaration per module.
    fn declarations(&self) -> TokenStream {
        let mut modules: BTreeMap<&[String], Vec<&String>> = BTreeMap::new();
        for (name, module) in &self.used {
            if let Some(module) = module {
                modules.entry(module).or_default().push(name);
            }
        }
        let mut modules: Vec<_> = modules.into_iter().collect();
        // Nested modules come before their parent, and optional imports last.
        let key = |module: &[String]| module.iter().cloned().chain(["~".to_owned()]).collect::<Vec<_>>();
        modules.sort_by_cached_key(|(module, _)| (*module == VIEWS, key(module)));
        let declarations = modules.into_iter().map(|(module, names)| {
            let is_optional = module == VIEWS;
            let segments = module.iter().map(|segment| ident(segment));
            let path = quote!(#(#segments::)*);
            let names = names.into_iter().map(|name| ident(name));
            if is_optional {
                quote!(uavspec_runtime::with_views! { #(use #path #names;)* })
            } else {
                quote!(use #path {#(#names),*};)
            }
        });
        declarations.collect()
    }
}

/// The index of the imported segment, and the number of segments from that index on.
fn imported(path: &[String], is_macro: bool) -> Option<(usize, usize)> {
    let last = path.len().checked_sub(1)?;
    let name = match path.iter().position(|segment| is_type(segment)) {
        // Keep the prefix of `fmt::Result`, which is a different type from `Result`.
        Some(_) if path[..last].ends_with(&["fmt".to_owned()]) => last - 1,
        Some(_) if matches!(path[last].as_str(), "None" | "Some") => last,
        Some(first) => first,
        None if is_macro => last,
        // Keep the module of a function as a prefix.
        None => last.checked_sub(1)?,
    };
    (name > 0).then_some((name, path.len() - name))
}

fn is_type(name: &str) -> bool {
    name.starts_with(|first: char| first.is_ascii_uppercase())
}

/// The names that a file declares or re-exports.
fn declared(tokens: &[TokenTree]) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    let mut at = 0;
    while let Some(token) = tokens.get(at) {
        at += 1;
        let TokenTree::Ident(word) = token else { continue };
        let rest = &tokens[at..];
        match (word.to_string().as_str(), rest) {
            ("enum" | "mod" | "static" | "struct", [TokenTree::Ident(name), ..]) => {
                names.insert(name.to_string());
            }
            ("use", _) => {
                let end = rest.iter().position(|token| is_punct(Some(token), ';')).unwrap_or(rest.len());
                collect_names(rest[..end].iter().cloned().collect(), &mut names);
            }
            // A macro call declares the types that are listed before its first semicolon.
            (_, [TokenTree::Punct(mark), TokenTree::Group(call), ..]) if mark.as_char() == '!' => {
                let head = call.stream().into_iter().take_while(|token| !is_punct(Some(token), ';'));
                let mut found = BTreeSet::new();
                collect_names(head.collect(), &mut found);
                names.extend(found.into_iter().filter(|name| is_type(name)));
            }
            _ => {}
        }
    }
    names
}

fn collect_names(tokens: TokenStream, names: &mut BTreeSet<String>) {
    for token in tokens {
        match token {
            TokenTree::Ident(name) => drop(names.insert(name.to_string())),
            TokenTree::Group(group) => collect_names(group.stream(), names),
            TokenTree::Punct(_) | TokenTree::Literal(_) => {}
        }
    }
}

/// True if `::` after these tokens starts a path, and doesn't continue one.
fn may_precede_path(tokens: &[TokenTree]) -> bool {
    match tokens {
        [.., TokenTree::Ident(word)] => BEFORE_PATH.contains(&word.to_string().as_str()),
        // The `>` of `->`, not of `<T>`.
        [before @ .., TokenTree::Punct(mark)] if mark.as_char() == '>' => is_punct(before.last(), '-'),
        _ => true,
    }
}

/// The segments of a path with a leading `::`, or an empty list.
fn segments(tokens: &[TokenTree]) -> Vec<String> {
    let name = |part: &[TokenTree]| match part {
        [TokenTree::Punct(first), TokenTree::Punct(second), TokenTree::Ident(name)]
            if first.as_char() == ':' && first.spacing() == Spacing::Joint && second.as_char() == ':' =>
        {
            Some(name.to_string())
        }
        _ => None,
    };
    tokens.chunks(3).map_while(name).collect()
}

fn is_punct(token: Option<&TokenTree>, mark: char) -> bool {
    matches!(token, Some(TokenTree::Punct(punct)) if punct.as_char() == mark)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shortened(file: &str) -> String {
        let tokens: TokenStream = file.parse().expect("tokens");
        shorten(tokens).to_string().replace(' ', "")
    }

    #[test]
    fn imports_names_with_one_declaration_per_module() {
        let found = shortened(
            "#![allow(x)] struct A { a: ::uavspec_runtime::alloc::vec::Vec<::core::option::Option<u8>>, b: \
             ::uavspec_runtime::Text<3> } impl ::uavspec_runtime::Message for A { fn f() -> ::core::fmt::Result { \
             g(::core::option::Option::Some(::core::array::from_fn(|_| ::core::default::Default::default()))) } } \
             ::uavspec_runtime::record! { A; }",
        );
        let expected = "#![allow(x)]usecore::{array,fmt};useuavspec_runtime::alloc::vec::{Vec};\
                        useuavspec_runtime::{Message,Text,record};structA{a:Vec<Option<u8>>,b:Text<3>}implMessageforA{fnf()->\
                        fmt::Result{g(Some(array::from_fn(|_|Default::default())))}}record!{A;}";
        assert_eq!(found, expected);
    }

    #[test]
    fn imports_names_of_views_only_if_views_are_enabled() {
        let found =
            shortened("::uavspec_runtime::record! { A; 0 a: ::uavspec_runtime::view::Elements<'b, u8, 2>; }");
        let expected = "useuavspec_runtime::{record};uavspec_runtime::with_views!{useuavspec_runtime::view::Elements;}\
                        record!{A;0a:Elements<'b,u8,2>;}";
        assert_eq!(found, expected);
    }

    #[test]
    fn does_not_import_names_that_the_file_declares() {
        for declaration in [
            "struct Text;",
            "enum Text {}",
            "mod Text;",
            "pub use self::a::{B, Text};",
            "::uavspec_runtime::record! { A, Text, 1, 1; }",
            "::other::open! { Text: u8 flags; }",
            "mod uavspec_runtime;",
        ] {
            let found = shortened(&format!("{declaration} type B = ::uavspec_runtime::Text<1>;"));
            assert!(found.ends_with("typeB=::uavspec_runtime::Text<1>;"), "{found}");
        }
        let found = shortened("struct Some(u8); const A: T = ::core::option::Option::Some(1);");
        assert!(found.contains("::core::option::Option::Some(1)"), "{found}");
        let found = shortened("type A = ::core::a::X; type B = ::core::b::X;");
        assert_eq!(found, "usecore::a::{X};typeA=X;typeB=::core::b::X;");
    }

    #[test]
    fn does_not_change_other_paths() {
        for file in
            ["type A = super::core::fmt::B;", "type A = ::other::fmt::B;", "type A = <B>::core::fmt::C;"]
        {
            assert_eq!(shortened(file), file.replace(' ', ""));
        }
    }
}
