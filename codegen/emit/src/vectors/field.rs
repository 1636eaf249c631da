//! Sample values of a field, by its type.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use uavspec_runtime::cdr::{HEADER, WIDE_UNIT};
use uavspec_runtime::{ConstraintKind, Scalar};
use uavspec_schema::{Element, Field, Message, Schema, Shape};

use super::case::{Change, Sample, Verdict, rule};
use super::number::{NumberSamples, booleans};
use super::part::Parts;
use super::typical::{Typical, letters};

/// Maximum JSON length, in bytes, of a string or sequence filled to its bound.
const LONGEST_FILLED: usize = 1 << 16;

/// A character with four UTF-8 bytes and two UTF-16 code units.
const WIDE: &str = "🚁";

/// Samples of a message field.
#[derive(Clone, Copy)]
pub(super) struct FieldSamples<'s> {
    pub(super) schema: &'s Schema,
    pub(super) message: &'s Message,
    pub(super) field: &'s Field,
    pub(super) parts: &'s Parts,
}

impl<'s> FieldSamples<'s> {
    /// The valid value nearest to zero, as JSON. `None` if there is no valid value.
    pub(super) fn zero(self) -> Option<String> {
        match self.field.ty.shape {
            Shape::Single => self.element_zero(),
            Shape::Array(length) => Some(list(&self.element_zero()?, length, None)),
            Shape::Bounded(_) | Shape::Sequence => Some("[]".to_owned()),
        }
    }

    /// A typical valid value as JSON. Adjacent bytes differ where possible.
    pub(super) fn typical(self, typical: &mut Typical) -> Option<String> {
        let length = match self.field.ty.shape {
            Shape::Single => return self.element_typical(typical),
            Shape::Array(length) => length,
            Shape::Bounded(bound) => typical.sequence().min(bound),
            Shape::Sequence => typical.sequence(),
        };
        let elements: Option<Vec<String>> = (0..length).map(|_| self.element_typical(typical)).collect();
        Some(format!("[{}]", elements?.join(",")))
    }

    /// All distinct sample values.
    pub(super) fn samples(self) -> Vec<Sample> {
        let mut samples = match self.field.ty.shape {
            Shape::Single => self.elements(),
            Shape::Array(length) => self.array(length),
            Shape::Bounded(bound) => self.sequence(Some(bound)),
            Shape::Sequence => self.sequence(None),
        };
        let mut seen = BTreeSet::new();
        samples.retain(|sample| sample.patch.is_some() || seen.insert(sample.json.clone()));
        samples
    }

    /// The valid element nearest to zero.
    fn element_zero(self) -> Option<String> {
        match self.field.ty.element {
            Element::Scalar(Scalar::Bool) => Some("false".to_owned()),
            Element::Scalar(scalar) => self.numbers(scalar).zero(),
            Element::Text(_) | Element::String { .. } => Some("\"\"".to_owned()),
            Element::Message(id) => self.parts.get(id).map(|part| part.zero.clone()),
        }
    }

    fn element_typical(self, typical: &mut Typical) -> Option<String> {
        match self.field.ty.element {
            Element::Scalar(Scalar::Bool) => Some(typical.boolean().to_string()),
            Element::Scalar(scalar) => self.numbers(scalar).typical(typical.bytes(scalar)),
            Element::Text(length) => Some(typical.text(length)),
            Element::String { bound, .. } => Some(typical.string(bound)),
            Element::Message(id) => {
                let message = self.schema.message(id);
                typical.enter();
                let json = message_typical(self.schema, message, self.parts, typical);
                typical.leave();
                json
            }
        }
    }

    fn elements(self) -> Vec<Sample> {
        match self.field.ty.element {
            Element::Scalar(Scalar::Bool) => booleans(),
            Element::Scalar(scalar) => self.numbers(scalar).samples(),
            Element::Text(length) => text(length),
            Element::String { wide, bound } => strings(wide, bound),
            Element::Message(id) => self.parts.get(id).map(|part| part.samples.clone()).unwrap_or_default(),
        }
    }

