//! The translatable texts of definitions, each with a key.
//!
//! | key | text |
//! |---|---|
//! | `px4/Wind` | the summary of a message, or of a part of a service or action (`px4/Tow_Request`) |
//! | `px4/Wind/description` | the paragraphs after the summary |
//! | `px4/Wind.speed` | a field |
//! | `px4/Wind.speed/invalid` | the text of a field constraint, here `invalid` |
//! | `px4/Wind.speed/frame` | the text of a field attribute, here `frame` |
//! | `px4/Wind.speed/group` | the heading of the group that starts with this field or constant |
//! | `px4/Wind.speed/group/description` | the paragraphs after the group heading |
//! | `px4/Wind::SPEED_LOW` | a constant: an enum value, a flag or a command |
//! | `px4/Wind::CMD_BLOW/parameter/1` | a parameter of a command, counted from 1 |
//! | `px4/Wind::CMD_BLOW/parameter/1/invalid` | the text of a parameter constraint, here `invalid` |
//! | `flockwave/error-code/134` | the description of an error code |
//! | `px4_events/px4::battery_low` | the message of an event |
//! | `px4_events/px4::battery_low/description` | the description of an event |
//! | `px4_events/px4::failsafe_action_t/land` | an entry of an enum in event metadata |
//! | `flockwave/error-table/128` | the title of the error-code table that starts at this code |

use std::collections::BTreeSet;

use super::translations::Language;
use crate::msg::attribute::Attribute;
use crate::msg::constraint::{self, ConstraintKind};
use crate::source::Span;
use crate::{Constraint, ErrorTable, EventComponent, Interface, Message, MessageId, Package, Schema};

/// A translatable text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Text<'s> {
    /// The unit that contains the text, such as `px4/Wind`, `harbour/Tow.srv` or `flockwave/error-codes`. A unit is
    /// translated as a whole.
    pub unit: String,
    /// The unique key, which stays the same unless the described item is renamed.
    pub key: String,
    /// The text.
    pub text: &'s str,
    /// A note for translators, if the key is not enough.
    pub note: String,
    /// Location in the definition.
    pub span: Span,
}

/// The translatable texts of a message. Numbers are indexes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MessageText {
    /// [`Docs::summary`](crate::Docs::summary) of the message.
    Summary,
    /// [`Docs::description`](crate::Docs::description) of the message.
    Description,
    /// The summary of a group.
    Group(usize),
    /// The description of a group.
    GroupDescription(usize),
    /// The description of a field.
    Field(usize),
    /// The text of a field constraint.
    Constraint(usize, &'static ConstraintKind),
    /// The text of a field attribute.
    Attribute(usize, &'static Attribute),
    /// The description of a constant.
    Constant(usize),
    /// The description of a command parameter. The first index identifies the constant that defines the command.
    Parameter(usize, usize),
    /// The text of a parameter constraint.
    ParameterConstraint(usize, usize, &'static ConstraintKind),
}

impl MessageText {
    /// The text in the definition, or an empty string.
    pub fn of(self, message: &Message) -> &str {
        match self {
            Self::Summary => &message.docs.summary,
            Self::Description => &message.docs.description,
            Self::Group(group) => &message.groups[group].summary,
            Self::GroupDescription(group) => &message.groups[group].description,
            Self::Field(index) => &message.fields[index].description,
            Self::Constraint(index, kind) => words(&message.fields[index].constraints, kind),
            Self::Attribute(index, attribute) => {
                message.fields[index].attribute(attribute).unwrap_or_default()
            }
            Self::Constant(index) => &message.constants[index].description,
            Self::Parameter(index, number) => &message.constants[index].parameters[number].description,
            Self::ParameterConstraint(index, number, kind) => {
                words(&message.constants[index].parameters[number].constraints, kind)
            }
        }
    }
}

fn words<'c>(constraints: &'c [Constraint], kind: &ConstraintKind) -> &'c str {
    constraint::find(constraints, kind).map_or("", |constraint| constraint.text.as_str())
}

/// The keys of a message's texts.
#[derive(Clone, Debug)]
pub struct MessageKeys<'s> {
    message: &'s Message,
    /// The key of the summary, which is the prefix of all other keys.
    base: String,
    /// The key of the first declaration in each group.
    starts: Vec<String>,
}

