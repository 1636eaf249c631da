//! The imports between the modules of a crate, found in its sources.
//!
//! A module is a file. An import is any path from one file to another: in a `use` declaration, an expression or a
//! macro. Test-only modules are ignored.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use proc_macro2::{Delimiter, TokenStream, TokenTree};

/// The names of a module and its parents, outermost first; empty for the crate root.
type ModulePath = Vec<String>;

/// The modules of a crate, with the modules that each of them imports.
pub(crate) struct Imports(BTreeMap<ModulePath, BTreeSet<ModulePath>>);

impl Imports {
    /// Reads the crate with the root `src/lib.rs` in `folder`.
    ///
    /// # Panics
    ///
    /// Panics if a file can't be read, or is not valid Rust.
    pub(crate) fn read(folder: &Path) -> Self {
        Self::of(&|path| fs::read_to_string(folder.join("src").join(path)).ok())
    }

    /// Reads a crate. `text` returns the content of a file by its path below `src`.
    fn of(text: &dyn Fn(&str) -> Option<String>) -> Self {
        let mut files = BTreeMap::new();
        let mut open = vec![(ModulePath::new(), "lib.rs".to_owned())];
        while let Some((module, path)) = open.pop() {
            let text = text(&path).unwrap_or_else(|| panic!("{path} can't be read"));
            let tokens: TokenStream = text.parse().unwrap_or_else(|error| panic!("{path}: {error}"));
            let file = File::read(tokens);
            for child in &file.children {
                let module = [module.as_slice(), std::slice::from_ref(child)].concat();
                open.push((module.clone(), format!("{}.rs", module.join("/"))));
            }
            files.insert(module, file);
        }
        let modules: BTreeSet<ModulePath> = files.keys().cloned().collect();
        Self(files.iter().map(|(module, file)| (module.clone(), file.imports(module, &modules))).collect())
    }

    /// The imports that violate `layers`, the layers of modules from top to bottom. A module may import only modules in
    /// lower layers, and no module may import the root of the crate.
    pub(crate) fn upward(&self, layers: &[&[&str]]) -> Vec<String> {
        let layer = |module: &ModulePath| {
            let name = module.first()?;
            layers.iter().position(|modules| modules.contains(&name.as_str()))
        };
        let mut found = Vec::new();
        for (module, imports) in &self.0 {
            if module.len() == 1 && layer(module).is_none() {
                found.push(format!("{} is in no layer", module[0]));
            }
            let others = imports.iter().filter(|import| import.first() != module.first());
            for import in others.filter(|import| !module.is_empty() && layer(import) <= layer(module)) {
                found.push(format!("{} imports {}", shown(module), shown(import)));
            }
        }
        found
    }

    /// The cycles of imports between files.
    pub(crate) fn cycles(&self) -> Vec<String> {
        let mut found = Vec::new();
        let mut done = BTreeSet::new();
        for module in self.0.keys() {
            let reached = self.reached(module);
            if reached.contains(module) && done.insert(module) {
                let ring: Vec<&ModulePath> =
                    reached.iter().filter(|other| self.reached(other).contains(module)).collect();
                found.push(ring.iter().map(|module| shown(module)).collect::<Vec<_>>().join(", "));
                done.extend(self.0.keys().filter(|key| ring.contains(key)));
            }
        }
        found
    }

    /// The modules that `module` imports, directly or indirectly.
    fn reached(&self, module: &ModulePath) -> BTreeSet<ModulePath> {
        let mut reached = BTreeSet::new();
        let mut open: Vec<&ModulePath> = self.0[module].iter().collect();
        while let Some(next) = open.pop() {
            if reached.insert(next.clone()) {
                open.extend(&self.0[next]);
            }
        }
        reached
    }

    /// The imports between the entries of each folder. A file and the folder of the same name count as a single entry.
    pub(crate) fn between_siblings(&self) -> Vec<Self> {
        let folders: BTreeSet<&[String]> =
            self.0.keys().filter_map(|module| module.split_last()).map(|(_, folder)| folder).collect();
        folders.into_iter().map(|folder| self.within(folder)).collect()
    }

    fn within(&self, folder: &[String]) -> Self {
        let part = |module: &ModulePath| {
            (module.len() > folder.len() && module.starts_with(folder))
                .then(|| module[..=folder.len()].to_vec())
        };
        let mut parts: BTreeMap<ModulePath, BTreeSet<ModulePath>> = BTreeMap::new();
        for (module, imports) in &self.0 {
            let Some(from) = part(module) else { continue };
            let others = imports.iter().filter_map(part).filter(|other| *other != from);
            let others: Vec<ModulePath> = others.collect();
            parts.entry(from).or_default().extend(others);
        }
        Self(parts)
    }
}

fn shown(module: &ModulePath) -> String {
    if module.is_empty() { "the root".to_owned() } else { module.join("::") }
}

