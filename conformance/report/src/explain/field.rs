//! Fields.

use uavspec_schema::fingerprint::ros_name;
use uavspec_schema::msg::constraint::{Constraint, RANGE};
use uavspec_schema::{EnumRef, Field as Defined, Message, Schema};

use super::annotation::{self, STATED, Texts};
use super::answer::{Field, Limits, Member, Presence, Values};
use super::catalogue::{Catalogue, Definition};
use super::presence;
use super::target::Place;

/// A field in a release, with the constants that it contains.
pub(super) struct Located {
    pub(super) definition: Definition,
    /// The indices of the message and of the field.
    at: (usize, usize),
    /// The source of the constants.
    known_from: String,
    /// True if the constants were inferred.
    is_inferred: bool,
}

impl Located {
    /// Finds a field. If the definition doesn't name the constants of the field, looks for them in other sources.
    pub(super) fn new(catalogue: &Catalogue<'_>, place: &Place) -> Option<Self> {
        let own = catalogue.text_of(&place.definition, place.release)?;
        let all = catalogue.texts_of(&place.definition, catalogue.family(place.release));
        Self::with_texts(catalogue, place, &Texts { own, all, release: place.release })
    }

    /// Like [`Self::new`], but uses these texts of the definition.
    pub(super) fn with_texts(catalogue: &Catalogue<'_>, place: &Place, texts: &Texts<'_>) -> Option<Self> {
        let found = annotation::find(catalogue, texts, &place.definition, &place.name);
        let annotation = found.as_ref().map(|found| (found.line.as_str(), found.text.as_str()));
        let definition = catalogue.read(&place.definition, place.release, annotation);
        let schema = &definition.schema;
        let part = definition.parts().find(|message| message.name == place.message)?;
        let message = schema.messages.iter().position(|message| std::ptr::eq(message, part))?;
        let field = part.fields.iter().position(|field| field.name == place.name)?;
        let is_inferred = found.as_ref().is_some_and(|found| found.is_inferred);
        let known_from = found.map_or_else(|| STATED.to_owned(), |found| found.known_from);
        Some(Self { definition, at: (message, field), known_from, is_inferred })
    }

    pub(super) fn schema(&self) -> &Schema {
        &self.definition.schema
    }

    pub(super) fn message(&self) -> &Message {
        &self.schema().messages[self.at.0]
    }

    pub(super) fn field(&self) -> &Defined {
        &self.message().fields[self.at.1]
    }

    /// The constraints of the release, or of the documented field.
    pub(super) fn constraints<'c>(&'c self, catalogue: &Catalogue<'c>) -> Vec<&'c Constraint> {
        let documented = catalogue.documented_field(self.schema(), self.message(), self.field());
        let mut constraints: Vec<&Constraint> = self.field().constraints.iter().collect();
        let more = documented.into_iter().flat_map(|field| &field.constraints);
        for constraint in more {
            if constraints.iter().all(|known| known.kind != constraint.kind) {
                constraints.push(constraint);
            }
        }
        constraints
    }

    /// The constants that the field contains.
    pub(super) fn values(&self, catalogue: &Catalogue<'_>) -> Option<Values> {
        let reference: EnumRef = self.field().enumeration?;
        let (schema, found) = (self.schema(), self.schema().enumeration(self.field().enumeration?));
        let owner = schema.message(reference.message);
        let member = |member: &uavspec_schema::Member| {
            let constant = &owner.constants[member.constant];
            Member {
                name: constant.name.clone(),
                value: if found.is_flags { format!("{:#x}", member.value) } else { member.value.to_string() },
                description: catalogue.description_of(schema, owner, constant),
            }
        };
        let mut members: Vec<Member> = found.members.iter().map(member).collect();
        members.dedup_by(|left, right| left.name == right.name);
        if members.is_empty() {
            return None;
        }
        Some(Values {
            message: ros_name(schema, owner),
            prefixes: found.prefixes.clone(),
            flags: found.is_flags,
            known_from: self.known_from.clone(),
            is_inferred: self.is_inferred,
            members,
        })
    }
}

/// Explains a field.
pub(super) fn explain(catalogue: &Catalogue<'_>, place: &Place) -> Field {
    let Some(located) = Located::new(catalogue, place) else { return Field::default() };
    let (schema, message, field) = (located.schema(), located.message(), located.field());
    let documented = catalogue.documented_field(schema, message, field);
    let unit = field.unit.as_deref().or_else(|| documented?.unit.as_deref());
    let mut limits = limits(unit, &located.constraints(catalogue));
    let attributes = field.attributes().map(|(attribute, text)| format!("{}: {text}", attribute.name));
    limits.facts.extend(attributes);
    let counted = field.counts.and_then(|at| message.fields.get(at));
    limits.facts.extend(counted.map(|array| format!("number of used entries in {}", array.name)));
    Field {
        name: place.path.clone(),
        message: place.definition.clone(),
        release: catalogue.label(place.release),
        ty: schema.type_text(message, field.ty),
        limits,
        default: field.default.as_ref().map(ToString::to_string),
        description: documented.map(|field| field.description.clone()).unwrap_or_default(),
        values: located.values(catalogue),
        asked: None,
        presence: presence_of(catalogue, &located.definition, &place.name),
    }
}

/// The presence of an item of a definition.
pub(super) fn presence_of(catalogue: &Catalogue<'_>, definition: &Definition, item: &str) -> Presence {
    let steps = catalogue.history(definition);
    presence::of_item(catalogue, catalogue.family(definition.release), &steps, item)
}

/// The unit and the valid values.
pub(super) fn limits(unit: Option<&str>, constraints: &[&Constraint]) -> Limits {
    let range = constraints.iter().find(|constraint| *constraint.kind == RANGE);
    let others = constraints.iter().filter(|constraint| *constraint.kind != RANGE);
    let fact = |constraint: &&Constraint| {
        let value = constraint.stated.value().map_or_else(|| "empty".to_owned(), ToString::to_string);
        let when = if constraint.text.is_empty() { String::new() } else { format!(" ({})", constraint.text) };
        format!("{value}: {}{when}", constraint.kind.words)
    };
    Limits {
        unit: unit.map(str::to_owned),
        range: range.and_then(|constraint| constraint.valid_values()),
        facts: others.map(fact).collect(),
    }
}
