//! Declarations of events: their enums, the types of their arguments, and the data that decodes them.

use uavspec_schema::event::scalar_name;
use uavspec_schema::translation::event_key;
use uavspec_schema::value::Value;
use uavspec_schema::{Event, EventArgument, EventComponent, EventEnum, EventEnumRef, Package};

use super::declaration::{Declaration, Kind, Named, Property, Type};
use super::names::{Names, identifier, top_level};
use crate::identifier::{Scope, pascal_case, upper_case};

/// The data that decodes the events of a package.
pub(crate) struct KnownEvents {
    pub(crate) enums: Vec<KnownEnum>,
    pub(crate) events: Vec<KnownEvent>,
}

/// An enum of event metadata.
pub(crate) struct KnownEnum {
    /// The common prefix of the keys of its labels.
    pub(crate) key: String,
    /// The number of bits; 0 if values aren't bit fields.
    pub(crate) bits: usize,
    /// The text between the labels of two bits.
    pub(crate) separator: String,
    /// The value, the name and the label of each entry.
    pub(crate) entries: Vec<(i128, String, String)>,
}

/// An event.
pub(crate) struct KnownEvent {
    pub(crate) id: u32,
    /// The key of its message.
    pub(crate) key: String,
    pub(crate) name: String,
    pub(crate) group: String,
    pub(crate) message: String,
    pub(crate) description: String,
    /// The name and the type of each argument, and the index of its enum.
    pub(crate) arguments: Vec<(String, String, Option<usize>)>,
}

/// Declares the enums and events of a package.
pub(super) fn declare(names: &mut Names, index: usize, package: &Package) -> Vec<Declaration> {
    let mut declarations = Vec::new();
    let mut enums: Vec<Vec<String>> = Vec::new();
    for component in &package.components {
        let mut own = Vec::new();
        for found in &component.enums {
            let name = names.extra(index, &top_level(&pascal_case(found.name.trim_end_matches("_t"))));
            declarations.push(enumeration(found, &name));
            own.push(name);
        }
        enums.push(own);
    }
    let name_of = |found: EventEnumRef| enums[found.component][found.index].clone();
    let mut all = Vec::new();
    for component in &package.components {
        for event in &component.events {
            let name = names.extra(index, &top_level(&pascal_case(&event.name)));
            let ty = Type::Named { module: None, name: name.clone() };
            all.push((format!("{}::{}", component.namespace, event.name), ty));
            declarations.push(arguments(package, component, event, name, &name_of));
        }
    }
    if !all.is_empty() {
        declarations.push(Declaration {
            name: names.extra(index, "Events"),
            text: "The arguments of all events, by name.".to_owned(),
            kind: Kind::Messages(all),
        });
    }
    declarations
}

fn enumeration(found: &EventEnum, name: &str) -> Declaration {
    let mut scope = Scope::default();
    let members = found.entries.iter().map(|entry| Named {
        name: scope.unique(&identifier(&upper_case(&entry.name))),
        value: Value::Int(entry.value),
        text: entry.description.clone(),
    });
    let text = if found.description.is_empty() {
        format!("The type {}.", found.name)
    } else {
        found.description.clone()
    };
    let is_signed = found.scalar.integer_bounds().is_some_and(|(min, _)| min < 0);
    let kind =
        Kind::Enumeration { is_flags: found.separator.is_some(), is_signed, members: members.collect() };
    Declaration { name: name.to_owned(), text, kind }
}

fn arguments(
    package: &Package,
    component: &EventComponent,
    event: &Event,
    name: String,
    name_of: &dyn Fn(EventEnumRef) -> String,
) -> Declaration {
    let property = |argument: &EventArgument| {
        let ty = match argument.enumeration {
            Some(found) => Type::Enumeration { module: None, name: name_of(found) },
            None if argument.scalar.is_float() => Type::Either(vec![Type::Number, Type::Null]),
            None => Type::Integer,
        };
        let mut text = argument.description.clone();
        if !text.is_empty() {
            text.push_str("\n\n");
        }
        text.extend(["type: ", &package.event_type(component, argument)]);
        Property { key: argument.name.clone(), is_required: true, ty, text }
    };
    let mut text = format!("Arguments of the event {}: {}", event.name, event.message);
    if !event.description.is_empty() {
        text = format!("{text}\n\n{}", event.description);
    }
    let properties = event.arguments.iter().map(property).collect();
    Declaration { name, text, kind: Kind::Record { properties, is_closed: true } }
}

/// The data that decodes the events of a package, sorted by id.
pub(super) fn known(package: &Package) -> KnownEvents {
    let enums = package.components.iter().flat_map(|component| {
        component.enums.iter().map(|found| KnownEnum {
            key: event_key(package, component, &found.name),
            bits: if found.separator.is_some() { 8 * found.scalar.size() } else { 0 },
            separator: found.separator.clone().unwrap_or_default(),
            entries: found
                .entries
                .iter()
                .map(|entry| (entry.value, entry.name.clone(), entry.description.clone()))
                .collect(),
        })
    });
    let index_of = |found: EventEnumRef| {
        let before = package.components[..found.component].iter().map(|component| component.enums.len());
        before.sum::<usize>() + found.index
    };
    let event = |component: &EventComponent, event: &Event| KnownEvent {
        id: event.id,
        key: event_key(package, component, &event.name),
        name: format!("{}::{}", component.namespace, event.name),
        group: event.group.clone(),
        message: event.message.clone(),
        description: event.description.clone(),
        arguments: event
            .arguments
            .iter()
            .map(|argument| {
                let ty = scalar_name(argument.scalar).into_owned();
                (argument.name.clone(), ty, argument.enumeration.map(index_of))
            })
            .collect(),
    };
    let components = package.components.iter();
    let events =
        components.flat_map(|component| component.events.iter().map(move |found| event(component, found)));
    let mut events: Vec<KnownEvent> = events.collect();
    events.sort_by_key(|event| event.id);
    KnownEvents { enums: enums.collect(), events }
}
