//! Lists the public items of a crate from its sources.
//!
//! The list contains no signatures, no trait implementations and no items defined by macros. An item of a private
//! module is listed under each path that re-exports it. If an item is public under another path, its re-export takes
//! only one line.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use syn::{Attribute, Fields, Ident, ImplItem, Item, Meta, TraitItem, Type, UseTree, Visibility};

/// The modules of a crate by path, such as `uavspec_emit::rust`.
pub(super) struct Crate {
    name: String,
    modules: BTreeMap<String, Module>,
}

struct Module {
    items: Vec<Item>,
    /// True if the module and all its parents are `pub`.
    public: bool,
    /// The `cfg` conditions of the module and all its parents.
    conditions: Vec<String>,
}

impl Crate {
    /// Reads a crate from its root file.
    pub(super) fn read(name: &str, root: &Path) -> Self {
        let text = fs::read_to_string(root).expect("the root of a crate");
        Self::parse(name, &text, root.parent().expect("a folder"))
    }

    /// Parses the root file of a crate; the files of its modules are in `folder`.
    pub(super) fn parse(name: &str, text: &str, folder: &Path) -> Self {
        let mut this = Self { name: name.to_owned(), modules: BTreeMap::new() };
        let items = syn::parse_file(text).expect("Rust").items;
        this.add(name, Module { items, public: true, conditions: Vec::new() }, folder);
        this
    }

    /// Adds a module and its submodules, whose files are in `folder`.
    fn add(&mut self, path: &str, mut module: Module, folder: &Path) {
        for item in &mut module.items {
            let Item::Mod(inner) = item else { continue };
            let Some(conditions) = conditions(&module.conditions, &inner.attrs) else { continue };
            let name = inner.ident.to_string();
            let folder = folder.join(&name);
            let items = inner.content.take().map_or_else(|| items(&folder), |(_, items)| items);
            let public = module.public && is_public(&inner.vis);
            self.add(&format!("{path}::{name}"), Module { items, public, conditions }, &folder);
        }
        self.modules.insert(path.to_owned(), module);
    }

    /// The public items, one per line, sorted by path.
    pub(super) fn public_items(&self) -> Vec<String> {
        let mut listing = Listing { of: self, lines: BTreeSet::new() };
        listing.module(&self.name, &self.name, &[]);
        for module in self.modules.values() {
            for item in &module.items {
                let Item::Macro(item) = item else { continue };
                let is_exported =
                    item.attrs.iter().any(|attribute| attribute.path().is_ident("macro_export"));
                if let (true, Some(name)) = (is_exported, &item.ident) {
                    let shown = format!("{}::{name}", self.name);
                    listing.line("macro", &shown, &module.conditions, &item.attrs);
                }
            }
        }
        listing.lines.into_iter().map(|(_, line)| line).collect()
    }

    /// The path of the definition that `path` refers to in `module`, or `None` if another crate defines it.
    fn resolve(&self, module: &str, path: &[String]) -> Option<String> {
        let Some((first, rest)) = path.split_first() else { return Some(module.to_owned()) };
        let next = match first.as_str() {
            "crate" => self.name.clone(),
            "self" => module.to_owned(),
            "super" => module.rsplit_once("::")?.0.to_owned(),
            name => self.look_up(module, name)?,
        };
        self.resolve(&next, rest)
    }

    /// The path of the definition with this name in a module, including imported names.
    fn look_up(&self, module: &str, name: &str) -> Option<String> {
        let items = &self.modules.get(module)?.items;
        if items.iter().filter_map(parts).any(|(_, _, _, ident)| ident == name) {
            return Some(format!("{module}::{name}"));
        }
        let uses =
            items.iter().filter_map(|item| if let Item::Use(item) = item { Some(&item.tree) } else { None });
        // `use name::…` in a module without `name` refers to another crate.
        let target = uses.flat_map(leaves).find(|(target, alias)| alias == name && target[0] != name)?.0;
        self.resolve(module, &target)
    }
}

/// The list of a crate's public items.
struct Listing<'c> {
    of: &'c Crate,
    /// The lines, each with its sort key.
    lines: BTreeSet<(String, String)>,
}

