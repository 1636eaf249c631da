//! A format that a source states, beside the definition that it should equal.

use std::collections::BTreeMap;
use std::fmt;

use uavspec_codegen::dynamic::{MessageType, Placed, PlacedElement};
use uavspec_codegen::schema::shape_text;

use crate::model::Detail;

/// How a format stands to the definition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Comparison {
    /// The same fields of the same types at the same places.
    Equal,
    /// Something differs.
    Differs(Differences),
    /// No definition is known for it.
    Undefined,
}

/// What the places of fields are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Order {
    /// Where they lie in memory.
    Memory,
    /// In which order they are declared, and so follow each other in CDR.
    Declared,
}

/// What differs between a format and the definition.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Differences {
    /// Fields that only the definition has, as `name (type)`.
    pub missing: Vec<String>,
    /// Fields that only the format has.
    pub extra: Vec<String>,
    /// Fields of another type: `name (type, defined as type)`.
    pub retyped: Vec<String>,
    /// Whether the fields are the same and stand at other places.
    pub is_moved: bool,
    /// Names of nested messages that differ.
    pub nested: Vec<String>,
    /// Fields that the format lets away, and the definition doesn't.
    pub optional: Vec<String>,
}

/// Fields that are told at most of each kind.
const MAX_LISTED_ITEMS: usize = 8;

impl Differences {
    /// What is said of them.
    pub(crate) fn detail(&self) -> Detail {
        Detail::new(self.to_string()).expected("the fields of the definition").actual("other fields")
    }
}

impl fmt::Display for Differences {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        let mut list = |what: &str, fields: &[String]| {
            if fields.is_empty() {
                return Ok(());
            }
            let reported = fields[..fields.len().min(MAX_LISTED_ITEMS)].join(", ");
            let more = fields.len().saturating_sub(MAX_LISTED_ITEMS);
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            write!(formatter, "{separator}{what} {reported}{more}")?;
            separator = "; ";
            Ok(())
        };
        list("it lacks", &self.missing)?;
        list("it also has", &self.extra)?;
        list("of another type:", &self.retyped)?;
        list("other contents of", &self.nested)?;
        list("it doesn't require", &self.optional)?;
        if self.is_moved {
            write!(formatter, "{separator}its fields lie at other places")?;
        }
        Ok(())
    }
}

/// Compares a format with the type of the definition, as they lie in memory.
pub(crate) fn compare(format: MessageType<'_>, defined: MessageType<'_>) -> Comparison {
    compare_in(Order::Memory, format, defined)
}

/// Compares a type that a source declares with that of the definition, as they follow each other in CDR. ROS 2
/// knows `char` as `uint8`.
pub(crate) fn compare_declared(declared: MessageType<'_>, defined: MessageType<'_>) -> Comparison {
    compare_in(Order::Declared, declared, defined)
}

fn compare_in(order: Order, format: MessageType<'_>, defined: MessageType<'_>) -> Comparison {
    if order.is_equal(format, defined) {
        Comparison::Equal
    } else {
        Comparison::Differs(order.differences(format, defined))
    }
}

impl Order {
    /// The fields in this order. Formats of logs come in the order of memory, definitions in any.
    fn fields(self, of: MessageType<'_>) -> Vec<Placed<'_>> {
        let mut fields: Vec<Placed<'_>> = of.layout().collect();
        if self == Self::Memory {
            fields.sort_unstable_by_key(|field| field.offset);
        }
        fields
    }

    /// Whether all is the same.
    fn is_equal(self, format: MessageType<'_>, defined: MessageType<'_>) -> bool {
        let is_same = |(left, right): (&Placed<'_>, &Placed<'_>)| {
            left.name == right.name
                && (self == Self::Declared || left.offset == right.offset)
                && self.is_same_type(*left, *right)
                && self.is_same_content(*left, *right)
        };
        let (found, expected) = (self.fields(format), self.fields(defined));
        (self == Self::Declared || format.size() == defined.size())
            && found.len() == expected.len()
            && found.iter().zip(&expected).all(is_same)
    }

    /// Whether two fields are of the same type, as far as a message is one.
    fn is_same_type(self, left: Placed<'_>, right: Placed<'_>) -> bool {
        match (left.element, right.element) {
            (PlacedElement::Message(_), PlacedElement::Message(_)) => left.shape == right.shape,
            _ => match self {
                Self::Memory => type_text(left) == type_text(right),
                Self::Declared => in_ros(&type_text(left)) == in_ros(&type_text(right)),
            },
        }
    }

    /// Whether two fields of the same type nest the same messages, if they do so.
    fn is_same_content(self, left: Placed<'_>, right: Placed<'_>) -> bool {
        match (left.element, right.element) {
            (PlacedElement::Message(left), PlacedElement::Message(right)) => self.is_equal(left, right),
            _ => true,
        }
    }

    /// What differs between two that aren't equal.
    fn differences(self, format: MessageType<'_>, defined: MessageType<'_>) -> Differences {
        let by_name = |of| -> BTreeMap<&str, Placed<'_>> {
            MessageType::layout(of).map(|field| (field.name, field)).collect()
        };
        let (found, expected) = (by_name(format), by_name(defined));
        let mut differences = Differences::default();
        for (name, field) in &expected {
            match found.get(name) {
                None => differences.missing.push(format!("{name} ({})", type_text(*field))),
                Some(other) if !self.is_same_type(*other, *field) => {
                    let (found, defined) = (type_text(*other), type_text(*field));
                    differences.retyped.push(format!("{name} ({found}, defined as {defined})"));
                }
                Some(other) if !self.is_same_content(*other, *field) => {
                    differences.nested.push((*name).to_owned());
                }
                Some(_) => {}
            }
        }
        let extra = found.iter().filter(|(name, _)| !expected.contains_key(*name));
        differences.extra = extra.map(|(name, field)| format!("{name} ({})", type_text(*field))).collect();
        // What else may differ than the fields themselves.
        differences.is_moved = differences == Differences::default();
        differences
    }
}

/// A type as ROS 2 sends it.
fn in_ros(ty: &str) -> String {
    match ty.strip_prefix("char") {
        Some(shape) => format!("uint8{shape}"),
        None => ty.to_owned(),
    }
}

/// A type in the words of definitions; messages by what they are, as logs name them otherwise.
fn type_text(field: Placed<'_>) -> String {
    let element = match field.element {
        PlacedElement::Scalar(scalar) => scalar.name().to_owned(),
        PlacedElement::Text(length) => return format!("char[{length}]"),
        PlacedElement::String => "string".to_owned(),
        PlacedElement::Message(_) => "message".to_owned(),
    };
    element + &shape_text(field.shape)
}
