//! The constraints on single values, compiled once from the definitions. The checks of memory, CDR and JSON share these
//! constraints.
//!
//! An encoding only determines how a value is read. This module contains the constraints, their rules, the messages for
//! violations, the number of values that each rule covers, and the number of entries in use in counted arrays.

use std::collections::BTreeMap;
use std::fmt;

use uavspec_model::{Detail, Findings, Rule};
use uavspec_runtime::{ConstraintKind, Number, Scalar};
use uavspec_schema::source::Span;
use uavspec_schema::{Dialect, Form, MessageId, Restriction, Schema, Shape};

/// The rules on single values.
#[derive(Debug)]
pub struct ValueRules {
    /// A bool is 0 or 1.
    pub bool: &'static Rule,
    /// Text is valid Unicode.
    pub text: &'static Rule,
    /// A number satisfies each demand of its restriction.
    pub number: fn(ConstraintKind) -> &'static Rule,
    /// A JSON object has each field of its message exactly once, and no others.
    pub members: &'static Rule,
    /// A JSON value has the type of its field.
    pub json_type: &'static Rule,
    /// A JSON array has the length that its field requires.
    pub length: &'static Rule,
}

/// The encodings of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    /// Payloads in memory, including messages decoded from CDR.
    Memory,
    Json,
}

/// The fields that a JSON Schema in a capture shares with a differing definition. True if the schema requires the field.
pub type SharedFields = BTreeMap<String, bool>;

/// The constraints on the values of all messages in a schema.
#[derive(Debug)]
pub struct Plans {
    pub(super) rules: &'static ValueRules,
    /// The constraints of each message, in the order of the schema.
    messages: Vec<MessagePlan>,
}

/// The constraints on the values of a message.
#[derive(Debug)]
pub(crate) struct MessagePlan {
    pub(super) name: String,
    pub(super) fields: Vec<FieldPlan>,
    pub(super) span: Span,
    /// True if the dialect distinguishes text from numbers.
    pub(super) has_text: bool,
    /// For each rule, the number of values that it covers in a JSON message. A sequence counts as one value.
    coverage: Coverage,
}

/// The constraints on the values of a field.
#[derive(Debug)]
pub(super) struct FieldPlan {
    pub(super) name: String,
    pub(super) element: Element,
    /// The number of elements. Text is a single element.
    pub(super) shape: Shape,
    pub(super) restriction: Option<Restriction>,
    /// The values with a special meaning, including values that the restriction allows.
    pub(super) special: Vec<Number>,
    /// The field that contains the number of used entries, if there is one.
    pub(super) counted_by: Option<usize>,
    /// The array whose used entries this field counts, if there is one.
    pub(super) counts: Option<usize>,
    pub(super) span: Span,
    /// The offset from the start of the message in memory; 0 if the message has no fixed size.
    pub(super) offset: usize,
    /// The distance between elements in memory, in bytes.
    pub(super) stride: usize,
}

/// The type of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Element {
    Scalar(Scalar),
    /// PX4's `char[N]`.
    Text(u32),
    String {
        is_wide: bool,
        bound: Option<u32>,
    },
    Message(MessageId),
}

/// The constraints on one value.
#[derive(Clone, Copy, Debug)]
pub(super) struct Constraint<'c> {
    pub(super) element: Element,
    /// The number of elements in the value's field.
    pub(super) shape: Shape,
    pub(super) restriction: Option<&'c Restriction>,
}

