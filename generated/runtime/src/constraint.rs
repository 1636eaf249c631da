//! What the values of a field may be beyond what its type says, and which rule a value breaks.

use core::cmp::Ordering;
use core::fmt;

use crate::{Open, Scalar};

/// A number of a definition or of a field. Integers of 64 bits, signed and unsigned, are exact; NaN is
/// equal to NaN.
#[derive(Clone, Copy, Debug)]
pub enum Number {
    /// Of an integer type, or a `bool` as 0 or 1.
    Int(i128),
    /// Of a float.
    Float(f64),
}

impl Number {
    /// Whether it is NaN.
    pub const fn is_nan(self) -> bool {
        matches!(self, Self::Float(value) if value.is_nan())
    }

    /// The number as a float; an integer beyond 2^53 as the nearest one.
    #[allow(clippy::cast_precision_loss)] // said so
    pub const fn as_f64(self) -> f64 {
        match self {
            Self::Int(value) => value as f64,
            Self::Float(value) => value,
        }
    }
}

impl PartialEq for Number {
    fn eq(&self, other: &Self) -> bool {
        self.partial_cmp(other) == Some(Ordering::Equal)
    }
}

impl PartialOrd for Number {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        match (self, other) {
            (Self::Int(left), Self::Int(right)) => Some(left.cmp(right)),
            _ if self.is_nan() && other.is_nan() => Some(Ordering::Equal),
            _ => self.as_f64().partial_cmp(&other.as_f64()),
        }
    }
}

impl fmt::Display for Number {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Int(value) => value.fmt(formatter),
            Self::Float(value) => value.fmt(formatter),
        }
    }
}

/// What a number may be. The definition says it; the published schema asserts the same of JSON, but
/// for documented values and the places of NaN, which a schema leaves open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constraint<'k> {
    /// Least value (`@range`).
    pub low: Option<Number>,
    /// Greatest value (`@range`).
    pub high: Option<Number>,
    /// Values that mean that there is no data (`@invalid`), or that a set point doesn't apply
    /// (`@uncontrolled`): allowed wherever they lie.
    pub special: &'k [Number],
    /// Length of the array whose entries in use the value counts (`@count`).
    pub count: Option<u32>,
    /// The documented values (`@enum`), or masks where `is_flags`.
    pub known: Option<&'k [i128]>,
    /// The names of the documented values, in the same order, where they are at hand.
    pub names: &'k [&'k str],
    /// Whether values are made of the `known` ones bit by bit (`@flags`).
    pub is_flags: bool,
    /// Whether NaN has no meaning. Of a float that the definition doesn't restrict at all, nobody knows.
    pub forbids_nan: bool,
}

impl Constraint<'_> {
    /// Any value that the type holds.
    pub const NONE: Self = Self {
        low: None,
        high: None,
        special: &[],
        count: None,
        known: None,
        names: &[],
        is_flags: false,
        forbids_nan: false,
    };

    /// The rule that `value` breaks, if it does: the first of count, range and documented values. What lies
    /// out of range isn't asked for its name too.
    pub fn broken_by(&self, value: Number) -> Option<Rule> {
        if self.special.contains(&value) {
            return None;
        }
        if value.is_nan() {
            return self.forbids_nan.then_some(Rule::Nan);
        }
        if self.count.is_some_and(|length| value > Number::Int(length.into())) {
            return Some(Rule::Count);
        }
        if self.low.is_some_and(|low| value < low) || self.high.is_some_and(|high| value > high) {
            return Some(Rule::Range);
        }
        (!self.is_documented(value)).then_some(Rule::Enum)
    }

    fn is_documented(&self, value: Number) -> bool {
        let (Some(known), Number::Int(value)) = (self.known, value) else { return true };
        if self.is_flags {
            // Of a negative number all bits above its type's are set too, as they are of a mask's.
            value & !known.iter().fold(0, |all, mask| all | mask) == 0
        } else {
            known.contains(&value)
        }
    }
}

/// The words of generated code.
impl Constraint<'static> {
    /// No less than `low`.
    #[must_use]
    pub const fn from(self, low: Number) -> Self {
        Self { low: Some(low), ..self }
    }

    /// No more than `high`.
    #[must_use]
    pub const fn to(self, high: Number) -> Self {
        Self { high: Some(high), ..self }
    }

    /// These values too, wherever they lie.
    #[must_use]
    pub const fn or(self, special: &'static [Number]) -> Self {
        Self { special, ..self }
    }

    /// A count of entries in use of an array of `length`.
    #[must_use]
    pub const fn counting(self, length: u32) -> Self {
        Self { count: Some(length), ..self }
    }

    /// The documented values of an enum.
    #[must_use]
    pub const fn values<T: Open>(self) -> Self {
        Self { known: Some(T::KNOWN), names: T::NAMES, ..self }
    }

    /// Any of the documented flags.
    #[must_use]
    pub const fn flags<T: Open>(self) -> Self {
        Self { known: Some(T::KNOWN), names: T::NAMES, is_flags: true, ..self }
    }

    /// NaN has no meaning.
    #[must_use]
    pub const fn not_nan(self) -> Self {
        Self { forbids_nan: true, ..self }
    }
}

