//! Sample numbers: the bounds of a field, and adjacent invalid values.

use uavspec_runtime::{ConstraintKind, Number, Scalar};
use uavspec_schema::msg::constraint::{Effect, Probe};
use uavspec_schema::value::Value;
use uavspec_schema::{Enum, Field, Message, Restriction, Schema};

use super::case::{Change, Sample, Verdict, rule};

/// Integers up to this magnitude are exact as 64-bit floats.
pub(super) const EXACT_WITHIN: u128 = 1 << 53;

/// An offset from a 64-bit integer bound, large enough to survive conversion to a 64-bit float.
const FAR: i128 = 1 << 12;

/// Samples of a numeric field, or of the elements of an array.
pub(super) struct NumberSamples<'s> {
    schema: &'s Schema,
    field: &'s Field,
    scalar: Scalar,
    restriction: Restriction,
    samples: Vec<Sample>,
}

impl<'s> NumberSamples<'s> {
    pub(super) fn new(schema: &'s Schema, message: &Message, field: &'s Field, scalar: Scalar) -> Self {
        let restriction = schema.restriction(message, field).unwrap_or_default();
        Self { schema, field, scalar, restriction, samples: Vec::new() }
    }

    /// The valid value nearest to zero, or `None` if the constraints are contradictory.
    pub(super) fn zero(&self) -> Option<String> {
        let zero = if self.scalar.is_float() { Number::Float(0.0) } else { Number::Int(0) };
        let known = self.restriction.known.iter().flatten().map(|value| Number::Int(*value));
        let ends = self.restriction.demands.iter().map(|(_, number)| *number);
        let special = self.restriction.special.iter().copied();
        let candidates = [zero].into_iter().chain(known).chain(ends).chain(special);
        candidates
            .map(|number| self.rounded(number))
            .find(|number| self.is_representable(*number) && self.verdict(*number).is_valid())
            .map(|number| self.json(number))
    }

    /// The value encoded by `bytes` if this value is valid, otherwise a valid value that is as distinctive as the
    /// constraints allow.
    pub(super) fn typical(&self, bytes: [u8; 8]) -> Option<String> {
        let turn = i128::from(bytes[0]);
        let known = self.restriction.known.as_deref().unwrap_or_default();
        let any = Number::Int(turn % 0x7f + 1);
        let all_flags = known.iter().fold(0, |all, mask| all | mask);
        let pick = usize::try_from(turn).unwrap_or(0) % known.len().max(1);
        let candidates = [
            Some(self.number_of_bytes(bytes)).filter(|number| !number.is_nan()),
            (self.restriction.limits.is_flags && all_flags != 0).then_some(Number::Int(turn & all_flags)),
            known.get(pick).map(|value| Number::Int(*value)),
            self.between(bytes[0]),
            Some(if self.scalar.is_float() { Number::Float(f64::from(bytes[0] % 0x7f) + 0.5) } else { any }),
        ];
        let valid = candidates
            .into_iter()
            .flatten()
            .map(|number| self.rounded(number))
            .find(|number| self.is_representable(*number) && self.verdict(*number).is_valid());
        valid.map(|number| self.json(number)).or_else(|| self.zero())
    }

    /// All sample values.
    pub(super) fn samples(mut self) -> Vec<Sample> {
        // If the same value has several names, the first name is used. The most specific names therefore come first.
        self.documented();
        for constraint in &self.field.constraints {
            let Effect::Allows { sample: (name, words), .. } = constraint.kind.effect else { continue };
            if let Some(number) = constraint.stated.value().and_then(Value::number) {
                self.push(name, words, number);
            }
        }
        self.ends();
        if self.scalar.is_float() {
            self.floats();
        } else {
            self.integers();
        }
        self.mistyped();
        self.samples
    }

    fn integers(&mut self) {
        let Some((min, max)) = self.scalar.integer_bounds() else { return };
        let name = self.scalar.name();
        // If the minimum is zero, the all-zero message covers it.
        if min < 0 {
            self.push("min", format!("the minimum {name}"), Number::Int(min));
        }
        self.push("max", format!("the maximum {name}"), Number::Int(max));
        // Near a nonzero bound of a 64-bit type, adjacent integers are equal as 64-bit floats.
        let is_coarse = |value: i128| self.scalar.size() == 8 && value != -1;
        let outside = [
            ("below-min", "far-below-min", "below the minimum", min - 1, min - FAR),
            ("above-max", "far-above-max", "above the maximum", max + 1, max + 1 + FAR),
        ];
        let mut beyond = Vec::new();
        for (near, far, words, value, far_value) in outside {
            let mut sample = Sample::mistyped(near, format!("one {words} {name}"), value.to_string());
            sample.verdict.suits_doubles = !is_coarse(value);
            beyond.push(sample);
            if is_coarse(value) {
                let words = format!("far {words} {name}");
                beyond.push(Sample::mistyped(far, words, far_value.to_string()));
            }
        }
        self.samples.append(&mut beyond);
    }

