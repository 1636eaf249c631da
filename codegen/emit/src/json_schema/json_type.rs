//! Schemas of the types and messages defined on pages.

use std::borrow::Cow;

use uavspec_schema::json_type::{
    Definition, Expression, JsonMessage, JsonPart, JsonType, Limits, Member, Object, Set, SetValue,
    SetValues, Typed,
};
use uavspec_schema::{Package, Schema};

use super::address::Target;
use super::annotation::{annotation, annotations, filled, list, range, unit};
use super::bounds;
use super::tree::{Member as Entry, Node, any_of_type, member};

/// A pattern for padded base64.
pub(crate) const BASE64: &str = "^([A-Za-z0-9+/]{4})*([A-Za-z0-9+/]{2}==|[A-Za-z0-9+/]{3}=)?$";

/// The schema members for a type.
pub(super) fn type_members<'s>(schema: &'s Schema, found: &'s JsonType) -> Vec<Entry<'s>> {
    let writer = Writer { schema, package: found.package };
    let mut members = vec![member("title", found.name.as_str())];
    let text = found.docs.text();
    let default = || format!("Type {} of package {}.", found.name, schema.packages[found.package].name);
    members.push(member("description", if text.is_empty() { default() } else { text }));
    let kind = match &found.definition {
        Definition::Object(object) => {
            members.extend(writer.object(object));
            None
        }
        Definition::Tuple(elements) => {
            members.extend(writer.tuple(elements));
            None
        }
        Definition::Set(set) => {
            members.extend(values(set));
            Some(if set.is_open { "open set" } else { "closed set" })
        }
        Definition::Named(typed) => {
            members.extend(writer.typed(typed));
            None
        }
    };
    let typed = match &found.definition {
        Definition::Named(typed) => Some(typed),
        _ => None,
    };
    members.extend(writer.annotations(typed, kind, &schema.packages[found.package]));
    members
}

/// The schema members for a message in one direction.
pub(super) fn part_members<'s>(
    schema: &'s Schema,
    message: &'s JsonMessage,
    part: &'s JsonPart,
) -> Vec<Entry<'s>> {
    let writer = Writer { schema, package: message.package };
    let package = &schema.packages[message.package];
    let texts = [message.docs.text(), part.docs.text()];
    let text =
        texts.iter().filter(|text| !text.is_empty()).map(String::as_str).collect::<Vec<_>>().join("\n\n");
    let default =
        || format!("Body of a {} of type {} in package {}.", part.direction, message.name, package.name);
    let mut members = vec![
        member("title", part.name.as_str()),
        member("description", if text.is_empty() { default() } else { text }),
    ];
    members.extend(writer.object(&part.body));
    members.extend(annotations([
        annotation("x-message", Some(message.name.as_str())),
        annotation("x-direction", Some(part.direction.name())),
        annotation("x-answers", list(part.answers.iter().map(|name| Node::from(name.as_str())))),
        annotation("x-origin", package.origin.as_deref()),
        annotation("x-revision", package.revision.as_deref()),
    ]));
    members
}

/// Writes the assertions for values of the types in a package.
#[derive(Clone, Copy)]
struct Writer<'s> {
    schema: &'s Schema,
    package: usize,
}

