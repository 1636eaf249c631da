//! The model: packages, messages and their parts.

use std::collections::BTreeMap;

use uavspec_runtime::Scalar;

use super::documentation::Docs;
use super::enumeration::{Enum, EnumRef};
use super::error_codes::ErrorTable;
use super::event::{EventArgument, EventComponent, EventEnum, EventEnumRef, scalar_name};
use super::id::MessageId;
use super::json_type::{
    Definition, ERROR_CODE, ERROR_LIST, Expression, JsonMessage, JsonMessageId, JsonType, JsonTypeId,
};
use crate::msg::ast::Shape;
use crate::msg::attribute::{ATTRIBUTES, Attribute};
use crate::msg::constraint::{self, ConstraintKind};
use crate::msg::{Dialect, Kind};
use crate::source::Span;
use crate::table::type_table::{built_in_name, is_number};
use crate::value::Value;

/// All packages of a run.
#[derive(Debug, Default)]
pub struct Schema {
    /// The packages, by name.
    pub packages: Vec<Package>,
    /// All messages, including the parts of services and actions, by package and name.
    pub messages: Vec<Message>,
    /// All messages. Each message follows the messages that it contains.
    pub topological_order: Vec<MessageId>,
    /// All types on pages, by package and name.
    pub json_types: Vec<JsonType>,
    /// All messages on pages, by package and name.
    pub json_messages: Vec<JsonMessage>,
}

impl Schema {
    /// The message with this id.
    pub fn message(&self, id: MessageId) -> &Message {
        &self.messages[id.0 as usize]
    }

    /// The package of a message.
    pub fn package_of(&self, message: &Message) -> &Package {
        &self.packages[message.package]
    }

    /// The enum that `reference` refers to.
    pub fn enumeration(&self, reference: EnumRef) -> &Enum {
        &self.message(reference.message).enums[reference.index]
    }

    /// The type of a field, as written in a `.msg` file of the same package.
    pub fn type_text(&self, message: &Message, ty: Type) -> String {
        let element = match ty.element {
            Element::Scalar(scalar) => scalar.name().to_owned(),
            Element::Text(length) => format!("char[{length}]"),
            Element::String { wide, bound } => {
                let name = if wide { "wstring" } else { "string" };
                bound.map_or_else(|| name.to_owned(), |bound| format!("{name}<={bound}"))
            }
            Element::Message(id) => {
                let target = self.message(id);
                if target.package == message.package {
                    target.name.clone()
                } else {
                    format!("{}/{}", self.package_of(target).name, target.name)
                }
            }
        };
        element + &shape_text(ty.shape)
    }
}

/// The brackets of an array type.
pub fn shape_text(shape: Shape) -> String {
    match shape {
        Shape::Single => String::new(),
        Shape::Array(length) => format!("[{length}]"),
        Shape::Bounded(bound) => format!("[<={bound}]"),
        Shape::Sequence => "[]".to_owned(),
    }
}

/// A package of definitions.
#[derive(Debug)]
pub struct Package {
    /// The name.
    pub name: String,
    /// The form of the definitions.
    pub form: Form,
    /// The name of the ROS package, as used in type hashes.
    pub ros_package: String,
    /// The origin of the definitions.
    pub origin: Option<String>,
    /// The revision of the origin.
    pub revision: Option<String>,
    /// True if the package contains only the messages that other packages refer to.
    pub is_dependency: bool,
    /// The messages, by name.
    pub messages: Vec<MessageId>,
    /// The services and actions, by kind and name.
    pub interfaces: Vec<Interface>,
    /// The error-code tables, by first code.
    pub error_tables: Vec<ErrorTable>,
    /// The types on the package's pages, by name.
    pub json_types: Vec<JsonTypeId>,
    /// The messages on the package's pages, by name.
    pub json_messages: Vec<JsonMessageId>,
    /// The components with events, by id.
    pub components: Vec<EventComponent>,
}

impl Package {
    /// A package without definitions.
    pub(crate) fn new(name: String, form: Form, ros_package: String) -> Self {
        Self {
            name,
            form,
            ros_package,
            origin: None,
            revision: None,
            is_dependency: false,
            messages: Vec::new(),
            interfaces: Vec::new(),
            error_tables: Vec::new(),
            json_types: Vec::new(),
            json_messages: Vec::new(),
            components: Vec::new(),
        }
    }

