//! Syntax trees to model: names become references, and all that is wrong across lines and files is
//! found. The only place that knows both sides.

mod enums;
mod lower;
mod measure;
mod order;
mod reference;

pub(crate) use lower::default_topic;

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::enumeration::{ByPrefix, EnumRef};
use super::json_type::{self, JsonMessageId, JsonTypeId};
use super::{CdrSize, Element, Form, Interface, Kind, Message, MessageId, Package, Schema, error_codes};
use crate::diagnostic::{Diagnostic, Problem, has_errors};
use crate::msg::ast::Definition;
use crate::msg::{Dialect, is_identifier};
use crate::source::Span;
use crate::table::Page;
use crate::value::Value;
use uavspec_runtime::Scalar;

/// A package before it is resolved.
#[derive(Debug)]
pub struct PackageSource<'s> {
    /// Its name.
    pub name: String,
    /// The form of its definitions.
    pub form: Form,
    /// The name that ROS knows it by, which type hashes contain.
    pub ros_package: String,
    /// Where its definitions come from.
    pub origin: Option<String>,
    /// Which state of the origin they follow.
    pub revision: Option<String>,
    /// Which messages are wanted, with what they refer to; all, where absent.
    pub select: Option<Vec<(String, Span)>>,
    /// Its `.msg` files and their relatives: file stem, kind, span, tree.
    pub files: Vec<(&'s str, Kind, Span, Definition<'s>)>,
    /// Its pages with tables.
    pub pages: Vec<Page>,
}