    fn numbers(self, scalar: Scalar) -> NumberSamples<'s> {
        NumberSamples::new(self.schema, self.message, self.field, scalar)
    }

    /// Samples for an array of fixed length. Each sample is used as the last element. The first valid and the first
    /// invalid sample are also used as the first element.
    fn array(self, length: u32) -> Vec<Sample> {
        let Some(zero) = self.element_zero() else { return Vec::new() };
        let at = |index: u32, sample: &Sample, name: String| Sample {
            name,
            words: format!("element {index} is {}", sample.words),
            ..sample.within(|json| list(&zero, length, Some((index, json))))
        };
        let elements = self.elements();
        let last = length.saturating_sub(1);
        let mut samples: Vec<Sample> =
            elements.iter().map(|sample| at(last, sample, sample.name.clone())).collect();
        if length > 1 {
            let find = |is_valid| {
                elements.iter().find(|sample| sample.verdict.is_valid() == is_valid && sample.patch.is_none())
            };
            let first = [find(true), find(false)].into_iter().flatten();
            samples.extend(first.map(|sample| at(0, sample, format!("first-{}", sample.name))));
        }
        let malformed = |name: &str, words: &str, length: u32| {
            Sample::new(name, words, list(&zero, length, None), Verdict::malformed(rule::LENGTH))
        };
        samples.push(malformed("short", "one element too few", last));
        samples.push(malformed("long", "one element too many", length.saturating_add(1)));
        samples.extend(self.no_list(zero));
        samples
    }

    /// Samples for a sequence. Each sample is used as the only element.
    fn sequence(self, bound: Option<u32>) -> Vec<Sample> {
        let Some(zero) = self.element_zero() else { return Vec::new() };
        let mut samples = Vec::new();
        if bound != Some(0) {
            samples.push(Sample::new("one", "one element", list(&zero, 1, None), Verdict::VALID));
            samples.extend(self.elements().iter().map(|sample| Sample {
                words: format!("its only element is {}", sample.words),
                ..sample.within(|json| format!("[{json}]"))
            }));
        }
        if let Some(bound) = bound.filter(|bound| is_fillable(*bound, &zero)) {
            let growth = Change::Growth { size: self.cdr_size(), filler: 0 };
            samples.extend(bounded(bound, "[]", growth, |length| list(&zero, length, None)));
        }
        samples.extend(self.no_list(zero));
        samples
    }

    /// Samples that contain a value of another type instead of an array.
    fn no_list(self, element: String) -> impl Iterator<Item = Sample> {
        let is_bytes = matches!(self.field.ty.element, Element::Scalar(scalar) if scalar.size() == 1);
        let base64 = Sample::mistyped("base64", "bytes in base64", "\"AAAA\"");
        // A sample of an invalid element may also be named `null`, so these names start with `array-`.
        let single = Sample::mistyped("array-single", "an element instead of an array", element);
        [single, Sample::mistyped("array-null", "null", "null")].into_iter().chain(is_bytes.then_some(base64))
    }

    /// The number of bytes that an element adds to CDR. For a message, the result is the minimum. For a string, the
    /// result is the size of the length prefix.
    fn cdr_size(self) -> usize {
        match self.field.ty.element {
            Element::Scalar(scalar) => scalar.size(),
            Element::Text(length) => length as usize,
            Element::String { .. } => 4,
            Element::Message(id) => {
                let min = usize::try_from(self.schema.message(id).cdr.min).unwrap_or(0);
                min.saturating_sub(HEADER)
            }
        }
    }
}

/// A typical valid message of the type `message`, as JSON. Adjacent bytes differ where possible.
pub(super) fn message_typical(
    schema: &Schema,
    message: &Message,
    parts: &Parts,
    typical: &mut Typical,
) -> Option<String> {
    let mut json = String::from("{");
    for (index, field) in message.fields.iter().enumerate() {
        let comma = if index == 0 { "" } else { "," };
        let value = FieldSamples { schema, message, field, parts }.typical(typical)?;
        // Writing to a string never fails.
        let _ = write!(json, "{comma}\"{}\":{value}", field.name);
    }
    json.push('}');
    Some(json)
}