    /// All messages, including the parts of services and actions.
    pub fn all_messages(&self) -> impl Iterator<Item = MessageId> {
        let parts = self.interfaces.iter().flat_map(|interface| &interface.parts);
        self.messages.iter().chain(parts).copied()
    }

    /// The enum that an argument of an event refers to.
    pub fn event_enum(&self, reference: EventEnumRef) -> &EventEnum {
        &self.components[reference.component].enums[reference.index]
    }

    /// The type of an argument of an event, as written in event metadata of its component.
    pub fn event_type(&self, component: &EventComponent, argument: &EventArgument) -> String {
        let Some(reference) = argument.enumeration else { return scalar_name(argument.scalar).into_owned() };
        let owner = &self.components[reference.component];
        let name = &self.event_enum(reference).name;
        if owner.id == component.id { name.clone() } else { format!("{}::{name}", owner.namespace) }
    }

    /// True if the package contains no definitions.
    pub fn is_empty(&self) -> bool {
        self.messages.is_empty()
            && self.interfaces.is_empty()
            && self.error_tables.is_empty()
            && self.json_types.is_empty()
            && self.json_messages.is_empty()
            && self.components.is_empty()
    }
}

/// The form of definitions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Form {
    /// `.msg`, `.srv` and `.action` files.
    Msg(Dialect),
    /// Pages with specification tables.
    Table,
    /// Event metadata.
    Events,
}

impl Form {
    /// The name in `uavspec.toml` and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Msg(dialect) => dialect.name(),
            Self::Table => "table",
            Self::Events => "events",
        }
    }
}

/// A service or an action.
#[derive(Debug)]
pub struct Interface {
    /// The name.
    pub name: String,
    /// Service or action.
    pub kind: Kind,
    /// The parts in order: request and response, or goal, result and feedback.
    pub parts: Vec<MessageId>,
    /// The ROS type hash, if available.
    pub type_hash: Option<String>,
    /// The whole file.
    pub span: Span,
}

/// A message, or a part of a service or action.
#[derive(Debug)]
pub struct Message {
    /// The index of the package.
    pub package: usize,
    /// The kind of the file.
    pub kind: Kind,
    /// The name. The name of a part includes the suffix from ROS.
    pub name: String,
    /// The location of the file or part.
    pub span: Span,
    /// The header comment.
    pub docs: Docs,
    /// The topics of the message (PX4), in the listed order.
    pub topics: Vec<String>,
    /// `MESSAGE_VERSION` (PX4).
    pub version: Option<u32>,
    /// `ORB_QUEUE_LENGTH` (PX4).
    pub queue_length: Option<u32>,
    /// The fields, in declaration order.
    pub fields: Vec<Field>,
    /// The constants, in declaration order.
    pub constants: Vec<Constant>,
    /// The enums, in the order of the fields that use them.
    pub enums: Vec<Enum>,
    /// The groups, in declaration order.
    pub groups: Vec<Docs>,
    /// The memory layout in uORB, if the size is fixed.
    pub uorb: Option<UorbLayout>,
    /// The size in CDR.
    pub cdr: CdrSize,
    /// PX4's hash of the fields.
    pub hash: u32,
    /// The ROS type hash (RIHS01).
    pub type_hash: String,
}

impl Message {
    /// A message without fields. `package` is the index of its package.
    pub(crate) fn new(package: usize, kind: Kind, name: String, span: Span) -> Self {
        Self {
            package,
            kind,
            name,
            span,
            docs: Docs::default(),
            topics: Vec::new(),
            version: None,
            queue_length: None,
            fields: Vec::new(),
            constants: Vec::new(),
            enums: Vec::new(),
            groups: Vec::new(),
            uorb: None,
            cdr: CdrSize::default(),
            hash: 0,
            type_hash: String::new(),
        }
    }

    /// The message types of the fields, in order.
    pub fn nested(&self) -> impl Iterator<Item = MessageId> {
        self.fields.iter().filter_map(|field| match field.ty.element {
            Element::Message(id) => Some(id),
            Element::Scalar(_) | Element::Text(_) | Element::String { .. } => None,
        })
    }
}

/// The size of a message in CDR, in bytes, including the encapsulation header.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CdrSize {
    /// The minimum size.
    pub min: u64,
    /// True if all values have the minimum size.
    pub is_fixed: bool,
}

/// A type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Type {
    /// The element.
    pub element: Element,
    /// The number of elements.
    pub shape: Shape,
}