/// A violation of a constraint.
#[derive(Debug)]
pub(super) enum Violation<'c> {
    /// A bool whose byte is neither 0 nor 1.
    Bool(u8),
    /// A JSON value with the wrong type, or out of the range of an integer type.
    Type,
    /// A finite JSON number that becomes infinite in the type of its field.
    TooLarge(Scalar),
    /// A number that violates a demand of its restriction.
    Number(ConstraintKind, Number, &'c Restriction),
    /// An array, sequence or string in JSON with the wrong length.
    Length { found: usize, unit: &'static str, shape: Shape },
    /// A NUL within a JSON string. The NUL would terminate the text.
    Nul(usize),
    /// Text with invalid UTF-8 at this byte.
    NotUtf8(usize),
    /// A `wstring` with an unpaired surrogate at this code unit.
    NotUtf16(usize),
}

/// Rules, each with the number of values that it covers.
#[derive(Debug, Default)]
pub(super) struct Coverage(Vec<(&'static Rule, u64)>);

impl Coverage {
    pub(super) fn add(&mut self, rule: &'static Rule, values: u64) {
        match self.0.iter_mut().find(|(known, _)| std::ptr::eq(*known, rule)) {
            Some((_, sum)) => *sum = sum.saturating_add(values),
            None => self.0.push((rule, values)),
        }
    }

    /// Adds the coverage of a nested message that occurs `times` times.
    fn add_nested(&mut self, nested: &Self, times: u64) {
        for (rule, values) in &nested.0 {
            self.add(rule, values.saturating_mul(times));
        }
    }

    /// Counts this many messages as covered.
    pub(super) fn count(&self, messages: u64, findings: &mut Findings) {
        for (rule, values) in &self.0 {
            findings.cover(rule, values.saturating_mul(messages));
        }
    }
}

impl<'c> Constraint<'c> {
    /// The rules that a value can violate in an encoding.
    pub(super) fn rules(
        self,
        encoding: Encoding,
        rules: &'static ValueRules,
    ) -> impl Iterator<Item = &'static Rule> + use<> {
        let is_json = encoding == Encoding::Json;
        let is_bounded = matches!(self.shape, Shape::Array(_) | Shape::Bounded(_))
            || matches!(self.element, Element::Text(_) | Element::String { bound: Some(_), .. });
        let restriction = self.restriction.map(|restriction| restriction.constraint().rules());
        let applicable = [
            (is_json, rules.json_type),
            (is_json && is_bounded, rules.length),
            (!is_json && self.element == Element::Scalar(Scalar::Bool), rules.bool),
            (matches!(self.element, Element::Text(_)), rules.text),
            // A string in JSON is always Unicode.
            (!is_json && matches!(self.element, Element::String { .. }), rules.text),
        ];
        let applicable = applicable.into_iter().filter(|(applies, _)| *applies).map(|(_, rule)| rule);
        applicable.chain(restriction.into_iter().flatten().map(rules.number))
    }

    /// Checks the little-endian bytes of a value in memory.
    pub(super) fn check_bytes(self, bytes: &[u8]) -> Result<(), Violation<'c>> {
        match self.element {
            Element::Scalar(Scalar::Bool) => match bytes.first() {
                Some(byte @ 2..) => Err(Violation::Bool(*byte)),
                _ => Ok(()),
            },
            Element::Scalar(scalar) => number(scalar, bytes).map_or(Ok(()), |found| self.check_number(found)),
            Element::Text(_) => check_text(bytes),
            Element::String { is_wide, .. } => check_string(bytes, is_wide),
            Element::Message(_) => Ok(()),
        }
    }

    /// Checks a number.
    pub(super) fn check_number(self, found: Number) -> Result<(), Violation<'c>> {
        let Some(restriction) = self.restriction else { return Ok(()) };
        match restriction.constraint().violated_by(found) {
            None => Ok(()),
            Some(demand) => Err(Violation::Number(demand, found, restriction)),
        }
    }
}

/// Checks the bytes of a text up to the first NUL.
pub(super) fn check_text<'c>(bytes: &[u8]) -> Result<(), Violation<'c>> {
    let end = memchr::memchr(0, bytes).unwrap_or(bytes.len());
    match std::str::from_utf8(&bytes[..end]) {
        Ok(_) => Ok(()),
        Err(error) => Err(Violation::NotUtf8(error.valid_up_to())),
    }
}

/// Checks the bytes of a string in memory, where a `wstring` is UTF-8 except for its unpaired surrogates.
fn check_string<'c>(bytes: &[u8], is_wide: bool) -> Result<(), Violation<'c>> {
    let Err(error) = std::str::from_utf8(bytes) else { return Ok(()) };
    if !is_wide {
        return Err(Violation::NotUtf8(error.valid_up_to()));
    }
    let before = bytes.utf8_chunks().next().map_or("", |chunk| chunk.valid());
    Err(Violation::NotUtf16(before.encode_utf16().count()))
}

