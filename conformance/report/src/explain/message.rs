//! Messages and services.

use uavspec_rules::definitions::Row;
use uavspec_schema::{Field, Message as Defined};

use super::answer::{Member, Message, Part, Summary};
use super::catalogue::{Catalogue, Definition};
use super::presence;

/// Explains a message or a service.
pub(super) fn explain(catalogue: &Catalogue<'_>, definition: &Definition) -> Message {
    let release = definition.release;
    let index = catalogue.library().index();
    let row: Option<&Row> = index.of_name(&definition.name).find(|row| row.releases.contains(release));
    let documented = catalogue.documented(&definition.name);
    let first = definition.parts().next();
    let steps = catalogue.history(definition);
    Message {
        name: definition.name.clone(),
        topics: row.map(Row::owned_topics).unwrap_or_default(),
        release: catalogue.label(release),
        version: first.and_then(|message| message.version),
        description: documented.map(|message| message.docs.text()).unwrap_or_default(),
        uorb_hash: row.filter(|row| !row.topics.is_empty()).map(|row| format!("0x{:08x}", row.hash)),
        type_hash: row.map(|row| row.type_hash.to_owned()),
        uorb_size: first
            .and_then(|message| message.uorb.as_ref())
            .map(|layout| layout.size)
            .filter(|_| row.is_some_and(|row| !row.topics.is_empty())),
        parts: definition.parts().map(|message| part(catalogue, definition, message)).collect(),
        presence: presence::of_definition(catalogue, catalogue.family(release), &steps),
    }
}

fn part(catalogue: &Catalogue<'_>, definition: &Definition, message: &Defined) -> Part {
    let schema = &definition.schema;
    let summary = |field: &Field| {
        let documented = catalogue.documented_field(schema, message, field);
        Summary {
            name: field.name.clone(),
            ty: schema.type_text(message, field.ty),
            unit: field.unit.clone().or_else(|| documented?.unit.clone()),
            description: documented.map(|field| field.description.clone()).unwrap_or_default(),
        }
    };
    let constants = message.constants.iter().map(|constant| Member {
        name: constant.name.clone(),
        value: constant.value.to_string(),
        description: catalogue.description_of(schema, message, constant),
    });
    Part {
        name: message.name.clone(),
        fields: message.fields.iter().map(summary).collect(),
        constants: constants.collect(),
    }
}