/// The type of a field, or of the elements of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Element {
    /// A number, a `bool`, a `byte` or a `char`.
    Scalar(Scalar),
    /// PX4's `char[N]`: one text of at most `N` bytes. In ROS 2, `char` is a number.
    Text(u32),
    /// A string.
    String {
        /// True for a `wstring`.
        wide: bool,
        /// The maximum length in characters.
        bound: Option<u32>,
    },
    /// A message.
    Message(MessageId),
}

impl Type {
    /// The type as written in a definition. A text is written as an array of `char`.
    #[must_use]
    pub fn written(self) -> Self {
        match self.element {
            Element::Text(length) => {
                Self { element: Element::Scalar(Scalar::Char), shape: Shape::Array(length) }
            }
            _ => self,
        }
    }

    /// The maximum number of elements of an array, or of bytes of a text.
    pub fn max_length(self) -> Option<u32> {
        let shape = self.written().shape;
        shape.bound().filter(|_| shape != Shape::Single)
    }
}

impl Element {
    /// The type of a number or a character.
    pub fn scalar(self) -> Option<Scalar> {
        match self {
            Self::Scalar(scalar) => Some(scalar),
            Self::Text(_) => Some(Scalar::Char),
            Self::String { .. } | Self::Message(_) => None,
        }
    }

    /// True for a float.
    pub fn is_float(self) -> bool {
        matches!(self, Self::Scalar(scalar) if scalar.is_float())
    }
}

/// A field.
#[derive(Debug)]
pub struct Field {
    /// The name.
    pub name: String,
    /// The type.
    pub ty: Type,
    /// The default (ROS 2).
    pub default: Option<Value>,
    /// The comment, without annotations.
    pub description: String,
    /// The index of the group in [`Message::groups`].
    pub group: Option<usize>,
    /// The unit: one of `crate::unit::UNITS`, or the unit as written.
    pub unit: Option<String>,
    /// The constraints, at most one of each kind, in the order of [`CONSTRAINTS`](constraint::CONSTRAINTS).
    pub constraints: Vec<constraint::Constraint>,
    /// The texts of the attributes, by name.
    pub attributes: BTreeMap<&'static str, String>,
    /// The prefixes of the constants, as written.
    pub enum_prefixes: Vec<String>,
    /// The enum with these prefixes.
    pub enumeration: Option<EnumRef>,
    /// False if the text only resembles an annotation with these prefixes. In that case, other values are also valid.
    pub is_enum_exact: bool,
    /// The index of the array field whose used elements this field counts.
    pub counts: Option<usize>,
    /// The declaration.
    pub span: Span,
}

impl Field {
    /// A field without annotations.
    pub(crate) fn new(name: String, ty: Type, span: Span) -> Self {
        Self {
            name,
            ty,
            default: None,
            description: String::new(),
            group: None,
            unit: None,
            constraints: Vec::new(),
            attributes: BTreeMap::new(),
            enum_prefixes: Vec::new(),
            enumeration: None,
            is_enum_exact: true,
            counts: None,
            span,
        }
    }

    /// The constraint of the given kind.
    pub fn constraint(&self, kind: &ConstraintKind) -> Option<&constraint::Constraint> {
        constraint::find(&self.constraints, kind)
    }

    /// True if a constraint restricts the values.
    pub fn is_restricted(&self) -> bool {
        !self.constraints.iter().all(constraint::Constraint::is_unbounded)
    }

    /// The text of an attribute.
    pub fn attribute(&self, attribute: &Attribute) -> Option<&str> {
        self.attributes.get(attribute.name).map(String::as_str)
    }

    /// The attributes and their texts, in the order of [`ATTRIBUTES`].
    pub fn attributes(&self) -> impl Iterator<Item = (&'static Attribute, &str)> {
        ATTRIBUTES.iter().filter_map(|attribute| Some((*attribute, self.attribute(attribute)?)))
    }

    /// True if the field is one text: `char[N]` of PX4.
    pub fn is_text(&self) -> bool {
        matches!(self.ty.element, Element::Text(_))
    }
}

/// A constant.
#[derive(Debug)]
pub struct Constant {
    /// The name.
    pub name: String,
    /// The type.
    pub ty: Element,
    /// The value, checked against the type's range.
    pub value: Value,
    /// The comment.
    pub description: String,
    /// The parameters of a command: seven, or an empty list.
    pub parameters: Vec<Parameter>,
    /// The index of the group in [`Message::groups`].
    pub group: Option<usize>,
    /// The declaration.
    pub span: Span,
}