impl<'s> MessageKeys<'s> {
    /// Prepares the keys for `message`.
    pub fn new(schema: &'s Schema, message: &'s Message) -> Self {
        let base = message_unit(schema, message);
        let mut keys = Self { message, base, starts: Vec::new() };
        keys.starts = keys.starts();
        keys
    }

    /// The key of a text.
    pub fn key(&self, text: MessageText) -> String {
        match text {
            MessageText::Summary => self.base.clone(),
            MessageText::Description => format!("{}/description", self.base),
            MessageText::Group(group) => format!("{}/group", self.starts[group]),
            MessageText::GroupDescription(group) => format!("{}/group/description", self.starts[group]),
            MessageText::Field(index) => self.field(index),
            MessageText::Constraint(index, kind) => format!("{}/{}", self.field(index), kind.name),
            MessageText::Attribute(index, attribute) => format!("{}/{}", self.field(index), attribute.name),
            MessageText::Constant(index) => self.constant(index),
            MessageText::Parameter(index, number) => {
                format!("{}/parameter/{}", self.constant(index), number + 1)
            }
            MessageText::ParameterConstraint(index, number, kind) => {
                format!("{}/parameter/{}/{}", self.constant(index), number + 1, kind.name)
            }
        }
    }

    fn field(&self, index: usize) -> String {
        format!("{}.{}", self.base, self.message.fields[index].name)
    }

    fn constant(&self, index: usize) -> String {
        format!("{}::{}", self.base, self.message.constants[index].name)
    }

    fn starts(&self) -> Vec<String> {
        let fields = self.message.fields.iter().enumerate();
        let fields = fields.filter_map(|(index, field)| Some((field.group?, field.span, self.field(index))));
        let constants = self.message.constants.iter().enumerate();
        let constants = constants
            .filter_map(|(index, constant)| Some((constant.group?, constant.span, self.constant(index))));
        let mut first: Vec<Option<(Span, String)>> = vec![None; self.message.groups.len()];
        for (group, span, key) in fields.chain(constants) {
            if first[group].as_ref().is_none_or(|(known, _)| span < *known) {
                first[group] = Some((span, key));
            }
        }
        // Every group contains at least one declaration.
        first.into_iter().map(|first| first.map_or_else(|| self.base.clone(), |(_, key)| key)).collect()
    }
}

/// The unit of a message.
pub fn message_unit(schema: &Schema, message: &Message) -> String {
    format!("{}/{}", schema.package_of(message).name, message.name)
}

/// The unit of a service or action.
pub fn interface_unit(package: &Package, interface: &Interface) -> String {
    format!("{}/{}.{}", package.name, interface.name, interface.kind.name())
}

/// The unit of a package's error-code tables.
pub fn error_codes_unit(package: &Package) -> String {
    format!("{}/error-codes", package.name)
}

/// The key of an error-code table's title.
pub fn error_table_key(package: &Package, table: &ErrorTable) -> String {
    format!("{}/error-table/{}", package.name, table.range.start())
}

/// The key of an error code's description.
pub fn error_code_key(package: &Package, code: u32) -> String {
    format!("{}/error-code/{code}", package.name)
}

/// The unit of a component with events.
pub fn events_unit(package: &Package, component: &EventComponent) -> String {
    format!("{}/{}.events", package.name, component.namespace)
}

/// The key of an event's message, or of an enum's name. The keys of the other texts start with this key.
pub fn event_key(package: &Package, component: &EventComponent, name: &str) -> String {
    format!("{}/{}::{name}", package.name, component.namespace)
}

/// The components of a package, with their texts translated. Texts without a translation stay unchanged.
pub fn in_language(package: &Package, language: &Language) -> Vec<EventComponent> {
    let mut components = package.components.clone();
    let translate = |key: &str, text: &mut String| {
        if let Some(translation) = language.get(key) {
            translation.clone_into(text);
        }
    };
    for (component, own) in components.iter_mut().zip(&package.components) {
        for found in &mut component.enums {
            let key = event_key(package, own, &found.name);
            found.entries.iter_mut().for_each(|entry| {
                translate(&format!("{key}/{}", entry.name), &mut entry.description);
            });
        }
        for event in &mut component.events {
            let key = event_key(package, own, &event.name);
            translate(&key, &mut event.message);
            translate(&format!("{key}/description"), &mut event.description);
        }
    }
    components
}