impl<'s> Writer<'s> {
    fn object(self, object: &'s Object) -> Vec<Entry<'s>> {
        let property = |field: &'s Member| (Cow::Borrowed(field.name.as_str()), self.member(field));
        let required = object.fields.iter().filter(|field| field.is_required);
        let mut members = vec![
            member("type", "object"),
            member("properties", Node::Object(object.fields.iter().map(property).collect())),
        ];
        members.extend(annotation("required", list(required.map(|field| Node::from(field.name.as_str())))));
        // Other fields are allowed unless the page forbids them.
        members.extend(object.is_closed.then(|| member("additionalProperties", false)));
        members
    }

    /// Elements at the end may be omitted. Strict validators require a complete list of elements, so each length is a
    /// separate alternative.
    fn tuple(self, elements: &'s [Member]) -> Vec<Entry<'s>> {
        let min = elements.iter().filter(|element| element.is_required).count();
        let exactly = |length: usize| {
            let count = u32::try_from(length).unwrap_or(u32::MAX);
            let mut members = vec![member("type", "array")];
            if length > 0 {
                let items = elements.iter().take(length).map(|element| self.member(element));
                members.push(member("prefixItems", items.collect::<Node>()));
            }
            members.extend([member("minItems", count), member("maxItems", count)]);
            members
        };
        if min == elements.len() {
            return exactly(min);
        }
        let alternatives = (min..=elements.len()).map(|length| Node::Object(exactly(length)));
        vec![member("type", "array"), member("oneOf", alternatives.collect::<Node>())]
    }

    /// The schema of a field or element.
    fn member(self, found: &'s Member) -> Node<'s> {
        let mut members = vec![member("title", found.name.as_str())];
        members.extend(annotation("description", filled(&found.description)));
        members.extend(self.typed(&found.typed));
        members.extend(self.limits(&found.typed).map_or_else(Vec::new, |found| vec![found]));
        Node::Object(members)
    }

    fn typed(self, typed: &'s Typed) -> Vec<Entry<'s>> {
        self.expression(&typed.ty, &typed.limits)
    }

    /// The assertions for values of an expression, restricted by `limits`.
    fn expression(self, expression: &Expression, limits: &Limits) -> Vec<Entry<'s>> {
        match expression {
            Expression::Any => Vec::new(),
            Expression::Null => vec![member("type", "null")],
            Expression::Boolean => vec![member("type", "boolean")],
            Expression::Integer => numbers("integer", limits),
            Expression::Number => numbers("number", limits),
            Expression::String => strings(limits),
            Expression::OneOf(constants) => one_of(constants),
            Expression::ErrorCode => reference(Target::ErrorCode(self.package)),
            Expression::ErrorList => self.restricted(Target::ErrorList(self.package), expression, limits),
            Expression::Named(id) => self.restricted(Target::JsonType(*id), expression, limits),
            Expression::List(element) => {
                let mut members = lists(limits);
                members.extend(self.within("items", element, limits));
                members
            }
            Expression::Map(value) => {
                let mut members = vec![member("type", "object")];
                members.extend(self.within("additionalProperties", value, limits));
                members
            }
            Expression::Either(alternatives) => self.either(alternatives, limits),
        }
    }

    /// The schema for elements of a list or map, or `None` if any value is allowed.
    fn within(self, name: &'static str, inner: &Expression, limits: &Limits) -> Option<Entry<'s>> {
        let members = self.expression(inner, &limits.of_elements());
        (!members.is_empty()).then(|| member(name, Node::Object(members)))
    }

    fn either(self, alternatives: &[Expression], limits: &Limits) -> Vec<Entry<'s>> {
        // The common expression `string or null` becomes one schema with two types.
        if let [plain, Expression::Null] | [Expression::Null, plain] = alternatives {
            let mut members = self.expression(plain, limits);
            // Schemas nested in `allOf` also have types, which would reject null.
            let is_nested = members.iter().any(|(name, _)| name == "allOf");
            if let Some((name, ty @ Node::Text(_))) = members.first_mut()
                && name == "type"
                && !is_nested
                && !matches!(plain, Expression::OneOf(_))
            {
                *ty = Node::List(vec![ty.clone(), Node::from("null")]);
                return members;
            }
        }
        let alternatives = alternatives.iter().map(|inner| Node::Object(self.expression(inner, limits)));
        vec![member("anyOf", alternatives.collect::<Node>())]
    }

    /// A reference to a named type, with additional restrictions.
    fn restricted(self, target: Target, expression: &Expression, limits: &Limits) -> Vec<Entry<'s>> {
        if !limits.is_restriction() {
            return reference(target);
        }
        // Up to draft 7, keywords next to a `$ref` are ignored, so the `$ref` is nested in `allOf`.
        let below = Node::Object(reference(target));
        let mut all = vec![below];
        all.extend(self.restrictions(expression, limits));
        vec![member("allOf", Node::List(all))]
    }

    /// The assertions of `limits` for values of a named type.
    fn restrictions(self, expression: &Expression, limits: &Limits) -> Option<Node<'s>> {
        let plain = self.schema.plain(expression)?;
        let members = self.expression(&plain, limits);
        (!members.is_empty()).then_some(Node::Object(members))
    }

    /// The annotations of a member: type, unit, range and format.
    fn limits(self, typed: &'s Typed) -> Option<Entry<'s>> {
        annotations(self.facts(typed))
    }

    fn facts(self, typed: &'s Typed) -> [Option<Entry<'s>>; 4] {
        let Limits { unit: symbol, range: bounds, format, .. } = &typed.limits;
        [
            annotation("x-type", Some(self.schema.expression_text(&typed.ty, &str::to_owned))),
            annotation("x-unit", unit(symbol.as_deref())),
            annotation("x-range", bounds.as_ref().map(range)),
            annotation("x-format", format.as_deref()),
        ]
    }

    fn annotations(
        self,
        typed: Option<&'s Typed>,
        kind: Option<&'static str>,
        package: &'s Package,
    ) -> Option<Entry<'s>> {
        let facts = typed.map(|typed| self.facts(typed)).into_iter().flatten();
        annotations(facts.chain([
            annotation("x-kind", kind),
            annotation("x-origin", package.origin.as_deref()),
            annotation("x-revision", package.revision.as_deref()),
        ]))
    }
}

fn reference<'s>(target: Target) -> Vec<Entry<'s>> {
    vec![member("$ref", Node::Reference(target))]
}

/// The assertions for the values of a set. An open set allows other values.
fn values(set: &Set) -> Vec<Entry<'_>> {
    let (ty, mut values): (&str, Vec<Node<'_>>) = match &set.values {
        SetValues::Integers(values) => {
            ("integer", values.iter().map(|found| known(found, Node::Integer(found.value.into()))).collect())
        }
        SetValues::Strings(values) => {
            ("string", values.iter().map(|found| known(found, Node::from(found.value.as_str()))).collect())
        }
    };
    values.extend(set.is_open.then(|| any_of_type(ty)));
    vec![member("type", ty), member("anyOf", Node::List(values))]
}