impl Violation<'_> {
    /// The violated rule.
    pub(super) fn rule(&self, rules: &ValueRules) -> &'static Rule {
        match self {
            Self::Bool(_) => rules.bool,
            Self::Type | Self::TooLarge(_) => rules.json_type,
            Self::Number(demand, ..) => (rules.number)(*demand),
            Self::Length { .. } => rules.length,
            Self::Nul(_) | Self::NotUtf8(_) | Self::NotUtf16(_) => rules.text,
        }
    }

    /// True if the violation concerns the value itself rather than its notation. Violations of this kind count only for
    /// array entries in use.
    pub(super) fn is_of_value(&self) -> bool {
        matches!(self, Self::Bool(_) | Self::Number(..) | Self::Nul(_) | Self::NotUtf8(_) | Self::NotUtf16(_))
    }

    /// The detail of a finding. For JSON, `expected` describes the type of the field, and `found` is the text of the
    /// value.
    pub(super) fn detail(&self, expected: &dyn fmt::Display, found: &str) -> Detail {
        match self {
            Self::Bool(byte) => Detail::new(format!("expected 0 or 1, found {byte}"))
                .expected("0 or 1")
                .actual(byte.to_string()),
            Self::Type => Detail::differs(expected, found),
            Self::TooLarge(scalar) => {
                let name = scalar.name();
                Detail::new(format!("expected {expected}, found {found}, which is too large for {name}"))
                    .expected(expected.to_string())
                    .actual(found)
            }
            Self::Number(demand, number, restriction) => Detail::number(*demand, *number, restriction),
            Self::Length { found, unit, shape } => {
                let expected = match shape {
                    Shape::Array(length) => format!("{length} {unit}"),
                    Shape::Bounded(bound) => format!("at most {bound} {unit}"),
                    Shape::Single | Shape::Sequence => unit.to_string(),
                };
                Detail::differs(expected, found)
            }
            Self::Nul(at) => Detail::new(format!("NUL at byte {at}, which terminates the text")),
            Self::NotUtf8(at) => Detail::new(format!("invalid UTF-8 at byte {at}")).expected("UTF-8"),
            Self::NotUtf16(at) => {
                Detail::new(format!("unpaired surrogate at code unit {at}")).expected("UTF-16")
            }
        }
    }
}

impl Plans {
    /// Compiles the constraints of a schema.
    pub fn new(schema: &Schema, rules: &'static ValueRules) -> Self {
        let messages = schema.messages.iter().map(|message| MessagePlan::new(message, schema));
        let mut plans = Self { rules, messages: messages.collect() };
        for id in &schema.topological_order {
            plans.messages[id.0 as usize].coverage = plans.coverage(*id, None);
        }
        plans
    }

    pub(crate) fn get(&self, id: MessageId) -> &MessagePlan {
        &self.messages[id.0 as usize]
    }

    /// Counts this many JSON messages as covered. `shared` contains the fields that were checked; `None` for all.
    pub fn count(
        &self,
        id: MessageId,
        shared: Option<&SharedFields>,
        messages: u64,
        findings: &mut Findings,
    ) {
        if shared.is_some() {
            self.coverage(id, shared).count(messages, findings);
        } else {
            self.get(id).coverage.count(messages, findings);
        }
    }

    fn coverage(&self, id: MessageId, shared: Option<&SharedFields>) -> Coverage {
        let mut coverage = Coverage::default();
        if shared.is_none_or(|shared| shared.values().any(|is_required| *is_required)) {
            coverage.add(self.rules.members, 1);
        }
        let is_checked = |field: &&FieldPlan| shared.is_none_or(|shared| shared.contains_key(&field.name));
        for field in self.get(id).fields.iter().filter(is_checked) {
            let count = match field.shape {
                Shape::Array(length) => u64::from(length),
                Shape::Single | Shape::Bounded(_) | Shape::Sequence => 1,
            };
            field.constraint().rules(Encoding::Json, self.rules).for_each(|rule| coverage.add(rule, count));
            if let Element::Message(nested) = field.element {
                coverage.add_nested(&self.get(nested).coverage, count);
            }
        }
        coverage
    }
}

