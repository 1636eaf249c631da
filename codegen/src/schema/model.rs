//! The model: packages, messages and their parts.

use std::collections::BTreeMap;

use uavspec_runtime::Scalar;

use super::documentation::Docs;
use super::enumeration::{Enum, EnumRef};
use super::error_codes::ErrorTable;
use super::id::MessageId;
use super::json_type::{
    Definition, ERROR_CODE, ERROR_LIST, Expression, JsonMessage, JsonMessageId, JsonType, JsonTypeId,
};
use crate::msg::ast::Shape;
use crate::msg::attribute::{ATTRIBUTES, Attribute};
use crate::msg::constraint::{self, ConstraintKind};
use crate::msg::{Dialect, Kind};
use crate::source::Span;
use crate::table::type_table::is_number;
use crate::value::Value;

/// All packages of a run.
#[derive(Debug, Default)]
pub struct Schema {
    /// The packages, by name.
    pub packages: Vec<Package>,
    /// All messages, those that are parts of services and actions too, by package and name.
    pub messages: Vec<Message>,
    /// All messages, each after those that it holds.
    pub nested_first: Vec<MessageId>,
    /// All types of pages, by package and name.
    pub json_types: Vec<JsonType>,
    /// All messages of pages, by package and name.
    pub json_messages: Vec<JsonMessage>,
}

impl Schema {
    /// The message that `id` names.
    pub fn message(&self, id: MessageId) -> &Message {
        &self.messages[id.0 as usize]
    }

    /// The package that a message belongs to.
    pub fn package_of(&self, message: &Message) -> &Package {
        &self.packages[message.package]
    }

    /// The enum that `reference` names.
    pub fn enumeration(&self, reference: EnumRef) -> &Enum {
        &self.message(reference.message).enums[reference.index]
    }

    /// The type of a field as a `.msg` file of that field's package writes it.
    pub fn type_text(&self, message: &Message, ty: Type) -> String {
        let element = match ty.element {
            Element::Scalar(scalar) => scalar.name().to_owned(),
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

/// Definitions that belong together, in one form.
#[derive(Debug)]
pub struct Package {
    /// Its name.
    pub name: String,
    /// The form of its definitions.
    pub form: Form,
    /// The name that ROS knows it by, which type hashes contain.
    pub ros_package: String,
    /// Where its definitions come from.
    pub origin: Option<String>,
    /// Which state of the origin they follow.
    pub revision: Option<String>,
    /// Its messages, by name.
    pub messages: Vec<MessageId>,
    /// Its services and actions, by kind and name.
    pub interfaces: Vec<Interface>,
    /// Its error-code tables, by their first code.
    pub error_tables: Vec<ErrorTable>,
    /// The types that its pages define, by name.
    pub json_types: Vec<JsonTypeId>,
    /// The messages that its pages define, by name.
    pub json_messages: Vec<JsonMessageId>,
}

impl Package {
    /// Whether it defines nothing.
    pub fn is_empty(&self) -> bool {
        self.messages.is_empty()
            && self.interfaces.is_empty()
            && self.error_tables.is_empty()
            && self.json_types.is_empty()
            && self.json_messages.is_empty()
    }
}

/// In what form definitions are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Form {
    /// `.msg` files and their relatives.
    Msg(Dialect),
    /// Pages with specification tables.
    Table,
}

impl Form {
    /// Its name in `uavspec.toml` and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Msg(dialect) => dialect.name(),
            Self::Table => "table",
        }
    }
}

/// A service or an action.
#[derive(Debug)]
pub struct Interface {
    /// Its name.
    pub name: String,
    /// Service or action.
    pub kind: Kind,
    /// Its parts in order: request and response; or goal, result and feedback.
    pub parts: Vec<MessageId>,
    /// Its ROS type hash, where it has one.
    pub type_hash: Option<String>,
    /// Its whole file.
    pub span: Span,
}

