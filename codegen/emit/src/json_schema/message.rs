//! Schemas of messages: closed objects with all fields required.

use std::borrow::Cow;

use uavspec_schema::value::Value;
use uavspec_schema::{Constant, Dialect, Field, Form, Kind, Message, Package, Parameter, Schema};

use super::annotation::{annotation, annotations, filled, list, object, prefixes, stated, unit};
use super::bounds;
use super::field::FieldSchema;
use super::tree::{Member, Node, member};

/// The schema members for `message`.
pub(super) fn members<'s>(schema: &'s Schema, message: &'s Message) -> Vec<Member<'s>> {
    let package = schema.package_of(message);
    let property = |field: &'s Field| {
        (Cow::Borrowed(field.name.as_str()), FieldSchema { schema, message, field }.node())
    };
    let mut members = vec![
        member("title", message.name.as_str()),
        member("description", description(package, message)),
        member("type", "object"),
        member("properties", Node::Object(message.fields.iter().map(property).collect())),
        member(
            "required",
            message.fields.iter().map(|field| Node::from(field.name.as_str())).collect::<Node>(),
        ),
        member("additionalProperties", false),
    ];
    members.extend(message_annotations(package, message));
    members
}

/// The header comment, or a default text. Service parts rarely have a header comment.
fn description(package: &Package, message: &Message) -> String {
    let text = message.docs.text();
    if !text.is_empty() {
        return text;
    }
    let (stem, part) = match message.kind {
        Kind::Message => (message.name.as_str(), "Message"),
        Kind::Service | Kind::Action => message.name.rsplit_once('_').unwrap_or((&message.name, "Part")),
    };
    match message.kind {
        Kind::Message => format!("Message {stem} of package {}.", package.name),
        Kind::Service => format!("{part} of service {stem} of package {}.", package.name),
        Kind::Action => format!("{part} of action {stem} of package {}.", package.name),
    }
}

fn message_annotations<'s>(package: &'s Package, message: &'s Message) -> Option<Member<'s>> {
    // Messages of other dialects have no uORB layout, even if their size is fixed.
    let is_uorb = package.form == Form::Msg(Dialect::Px4) && message.kind == Kind::Message;
    let layout = message.uorb.as_ref().filter(|_| is_uorb);
    let size = |size: usize| Node::Integer(i128::try_from(size).unwrap_or(i128::MAX));
    let constants = message
        .constants
        .iter()
        .map(|constant| Some((Cow::Borrowed(constant.name.as_str()), value(&constant.value))));
    annotations([
        annotation(
            "x-ros-type",
            Some(format!("{}/{}/{}", package.ros_package, message.kind.name(), message.name)),
        ),
        annotation("x-rihs01", filled(&message.type_hash)),
        annotation("x-topics", list(message.topics.iter().map(|topic| Node::from(topic.as_str())))),
        annotation("x-version", message.version),
        annotation("x-queue-length", message.queue_length),
        annotation("x-hash", is_uorb.then_some(message.hash)),
        annotation("x-uorb-size", layout.map(|layout| size(layout.size))),
        annotation("x-uorb-size-no-padding", layout.map(|layout| size(layout.size_no_padding))),
        annotation("x-origin", package.origin.as_deref()),
        annotation("x-revision", package.revision.as_deref()),
        annotation("x-constants", object(constants)),
        annotation("x-parameters", object(message.constants.iter().map(parameters))),
    ])
}

/// The parameters of a command.
fn parameters(constant: &Constant) -> Option<Member<'_>> {
    let found = list(constant.parameters.iter().map(parameter))?;
    Some((Cow::Borrowed(constant.name.as_str()), found))
}

/// A parameter of a command. An undocumented parameter is an empty object, so later parameters keep their positions.
fn parameter(parameter: &Parameter) -> Node<'_> {
    let head = [
        annotation("description", filled(&parameter.description)),
        annotation("unit", unit(parameter.unit.as_deref())),
    ];
    let constraints = parameter.constraints.iter();
    let constraints = constraints.map(|found| annotation(found.kind.name, stated(&found.stated, number)));
    let prefixes = annotation("enum", prefixes(&parameter.enum_prefixes));
    object(head.into_iter().chain(constraints).chain([prefixes])).unwrap_or_else(|| Node::Object(Vec::new()))
}

/// A parameter value. `None`, the empty value, has no JSON form.
fn number(value: Option<&Value>) -> Option<Node<'_>> {
    value.map(bounds::number)
}

/// The value of a constant. NaN and infinities are strings.
fn value(value: &Value) -> Node<'_> {
    match value {
        Value::Bool(value) => Node::Bool(*value),
        Value::Int(value) => Node::Integer(*value),
        Value::Float(value) if value.is_finite() => Node::Float(*value),
        Value::Float(_) => Node::from(value.to_string()),
        Value::Text(text) => Node::from(text.as_str()),
        Value::List(values) => values.iter().map(self::value).collect(),
    }
}
