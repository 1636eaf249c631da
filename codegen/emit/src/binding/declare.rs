//! Lowering of packages to modules.

use std::collections::BTreeSet;

use uavspec_schema::json_type::Direction;
use uavspec_schema::{ErrorCode, Package, Schema};

use super::declaration::{Declaration, Kind, KnownCode, Module, Type};
use super::declarer::Declarer;
use super::names::{Names, identifier};
use super::{event, json_type, message, text};
use crate::identifier::error_code_names;

/// Lowers all packages that contain definitions, sorted by name.
pub(crate) fn modules(schema: &Schema) -> Vec<Module> {
    let mut names = Names::new(schema);
    let packages = schema.packages.iter().enumerate().filter(|(_, package)| !package.is_empty());
    let mut modules: Vec<Module> =
        packages.map(|(index, package)| module(schema, &mut names, index, package)).collect();
    modules.sort_by(|left, right| left.name.cmp(&right.name));
    modules
}

fn module(schema: &Schema, names: &mut Names, index: usize, package: &Package) -> Module {
    let mut declarer = Declarer { schema, names, imports: BTreeSet::new() };
    let mut declarations = Vec::new();
    for id in package.all_messages() {
        declarations.append(&mut message::declare(&mut declarer, id));
    }
    for id in &package.json_types {
        let name = declarer.names.json_type(*id);
        declarations.push(json_type::declare(&declarer, name, schema.json_type(*id)));
    }
    for id in &package.json_messages {
        let message = schema.json_message(*id);
        for part in &message.parts {
            let name = &declarer.names.parts[&(*id, part.direction)];
            declarations.push(json_type::declare_part(&declarer, name, message, part));
        }
    }
    let imports = declarer.imports;
    declarations.append(&mut directions(schema, names, index, package));
    declarations.append(&mut all_messages(schema, names, index, package));
    declarations.append(&mut event::declare(names, index, package));
    Module {
        name: names.modules[index].clone(),
        package: package.name.clone(),
        text: text::package(package),
        imports,
        declarations,
        error_codes: error_codes(package),
        events: (!package.components.is_empty()).then(|| event::known(package)),
    }
}

/// For each direction, declares two types: a map from message types to bodies, and the union of these bodies.
fn directions(schema: &Schema, names: &mut Names, index: usize, package: &Package) -> Vec<Declaration> {
    let mut declarations = Vec::new();
    for direction in Direction::ALL {
        let bodies: Vec<(String, Type)> = package
            .json_messages
            .iter()
            .filter_map(|id| Some((schema.json_message(*id), names.parts.get(&(*id, direction))?)))
            .map(|(message, name)| (message.name.clone(), named(name)))
            .collect();
        if bodies.is_empty() {
            continue;
        }
        let (what, plural) = match direction {
            Direction::Request => ("a message from a client that expects a response", "requests"),
            Direction::Response => ("a response to a request", "responses"),
            Direction::Notification => ("an unsolicited message from a server", "notifications"),
        };
        let union = Type::Either(bodies.iter().map(|(_, ty)| ty.clone()).collect());
        declarations.push(Declaration {
            name: names.extra(index, &format!("{}s", direction.title())),
            text: format!("Body types of {plural}, by message type."),
            kind: Kind::Messages(bodies),
        });
        declarations.push(Declaration {
            name: names.extra(index, direction.title()),
            text: format!("Body of {what}, discriminated by `type`."),
            kind: Kind::Alias(union),
        });
    }
    declarations
}

/// Declares a map of all messages by name, and their union.
fn all_messages(schema: &Schema, names: &mut Names, index: usize, package: &Package) -> Vec<Declaration> {
    let plain = package.messages.iter();
    let mut entries: Vec<(String, Type)> =
        plain.map(|id| (schema.message(*id).name.clone(), named(names.message(*id)))).collect();
    entries.extend(package.json_messages.iter().map(|id| {
        let message = schema.json_message(*id);
        let bodies = message.parts.iter().map(|part| named(&names.parts[&(*id, part.direction)]));
        (message.name.clone(), Type::Either(bodies.collect()))
    }));
    if entries.is_empty() {
        return Vec::new();
    }
    let union = Type::Either(entries.iter().map(|(_, ty)| ty.clone()).collect());
    vec![
        Declaration {
            name: names.extra(index, "Messages"),
            text: "All message types, by name.".to_owned(),
            kind: Kind::Messages(entries),
        },
        Declaration {
            name: names.extra(index, "Message"),
            text: "Any message.".to_owned(),
            kind: Kind::Alias(union),
        },
    ]
}

fn named(name: &str) -> Type {
    Type::Named { module: None, name: name.to_owned() }
}

fn error_codes(package: &Package) -> Vec<KnownCode> {
    let mut codes: Vec<&ErrorCode> = package.error_tables.iter().flat_map(|table| &table.codes).collect();
    let names = error_code_names(&codes);
    let mut known: Vec<KnownCode> = codes
        .drain(..)
        .zip(names)
        .map(|(code, name)| KnownCode {
            name: identifier(&name),
            code: code.code,
            abbreviation: code.abbreviation.clone(),
            description: code.description.clone(),
            alternatives: code.alternatives.clone(),
            see_also: code.see_also.clone(),
        })
        .collect();
    known.sort_by_key(|code| code.code);
    known
}