/// A message, or a part of a service or action.
#[derive(Debug)]
pub struct Message {
    /// Index of its package.
    pub package: usize,
    /// What kind of file defines it.
    pub kind: Kind,
    /// Its name; of a part, with the suffix that ROS gives it.
    pub name: String,
    /// Its file, or its part of it.
    pub span: Span,
    /// What the header comment says.
    pub docs: Docs,
    /// Topics that carry it (PX4), in the order in which they are listed.
    pub topics: Vec<String>,
    /// `MESSAGE_VERSION` (PX4).
    pub version: Option<u32>,
    /// `ORB_QUEUE_LENGTH` (PX4).
    pub queue_length: Option<u32>,
    /// Its fields, in declared order.
    pub fields: Vec<Field>,
    /// Its constants, in declared order.
    pub constants: Vec<Constant>,
    /// Its enums, in the order of the fields that use them.
    pub enums: Vec<Enum>,
    /// Its groups, in declared order.
    pub groups: Vec<Docs>,
    /// Its memory layout in uORB, where its size is fixed.
    pub uorb: Option<UorbLayout>,
    /// Size of its CDR form.
    pub cdr: CdrSize,
    /// PX4's hash of its fields.
    pub hash: u32,
    /// Its ROS type hash (RIHS01).
    pub type_hash: String,
}

/// Size of a message in CDR, in bytes, with the encapsulation header.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CdrSize {
    /// The least that a value takes.
    pub least: u64,
    /// Whether all values take that.
    pub is_fixed: bool,
}

/// A type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Type {
    /// The element.
    pub element: Element,
    /// How many of them.
    pub shape: Shape,
}

/// Type of a field, or of the elements of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Element {
    /// A number, a `bool`, a `byte` or a `char`.
    Scalar(Scalar),
    /// A string.
    String {
        /// Whether it is a `wstring`.
        wide: bool,
        /// Greatest length in characters.
        bound: Option<u32>,
    },
    /// A message.
    Message(MessageId),
}

/// A field.
#[derive(Debug)]
pub struct Field {
    /// Its name.
    pub name: String,
    /// Its type.
    pub ty: Type,
    /// Its default (ROS 2).
    pub default: Option<Value>,
    /// What its comment says, annotations taken out.
    pub description: String,
    /// Index of its group in [`Message::groups`].
    pub group: Option<usize>,
    /// Its unit: one of `crate::unit::UNITS`, or as written.
    pub unit: Option<String>,
    /// Its constraints, one of a kind, in the order of [`CONSTRAINTS`](constraint::CONSTRAINTS).
    pub constraints: Vec<constraint::Constraint>,
    /// The texts of its attributes, by their names.
    pub attributes: BTreeMap<&'static str, String>,
    /// The prefixes of the constants that it holds, as written.
    pub enum_prefixes: Vec<String>,
    /// The enum that these give.
    pub enumeration: Option<EnumRef>,
    /// Index of the array field whose entries in use it counts.
    pub counts: Option<usize>,
    /// Its declaration.
    pub span: Span,
}

impl Field {
    /// The constraint of a kind.
    pub fn constraint(&self, kind: &ConstraintKind) -> Option<&constraint::Constraint> {
        constraint::find(&self.constraints, kind)
    }

    /// The text of an attribute.
    pub fn attribute(&self, attribute: &Attribute) -> Option<&str> {
        self.attributes.get(attribute.name).map(String::as_str)
    }

    /// Its attributes with their texts, in the order of [`ATTRIBUTES`].
    pub fn attributes(&self) -> impl Iterator<Item = (&'static Attribute, &str)> {
        ATTRIBUTES.iter().filter_map(|attribute| Some((*attribute, self.attribute(attribute)?)))
    }

    /// Whether PX4 reads it as text: `char[N]`.
    pub fn is_text(&self, dialect: Dialect) -> bool {
        dialect == Dialect::Px4
            && self.ty.element == Element::Scalar(Scalar::Char)
            && matches!(self.ty.shape, Shape::Array(_))
    }
}

