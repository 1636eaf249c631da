//! All that definitions say and that can be translated, each text with a key.
//!
//! | key | what it is the text of |
//! |---|---|
//! | `px4/Wind` | the summary of a message, or of a part of a service or action (`px4/Tow_Request`) |
//! | `px4/Wind/description` | the paragraphs after it |
//! | `px4/Wind.speed` | a field |
//! | `px4/Wind.speed/invalid` | the words of a constraint, by its name |
//! | `px4/Wind.speed/frame` | an attribute, by its name |
//! | `px4/Wind.speed/group` | the heading of the group that begins with this field (or constant) |
//! | `px4/Wind.speed/group/description` | the paragraphs after it |
//! | `px4/Wind::SPEED_LOW` | a constant: a value of an enum, a flag, a command |
//! | `px4/Wind::CMD_BLOW/parameter/1` | a parameter of a command, from 1 |
//! | `px4/Wind::CMD_BLOW/parameter/1/invalid` | the words of a constraint, by its name |
//! | `flockwave/error-code/134` | the description of an error code |
//! | `flockwave/error-table/128` | the title of the table whose range begins there |

use std::collections::BTreeSet;

use crate::msg::attribute::Attribute;
use crate::msg::constraint::{self, ConstraintKind};
use crate::schema::{Constraint, ErrorTable, Interface, Message, MessageId, Package, Schema};
use crate::source::Span;

/// A text that can be translated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Text<'s> {
    /// What it belongs to, and is translated with: the page that shows it. `px4/Wind`, `harbour/Tow.srv`,
    /// `flockwave/error-codes`.
    pub unit: String,
    /// What it is the text of: unique, and the same as long as that has its name.
    pub key: String,
    /// The text.
    pub text: &'s str,
    /// A word for translators on what it is of, where the key doesn't say it.
    pub note: String,
    /// Where the definition has it.
    pub span: Span,
}

/// What of a message can be translated; numbers are indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MessageText {
    /// [`Docs::summary`](crate::schema::Docs::summary) of the message.
    Summary,
    /// [`Docs::description`](crate::schema::Docs::description) of the message.
    Description,
    /// The summary of a group.
    Group(usize),
    /// The description of a group.
    GroupDescription(usize),
    /// The description of a field.
    Field(usize),
    /// The words of one of its constraints.
    Constraint(usize, &'static ConstraintKind),
    /// The text of one of its attributes.
    Attribute(usize, &'static Attribute),
    /// The description of a constant.
    Constant(usize),
    /// The description of a parameter of a command, which is the constant that comes first.
    Parameter(usize, usize),
    /// The words of one of its constraints.
    ParameterConstraint(usize, usize, &'static ConstraintKind),
}

impl MessageText {
    /// What the definition says; empty where it says nothing.
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

/// The keys of all texts of a message.
#[derive(Clone, Debug)]
pub struct MessageKeys<'s> {
    message: &'s Message,
    /// The key of its summary, with which all others begin.
    base: String,
    /// By group, the key of the declaration that it begins with.
    starts: Vec<String>,
}

impl<'s> MessageKeys<'s> {
    /// The keys of the texts of `message`.
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
        // Each group has a declaration: it begins with one.
        first.into_iter().map(|first| first.map_or_else(|| self.base.clone(), |(_, key)| key)).collect()
    }
}

/// What a message belongs to.
pub fn message_unit(schema: &Schema, message: &Message) -> String {
    format!("{}/{}", schema.package_of(message).name, message.name)
}

/// What the parts of a service or action belong to.
pub fn interface_unit(package: &Package, interface: &Interface) -> String {
    format!("{}/{}.{}", package.name, interface.name, interface.kind.name())
}

/// What all tables of error codes of a package belong to.
pub fn error_codes_unit(package: &Package) -> String {
    format!("{}/error-codes", package.name)
}

/// The key of the title of a table of error codes.
pub fn error_table_key(package: &Package, table: &ErrorTable) -> String {
    format!("{}/error-table/{}", package.name, table.range.start())
}

/// The key of the description of an error code.
pub fn error_code_key(package: &Package, code: u32) -> String {
    format!("{}/error-code/{code}", package.name)
}

/// All texts of a schema that can be translated, unit by unit, each in the order of its definition. Empty ones
/// are left out, and so are messages that aren't selected.
pub fn texts(schema: &Schema) -> Vec<Text<'_>> {
    let mut texts = Vec::new();
    for package in &schema.packages {
        for id in &package.messages {
            let unit = message_unit(schema, schema.message(*id));
            of_message(schema, *id, &unit, &mut texts);
        }
        for interface in &package.interfaces {
            let unit = interface_unit(package, interface);
            interface.parts.iter().for_each(|id| of_message(schema, *id, &unit, &mut texts));
        }
        of_error_codes(package, &mut texts);
    }
    texts
}

fn of_message<'s>(schema: &'s Schema, id: MessageId, unit: &str, texts: &mut Vec<Text<'s>>) {
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
    // Stable: what belongs to a declaration stays together.
    found.sort_by_key(|(_, span)| *span);
    let head = [MessageText::Summary, MessageText::Description].map(|text| (text, message.span));
    let mut known = BTreeSet::new();
    for (text, span) in head.into_iter().chain(found) {
        let (key, source) = (keys.key(text), text.of(message));
        // Each declaration of a group has brought along its heading.
        if !source.is_empty() && known.insert(key.clone()) {
            texts.push(Text { unit: unit.to_owned(), key, text: source, note: String::new(), span });
        }
    }
}

fn of_error_codes<'s>(package: &'s Package, texts: &mut Vec<Text<'s>>) {
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
    texts.retain(|text| !text.text.is_empty());
}