/// The paths and modules in a file.
#[derive(Default)]
struct File {
    /// The declared modules that have separate files.
    children: Vec<String>,
    /// The paths as written.
    paths: Vec<Vec<String>>,
    /// The target of each name that a `use` declaration introduces.
    names: BTreeMap<String, Vec<String>>,
}

impl File {
    fn read(tokens: TokenStream) -> Self {
        let mut file = Self::default();
        file.items(tokens);
        file
    }

    /// The modules that the file of `module` imports.
    fn imports(&self, module: &ModulePath, modules: &BTreeSet<ModulePath>) -> BTreeSet<ModulePath> {
        let imports = self.paths.iter().filter_map(|path| self.target(path, module, modules));
        imports.filter(|import| import != module).collect()
    }

    /// The module that a path refers to, or `None` for other crates and local names.
    fn target(
        &self,
        path: &[String],
        module: &ModulePath,
        modules: &BTreeSet<ModulePath>,
    ) -> Option<ModulePath> {
        let (first, mut rest) = path.split_first()?;
        let mut target = match first.as_str() {
            "crate" => ModulePath::new(),
            "self" => module.clone(),
            "super" => {
                let ups = rest.iter().take_while(|name| *name == "super").count();
                rest = &rest[ups..];
                module[..module.len().checked_sub(ups + 1)?].to_vec()
            }
            name if self.children.iter().any(|child| child == name) => {
                [module.as_slice(), &[name.to_owned()]].concat()
            }
            name => {
                let used = self.names.get(name).filter(|used| used[0] != *name)?;
                self.target(used, module, modules)?
            }
        };
        for name in rest {
            target.push(name.clone());
            if !modules.contains(&target) {
                target.pop();
                break;
            }
        }
        Some(target)
    }

    fn items(&mut self, tokens: TokenStream) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let mut at = 0;
        while at < tokens.len() {
            at = self.item(&tokens, at);
        }
    }

    /// Reads the item that starts at `at`, and returns its end.
    fn item(&mut self, tokens: &[TokenTree], at: usize) -> usize {
        let word = word(tokens, at);
        match &tokens[at] {
            TokenTree::Punct(mark) if mark.as_char() == '#' => match tokens.get(at + 1) {
                Some(TokenTree::Group(group)) if group.stream().to_string() == "cfg (test)" => {
                    end_of_item(tokens, at + 2)
                }
                // Attributes contain no imports.
                Some(TokenTree::Group(_)) => at + 2,
                _ => at + 1,
            },
            // `pub(in crate::emit)` restricts visibility; it is not an import.
            TokenTree::Ident(_) if word == "pub" => match tokens.get(at + 1) {
                Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Parenthesis => at + 2,
                _ => at + 1,
            },
            // Quoted tokens are output of the program, not imports.
            TokenTree::Ident(_) if word == "quote" && is_mark(tokens, at + 1, '!') => at + 3,
            TokenTree::Ident(_) if word == "use" => {
                let end = end_of_item(tokens, at);
                self.uses(&[], &tokens[at + 1..end]);
                end
            }
            TokenTree::Ident(_) if word == "mod" && is_mark(tokens, at + 2, ';') => {
                self.children.push(self::word(tokens, at + 1));
                at + 3
            }
            TokenTree::Ident(_) => {
                let path = path(tokens, at);
                // A single name is not a path. After `.` or `::`, it belongs to the previous tokens.
                let is_start = at == 0 || !(is_mark(tokens, at - 1, '.') || is_mark(tokens, at - 1, ':'));
                let end = at + 3 * path.len() - 2;
                if path.len() > 1 && is_start {
                    self.paths.push(path);
                }
                end
            }
            TokenTree::Group(group) => {
                self.items(group.stream());
                at + 1
            }
            TokenTree::Punct(_) | TokenTree::Literal(_) => at + 1,
        }
    }

    /// Reads the tree of a `use` declaration after the path `before`.
    fn uses(&mut self, before: &[String], tokens: &[TokenTree]) {
        for tree in tokens.split(|token| matches!(token, TokenTree::Punct(mark) if mark.as_char() == ',')) {
            let start = tree.iter().position(|token| !matches!(token, TokenTree::Punct(_))).unwrap_or(0);
            let tree = &tree[start..];
            if tree.is_empty() {
                continue;
            }
            let mut path = [before, &path(tree, 0)].concat();
            if let Some(TokenTree::Group(group)) =
                tree.iter().find(|token| matches!(token, TokenTree::Group(_)))
            {
                let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                self.uses(&path, &inner);
                continue;
            }
            if path.len() > 1 && path.last().is_some_and(|name| name == "self") {
                path.pop();
            }
            let renamed = (0..tree.len()).find(|at| word(tree, *at) == "as").map(|at| word(tree, at + 1));
            if let Some(name) = renamed.or_else(|| path.last().cloned()) {
                self.names.insert(name, path.clone());
            }
            self.paths.push(path);
        }
    }
}