impl Listing<'_> {
    /// Adds a line for an item with the path `shown`, unless its attributes hide it. Returns all `cfg` conditions of
    /// the item.
    fn line(&mut self, kind: &str, shown: &str, outer: &[String], own: &[Attribute]) -> Option<Vec<String>> {
        let all = conditions(outer, own)?;
        let suffix: String = all.iter().map(|condition| format!(" ({condition})")).collect();
        self.lines.insert((shown.to_owned(), format!("{kind} {shown}{suffix}")));
        Some(all)
    }

    /// Lists the public items of `module` under the path `shown`.
    fn module(&mut self, module: &str, shown: &str, outer: &[String]) {
        let Module { items, conditions: own, .. } = &self.of.modules[module];
        let outer = joined(outer, own);
        for item in items {
            match item {
                Item::Use(item) if is_public(&item.vis) => {
                    let Some(outer) = conditions(&outer, &item.attrs) else { continue };
                    for (target, name) in leaves(&item.tree) {
                        assert_ne!(name, "*", "glob re-exports are not supported: {}", target.join("::"));
                        self.reexport(module, &target, shown, &name, &outer);
                    }
                }
                Item::ExternCrate(item) if is_public(&item.vis) => {
                    self.line("use", &format!("{shown}::{}", item.ident), &outer, &item.attrs);
                }
                _ => self.item(module, item, shown, None, &outer),
            }
        }
    }

    /// Lists the target of a `pub use` in `module` under the path `outside::name`.
    fn reexport(&mut self, module: &str, target: &[String], outside: &str, name: &str, outer: &[String]) {
        let modules = &self.of.modules;
        let is_private = |path: &str| modules.get(path).is_some_and(|module| !module.public);
        let shown = format!("{outside}::{name}");
        let found = self.of.resolve(module, target).unwrap_or_else(|| target.join("::"));
        match found.rsplit_once("::") {
            _ if is_private(&found) => {
                self.line("mod", &shown, outer, &[]);
                self.module(&found, &shown, outer);
            }
            Some((home, original)) if is_private(home) => {
                let outer = joined(outer, &modules[home].conditions);
                for item in &modules[home].items {
                    if parts(item).is_some_and(|(_, _, _, ident)| ident == original) {
                        self.item(home, item, outside, Some(name), &outer);
                    }
                }
            }
            _ => {
                self.line("use", &format!("{shown} = {found}"), outer, &[]);
            }
        }
    }

    /// Lists a public item of `module` under the path `outside`, with its members.
    fn item(&mut self, module: &str, item: &Item, outside: &str, alias: Option<&str>, outer: &[String]) {
        let Some((kind, attributes, visibility, ident)) = parts(item) else { return };
        if !is_public(visibility) {
            return;
        }
        let shown = format!("{outside}::{}", alias.map_or_else(|| ident.to_string(), str::to_owned));
        let Some(outer) = self.line(kind, &shown, outer, attributes) else { return };
        let defined = format!("{module}::{ident}");
        match item {
            Item::Mod(_) => self.module(&defined, &shown, &outer),
            Item::Struct(item) => {
                self.fields(&item.fields, &shown, false, &outer);
                self.methods(&defined, &shown, &outer);
            }
            Item::Enum(item) => {
                for variant in &item.variants {
                    let shown = format!("{shown}::{}", variant.ident);
                    let Some(outer) = self.line("variant", &shown, &outer, &variant.attrs) else { continue };
                    self.fields(&variant.fields, &shown, true, &outer);
                }
                self.methods(&defined, &shown, &outer);
            }
            Item::Trait(item) => {
                for item in &item.items {
                    let (kind, attributes, ident) = match item {
                        TraitItem::Fn(item) => ("fn", &item.attrs, &item.sig.ident),
                        TraitItem::Const(item) => ("const", &item.attrs, &item.ident),
                        TraitItem::Type(item) => ("type", &item.attrs, &item.ident),
                        _ => continue,
                    };
                    self.line(kind, &format!("{shown}::{ident}"), &outer, attributes);
                }
            }
            _ => {}
        }
    }

    /// Lists public fields, and the named fields of a variant.
    fn fields(&mut self, fields: &Fields, shown: &str, in_variant: bool, outer: &[String]) {
        for (index, field) in fields.iter().enumerate() {
            let name = field.ident.as_ref().map_or_else(|| index.to_string(), Ident::to_string);
            if in_variant && field.ident.is_some() || is_public(&field.vis) {
                self.line("field", &format!("{shown}::{name}"), outer, &field.attrs);
            }
        }
    }

    /// Lists the public associated items of the type at the path `defined`, from all files.
    fn methods(&mut self, defined: &str, shown: &str, outer: &[String]) {
        for (path, module) in &self.of.modules {
            for item in &module.items {
                let Item::Impl(block) = item else { continue };
                let (Type::Path(ty), None) = (&*block.self_ty, &block.trait_) else { continue };
                let ty: Vec<String> = ty.path.segments.iter().map(|part| part.ident.to_string()).collect();
                if self.of.resolve(path, &ty).as_deref() != Some(defined) {
                    continue;
                }
                let outer = joined(outer, &module.conditions);
                let Some(outer) = conditions(&outer, &block.attrs) else { continue };
                for item in &block.items {
                    let (kind, attributes, visibility, ident) = match item {
                        ImplItem::Fn(item) => ("fn", &item.attrs, &item.vis, &item.sig.ident),
                        ImplItem::Const(item) => ("const", &item.attrs, &item.vis, &item.ident),
                        _ => continue,
                    };
                    if is_public(visibility) {
                        self.line(kind, &format!("{shown}::{ident}"), &outer, attributes);
                    }
                }
            }
        }
    }
}

