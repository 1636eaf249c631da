//! Schemas of fields.

use std::iter::once;

use uavspec_runtime::{Number, Scalar};
use uavspec_schema::msg::constraint::Effect;
use uavspec_schema::value::Value;
use uavspec_schema::{Element, Enum, EnumRef, Field, Message, Schema, Shape};

use super::address::Target;
use super::annotation::{annotation, annotations, filled, prefixes, stated, unit};
use super::bounds::{self, Numbers};
use super::tree::{Member, Node, any_of_type, member};

/// A field of a message.
#[derive(Clone, Copy)]
pub(super) struct FieldSchema<'s> {
    pub(super) schema: &'s Schema,
    pub(super) message: &'s Message,
    pub(super) field: &'s Field,
}

impl<'s> FieldSchema<'s> {
    /// The complete schema of the field.
    pub(super) fn node(self) -> Node<'s> {
        let mut members = vec![member("title", self.field.name.as_str())];
        members.extend(annotation("description", filled(&self.field.description)));
        members.extend(self.assertions());
        members.extend(annotation(
            "default",
            self.field.default.as_ref().and_then(|value| self.instance(value)),
        ));
        members.extend(self.annotations());
        Node::Object(members)
    }

    fn assertions(self) -> Vec<Member<'s>> {
        let (min, max) = match self.field.ty.shape {
            Shape::Single => return self.element(),
            Shape::Array(length) => (Some(length), Some(length)),
            Shape::Bounded(bound) => (None, Some(bound)),
            Shape::Sequence => (None, None),
        };
        let mut members = vec![member("type", "array"), member("items", Node::Object(self.element()))];
        members.extend(annotation("minItems", min));
        members.extend(annotation("maxItems", max));
        members
    }

    /// The assertions for the value, or for each element of an array.
    fn element(self) -> Vec<Member<'s>> {
        match self.field.ty.element {
            Element::Scalar(scalar) => self.scalar(scalar),
            Element::Text(length) => vec![member("type", "string"), member("maxLength", length)],
            Element::String { bound, .. } => {
                let mut members = vec![member("type", "string")];
                members.extend(annotation("maxLength", bound));
                members
            }
            Element::Message(id) => vec![member("$ref", Node::Reference(Target::Message(id)))],
        }
    }

    fn scalar(self, scalar: Scalar) -> Vec<Member<'s>> {
        let Some(whole) = Numbers::NONE.asserted(scalar) else { return vec![member("type", "boolean")] };
        let restriction = self.schema.restriction(self.message, self.field);
        let used = restriction.and_then(|found| found.limits.asserted(scalar)).unwrap_or(whole);
        let ty = if scalar.is_float() {
            ["number", "null"].into_iter().map(Node::from).collect()
        } else {
            Node::from("integer")
        };
        let outside = self.outside(&used, &whole, scalar);
        let alternatives = (!outside.is_empty()).then(|| {
            let within = once(member("type", ty.clone())).chain(bounds::members(&used)).collect();
            let keyword = if self.are_disjoint(&used, &whole, scalar) { "oneOf" } else { "anyOf" };
            member(keyword, once(Node::Object(within)).chain(outside).collect::<Node>())
        });
        let mut members = vec![member("type", ty.clone())];
        if alternatives.is_none() {
            members.extend(bounds::members(&used));
        }
        let Some((owner, found)) = self.enumeration().filter(|(_, found)| !found.is_flags) else {
            members.extend(alternatives);
            return members;
        };
        // A schema can have one `anyOf`. If the enum uses it, the alternatives are nested in `allOf`.
        members.push(member("anyOf", open_enum(owner, found, ty)));
        let below = alternatives.map(|alternatives| Node::List(vec![Node::Object(vec![alternatives])]));
        members.extend(annotation("allOf", below));
        members
    }

    /// True if the special values and the normal range are disjoint for all readers. Code generators need `oneOf` to
    /// create union types, but `oneOf` is correct only for disjoint alternatives. For readers that store all numbers as
    /// 64-bit floats, adjacent large integers are equal, so one value could match two alternatives.
    fn are_disjoint(self, used: &Numbers, whole: &Numbers, scalar: Scalar) -> bool {
        let specials = self.field.constraints.iter().filter(|found| found.is_special());
        let values = specials.filter_map(|special| bounds::stored(special.stated.value()?, scalar).number());
        let exact = values.filter(|value| is_outside(*value, used, whole));
        let exact = exact.map(|value| bounds::exactly(value, scalar));
        let all: Vec<Numbers> = once(*used).chain(exact).collect();
        all.iter()
            .enumerate()
            .all(|(index, found)| all.iter().skip(index + 1).all(|other| bounds::are_disjoint(found, other)))
    }

    /// The special values outside `used`. NaN is skipped, because it is represented as null, which is valid for all
    /// floats.
    fn outside(self, used: &Numbers, whole: &Numbers, scalar: Scalar) -> Vec<Node<'s>> {
        let nodes = self.field.constraints.iter().filter_map(|special| {
            let Effect::Allows { title, .. } = special.kind.effect else { return None };
            let value = bounds::stored(special.stated.value()?, scalar).number()?;
            if !is_outside(value, used, whole) {
                return None;
            }
            let mut members = bounds::only(value, scalar);
            members.push(member("title", title));
            members.extend(annotation("description", filled(&special.text)));
            Some(Node::Object(members))
        });
        nodes.collect()
    }

    fn annotations(self) -> Option<Member<'s>> {
        let field = self.field;
        let flags = self.enumeration().filter(|(_, found)| found.is_flags);
        let counted = field.counts.and_then(|array| self.message.fields.get(array));
        let group = field.group.and_then(|group| self.message.groups.get(group));
        let head = [
            annotation("x-type", Some(self.schema.type_text(self.message, field.ty))),
            annotation("x-unit", unit(field.unit.as_deref())),
        ];
        let attributes =
            field.attributes().map(|(attribute, text)| annotation(attribute.keyword, Some(text)));
        let constraints = field.constraints.iter().flat_map(|found| {
            let when =
                filled(&found.text).map(|text| (format!("{}-when", found.kind.keyword).into(), text.into()));
            [annotation(found.kind.keyword, stated(&found.stated, |value| self.special(value))), when]
        });
        let rest = [
            annotation("x-enum", prefixes(&field.enum_prefixes)),
            annotation("x-flags", flags.map(|(owner, found)| flag_list(owner, found))),
            annotation("x-count-of", counted.map(|array| array.name.as_str())),
            annotation("x-group", group.and_then(|group| filled(&group.summary))),
        ];
        annotations(head.into_iter().chain(attributes).chain(constraints).chain(rest))
    }

    /// A value in JSON. `None` is the empty value.
    fn special(self, value: Option<&'s Value>) -> Option<Node<'s>> {
        match (value, self.field.ty.shape, self.field.ty.element) {
            (Some(value), ..) => self.instance(value),
            (None, Shape::Single, Element::Text(_) | Element::String { .. }) => Some(Node::from("")),
            (None, Shape::Bounded(_) | Shape::Sequence, _) => Some(Node::List(Vec::new())),
            // An array of fixed length is never empty.
            (None, ..) => None,
        }
    }

    /// A value of the field's type as JSON. JSON can't represent infinity.
    fn instance(self, value: &'s Value) -> Option<Node<'s>> {
        match value {
            Value::Int(value) if self.field.ty.element == Element::Scalar(Scalar::Bool) => {
                Some(Node::Bool(*value != 0))
            }
            Value::Bool(value) => Some(Node::Bool(*value)),
            Value::Float(value) if value.is_infinite() => None,
            Value::Int(_) | Value::Float(_) => Some(bounds::number(value)),
            Value::Text(text) => Some(Node::from(text.as_str())),
            Value::List(values) => {
                values.iter().map(|value| self.instance(value)).collect::<Option<_>>().map(Node::List)
            }
        }
    }

    /// The enum of the field, and the message that declares its constants. Text fields have no enum, even though `char`
    /// is a number.
    fn enumeration(self) -> Option<(&'s Message, &'s Enum)> {
        let reference: EnumRef = self.field.enumeration.filter(|_| !self.field.is_text())?;
        Some((self.schema.message(reference.message), self.schema.enforced_enum(self.field)?))
    }
}

/// True if `value` is a value of the type, but not in the normal range. NaN is not such a value: see
/// [`FieldSchema::outside`].
fn is_outside(value: Number, used: &Numbers, whole: &Numbers) -> bool {
    whole.violated_by(value).is_none() && used.violated_by(value).is_some()
}

/// The schema of an enum: the documented values, and any other value, because newer firmware may send undocumented
/// values.
fn open_enum<'s>(owner: &'s Message, found: &'s Enum, ty: Node<'s>) -> Node<'s> {
    let documented = found.members.iter().map(|entry| {
        let constant = owner.constants.get(entry.constant);
        let mut members =
            vec![member("const", Node::Integer(entry.value)), member("title", entry.name.as_str())];
        members
            .extend(annotation("description", constant.and_then(|constant| filled(&constant.description))));
        Node::Object(members)
    });
    documented.chain([any_of_type(ty)]).collect()
}

fn flag_list<'s>(owner: &'s Message, found: &'s Enum) -> Node<'s> {
    let flags = found.members.iter().map(|entry| {
        let mut members =
            vec![member("name", entry.name.as_str()), member("mask", Node::Integer(entry.value))];
        let description = owner.constants.get(entry.constant).map(|constant| constant.description.as_str());
        members.extend(annotation("description", description.and_then(filled)));
        Node::Object(members)
    });
    flags.collect()
}