/// A constant.
#[derive(Debug)]
pub struct Constant {
    /// Its name.
    pub name: String,
    /// Its type.
    pub ty: Element,
    /// Its value, which its type holds.
    pub value: Value,
    /// What its comment says.
    pub description: String,
    /// Parameters of a command: seven, or none.
    pub parameters: Vec<Parameter>,
    /// Index of its group in [`Message::groups`].
    pub group: Option<usize>,
    /// Its declaration.
    pub span: Span,
}

/// What descriptions say of a parameter that means nothing.
const UNUSED: [&str; 6] = ["", "-", "empty", "reserved", "unused", "n/a"];

/// A parameter of a command.
#[derive(Debug)]
pub struct Parameter {
    /// Its unit.
    pub unit: Option<String>,
    /// Its constraints, one of a kind, in the order of [`CONSTRAINTS`](constraint::CONSTRAINTS).
    pub constraints: Vec<constraint::Constraint>,
    /// The prefixes of the constants that it holds.
    pub enum_prefixes: Vec<String>,
    /// What is said of it.
    pub description: String,
}

impl Parameter {
    /// Whether it means nothing: commands have seven parameters, however few they need.
    pub fn is_unused(&self) -> bool {
        let text = self.description.trim().trim_end_matches('.').to_ascii_lowercase();
        let says_nothing = self.constraints.is_empty() && self.enum_prefixes.is_empty();
        says_nothing && UNUSED.contains(&text.as_str())
    }
}

/// Where each member of a message lies in memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UorbLayout {
    /// Size with the padding at the end, in bytes.
    pub size: usize,
    /// Size without it.
    pub size_no_padding: usize,
    /// Members and padding in the order of their offsets.
    pub slots: Vec<Slot>,
}

/// A member, or padding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Slot {
    /// Index of the field; none for padding.
    pub field: Option<usize>,
    /// Name of the field, or `_paddingN`.
    pub name: String,
    /// Its type as a `.msg` file writes it.
    pub type_text: String,
    /// Its first byte.
    pub offset: usize,
    /// Its length in bytes.
    pub size: usize,
}

impl Schema {
    /// The type that `id` names.
    pub fn json_type(&self, id: JsonTypeId) -> &JsonType {
        &self.json_types[id.0 as usize]
    }

    /// The message that `id` names.
    pub fn json_message(&self, id: JsonMessageId) -> &JsonMessage {
        &self.json_messages[id.0 as usize]
    }

    /// What `expression` is once the names in it that stand for other types are read as those; none where nothing
    /// can be said of its values beyond what the definitions say.
    pub(crate) fn plain(&self, expression: &Expression) -> Option<Expression> {
        match expression {
            Expression::Named(id) => match &self.json_type(*id).definition {
                // Names don't stand for themselves, so this ends.
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

    /// An expression as pages write it; `name` writes the names of types.
    pub fn expression_text(&self, expression: &Expression, name: &dyn Fn(&str) -> String) -> String {
        let inner = |inner: &Expression| {
            let text = self.expression_text(inner, name);
            if matches!(inner, Expression::Either(_)) { format!("({text})") } else { text }
        };
        match expression {
            Expression::Any => "any".to_owned(),
            Expression::Null => "null".to_owned(),
            Expression::Boolean => "boolean".to_owned(),
            Expression::Integer => "integer".to_owned(),
            Expression::Number => "number".to_owned(),
            Expression::String => "string".to_owned(),
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
        }
    }
}

/// A constant, between quotes where it has to be.
fn quoted(constant: &str) -> String {
    let is_word = !constant.is_empty()
        && !is_number(constant)
        && !constant.contains(|c: char| c.is_whitespace() || matches!(c, '(' | ')' | ',' | '"'));
    if is_word { constant.to_owned() } else { format!("\"{constant}\"") }
}