/// Resolves all packages together, which are sorted by name. Where an error is among the diagnostics, the
/// schema is not complete, and nothing should be generated from it.
pub fn resolve(packages: &[PackageSource<'_>]) -> (Schema, Vec<Diagnostic>) {
    let mut resolver = Resolver::default();
    resolver.declare(packages);
    resolver.lower(packages);
    resolver.tables(packages);
    let order = resolver.order();
    resolver.enums();
    resolver.measure(&order);
    resolver.schema.nested_first = order;
    if !has_errors(&resolver.diagnostics) {
        resolver.fingerprints();
    }
    resolver.select();
    (resolver.schema, resolver.diagnostics)
}

/// A field that is annotated with an enum, which is gathered once all constants are known.
struct PendingEnum {
    /// Index of the message that has the field.
    message: usize,
    field: usize,
    /// The message that owns the constants.
    owner: MessageId,
    prefixes: Vec<String>,
    is_flags: bool,
    span: Span,
}

/// Owner, prefixes, type, and whether it is a mask.
type EnumKey = (MessageId, Vec<String>, Scalar, bool);

#[derive(Default)]
struct Resolver<'s> {
    schema: Schema,
    diagnostics: Vec<Diagnostic>,
    /// Messages by package and name.
    by_name: HashMap<(usize, &'s str), MessageId>,
    package_by_name: HashMap<String, usize>,
    /// Where each message comes from, in the order of [`Schema::messages`].
    origins: Vec<Origin>,
    pending: Vec<PendingEnum>,
    claimed: Vec<BTreeSet<String>>,
    suggestions: usize,
    selections: Vec<Option<Vec<(String, Span)>>>,
    /// The constants of the part that is being lowered.
    constants: HashMap<&'s str, Value>,
    /// The enums that have been gathered: none where there is nothing to gather.
    gathered: HashMap<EnumKey, Option<EnumRef>>,
    /// The constants of each message that has enums.
    by_prefix: HashMap<MessageId, ByPrefix>,
    /// How many members they have.
    members: usize,
}

#[derive(Clone, Copy)]
struct Origin {
    package: usize,
    file: usize,
    part: usize,
}

impl<'s> Resolver<'s> {
    /// Gives each message its id, in the order of package, kind and name.
    fn declare(&mut self, packages: &[PackageSource<'s>]) {
        for (package, source) in packages.iter().enumerate() {
            self.package_by_name.insert(source.name.clone(), package);
            self.selections.push(source.select.clone());
            let mut files: Vec<usize> = (0..source.files.len()).collect();
            files.sort_by_key(|file| (source.files[*file].1, source.files[*file].0));
            let mut interfaces = Vec::new();
            let mut messages = Vec::new();
            let mut first: BTreeMap<(Kind, String), (&str, Span)> = BTreeMap::new();
            for file in files {
                let (stem, kind, span, ref definition) = source.files[file];
                self.check_message_name(stem, source.form, span);
                if let Some((earlier, place)) = first.insert((kind, stem.to_lowercase()), (stem, span)) {
                    let problem =
                        Problem::DuplicateMessage { name: stem.to_owned(), package: source.name.clone() };
                    let mut diagnostic = Diagnostic::new(problem, span.part(0..0))
                        .with_related(place.part(0..0), "the first one");
                    if earlier != stem {
                        let hint = format!(
                            "on some systems `{earlier}` and `{stem}` are one file: rename one of them"
                        );
                        diagnostic = diagnostic.with_hint(hint);
                    }
                    self.report(diagnostic);
                    continue;
                }
                let mut parts = Vec::new();
                for (part, suffix) in kind.part_suffixes().iter().enumerate().take(definition.parts.len()) {
                    let id = id(self.schema.messages.len());
                    self.origins.push(Origin { package, file, part });
                    self.schema.messages.push(empty_message(package, kind, format!("{stem}{suffix}"), span));
                    parts.push(id);
                }
                if kind == Kind::Message {
                    self.by_name.insert((package, stem), parts[0]);
                    messages.append(&mut parts);
                } else {
                    interfaces.push(Interface { name: stem.to_owned(), kind, parts, type_hash: None, span });
                }
            }
            self.schema.packages.push(Package {
                name: source.name.clone(),
                form: source.form,
                ros_package: source.ros_package.clone(),
                origin: source.origin.clone(),
                revision: source.revision.clone(),
                messages,
                interfaces,
                error_tables: Vec::new(),
                json_types: Vec::new(),
                json_messages: Vec::new(),
            });
        }
    }

    fn check_message_name(&mut self, stem: &str, form: Form, span: Span) {
        let is_pascal_case = stem.starts_with(|c: char| c.is_ascii_uppercase()) && !stem.contains('_');
        let stem_text = stem.to_owned();
        let problem = if !is_identifier(stem) {
            Problem::MessageName { stem: stem_text }
        } else if is_pascal_case {
            return;
        } else if form == Form::Msg(Dialect::Ros2) {
            Problem::NameStyleRos { name: stem_text, style: "PascalCase" }
        } else {
            Problem::MessageNameStyle { stem: stem_text }
        };
        let diagnostic = Diagnostic::new(problem, span.part(0..0));
        self.report(if is_identifier(stem) { diagnostic.with_hint("rename the file") } else { diagnostic });
    }

    fn tables(&mut self, packages: &[PackageSource<'s>]) {
        for (index, source) in packages.iter().enumerate() {
            if source.form == Form::Table {
                self.pages(index, source);
            }
        }
    }

    fn pages(&mut self, index: usize, source: &PackageSource<'_>) {
        let (tables, mut diagnostics) = error_codes::resolve(&source.pages);
        let first = JsonTypeId(offset(self.schema.json_types.len()));
        let mut found = json_type::resolve(&source.pages, (index, &source.name), first.0, !tables.is_empty());
        for (page, has_types) in source.pages.iter().zip(found.has_definitions) {
            let is_within = |span: Span| page.span.start <= span.start && span.end <= page.span.end;
            let has_codes = tables.iter().any(|table| is_within(table.span))
                || diagnostics.iter().any(|diagnostic| is_within(diagnostic.span));
            if !has_types && !has_codes {
                let heading = page.headings.first().map_or(page.span.part(0..0), |first| first.text.span());
                self.report(Diagnostic::new(Problem::NoTable, heading));
            }
        }
        self.diagnostics.append(&mut diagnostics);
        self.diagnostics.append(&mut found.diagnostics);
        let package = &mut self.schema.packages[index];
        package.error_tables = tables;
        package.json_types = (first.0..).zip(&found.types).map(|(id, _)| JsonTypeId(id)).collect();
        let messages = offset(self.schema.json_messages.len());
        package.json_messages = (messages..).zip(&found.messages).map(|(id, _)| JsonMessageId(id)).collect();
        self.schema.json_types.append(&mut found.types);
        self.schema.json_messages.append(&mut found.messages);
    }

    /// Lists only what is selected in each package, with all that it refers to.
    fn select(&mut self) {
        if self.selections.iter().all(Option::is_none) {
            return;
        }
        let mut open: Vec<MessageId> = Vec::new();
        for (index, selection) in std::mem::take(&mut self.selections).into_iter().enumerate() {
            let package = &mut self.schema.packages[index];
            let Some(selection) = selection else {
                open.extend(
                    package
                        .messages
                        .iter()
                        .chain(package.interfaces.iter().flat_map(|interface| &interface.parts)),
                );
                continue;
            };
            let wants = |name: &str| selection.iter().any(|(wanted, _)| wanted == name);
            package.interfaces.retain(|interface| wants(&interface.name));
            open.extend(package.interfaces.iter().flat_map(|interface| &interface.parts));
            let messages = &self.schema.messages;
            open.extend(package.messages.iter().filter(|id| wants(&messages[id.0 as usize].name)));
            for (name, span) in &selection {
                let is_message = package.messages.iter().any(|id| messages[id.0 as usize].name == *name);
                if !is_message && !package.interfaces.iter().any(|interface| interface.name == *name) {
                    let problem = Problem::UnknownType { name: name.clone(), package: package.name.clone() };
                    self.diagnostics.push(Diagnostic::new(problem, *span));
                }
            }
        }
        let mut wanted: BTreeSet<MessageId> = BTreeSet::new();
        while let Some(id) = open.pop() {
            if wanted.insert(id) {
                let message = self.schema.message(id);
                open.extend(nested_ids(message));
                open.extend(message.fields.iter().filter_map(|field| Some(field.enumeration?.message)));
            }
        }
        for package in &mut self.schema.packages {
            package.messages.retain(|id| wanted.contains(id));
        }
    }

    fn report(&mut self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
    }
}

/// The id of the message at `index` of [`Schema::messages`]; there are fewer than bytes of sources.
fn id(index: usize) -> MessageId {
    MessageId(offset(index))
}

/// An index into a list that has fewer entries than there are bytes of sources.
fn offset(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(u32::MAX)
}

fn empty_message(package: usize, kind: Kind, name: String, span: Span) -> Message {
    Message {
        package,
        kind,
        name,
        span,
        docs: super::Docs::default(),
        topics: Vec::new(),
        version: None,
        queue_length: None,
        fields: Vec::new(),
        constants: Vec::new(),
        enums: Vec::new(),
        groups: Vec::new(),
        uorb: None,
        cdr: CdrSize::default(),
        hash: 0,
        type_hash: String::new(),
    }
}

fn nested_ids(message: &Message) -> impl Iterator<Item = MessageId> {
    message.fields.iter().filter_map(|field| match field.ty.element {
        Element::Message(id) => Some(id),
        Element::Scalar(_) | Element::String { .. } => None,
    })
}
