//! Declarations of messages from `.msg` files, with their enums and constants.

use uavspec_schema::value::Value;
use uavspec_schema::{Element, Enum, Field, Message, MessageId, Shape};

use super::declaration::{Declaration, Kind, Named, Property, Type};
use super::declarer::Declarer;
use super::names::identifier;
use super::text;
use crate::identifier::{Scope, upper_case};

/// Declares the message itself, its enums and its constants.
pub(super) fn declare(declarer: &mut Declarer<'_>, id: MessageId) -> Vec<Declaration> {
    let message = declarer.schema.message(id);
    let names = declarer.names;
    let fields = message.fields.iter().map(|field| {
        let ty = field_type(declarer, message, field);
        Property {
            key: field.name.clone(),
            is_required: true,
            text: text::field(declarer.schema, message, field, &ty),
            ty,
        }
    });
    let mut declarations = vec![Declaration {
        name: names.message(id).to_owned(),
        text: text::message(message),
        kind: Kind::Record { properties: fields.collect(), is_closed: true },
    }];
    let enums = message.enums.iter().zip(&names.enums[id.0 as usize]);
    declarations.extend(enums.map(|(found, name)| enumeration(message, found, name)));
    if !message.constants.is_empty() {
        declarations.push(Declaration {
            name: names.constants[id.0 as usize].clone(),
            text: format!("Constants of {}.", message.name),
            kind: Kind::Constants(constants(message)),
        });
    }
    declarations
}

fn field_type(declarer: &mut Declarer<'_>, message: &Message, field: &Field) -> Type {
    let element = match field.ty.element {
        Element::Scalar(scalar) if scalar.is_float() => Type::Either(vec![Type::Number, Type::Null]),
        Element::Scalar(scalar) if scalar.integer_bounds().is_none() => Type::Boolean,
        Element::Scalar(_) => match field.enumeration {
            Some(reference) => declarer.enumeration(message.package, reference),
            None => Type::Integer,
        },
        Element::Text(_) | Element::String { .. } => Type::String,
        Element::Message(nested) => declarer.message(message.package, nested),
    };
    if field.ty.shape == Shape::Single { element } else { Type::List(Box::new(element)) }
}

fn enumeration(owner: &Message, found: &Enum, name: &str) -> Declaration {
    let prefixes = found.prefixes.join(", ");
    let text = if found.is_flags {
        format!("{prefixes} flags of {}. Any combination is valid; unnamed bits may be set too.", owner.name)
    } else {
        format!("{prefixes} values of {}. Other firmware versions may use other values.", owner.name)
    };
    let mut scope = Scope::default();
    let members = found.members.iter().map(|member| Named {
        name: scope.unique(&identifier(&upper_case(&member.name))),
        value: Value::Int(member.value),
        text: text::constant(&owner.constants[member.constant]),
    });
    let is_signed = found.scalar.integer_bounds().is_some_and(|(min, _)| min < 0);
    Declaration {
        name: name.to_owned(),
        text,
        kind: Kind::Enumeration { is_flags: found.is_flags, is_signed, members: members.collect() },
    }
}

fn constants(message: &Message) -> Vec<Named> {
    let mut scope = Scope::default();
    let constants = message.constants.iter().map(|constant| Named {
        name: scope.unique(&identifier(&constant.name)),
        value: constant.value.clone(),
        text: text::constant(constant),
    });
    constants.collect()
}