fn known<'s, T>(found: &'s SetValue<T>, value: Node<'s>) -> Node<'s> {
    let mut members = vec![member("const", value)];
    members.extend(annotation("description", filled(&found.description)));
    Node::Object(members)
}

fn one_of<'s>(constants: &[String]) -> Vec<Entry<'s>> {
    let constant = |text: &String| member("const", text.clone());
    let assertion = match constants {
        [only] => constant(only),
        _ => {
            member("anyOf", constants.iter().map(|text| Node::Object(vec![constant(text)])).collect::<Node>())
        }
    };
    vec![member("type", "string"), assertion]
}

fn numbers<'s>(ty: &'static str, limits: &Limits) -> Vec<Entry<'s>> {
    let mut members = vec![member("type", ty)];
    if let Some(range) = &limits.range {
        members.extend(range.low.as_ref().map(|low| member("minimum", bounds::number(low))));
        members.extend(range.high.as_ref().map(|high| member("maximum", bounds::number(high))));
    }
    members
}

fn strings<'s>(limits: &Limits) -> Vec<Entry<'s>> {
    let mut members = vec![member("type", "string")];
    members.extend(annotation("minLength", limits.min));
    members.extend(annotation("maxLength", limits.max));
    // The only format is base64. Validators ignore `contentEncoding`, so a pattern also checks the format.
    let pattern = limits.pattern.clone();
    match (pattern, &limits.format) {
        (Some(pattern), None) => members.push(member("pattern", pattern)),
        (pattern, Some(format)) => {
            members.push(member("pattern", BASE64));
            members.push(member("contentEncoding", format.clone()));
            let below = pattern.map(|pattern| {
                Node::List(vec![Node::Object(vec![member("type", "string"), member("pattern", pattern)])])
            });
            members.extend(annotation("allOf", below));
        }
        (None, None) => {}
    }
    members
}

fn lists<'s>(limits: &Limits) -> Vec<Entry<'s>> {
    let mut members = vec![member("type", "array")];
    members.extend(annotation("minItems", limits.min));
    members.extend(annotation("maxItems", limits.max));
    members.extend(limits.is_unique.then(|| member("uniqueItems", true)));
    members
}
