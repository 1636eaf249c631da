//! Compares a format in a capture with its definition.

use std::collections::BTreeMap;
use std::fmt;

use uavspec_dynamic::{Field, MessageType};
use uavspec_model::Detail;
use uavspec_schema::{Element, shape_text};

/// The result of comparing a format with its definition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Comparison {
    /// The fields have the same types and positions.
    Equal,
    /// There are differences.
    Differs(Differences),
    /// There is no definition.
    Undefined,
}

/// The meaning of a field's position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Order {
    /// The offset in memory.
    Memory,
    /// The declaration order, which is also the order in CDR.
    Declared,
}

/// The differences between a format and its definition.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Differences {
    /// The fields that only the definition contains, as `name (type)`.
    pub missing: Vec<String>,
    /// The fields that only the format contains, as `name (type)`.
    pub extra: Vec<String>,
    /// The fields with different types, as `name (type, defined as type)`.
    pub retyped: Vec<String>,
    /// True if the fields are the same but have different positions.
    pub is_moved: bool,
    /// The names of fields whose nested messages differ.
    pub nested: Vec<String>,
    /// The fields that are optional in the format but not in the definition.
    pub optional: Vec<String>,
}

/// The maximum number of fields to list for each kind of difference.
const MAX_LISTED_ITEMS: usize = 8;

impl Differences {
    /// The differences, as the detail of a finding.
    pub fn detail(&self) -> Detail {
        Detail::new(self.to_string()).expected("the fields of the definition").actual("different fields")
    }
}

impl fmt::Display for Differences {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        let mut list = |label: &str, fields: &[String]| {
            if fields.is_empty() {
                return Ok(());
            }
            let reported = fields[..fields.len().min(MAX_LISTED_ITEMS)].join(", ");
            let more = fields.len().saturating_sub(MAX_LISTED_ITEMS);
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            write!(formatter, "{separator}{label} {reported}{more}")?;
            separator = "; ";
            Ok(())
        };
        list("missing fields:", &self.missing)?;
        list("additional fields:", &self.extra)?;
        list("fields of a different type:", &self.retyped)?;
        list("different nested messages:", &self.nested)?;
        list("fields that aren't required:", &self.optional)?;
        if self.is_moved {
            write!(formatter, "{separator}fields at different positions")?;
        }
        Ok(())
    }
}

/// Compares the memory layout of a format with the layout of the definition.
pub fn compare(format: MessageType<'_>, defined: MessageType<'_>) -> Comparison {
    compare_in(Order::Memory, format, defined)
}

/// Compares a declared type with the definition by field order, which determines the CDR encoding. In ROS 2, `char` is
/// `uint8`.
pub fn compare_declared(declared: MessageType<'_>, defined: MessageType<'_>) -> Comparison {
    compare_in(Order::Declared, declared, defined)
}

/// Compares two texts that PX4's message hash covers: a line with type and name for each field.
pub fn compare_texts(found: &str, defined: &str) -> Differences {
    let relation =
        |found: &str, defined: &str| if found == defined { Relation::Equal } else { Relation::OtherType };
    differences(&by_name(found), &by_name(defined), str::to_owned, relation)
}

/// The relation between two fields of the same name.
enum Relation {
    Equal,
    OtherType,
    /// The nested messages differ.
    OtherContent,
}

/// The differences between the fields of two unequal types, by name. `text` formats the type of a field.
fn differences<T: Copy>(
    found: &BTreeMap<&str, T>,
    expected: &BTreeMap<&str, T>,
    text: impl Fn(T) -> String,
    relation: impl Fn(T, T) -> Relation,
) -> Differences {
    let mut differences = Differences::default();
    for (name, field) in expected {
        let Some(other) = found.get(name) else {
            differences.missing.push(format!("{name} ({})", text(*field)));
            continue;
        };
        match relation(*other, *field) {
            Relation::Equal => {}
            Relation::OtherType => {
                let (found, defined) = (text(*other), text(*field));
                differences.retyped.push(format!("{name} ({found}, defined as {defined})"));
            }
            Relation::OtherContent => differences.nested.push((*name).to_owned()),
        }
    }
    let extra = found.iter().filter(|(name, _)| !expected.contains_key(*name));
    differences.extra = extra.map(|(name, field)| format!("{name} ({})", text(*field))).collect();
    // If the fields are equal, only their positions can differ.
    differences.is_moved = differences == Differences::default();
    differences
}

