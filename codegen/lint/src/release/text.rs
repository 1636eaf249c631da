//! Writes definitions as text without comments.

use std::fmt::Write as _;

use uavspec_schema::msg::constraint::Range;
use uavspec_schema::msg::{Dialect, Kind};
use uavspec_schema::resolve::default_topic;
use uavspec_schema::value::Value;
use uavspec_schema::{
    Constant, Constraint, Element, Field, Form, Interface, Message, MessageId, Package, Schema, Stated, bits,
    mentions_nan,
};

use super::entries::heading_word;

/// The length of a separator line.
const SEPARATOR: usize = 80;

/// The facts of all definitions, by kind, package and name. Pages with tables are omitted.
pub fn write(schema: &Schema) -> String {
    let mut text = String::new();
    for kind in [Kind::Message, Kind::Service, Kind::Action] {
        for package in &schema.packages {
            write_package(&mut text, schema, package, kind);
        }
    }
    text
}

fn write_package(text: &mut String, schema: &Schema, package: &Package, kind: Kind) {
    let Form::Msg(dialect) = package.form else { return };
    let is_whole = |id: &&MessageId| kind == Kind::Message && schema.message(**id).kind == Kind::Message;
    let messages = package.messages.iter().filter(is_whole).map(|id| {
        let name = schema.message(*id).name.as_str();
        (name, std::slice::from_ref(id))
    });
    let interfaces = package.interfaces.iter().filter(|interface| interface.kind == kind);
    let interfaces = interfaces.map(|Interface { name, parts, .. }| (name.as_str(), parts.as_slice()));
    for (name, parts) in messages.chain(interfaces) {
        write_heading(text, kind, &format!("{}/{}/{name}", package.ros_package, kind.name()));
        for (at, id) in parts.iter().enumerate() {
            if at > 0 {
                text.push_str("---\n");
            }
            write_part(text, schema, schema.message(*id), dialect);
        }
    }
}

/// Writes the lines before a definition.
pub(super) fn write_heading(text: &mut String, kind: Kind, full_name: &str) {
    let _ = writeln!(text, "{}\n{}: {full_name}", "=".repeat(SEPARATOR), heading_word(kind));
}