    fn floats(&mut self) {
        let is_single = self.scalar == Scalar::Float32;
        let (max, min) = if is_single {
            (f64::from(f32::MAX), f64::from(f32::from_bits(1)))
        } else {
            (f64::MAX, f64::from_bits(1))
        };
        let name = self.scalar.name();
        self.push("min", format!("the minimum {name}"), Number::Float(-max));
        self.push("max", format!("the maximum {name}"), Number::Float(max));
        self.push("subnormal", format!("the smallest positive {name}"), Number::Float(min));
        self.push("minus-zero", "negative zero", Number::Float(-0.0));
        self.push("nan", "NaN", Number::Float(f64::NAN));
        if is_single {
            // JSON has no infinity, and some readers reject numbers beyond the range of 64-bit floats. Therefore, only
            // float32 has samples beyond its bounds.
            self.samples.push(Sample::mistyped("below-min", "below the minimum float32", "-3.5e38"));
            self.samples.push(Sample::mistyped("above-max", "above the maximum float32", "3.5e38"));
        }
    }

    /// Adds the bounds set by constraints, the maximum count, and the next value beyond each of them.
    fn ends(&mut self) {
        for constraint in &self.field.constraints {
            let Effect::Narrows { samples, .. } = constraint.kind.effect else { continue };
            for Probe { name, words, number, up } in samples(&constraint.stated, self.scalar) {
                let number = self.rounded(number);
                let number = up.map_or(Some(number), |up| self.step(number, up));
                self.push_outside(name, words, number);
            }
        }
        if let Some(count) = self.restriction.limits.count.map(|count| Number::Int(count.into())) {
            self.push("full", "the length of the array", count);
            self.push_outside("above-count", "one more than the length of the array", self.step(count, true));
        }
    }

    /// Adds each documented value, and one undocumented value.
    fn documented(&mut self) {
        let Some(found) = self.field.enumeration.map(|reference| self.schema.enumeration(reference)) else {
            return;
        };
        let (kind, words) = if found.is_flags { ("flag", "the flag") } else { ("enum", "the value") };
        for (member, _) in found.with_aliases().filter(|(_, alias_of)| alias_of.is_none()) {
            let name = format!("{kind}-{}", member.name);
            self.push(name, format!("{words} {}", member.name), Number::Int(member.value));
        }
        if found.is_flags {
            let all = found.members.iter().fold(0, |all, member| all | member.value);
            self.push("all-flags", "all flags", Number::Int(all));
        }
        let (name, words) = if found.is_flags {
            ("undocumented-bit", "an undocumented bit")
        } else {
            ("undocumented", "an undocumented value")
        };
        if let Some(number) = self.undocumented(found) {
            self.push(name, words, number);
        }
    }

    /// A value that violates only the enum rule.
    fn undocumented(&self, found: &Enum) -> Option<Number> {
        let values = || found.members.iter().map(|member| member.value);
        let bits = (0..8 * self.scalar.size()).map(|bit| 1_i128 << bit);
        let neighbours = values().max().map(|value| value + 1).into_iter();
        let neighbours =
            neighbours.chain(values().map(|value| value - 1)).chain(values().map(|value| value + 1));
        let candidates: Vec<i128> = if found.is_flags { bits.collect() } else { neighbours.collect() };
        let is_undocumented = |number: &Number| {
            self.restriction.constraint().violated_by(*number) == Some(ConstraintKind::Enum)
                && self.is_representable(*number)
        };
        candidates.into_iter().map(Number::Int).find(is_undocumented)
    }

    fn mistyped(&mut self) {
        if self.scalar.is_float() {
            self.samples.push(Sample::mistyped("string", "a string", "\"NaN\""));
        } else {
            self.samples.push(Sample::mistyped("null", "null", "null"));
            self.samples.push(Sample::mistyped("string", "a string", "\"1\""));
            self.samples.push(Sample::mistyped("fraction", "a fraction", "0.5"));
        }
        self.samples.push(Sample::mistyped("boolean", "a boolean", "true"));
    }

    fn push(&mut self, name: impl Into<String>, words: impl Into<String>, number: Number) {
        let number = self.rounded(number);
        if self.is_representable(number) {
            let mut sample = Sample::new(name, words, self.json(number), self.verdict(number));
            // As 64-bit floats, such an integer may be equal to a valid integer.
            sample.verdict.suits_doubles = match number {
                Number::Int(value) => sample.verdict.passes_schema || value.unsigned_abs() <= EXACT_WITHIN,
                Number::Float(_) => true,
            };
            self.samples.push(sample);
        }
    }

    fn push_outside(&mut self, name: &'static str, words: &'static str, number: Option<Number>) {
        if let Some(number) = number {
            self.push(name, words, number);
        }
    }

    fn verdict(&self, number: Number) -> Verdict {
        Verdict::of(&self.restriction.constraint(), number)
    }