/// Samples for a PX4 text field of `length` bytes.
fn text(length: u32) -> Vec<Sample> {
    let room = length as usize;
    let ascii = |length: u32| format!("\"{}\"", letters(0, length));
    let not_utf8 = Sample::new(
        "not-utf8",
        "an invalid UTF-8 byte",
        "\"a\"",
        Verdict::invalid_bytes(ConstraintKind::Text.id()),
    );
    let mut samples = vec![
        Sample::new("full", "text that fills all bytes, without NUL", ascii(length), Verdict::VALID),
        Sample::mistyped("too-long", "text that is one byte too long", ascii(length.saturating_add(1))),
        Sample::new("nul", "text with a NUL", "\"\\u0000\"", Verdict::accepted_by_schema(rule::TYPE)),
        not_utf8.patched("\"\"", Change::Byte(0xff)),
        Sample::mistyped("numbers", "numbers instead of text", "[0]"),
        Sample::mistyped("null", "null", "null"),
    ];
    if let Some(rest) = room.checked_sub(WIDE.len()) {
        let plain = letters(0, length % 4); // the remaining bytes
        let json = format!("\"{plain}{}\"", WIDE.repeat(rest / WIDE.len() + 1));
        samples.push(Sample::new(
            "multibyte",
            "multibyte characters that fill all bytes",
            json,
            Verdict::VALID,
        ));
    }
    if room > 1 {
        // The schema counts characters, so it accepts this value.
        samples.push(Sample::new(
            "multibyte-too-long",
            "multibyte characters with too many bytes",
            format!("\"{}\"", WIDE.repeat(room / WIDE.len() + 1)),
            Verdict::accepted_by_schema(rule::TYPE),
        ));
    }
    samples
}

/// Samples for a string. Some implementations count the characters of a bounded string, and others count the bytes of a
/// `string` and the UTF-16 code units of a `wstring`. Each sample is within the bound, or beyond it, in all
/// implementations.
fn strings(is_wide: bool, bound: Option<u32>) -> Vec<Sample> {
    let mut samples = Vec::new();
    let multibyte = format!("aé{WIDE}");
    let length = if is_wide { multibyte.encode_utf16().count() } else { multibyte.len() };
    if bound.is_none_or(|bound| length <= bound as usize) {
        let json = format!("\"{multibyte}\"");
        samples.push(Sample::new("multibyte", "multibyte characters", json, Verdict::VALID));
    }
    if let Some(bound) = bound.filter(|bound| is_fillable(*bound, "a")) {
        let growth = Change::Growth { size: if is_wide { WIDE_UNIT } else { 1 }, filler: b'a' };
        samples.extend(bounded(bound, "\"\"", growth, |length| format!("\"{}\"", letters(0, length))));
    }
    samples.push(Sample::mistyped("null", "null", "null"));
    samples.push(Sample::mistyped("number", "a number", "1"));
    samples
}

fn is_fillable(bound: u32, element: &str) -> bool {
    element.len().saturating_mul(bound as usize) <= LONGEST_FILLED
}

/// A sample with the maximum length, and samples that are too long in JSON and in CDR.
fn bounded(
    bound: u32,
    empty: &str,
    growth: Change,
    json: impl Fn(u32) -> String,
) -> impl Iterator<Item = Sample> {
    let over = Verdict::malformed(ConstraintKind::Bound.id());
    let in_cdr = (bound > 0).then(|| {
        let verdict = Verdict::invalid_bytes(ConstraintKind::Bound.id());
        Sample::new("cdr-above-bound", "longer than its bound in CDR", json(bound), verdict)
            .patched(empty, growth)
    });
    let full = Sample::new("at-bound", "as long as its bound", json(bound), Verdict::VALID);
    let long = Sample::new("above-bound", "one longer than its bound", json(bound.saturating_add(1)), over);
    [full, long].into_iter().chain(in_cdr)
}

/// A list of `length` elements: copies of `element`, except for the element that `other` replaces.
fn list(element: &str, length: u32, other: Option<(u32, &str)>) -> String {
    let mut json = String::with_capacity((element.len() + 1) * length as usize + 2);
    json.push('[');
    for index in 0..length {
        if index > 0 {
            json.push(',');
        }
        json.push_str(other.filter(|(at, _)| *at == index).map_or(element, |(_, other)| other));
    }
    json.push(']');
    json
}
