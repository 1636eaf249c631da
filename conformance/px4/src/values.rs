//! The parts that the checks of memory, CDR and JSON share, in addition to the checks of single values: the rules, the
//! messages for violations, the number of values that each rule covers, and the number of entries in use in counted
//! arrays.

use std::collections::BTreeMap;
use std::fmt;

use uavspec_dynamic::{Field, Types, ValueType, Violation};
use uavspec_model::{Detail, Findings, Rule};
use uavspec_runtime::{ConstraintKind, Number, Scalar};
use uavspec_schema::{Element, MessageId, Schema, Shape};

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

/// The fields that a JSON Schema in a capture shares with a differing definition. The value is true if the schema
/// requires the field.
pub type SharedFields = BTreeMap<String, bool>;

/// The constraints on the values of all messages in a schema.
#[derive(Debug)]
pub struct Plans<'d> {
    pub(super) rules: &'static ValueRules,
    pub(super) types: &'d Types,
    /// The coverage of each message in JSON, in the order of the schema. A sequence counts as one value.
    coverage: Vec<Coverage>,
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

/// The rules that a value can violate in an encoding.
pub(super) fn rules_on(
    value: ValueType<'_>,
    encoding: Encoding,
    rules: &'static ValueRules,
) -> impl Iterator<Item = &'static Rule> + use<> {
    let is_json = encoding == Encoding::Json;
    let is_bounded = matches!(value.shape, Shape::Array(_) | Shape::Bounded(_))
        || matches!(value.element, Element::Text(_) | Element::String { bound: Some(_), .. });
    let restriction = value.restriction.map(|restriction| restriction.constraint().rules());
    let applicable = [
        (is_json, rules.json_type),
        (is_json && is_bounded, rules.length),
        (!is_json && value.element == Element::Scalar(Scalar::Bool), rules.bool),
        (matches!(value.element, Element::Text(_)), rules.text),
        // A string in JSON is always Unicode.
        (!is_json && matches!(value.element, Element::String { .. }), rules.text),
    ];
    let applicable = applicable.into_iter().filter(|(applies, _)| *applies).map(|(_, rule)| rule);
    applicable.chain(restriction.into_iter().flatten().map(rules.number))
}

impl ValueRules {
    /// The rule that a violation violates.
    pub(super) fn violated_by(&self, violation: &Violation<'_>) -> &'static Rule {
        match violation {
            Violation::Bool(_) => self.bool,
            Violation::Type | Violation::TooLarge(_) => self.json_type,
            Violation::Number(kind, ..) => (self.number)(*kind),
            Violation::Length { .. } => self.length,
            Violation::Nul(_) | Violation::NotUtf8(_) | Violation::NotUtf16(_) => self.text,
        }
    }
}

/// True if a violation concerns the value itself rather than its notation. Violations of this kind count only for array
/// entries in use.
pub(super) fn is_of_value(violation: &Violation<'_>) -> bool {
    match violation {
        Violation::Bool(_)
        | Violation::Number(..)
        | Violation::Nul(_)
        | Violation::NotUtf8(_)
        | Violation::NotUtf16(_) => true,
        Violation::Type | Violation::TooLarge(_) | Violation::Length { .. } => false,
    }
}

/// The detail of a finding. For JSON, `expected` describes the type of the field, and `found` is the text of the value.
pub(super) fn detail(violation: &Violation<'_>, expected: &dyn fmt::Display, found: &str) -> Detail {
    match violation {
        Violation::Bool(byte) => {
            Detail::new(format!("expected 0 or 1, found {byte}")).expected("0 or 1").actual(byte.to_string())
        }
        Violation::Type => Detail::differs(expected, found),
        Violation::TooLarge(scalar) => {
            let name = scalar.name();
            Detail::new(format!("expected {expected}, found {found}, which is too large for {name}"))
                .expected(expected.to_string())
                .actual(found)
        }
        Violation::Number(kind, number, restriction) => Detail::number(*kind, *number, restriction),
        Violation::Length { found, unit, shape } => {
            let expected = match shape {
                Shape::Array(length) => format!("{length} {unit}"),
                Shape::Bounded(bound) => format!("at most {bound} {unit}"),
                Shape::Single | Shape::Sequence => unit.to_string(),
            };
            Detail::differs(expected, found)
        }
        Violation::Nul(at) => Detail::new(format!("NUL at byte {at}, which terminates the text")),
        Violation::NotUtf8(at) => Detail::new(format!("invalid UTF-8 at byte {at}")).expected("UTF-8"),
        Violation::NotUtf16(at) => {
            Detail::new(format!("unpaired surrogate at code unit {at}")).expected("UTF-16")
        }
    }
}

impl<'d> Plans<'d> {
    /// Counts the values that each rule covers in the messages of a schema, whose types are `types`.
    pub fn new(schema: &Schema, types: &'d Types, rules: &'static ValueRules) -> Self {
        let coverage = schema.messages.iter().map(|_| Coverage::default()).collect();
        let mut plans = Self { rules, types, coverage };
        for id in &schema.topological_order {
            plans.coverage[id.0 as usize] = plans.coverage(*id, None);
        }
        plans
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
            self.coverage[id.0 as usize].count(messages, findings);
        }
    }

    fn coverage(&self, id: MessageId, shared: Option<&SharedFields>) -> Coverage {
        let mut coverage = Coverage::default();
        if shared.is_none_or(|shared| shared.values().any(|is_required| *is_required)) {
            coverage.add(self.rules.members, 1);
        }
        let is_checked = |field: &&Field| shared.is_none_or(|shared| shared.contains_key(&*field.name));
        for field in self.types.get(id).fields().iter().filter(is_checked) {
            let count = if field.is_sequence() { 1 } else { field.count() as u64 };
            rules_on(field.value_type(), Encoding::Json, self.rules)
                .for_each(|rule| coverage.add(rule, count));
            if let Element::Message(nested) = field.element {
                coverage.add_nested(&self.coverage[nested.0 as usize], count);
            }
        }
        coverage
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