/// Descriptions of unused parameters.
const UNUSED: [&str; 6] = ["", "-", "empty", "reserved", "unused", "n/a"];

/// A parameter of a command.
#[derive(Debug)]
pub struct Parameter {
    /// The unit.
    pub unit: Option<String>,
    /// The constraints, at most one of each kind, in the order of [`CONSTRAINTS`](constraint::CONSTRAINTS).
    pub constraints: Vec<constraint::Constraint>,
    /// The prefixes of the constants.
    pub enum_prefixes: Vec<String>,
    /// The description.
    pub description: String,
}

impl Parameter {
    /// True if the parameter is unused. All commands have seven parameters, even if they need fewer.
    pub fn is_unused(&self) -> bool {
        let text = self.description.trim().trim_end_matches('.').to_ascii_lowercase();
        let is_unrestricted = self.constraints.is_empty() && self.enum_prefixes.is_empty();
        is_unrestricted && UNUSED.contains(&text.as_str())
    }
}

/// The memory layout of a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UorbLayout {
    /// The size in bytes, including the padding at the end.
    pub size: usize,
    /// The size without the padding at the end.
    pub size_no_padding: usize,
    /// The members and the padding, by offset.
    pub slots: Vec<Slot>,
}

impl UorbLayout {
    /// The offset of each field, by the index of the field.
    pub fn offsets(&self) -> BTreeMap<usize, usize> {
        self.slots.iter().filter_map(|slot| Some((slot.field?, slot.offset))).collect()
    }
}

/// A member, or padding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Slot {
    /// The index of the field, or `None` for padding.
    pub field: Option<usize>,
    /// The name of the field, or `_paddingN`.
    pub name: String,
    /// The type, as written in a `.msg` file.
    pub type_text: String,
    /// The offset of the first byte.
    pub offset: usize,
    /// The length in bytes.
    pub size: usize,
}

impl Schema {
    /// The type with this id.
    pub fn json_type(&self, id: JsonTypeId) -> &JsonType {
        &self.json_types[id.0 as usize]
    }

    /// The message with this id.
    pub fn json_message(&self, id: JsonMessageId) -> &JsonMessage {
        &self.json_messages[id.0 as usize]
    }

    /// Resolves the aliases in `expression`. Returns `None` for types that are not aliases.
    pub fn plain(&self, expression: &Expression) -> Option<Expression> {
        match expression {
            Expression::Named(id) => match &self.json_type(*id).definition {
                // Aliases are not recursive, so this terminates.
                Definition::Named(typed) => self.plain(&typed.ty),
                Definition::Object(_) | Definition::Tuple(_) | Definition::Set(_) => None,
            },
            Expression::ErrorList => Some(Expression::List(Box::new(Expression::ErrorCode))),
            Expression::Either(alternatives) => {
                let plain = |inner: &Expression| self.plain(inner).unwrap_or_else(|| inner.clone());
                Some(Expression::Either(alternatives.iter().map(plain).collect()))
            }
            other => Some(other.clone()),
        }
    }

    /// An expression as written on pages. `name` formats the names of types.
    pub fn expression_text(&self, expression: &Expression, name: &dyn Fn(&str) -> String) -> String {
        let inner = |inner: &Expression| {
            let text = self.expression_text(inner, name);
            if matches!(inner, Expression::Either(_)) { format!("({text})") } else { text }
        };
        match expression {
            Expression::ErrorCode => name(ERROR_CODE),
            Expression::ErrorList => name(ERROR_LIST),
            Expression::Named(id) => name(&self.json_type(*id).name),
            Expression::List(element) => format!("list of {}", inner(element)),
            Expression::Map(value) => format!("map of {}", inner(value)),
            Expression::Either(all) => all.iter().map(inner).collect::<Vec<_>>().join(" or "),
            Expression::OneOf(constants) => {
                let constants: Vec<String> = constants.iter().map(|constant| quoted(constant)).collect();
                format!("one of {}", constants.join(", "))
            }
            built_in => built_in_name(built_in).to_owned(),
        }
    }
}

/// A constant, in quotes if required.
fn quoted(constant: &str) -> String {
    let is_word = !constant.is_empty()
        && !is_number(constant)
        && !constant.contains(|c: char| c.is_whitespace() || matches!(c, '(' | ')' | ',' | '"'));
    if is_word { constant.to_owned() } else { format!("\"{constant}\"") }
}
