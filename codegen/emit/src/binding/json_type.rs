//! Declarations of the types and messages defined on pages.

use uavspec_schema::json_type::{
    Definition, Expression, JsonMessage, JsonPart, JsonType, Member, Object, Set, SetValues,
};

use super::declaration::{Declaration, ERROR_CODE, Kind, Property, Type};
use super::declarer::Declarer;
use super::text;
use crate::facts::{PLAIN, with_facts};

/// Declares a type defined on a page.
pub(super) fn declare(declarer: &Declarer<'_>, name: &str, found: &JsonType) -> Declaration {
    let documentation = text::documentation(&found.docs, || {
        format!("Type {}; the definition has no description.", found.name)
    });
    let (kind, text) = match &found.definition {
        Definition::Object(object) => (record(declarer, found.package, object), documentation),
        Definition::Tuple(elements) => {
            let lines = elements.iter().map(|element| {
                let text = with_facts(&element.description, &PLAIN.limits(&element.typed.limits));
                format!("- {}: {}", element.name, text.replace("\n\n", " "))
            });
            let lines: Vec<String> = lines.collect();
            let properties = properties(declarer, found.package, elements).into_iter();
            let elements = properties.map(|found| (found.key, found.is_required, found.ty)).collect();
            (Kind::Alias(Type::Tuple(elements)), format!("{documentation}\n\n{}", lines.join("\n")))
        }
        Definition::Set(set) => {
            let (ty, lines) = set_type(set);
            (Kind::Alias(ty), format!("{documentation}\n\n{}", lines.join("\n")))
        }
        Definition::Named(typed) => {
            let text = with_facts(&documentation, &PLAIN.limits(&typed.limits));
            (Kind::Alias(expression(declarer, found.package, &typed.ty)), text)
        }
    };
    Declaration { name: name.to_owned(), text, kind }
}

/// Declares the body of a message in one direction.
pub(super) fn declare_part(
    declarer: &Declarer<'_>,
    name: &str,
    message: &JsonMessage,
    part: &JsonPart,
) -> Declaration {
    let mut paragraphs = vec![format!("Body of a {} of type {}.", part.direction, message.name)];
    paragraphs.extend([message.docs.text(), part.docs.text()].into_iter().filter(|text| !text.is_empty()));
    if !part.answers.is_empty() {
        paragraphs.push(format!("Responses: {}.", part.answers.join(", ")));
    }
    let kind = record(declarer, message.package, &part.body);
    Declaration { name: name.to_owned(), text: paragraphs.join("\n\n"), kind }
}

fn record(declarer: &Declarer<'_>, package: usize, object: &Object) -> Kind {
    Kind::Record { properties: properties(declarer, package, &object.fields), is_closed: object.is_closed }
}

fn properties(declarer: &Declarer<'_>, package: usize, members: &[Member]) -> Vec<Property> {
    let property = |member: &Member| {
        let ty = expression(declarer, package, &member.typed.ty);
        let mut facts: Vec<String> = text::values(&ty).into_iter().collect();
        facts.extend(PLAIN.limits(&member.typed.limits));
        Property {
            key: member.name.clone(),
            is_required: member.is_required,
            text: with_facts(&member.description, &facts),
            ty,
        }
    };
    members.iter().map(property).collect()
}

fn set_type(set: &Set) -> (Type, Vec<String>) {
    let is_open = set.is_open;
    let line = |value: String, description: &str| match description {
        "" => format!("- {value}"),
        description => format!("- {value}: {description}"),
    };
    match &set.values {
        SetValues::Integers(found) => (
            Type::Integers { values: found.iter().map(|found| found.value).collect(), is_open },
            found.iter().map(|found| line(found.value.to_string(), &found.description)).collect(),
        ),
        SetValues::Strings(found) => (
            Type::Strings { values: found.iter().map(|found| found.value.clone()).collect(), is_open },
            found.iter().map(|found| line(format!("{:?}", found.value), &found.description)).collect(),
        ),
    }
}

fn expression(declarer: &Declarer<'_>, package: usize, found: &Expression) -> Type {
    let inner = |inner: &Expression| expression(declarer, package, inner);
    match found {
        Expression::Any => Type::Any,
        Expression::Null => Type::Null,
        Expression::Boolean => Type::Boolean,
        Expression::Integer => Type::Integer,
        Expression::Number => Type::Number,
        Expression::String => Type::String,
        Expression::ErrorCode => error_code(declarer, package),
        Expression::ErrorList => Type::List(Box::new(error_code(declarer, package))),
        Expression::Named(id) => {
            let name = declarer.names.json_type(*id).to_owned();
            match declarer.schema.json_type(*id).definition {
                Definition::Set(_) => Type::Set(name),
                _ => Type::Named { module: None, name },
            }
        }
        Expression::List(element) => Type::List(Box::new(inner(element))),
        Expression::Map(value) => Type::Map(Box::new(inner(value))),
        Expression::Either(alternatives) => Type::Either(alternatives.iter().map(inner).collect()),
        Expression::OneOf(values) => Type::Strings { values: values.clone(), is_open: false },
    }
}

/// The type of error codes. A module declares `ErrorCode` only if a table contains a code.
fn error_code(declarer: &Declarer<'_>, package: usize) -> Type {
    let tables = &declarer.schema.packages[package].error_tables;
    if tables.iter().all(|table| table.codes.is_empty()) {
        return Type::Integer;
    }
    Type::Enumeration { module: None, name: ERROR_CODE.to_owned() }
}