fn word(tokens: &[TokenTree], at: usize) -> String {
    match tokens.get(at) {
        Some(TokenTree::Ident(word)) => word.to_string(),
        _ => String::new(),
    }
}

fn is_mark(tokens: &[TokenTree], at: usize, mark: char) -> bool {
    matches!(tokens.get(at), Some(TokenTree::Punct(found)) if found.as_char() == mark)
}

/// The names joined by `::`, starting at `at`.
fn path(tokens: &[TokenTree], mut at: usize) -> Vec<String> {
    let mut path = Vec::new();
    while let Some(TokenTree::Ident(name)) = tokens.get(at) {
        path.push(name.to_string());
        if !is_mark(tokens, at + 1, ':') || !is_mark(tokens, at + 2, ':') {
            break;
        }
        at += 3;
    }
    path
}

/// The end of the item that starts at `at`: after its `;` or braces.
fn end_of_item(tokens: &[TokenTree], at: usize) -> usize {
    let is_use = (at..tokens.len()).map(|at| word(tokens, at)).find(|word| !word.is_empty() && word != "pub");
    let is_use = is_use.is_some_and(|word| word == "use");
    let is_end = |token: &TokenTree| match token {
        TokenTree::Punct(mark) => mark.as_char() == ';',
        TokenTree::Group(group) => !is_use && group.delimiter() == Delimiter::Brace,
        TokenTree::Ident(_) | TokenTree::Literal(_) => false,
    };
    tokens[at..].iter().position(is_end).map_or(tokens.len(), |end| at + end + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn imports(files: &[(&str, &str)]) -> Imports {
        Imports::of(&|path| files.iter().find(|(name, _)| *name == path).map(|(_, text)| (*text).to_owned()))
    }

    #[test]
    fn finds_all_kinds_of_imports() {
        let found = imports(&[
            ("lib.rs", "pub mod a; mod b; mod c; mod d; mod e; mod f;"),
            (
                "a.rs",
                "use crate::{b::{self, Text}, c as other}; fn f(x: other::X) { super::d::g(e!(crate::e::h)) }",
            ),
            ("b.rs", "/// [`crate::a`]\npub(in crate::a) struct S; const TEXT: &str = \"crate::a\";"),
            ("c.rs", "mod inner; use super::f; #[cfg(test)] mod tests { use crate::a; }"),
            ("c/inner.rs", "use super::super::d; fn f() { std::a::b(); x.a::<u8>(); d::g() }"),
            ("d.rs", "#[cfg(test)]\nuse crate::a;\n#[cfg(test)]\nmod tests;"),
            ("e.rs", "use std::fmt; macro_rules! m { () => { $crate::f::g() } }"),
            ("f.rs", "#[cfg(feature = \"x\")] use crate::Root; fn f() { quote! { crate::a::A } }"),
        ]);
        let named = |module: &ModulePath| found.0[module].iter().map(shown).collect::<Vec<_>>().join(" ");
        let all: Vec<String> =
            found.0.keys().map(|module| format!("{}: {}", shown(module), named(module))).collect();
        assert_eq!(
            all,
            ["the root: ", "a: b c d e", "b: ", "c: f", "c::inner: d", "d: ", "e: f", "f: the root"]
        );
    }

    #[test]
    fn finds_upward_imports() {
        let files =
            [("lib.rs", "mod a; mod b; mod c;"), ("a.rs", "use crate::b::X;"), ("b.rs", ""), ("c.rs", "")];
        assert!(imports(&files).upward(&[&["a"], &["b", "c"]]).is_empty());
        assert_eq!(imports(&files).upward(&[&["b"], &["a", "c"]]), ["a imports b"]);
        assert_eq!(imports(&files).upward(&[&["a", "b"], &["c"]]), ["a imports b"]);
        assert_eq!(imports(&files).upward(&[&["a"], &["b"]]), ["c is in no layer"]);
    }

    #[test]
    fn finds_cycles_between_files_and_folders() {
        let found = imports(&[
            ("lib.rs", "mod a; mod b;"),
            ("a.rs", "mod x; mod y;"),
            ("a/x.rs", "use super::y::Y; use crate::b::B;"),
            ("a/y.rs", "use super::x::X;"),
            ("b.rs", "use crate::a::y::Y;"),
        ]);
        assert_eq!(found.cycles(), ["a::x, a::y, b"]);
        let levels: Vec<Vec<String>> = found.between_siblings().iter().map(Imports::cycles).collect();
        assert_eq!(levels, [vec!["a, b".to_owned()], vec!["a::x, a::y".to_owned()]]);
    }
}