    /// True if this value is in the range of the type and can be represented in JSON.
    fn is_representable(&self, number: Number) -> bool {
        match (number, self.scalar.integer_bounds()) {
            (Number::Int(value), Some((min, max))) => (min..=max).contains(&value),
            (Number::Float(value), None) => !value.is_infinite(),
            _ => false,
        }
    }

    /// The value of the field type that is nearest to `number`.
    #[allow(clippy::cast_possible_truncation, clippy::cast_precision_loss)] // rounding is intended
    fn rounded(&self, number: Number) -> Number {
        match (number, self.scalar) {
            (Number::Float(value), Scalar::Float32) => Number::Float(f64::from(value as f32)),
            (Number::Int(value), Scalar::Float32) => Number::Float(f64::from(value as f32)),
            (Number::Int(value), Scalar::Float64) => Number::Float(value as f64),
            (Number::Float(value), Scalar::Float64) => Number::Float(value),
            (Number::Float(value), _) => Number::Int(value as i128),
            (Number::Int(value), _) => Number::Int(value),
        }
    }

    /// The next higher value of the field type if `up` is true, otherwise the next lower value.
    #[allow(clippy::cast_possible_truncation)] // the value is a float32
    fn step(&self, number: Number, up: bool) -> Option<Number> {
        let next = match number {
            Number::Int(value) => Number::Int(if up { value + 1 } else { value - 1 }),
            Number::Float(value) if self.scalar == Scalar::Float32 => {
                let value = value as f32;
                Number::Float(f64::from(if up { value.next_up() } else { value.next_down() }))
            }
            Number::Float(value) => Number::Float(if up { value.next_up() } else { value.next_down() }),
        };
        self.is_representable(next).then_some(next)
    }

    fn number_of_bytes(&self, bytes: [u8; 8]) -> Number {
        let [a, b, c, d, ..] = bytes;
        match self.scalar {
            Scalar::Float32 => Number::Float(f32::from_le_bytes([a, b, c, d]).into()),
            Scalar::Float64 => Number::Float(f64::from_le_bytes(bytes)),
            Scalar::Bool | Scalar::Byte | Scalar::Char | Scalar::UInt8 => Number::Int(a.into()),
            Scalar::Int8 => Number::Int(i8::from_le_bytes([a]).into()),
            Scalar::Int16 => Number::Int(i16::from_le_bytes([a, b]).into()),
            Scalar::UInt16 => Number::Int(u16::from_le_bytes([a, b]).into()),
            Scalar::Int32 => Number::Int(i32::from_le_bytes([a, b, c, d]).into()),
            Scalar::UInt32 => Number::Int(u32::from_le_bytes([a, b, c, d]).into()),
            Scalar::Int64 => Number::Int(i64::from_le_bytes(bytes).into()),
            Scalar::UInt64 => Number::Int(u64::from_le_bytes(bytes).into()),
        }
    }

    /// A value in the range, chosen by `turn`.
    fn between(&self, turn: u8) -> Option<Number> {
        let count = self.restriction.limits.count.map(|count| Number::Int(count.into()));
        let low = self.restriction.limits.low.or(count.map(|_| Number::Int(0)));
        let high = self.restriction.limits.high.or(count);
        Some(match (low, high) {
            (Some(Number::Int(low)), Some(Number::Int(high))) if !self.scalar.is_float() => {
                Number::Int(low + i128::from(turn) % (high - low + 1).max(1))
            }
            (Some(low), Some(high)) => {
                let (low, high) = (low.as_f64(), high.as_f64());
                Number::Float(low + (high - low) * (f64::from(turn) + 1.0) / 257.0)
            }
            (Some(low), None) => Number::Float(low.as_f64() + f64::from(turn)),
            (None, Some(high)) => Number::Float(high.as_f64() - f64::from(turn)),
            (None, None) => return None,
        })
    }

    fn json(&self, number: Number) -> String {
        match number {
            Number::Int(value) => value.to_string(),
            Number::Float(value) => float_json(value, self.scalar),
        }
    }
}

/// The shortest JSON that parses to this float. NaN is null.
#[allow(clippy::cast_possible_truncation)] // the value is a float32
fn float_json(value: f64, scalar: Scalar) -> String {
    let value = match scalar {
        Scalar::Float32 => (value as f32).to_string().parse().unwrap_or(value),
        _ => value,
    };
    serde_json::Number::from_f64(value).map_or_else(|| "null".to_owned(), |number| number.to_string())
}

/// Samples for a `bool`.
pub(super) fn booleans() -> Vec<Sample> {
    let odd = Sample::new(
        "byte-153",
        "the byte 153, which some firmware sends",
        "true",
        Verdict::invalid_bytes(rule::BOOL),
    );
    vec![
        Sample::new("true", "true", "true", Verdict::VALID),
        odd.patched("false", Change::Byte(153)),
        Sample::mistyped("null", "null", "null"),
        Sample::mistyped("number", "a number", "1"),
        Sample::mistyped("string", "a string", "\"true\""),
    ]
}