impl Constraint<'_> {
    /// The constraint that a JSON Schema asserts of the data in a field of a type; none for `bool`. Special and
    /// documented values are alternatives to it, and NaN is null.
    #[doc(hidden)]
    pub fn asserted(&self, scalar: Scalar) -> Option<Constraint<'static>> {
        let (least, most) = json_bounds(scalar)?;
        let low = self.low.filter(|low| *low > least).unwrap_or(least);
        let high = self.high.filter(|high| *high < most).unwrap_or(most);
        let count = self.count.map(|length| Number::Int(length.into()));
        let high = count.filter(|count| *count < high).unwrap_or(high);
        Some(Constraint { low: Some(low), high: Some(high), forbids_nan: true, ..Constraint::NONE })
    }

    /// True if all numbers between its bounds are valid.
    #[doc(hidden)]
    pub const fn is_interval(&self) -> bool {
        self.known.is_none()
    }

    /// The rules that a number can violate.
    pub fn rules(&self) -> impl Iterator<Item = Rule> + use<> {
        let rules = [
            (Rule::Count, self.count.is_some()),
            (Rule::Range, self.low.is_some() || self.high.is_some()),
            (Rule::Enum, self.known.is_some()),
            (Rule::Nan, self.forbids_nan),
        ];
        rules.into_iter().filter(|(_, is_stated)| *is_stated).map(|(rule, _)| rule)
    }

    /// The keywords of JSON Schemas that assert it.
    #[doc(hidden)]
    pub fn keywords(&self) -> impl Iterator<Item = (&'static str, Number)> + use<> {
        let keywords = [("minimum", self.low), ("maximum", self.high)];
        keywords.into_iter().filter_map(|(keyword, number)| Some((keyword, number?)))
    }
}

/// The least and the greatest number of a type in JSON; none for `bool`.
const fn json_bounds(scalar: Scalar) -> Option<(Number, Number)> {
    /// In the shortest form that reads back as it. Most programs write that form, and it is slightly above the exact
    /// value.
    const MAX_FLOAT32: f64 = 3.402_823_5e38;
    match (scalar, scalar.integer_bounds()) {
        (_, Some((least, most))) => Some((Number::Int(least), Number::Int(most))),
        (Scalar::Float32, None) => Some((Number::Float(-MAX_FLOAT32), Number::Float(MAX_FLOAT32))),
        // Some readers of JSON take 1e999 and pass it on as infinity.
        (Scalar::Float64, None) => Some((Number::Float(f64::MIN), Number::Float(f64::MAX))),
        _ => None,
    }
}

/// A rule that a value can break. [`id`](Self::id) is its permanent name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Rule {
    /// A count is at most the length of the array that it counts.
    Count,
    /// A sequence or string keeps to its bound.
    Bound,
    /// Text of fixed size is UTF-8 up to its first NUL.
    Text,
    /// A field with an `@enum` holds a documented value.
    Enum,
    /// A value lies in its `@range`, unless it is the `@invalid` one.
    Range,
    /// NaN doesn't stand in a field that the definition restricts without a word of NaN.
    Nan,
}

impl Rule {
    /// All of them.
    pub const ALL: [Self; 6] = [Self::Count, Self::Bound, Self::Text, Self::Enum, Self::Range, Self::Nan];

    /// Its permanent id, as the conformance suite reports it.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Count => "PX-LEN-01",
            Self::Bound => "PX-CDR-02",
            Self::Text => "PX-STR-01",
            Self::Enum => "PX-ENUM-01",
            Self::Range => "PX-RANGE-01",
            Self::Nan => "PX-NAN-01",
        }
    }

    /// Writes what `found`, which breaks it, should have been, by the constraint of a number or the bound
    /// of a sequence or string; and the id.
    pub fn explain(
        self,
        found: Number,
        constraint: Option<&Constraint<'_>>,
        bound: Option<u32>,
        formatter: &mut fmt::Formatter<'_>,
    ) -> fmt::Result {
        let Constraint { low, high, count, is_flags, .. } = *constraint.unwrap_or(&Constraint::NONE);
        match self {
            Self::Count => {
                let length = count.unwrap_or_default();
                write!(formatter, "{found} entries in use of an array of {length}")
            }
            Self::Bound => {
                write!(formatter, "{found} elements or characters where {} fit", bound.unwrap_or_default())
            }
            Self::Text => write!(formatter, "no UTF-8 from byte {found} on"),
            Self::Enum if is_flags => write!(formatter, "{found} has bits that are not documented"),
            Self::Enum => write!(formatter, "{found} is not a documented value"),
            Self::Range => match (low, high) {
                (Some(low), Some(high)) => write!(formatter, "{found} is out of range, {low} to {high}"),
                (Some(low), None) => write!(formatter, "{found} is out of range, {low} or more"),
                (None, high) => {
                    write!(formatter, "{found} is out of range, at most {}", high.unwrap_or(found))
                }
            },
            Self::Nan => formatter.write_str("NaN, which has no meaning here"),
        }?;
        write!(formatter, " ({})", self.id())
    }
}

/// The id.
impl fmt::Display for Rule {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.id())
    }
}
