//! A format that a source states, beside the definition that it should equal.

use std::collections::BTreeMap;
use std::fmt;

use uavspec_codegen::dynamic::{MessageType, Placed, PlacedElement};
use uavspec_codegen::schema::shape_text;

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
const MAX_TOLD: usize = 8;

impl fmt::Display for Differences {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        let mut list = |what: &str, fields: &[String]| {
            if fields.is_empty() {
                return Ok(());
            }
            let told = fields[..fields.len().min(MAX_TOLD)].join(", ");
            let more = fields.len().saturating_sub(MAX_TOLD);
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            write!(formatter, "{separator}{what} {told}{more}")?;
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
pub fn compare(format: MessageType<'_>, defined: MessageType<'_>) -> Comparison {
    compare_in(Order::Memory, format, defined)
}

/// Compares a type that a source declares with that of the definition, as they follow each other in CDR. ROS 2
/// knows `char` as `uint8`.
pub fn compare_declared(declared: MessageType<'_>, defined: MessageType<'_>) -> Comparison {
    compare_in(Order::Declared, declared, defined)
}

fn compare_in(order: Order, format: MessageType<'_>, defined: MessageType<'_>) -> Comparison {
    let by_name = |of| -> BTreeMap<&str, Placed<'_>> {
        MessageType::layout(of).map(|field| (field.name, field)).collect()
    };
    let (found, expected) = (by_name(format), by_name(defined));
    let mut differences = Differences::default();
    for (name, field) in &expected {
        let ty = type_text(*field);
        let Some(other) = found.get(name) else {
            differences.missing.push(format!("{name} ({ty})"));
            continue;
        };
        let other_ty = type_text(*other);
        let is_same = match order {
            Order::Memory => other_ty == ty,
            Order::Declared => in_ros(&other_ty) == in_ros(&ty),
        };
        if !is_same {
            differences.retyped.push(format!("{name} ({other_ty}, defined as {ty})"));
        } else if let (PlacedElement::Message(left), PlacedElement::Message(right)) =
            (other.element, field.element)
            && compare_in(order, left, right) != Comparison::Equal
        {
            differences.nested.push((*name).to_owned());
        }
    }
    let extra = found.iter().filter(|(name, _)| !expected.contains_key(*name));
    differences.extra = extra.map(|(name, field)| format!("{name} ({})", type_text(*field))).collect();
    let places = |of: MessageType<'_>| -> Vec<(usize, String)> {
        let mut places: Vec<_> = of.layout().map(|field| (field.offset, field.name.to_owned())).collect();
        places.sort();
        places
    };
    if differences == Differences::default() {
        let is_same = match order {
            Order::Memory => places(format) == places(defined) && format.size() == defined.size(),
            Order::Declared => format.field_names().eq(defined.field_names()),
        };
        differences.is_moved = !is_same;
    }
    if differences == Differences::default() { Comparison::Equal } else { Comparison::Differs(differences) }
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
