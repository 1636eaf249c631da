//! Constants and commands.

use uavspec_schema::msg::constraint::Constraint;
use uavspec_schema::{Parameter as Defined, Shape, Type};

use super::annotation::Texts;
use super::answer::{Constant, Member, Parameter, Values};
use super::catalogue::Catalogue;
use super::field::{Located, limits, presence_of};
use super::target::Place;

/// Explains a constant. `others` are the names of other definitions that have a constant with this name.
pub(super) fn explain(catalogue: &Catalogue<'_>, place: &Place, others: Vec<String>) -> Constant {
    let definition = catalogue.read(&place.definition, place.release, None);
    let part = definition.parts().find(|message| message.name == place.message);
    let found = part.and_then(|message| {
        Some((message, message.constants.iter().find(|constant| constant.name == place.name)?))
    });
    let schema = &definition.schema;
    let ty = found.map(|(message, constant)| {
        schema.type_text(message, Type { element: constant.ty, shape: Shape::Single })
    });
    let description = found
        .map(|(message, constant)| catalogue.description_of(schema, message, constant))
        .unwrap_or_default();
    let parameters = found.map(|(_, constant)| constant.parameters.as_slice()).unwrap_or_default();
    let users = users(catalogue, place, found.map_or(&[], |(message, _)| &message.fields));
    let alternatives = users.first().map(|(_, values)| others_of(values, &place.name)).unwrap_or_default();
    Constant {
        name: place.name.clone(),
        message: place.definition.clone(),
        release: catalogue.label(place.release),
        ty: ty.unwrap_or_default(),
        value: found.map(|(_, constant)| constant.value.to_string()).unwrap_or_default(),
        description,
        fields: users.into_iter().map(|(name, _)| name).collect(),
        alternatives,
        parameters: parameters.iter().enumerate().map(|(at, found)| parameter(at + 1, found)).collect(),
        also_in: others,
        presence: presence_of(catalogue, &definition, &place.name),
    }
}

/// The fields of the message that may contain the constant, each with its values.
fn users(
    catalogue: &Catalogue<'_>,
    place: &Place,
    fields: &[uavspec_schema::Field],
) -> Vec<(String, Values)> {
    let Some(own) = catalogue.text_of(&place.definition, place.release) else { return Vec::new() };
    let all = catalogue.texts_of(&place.definition, catalogue.family(place.release));
    let texts = Texts { own, all, release: place.release };
    let mut users = Vec::new();
    for field in fields {
        let is_mentioned = field.enumeration.is_some()
            || super::annotation::find(catalogue, &texts, &place.definition, &field.name).is_some();
        if !is_mentioned {
            continue;
        }
        let field_place = Place { name: field.name.clone(), ..place.clone() };
        let located = Located::with_texts(catalogue, &field_place, &texts);
        let Some(values) = located.and_then(|located| located.values(catalogue)) else { continue };
        if values.message == place.definition && values.members.iter().any(|member| member.name == place.name)
        {
            users.push((field.name.clone(), values));
        }
    }
    users
}

/// The other values whose constants have the same prefix.
fn others_of(values: &Values, name: &str) -> Vec<Member> {
    let prefix = values.prefixes.iter().find(|prefix| name.starts_with(prefix.as_str()));
    let is_other = |member: &&Member| {
        member.name != name && prefix.is_none_or(|prefix| member.name.starts_with(prefix.as_str()))
    };
    values.members.iter().filter(is_other).cloned().collect()
}

fn parameter(number: usize, found: &Defined) -> Parameter {
    let constraints: Vec<&Constraint> = found.constraints.iter().collect();
    Parameter {
        number,
        limits: limits(found.unit.as_deref(), &constraints),
        values: found.enum_prefixes.clone(),
        description: found.description.clone(),
    }
}