impl MessagePlan {
    /// Compiles the constraints of a message, except for its coverage in JSON.
    pub(super) fn new(message: &uavspec_schema::Message, schema: &Schema) -> Self {
        Self {
            name: message.name.clone(),
            fields: (0..message.fields.len()).map(|index| FieldPlan::new(message, index, schema)).collect(),
            span: message.span,
            has_text: has_text(message, schema),
            coverage: Coverage::default(),
        }
    }
}

impl FieldPlan {
    fn new(message: &uavspec_schema::Message, index: usize, schema: &Schema) -> Self {
        let field = &message.fields[index];
        let (element, shape) = match (field.ty.element, field.ty.shape) {
            (uavspec_schema::Element::Scalar(Scalar::Char), Shape::Array(length))
                if has_text(message, schema) =>
            {
                (Element::Text(length), Shape::Single)
            }
            (uavspec_schema::Element::Scalar(scalar), shape) => (Element::Scalar(scalar), shape),
            (uavspec_schema::Element::String { wide, bound }, shape) => {
                (Element::String { is_wide: wide, bound }, shape)
            }
            (uavspec_schema::Element::Message(id), shape) => (Element::Message(id), shape),
        };
        let slots = message.uorb.iter().flat_map(|layout| &layout.slots);
        let slot = slots.into_iter().find(|slot| slot.field == Some(index));
        let (offset, size) = slot.map_or((0, 0), |slot| (slot.offset, slot.size));
        Self {
            name: field.name.clone(),
            element,
            shape,
            restriction: schema.restriction(message, field),
            special: field.special_values(),
            counted_by: message.fields.iter().position(|other| other.counts == Some(index)),
            counts: field.counts,
            span: field.span,
            offset,
            stride: if let Shape::Array(length) = shape { size / (length as usize).max(1) } else { size },
        }
    }

    /// The constraints on each of the field's values.
    pub(super) fn constraint(&self) -> Constraint<'_> {
        Constraint { element: self.element, shape: self.shape, restriction: self.restriction.as_ref() }
    }

    /// True for an array of bytes, which rosbridge writes as base64.
    pub(super) fn is_byte_array(&self) -> bool {
        let is_byte = matches!(self.element, Element::Scalar(Scalar::UInt8 | Scalar::Byte | Scalar::Char));
        is_byte && self.shape != Shape::Single
    }
}

/// The number of entries in use in an array, from the count and the special values of the count's field. A negative or
/// special count doesn't say which entries are in use. The number is then 0, so the entries may have any values.
pub(super) fn entries_in_use(count: i128, special: &[Number]) -> usize {
    if count <= 0 || special.contains(&Number::Int(count)) {
        return 0;
    }
    usize::try_from(count).unwrap_or(usize::MAX)
}

/// True if `char` is text. In ROS 2, `char` is a number.
fn has_text(message: &uavspec_schema::Message, schema: &Schema) -> bool {
    schema.package_of(message).form == Form::Msg(Dialect::Px4)
}

/// The number with these little-endian bytes.
pub(super) fn number(scalar: Scalar, bytes: &[u8]) -> Option<Number> {
    let integer = match scalar {
        Scalar::Bool | Scalar::UInt8 | Scalar::Byte | Scalar::Char => i128::from(*bytes.first()?),
        Scalar::Int8 => i128::from(i8::from_le_bytes(bytes.try_into().ok()?)),
        Scalar::UInt16 => i128::from(u16::from_le_bytes(bytes.try_into().ok()?)),
        Scalar::Int16 => i128::from(i16::from_le_bytes(bytes.try_into().ok()?)),
        Scalar::UInt32 => i128::from(u32::from_le_bytes(bytes.try_into().ok()?)),
        Scalar::Int32 => i128::from(i32::from_le_bytes(bytes.try_into().ok()?)),
        Scalar::UInt64 => i128::from(u64::from_le_bytes(bytes.try_into().ok()?)),
        Scalar::Int64 => i128::from(i64::from_le_bytes(bytes.try_into().ok()?)),
        Scalar::Float32 => return Some(Number::Float(f32::from_le_bytes(bytes.try_into().ok()?).into())),
        Scalar::Float64 => return Some(Number::Float(f64::from_le_bytes(bytes.try_into().ok()?))),
    };
    Some(Number::Int(integer))
}