/// All translatable texts of a schema, unit by unit, in the order of the definitions. Empty texts and unselected
/// messages are skipped.
pub fn texts(schema: &Schema) -> Vec<Text<'_>> {
    let mut texts = Vec::new();
    for package in &schema.packages {
        for id in &package.messages {
            let unit = message_unit(schema, schema.message(*id));
            push_message(schema, *id, &unit, &mut texts);
        }
        for interface in &package.interfaces {
            let unit = interface_unit(package, interface);
            interface.parts.iter().for_each(|id| push_message(schema, *id, &unit, &mut texts));
        }
        push_error_codes(package, &mut texts);
        package.components.iter().for_each(|component| push_events(package, component, &mut texts));
    }
    texts.retain(|text| !text.text.is_empty());
    texts
}

fn push_message<'s>(schema: &'s Schema, id: MessageId, unit: &str, texts: &mut Vec<Text<'s>>) {
    let message = schema.message(id);
    let keys = MessageKeys::new(schema, message);
    let mut found: Vec<(MessageText, Span)> = Vec::new();
    for (index, field) in message.fields.iter().enumerate() {
        use MessageText::{Attribute, Constraint, Field, Group, GroupDescription};
        let group = field.group.into_iter().flat_map(|group| [Group(group), GroupDescription(group)]);
        let own = std::iter::once(Field(index));
        let own = own.chain(field.constraints.iter().map(|found| Constraint(index, found.kind)));
        let attributes = field.attributes().map(|(attribute, _)| Attribute(index, attribute));
        found.extend(group.chain(own).chain(attributes).map(|text| (text, field.span)));
    }
    for (index, constant) in message.constants.iter().enumerate() {
        use MessageText::{Group, GroupDescription, Parameter, ParameterConstraint};
        let group = constant.group.into_iter().flat_map(|group| [Group(group), GroupDescription(group)]);
        let parameters = constant.parameters.iter().enumerate().filter(|(_, found)| !found.is_unused());
        let parameters = parameters.flat_map(|(number, found)| {
            let constraints = found.constraints.iter();
            let constraints = constraints.map(move |found| ParameterConstraint(index, number, found.kind));
            std::iter::once(Parameter(index, number)).chain(constraints)
        });
        let own = std::iter::once(MessageText::Constant(index)).chain(parameters);
        found.extend(group.chain(own).map(|text| (text, constant.span)));
    }
    // The sort is stable, so texts of the same declaration keep their order.
    found.sort_by_key(|(_, span)| *span);
    let head = [MessageText::Summary, MessageText::Description].map(|text| (text, message.span));
    let mut known = BTreeSet::new();
    for (text, span) in head.into_iter().chain(found) {
        let (key, source) = (keys.key(text), text.of(message));
        // A group heading occurs once for each declaration in the group, but is added only once.
        if !source.is_empty() && known.insert(key.clone()) {
            texts.push(Text { unit: unit.to_owned(), key, text: source, note: String::new(), span });
        }
    }
}

fn push_error_codes<'s>(package: &'s Package, texts: &mut Vec<Text<'s>>) {
    let unit = error_codes_unit(package);
    for table in &package.error_tables {
        texts.push(Text {
            unit: unit.clone(),
            key: error_table_key(package, table),
            text: &table.title,
            note: String::new(),
            span: table.span,
        });
        for code in &table.codes {
            let abbreviation = code.abbreviation.as_deref().unwrap_or_default();
            texts.push(Text {
                unit: unit.clone(),
                key: error_code_key(package, code.code),
                text: &code.description,
                note: format!("{abbreviation} ({})", code.severity()).trim_start().to_owned(),
                span: code.span,
            });
        }
    }
}

fn push_events<'s>(package: &'s Package, component: &'s EventComponent, texts: &mut Vec<Text<'s>>) {
    let unit = events_unit(package, component);
    let mut push = |key, text: &'s str, span| {
        texts.push(Text { unit: unit.clone(), key, text, note: String::new(), span });
    };
    for found in &component.enums {
        let key = event_key(package, component, &found.name);
        for entry in &found.entries {
            push(format!("{key}/{}", entry.name), &entry.description, entry.span);
        }
    }
    for event in &component.events {
        let key = event_key(package, component, &event.name);
        push(key.clone(), &event.message, event.span);
        push(format!("{key}/description"), &event.description, event.span);
    }
}