/// The items of the module with this folder path, from its file.
fn items(folder: &Path) -> Vec<Item> {
    let files: [PathBuf; 2] = [folder.with_extension("rs"), folder.join("mod.rs")];
    let text = files.iter().find_map(|file| fs::read_to_string(file).ok());
    syn::parse_file(&text.unwrap_or_else(|| panic!("no file for {}", folder.display()))).expect("Rust").items
}

/// The conditions of an item, appended to the conditions of its parents, or `None` if the item is hidden or test-only.
fn conditions(outer: &[String], attributes: &[Attribute]) -> Option<Vec<String>> {
    let mut own = Vec::new();
    for attribute in attributes {
        let Meta::List(list) = &attribute.meta else { continue };
        let tokens = list.tokens.to_string();
        if list.path.is_ident("cfg") && tokens == "test" || list.path.is_ident("doc") && tokens == "hidden" {
            return None;
        }
        if list.path.is_ident("cfg") {
            own.push(tokens);
        }
    }
    Some(joined(outer, &own))
}

/// Both lists of conditions, without duplicates.
fn joined(outer: &[String], inner: &[String]) -> Vec<String> {
    outer.iter().chain(inner.iter().filter(|condition| !outer.contains(condition))).cloned().collect()
}

fn is_public(visibility: &Visibility) -> bool {
    matches!(visibility, Visibility::Public(_))
}

/// The kind, attributes, visibility and name of an item that other modules can name.
fn parts(item: &Item) -> Option<(&'static str, &[Attribute], &Visibility, &Ident)> {
    Some(match item {
        Item::Const(item) => ("const", &item.attrs, &item.vis, &item.ident),
        Item::Enum(item) => ("enum", &item.attrs, &item.vis, &item.ident),
        Item::Fn(item) => ("fn", &item.attrs, &item.vis, &item.sig.ident),
        Item::Mod(item) => ("mod", &item.attrs, &item.vis, &item.ident),
        Item::Static(item) => ("static", &item.attrs, &item.vis, &item.ident),
        Item::Struct(item) => ("struct", &item.attrs, &item.vis, &item.ident),
        Item::Trait(item) => ("trait", &item.attrs, &item.vis, &item.ident),
        Item::Type(item) => ("type", &item.attrs, &item.vis, &item.ident),
        _ => return None,
    })
}

/// The imported paths, each with its local name.
fn leaves(tree: &UseTree) -> Vec<(Vec<String>, String)> {
    match tree {
        UseTree::Path(path) => {
            let first = path.ident.to_string();
            let inner = leaves(&path.tree).into_iter();
            inner
                .map(|(mut rest, name)| {
                    let name = if name == "self" { first.clone() } else { name };
                    rest.retain(|part| part != "self");
                    rest.insert(0, first.clone());
                    (rest, name)
                })
                .collect()
        }
        UseTree::Name(name) => vec![(vec![name.ident.to_string()], name.ident.to_string())],
        UseTree::Rename(rename) => vec![(vec![rename.ident.to_string()], rename.rename.to_string())],
        UseTree::Glob(_) => vec![(vec!["*".to_owned()], "*".to_owned())],
        UseTree::Group(group) => group.items.iter().flat_map(leaves).collect(),
    }
}