/// A declaration in a definition.
enum Item<'m> {
    Field(&'m Field),
    Constant(&'m Constant),
}

fn write_part(text: &mut String, schema: &Schema, message: &Message, dialect: Dialect) {
    let is_default = message.topics.iter().map(String::as_str).eq([default_topic(&message.name)]);
    if dialect == Dialect::Px4 && message.kind == Kind::Message && !is_default {
        let _ = writeln!(text, "# TOPICS {}", message.topics.join(" "));
    }
    let fields = message.fields.iter().map(|field| (field.span.start, Item::Field(field)));
    let constants = message.constants.iter().map(|constant| (constant.span.start, Item::Constant(constant)));
    let mut items: Vec<(u32, Item<'_>)> = fields.chain(constants).collect();
    items.sort_by_key(|(start, _)| *start);
    for (_, item) in items {
        let (declaration, facts) = match item {
            Item::Field(field) => {
                (declared_field(schema, message, field), field_facts(schema, message, field))
            }
            Item::Constant(constant) => (declared_constant(constant), parameters(constant)),
        };
        text.push_str(&declaration);
        if !facts.is_empty() {
            let _ = write!(text, " # {facts}");
        }
        text.push('\n');
    }
}

fn declared_field(schema: &Schema, message: &Message, field: &Field) -> String {
    let default = field.default.as_ref().map(|value| format!(" {value}")).unwrap_or_default();
    format!("{} {}{default}", schema.type_text(message, field.ty), field.name)
}

fn declared_constant(constant: &Constant) -> String {
    let ty = match constant.ty {
        Element::Scalar(scalar) => scalar.name(),
        Element::String { wide: true, .. } => "wstring",
        // A constant can't be a text or a message.
        Element::Text(_) | Element::String { .. } | Element::Message(_) => "string",
    };
    format!("{ty} {}={}", constant.name, constant.value)
}

/// The annotations of a field, and the words of its texts that exempt values from checks.
fn field_facts(schema: &Schema, message: &Message, field: &Field) -> String {
    let mut facts = restrictions(field.unit.as_deref(), &field.constraints);
    let found = field.enumeration.map(|reference| schema.enumeration(reference));
    if let Some(found) = found {
        let word = if found.is_flags { "flags" } else { "enum" };
        let mark = if field.is_enum_exact { "@" } else { "" };
        facts.push(format!("[{mark}{word} {}]", field.enum_prefixes.join(" ")));
    }
    facts.extend(field.attributes().map(|(attribute, text)| format!("[@{} {text}]", attribute.name)));
    if let Some(array) = field.counts.and_then(|at| message.fields.get(at)) {
        facts.push(format!("[@count {}]", array.name));
    }
    if found.is_some_and(|found| !found.is_flags) && bits::mentions_bits(field) {
        facts.push("bitmask".to_owned());
    }
    let is_limited_float = field.ty.element.is_float() && field.is_restricted();
    if is_limited_float && mentions_nan(message, field) && !field.states_nan() {
        facts.push("NaN".to_owned());
    }
    facts.join(" ")
}

/// The unit and the constraints.
fn restrictions(unit: Option<&str>, constraints: &[Constraint]) -> Vec<String> {
    let unit = unit.map(|unit| format!("[{unit}]"));
    let constraints = constraints.iter().filter(|constraint| !constraint.is_unbounded()).map(|constraint| {
        let argument = match &constraint.stated {
            Stated::Value(value) => value.to_string(),
            Stated::Empty => "empty".to_owned(),
            Stated::Range(Range { low, high }) => {
                let bound = |value: &Option<Value>| value.as_ref().map(Value::to_string).unwrap_or_default();
                format!("{}, {}", bound(low), bound(high)).trim_end().to_owned()
            }
        };
        format!("[@{} {argument}]", constraint.kind.name)
    });
    unit.into_iter().chain(constraints).collect()
}

/// The parameters of a command, separated by pipes. Empty if nothing is known about them.
fn parameters(constant: &Constant) -> String {
    let facts = constant.parameters.iter().map(|parameter| {
        let mut facts = restrictions(parameter.unit.as_deref(), &parameter.constraints);
        if !parameter.enum_prefixes.is_empty() {
            facts.push(format!("[@enum {}]", parameter.enum_prefixes.join(" ")));
        }
        facts.join(" ")
    });
    let facts: Vec<String> = facts.collect();
    if facts.iter().all(String::is_empty) { String::new() } else { format!("|{}|", facts.join("|")) }
}

#[cfg(test)]
mod tests {
    use uavspec_schema::{PackageInput, SourceMap, read};

    use super::*;

    /// The facts about a field, and the data that checks use: true if NaN is forbidden, and the known values.
    type Facts = (String, Option<(bool, Option<Vec<i128>>)>);

    fn schema(text: &str) -> Schema {
        let mut sources = SourceMap::default();
        let id = sources.add("Kite.msg", text.into()).expect("a source");
        read(&sources, &[PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])]).0
    }

    fn fields(text: &str) -> Vec<Facts> {
        let schema = schema(text);
        let message = &schema.messages[0];
        let facts = |field: &Field| {
            let limits = schema.restriction(message, field);
            let limits = limits.map(|found| (found.limits.forbids_nan, found.known));
            (field_facts(&schema, message, field), limits)
        };
        message.fields.iter().map(facts).collect()
    }

    /// Writes a message as a release, and returns the facts about its fields.
    fn fields_of_release(text: &str) -> Vec<Facts> {
        let release = write(&schema(text));
        fields(crate::release::entries(&release).next().expect("a message").text)
    }

    #[test]
    fn a_release_keeps_what_only_texts_say() {
        let text = "# Kite\n\nuint64 timestamp  # [us] Time\n\
            float32 lift  # [@range -1, 1] NaN if it is unknown\n\
            float32 drag  # [@range 0, 1] [@invalid -1] NaN if it is unknown\n\
            float32 pull  # [@range 0, 1] Pull\n\
            float32 sway  # [@range -inf (Left), inf (Right)] Sway\n\
            float32 roll  # [@range -inf, inf] [@invalid -1] Roll\n\
            uint8 FAULT_LINE = 0\nuint8 FAULT_TAIL = 1\nuint8 FAULT_WING = 2\nuint8 FAULT_KNOT = 3\n\
            uint16 faults  # [@enum FAULT] Bitmask of faults\n\
            uint8 reason  # [enum FAULT] Any number, such as that of a fault\n\
            uint8 latest  # [@enum FAULT] Latest fault\n";
        let found = fields_of_release(text);
        let facts: Vec<&str> = found.iter().map(|(facts, _)| facts.as_str()).collect();
        assert_eq!(
            facts,
            [
                "[us]",
                "[@range -1, 1] NaN",
                "[@range 0, 1] [@invalid -1] NaN",
                "[@range 0, 1]",
                "",
                "[@invalid -1]",
                "[@enum FAULT] bitmask",
                "[enum FAULT]",
                "[@enum FAULT]"
            ]
        );
        let limits: Vec<_> = found.into_iter().map(|(_, limits)| limits).collect();
        let known = Some(vec![0, 1, 2, 3]);
        assert_eq!(
            limits,
            [
                None,
                Some((false, None)),
                Some((false, None)),
                Some((true, None)),
                None,
                Some((true, None)),
                None,
                None,
                Some((false, known))
            ]
        );
        assert_eq!(limits, fields(text).into_iter().map(|(_, limits)| limits).collect::<Vec<_>>());
    }
}