/// The types of the fields, by name.
fn by_name(text: &str) -> BTreeMap<&str, &str> {
    text.lines().filter_map(|line| line.split_once(' ')).map(|(ty, name)| (name, ty)).collect()
}

fn compare_in(order: Order, format: MessageType<'_>, defined: MessageType<'_>) -> Comparison {
    if order.is_equal(format, defined) {
        Comparison::Equal
    } else {
        Comparison::Differs(order.differences(format, defined))
    }
}

impl Order {
    /// The fields of a message type in this order. The formats in logs list fields in memory order, but definitions
    /// list them in any order.
    fn fields(self, message_type: MessageType<'_>) -> Vec<&Field> {
        let mut fields: Vec<&Field> = message_type.fields().iter().collect();
        if self == Self::Memory {
            fields.sort_unstable_by_key(|field| field.offset);
        }
        fields
    }

    /// True if there are no differences.
    fn is_equal(self, format: MessageType<'_>, defined: MessageType<'_>) -> bool {
        let is_same = |(left, right): (&&Field, &&Field)| {
            left.name == right.name
                && (self == Self::Declared || left.offset == right.offset)
                && self.is_same_type(left, right)
                && self.is_same_content((format, left), (defined, right))
        };
        let (found, expected) = (self.fields(format), self.fields(defined));
        (self == Self::Declared || format.size() == defined.size())
            && found.len() == expected.len()
            && found.iter().zip(&expected).all(is_same)
    }

    /// True if two fields have the same type. Nested messages aren't compared.
    fn is_same_type(self, left: &Field, right: &Field) -> bool {
        match (left.element, right.element) {
            (Element::Message(_), Element::Message(_)) => left.shape == right.shape,
            _ => match self {
                Self::Memory => type_text(left) == type_text(right),
                Self::Declared => in_ros(&type_text(left)) == in_ros(&type_text(right)),
            },
        }
    }

    /// True if two fields of the same type have equal nested messages, if any.
    fn is_same_content(
        self,
        (format, left): (MessageType<'_>, &Field),
        (defined, right): (MessageType<'_>, &Field),
    ) -> bool {
        match (left.element, right.element) {
            (Element::Message(left), Element::Message(right)) => {
                self.is_equal(format.nested(left), defined.nested(right))
            }
            _ => true,
        }
    }

    /// The differences between two unequal types.
    fn differences(self, format: MessageType<'_>, defined: MessageType<'_>) -> Differences {
        let relation = |left: &Field, right: &Field| {
            if !self.is_same_type(left, right) {
                Relation::OtherType
            } else if self.is_same_content((format, left), (defined, right)) {
                Relation::Equal
            } else {
                Relation::OtherContent
            }
        };
        differences(&fields_by_name(format), &fields_by_name(defined), type_text, relation)
    }
}

fn fields_by_name(message_type: MessageType<'_>) -> BTreeMap<&str, &Field> {
    message_type.fields().iter().map(|field| (&*field.name, field)).collect()
}

/// The equivalent type in ROS 2.
fn in_ros(ty: &str) -> String {
    match ty.strip_prefix("char") {
        Some(shape) => format!("uint8{shape}"),
        None => ty.to_owned(),
    }
}

/// The type in the notation of definitions. Logs name messages differently, so all nested messages are called
/// `message`.
fn type_text(field: &Field) -> String {
    let element = match field.element {
        Element::Scalar(scalar) => scalar.name().to_owned(),
        Element::Text(length) => return format!("char[{length}]"),
        Element::String { wide, bound } => {
            let bound = bound.map(|bound| format!("<={bound}")).unwrap_or_default();
            format!("{}{bound}", if wide { "wstring" } else { "string" })
        }
        Element::Message(_) => "message".to_owned(),
    };
    element + &shape_text(field.shape)
}
