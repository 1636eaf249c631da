//! Constraints on field values, and the rules that values can violate.

use core::cmp::Ordering;
use core::fmt;

use crate::{Open, Scalar};

/// A number from a definition or a field. Signed and unsigned 64-bit integers are exact. NaN equals NaN.
#[derive(Clone, Copy, Debug)]
pub enum Number {
    /// An integer, or a `bool` as 0 or 1.
    Int(i128),
    /// A float.
    Float(f64),
}

impl Number {
    /// True if the number is NaN.
    pub const fn is_nan(self) -> bool {
        matches!(self, Self::Float(value) if value.is_nan())
    }

    /// The number as a float. An integer beyond 2^53 becomes the nearest float.
    #[allow(clippy::cast_precision_loss)] // documented
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

/// The values that a definition allows for a number. The published JSON Schema has the same constraints, except that it
/// allows NaN and undocumented values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constraint<'k> {
    /// Minimum (`@range`).
    pub low: Option<Number>,
    /// Maximum (`@range`).
    pub high: Option<Number>,
    /// Values that mean "no data" (`@invalid`) or "set point not controlled" (`@uncontrolled`). Such values are valid
    /// even if they are out of range.
    pub special: &'k [Number],
    /// The length of the array whose used elements the value counts, if any (`@count`).
    pub count: Option<u32>,
    /// The documented values (`@enum`), or the masks of the documented flags (`@flags`).
    pub known: Option<&'k [i128]>,
    /// The names of the `known` values, in the same order. Empty if the names are not available.
    pub names: &'k [&'k str],
    /// True if a value is a combination of the `known` masks (`@flags`).
    pub is_flags: bool,
    /// True if NaN is not allowed. A float without any restrictions allows NaN.
    pub forbids_nan: bool,
}

impl Constraint<'_> {
    /// Allows every value of the type.
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

    /// The first rule that `value` violates, if any. The rules are checked in the order NaN, count, range, documented
    /// values.
    pub fn violated_by(&self, value: Number) -> Option<ConstraintKind> {
        if self.special.contains(&value) {
            return None;
        }
        if value.is_nan() {
            return self.forbids_nan.then_some(ConstraintKind::Nan);
        }
        if self.count.is_some_and(|length| value > Number::Int(length.into())) {
            return Some(ConstraintKind::Count);
        }
        if self.low.is_some_and(|low| value < low) || self.high.is_some_and(|high| value > high) {
            return Some(ConstraintKind::Range);
        }
        (!self.is_documented(value)).then_some(ConstraintKind::Enum)
    }

    fn is_documented(&self, value: Number) -> bool {
        let (Some(known), Number::Int(value)) = (self.known, value) else { return true };
        if self.is_flags {
            // Negative numbers and negative masks are both sign-extended: all bits above the width of the type are set.
            value & !known.iter().fold(0, |all, mask| all | mask) == 0
        } else {
            known.contains(&value)
        }
    }
}

/// The methods that generated code calls.
impl Constraint<'static> {
    /// Sets the minimum.
    #[must_use]
    pub const fn from(self, low: Number) -> Self {
        Self { low: Some(low), ..self }
    }

    /// Sets the maximum.
    #[must_use]
    pub const fn to(self, high: Number) -> Self {
        Self { high: Some(high), ..self }
    }

    /// Allows the `special` values even if they are out of range.
    #[must_use]
    pub const fn or(self, special: &'static [Number]) -> Self {
        Self { special, ..self }
    }

    /// Declares that the value counts the used elements of an array of `length` elements.
    #[must_use]
    pub const fn counting(self, length: u32) -> Self {
        Self { count: Some(length), ..self }
    }

    /// Allows only the documented values of an enum.
    #[must_use]
    pub const fn values<T: Open>(self) -> Self {
        Self { known: Some(T::KNOWN), names: T::NAMES, ..self }
    }

    /// Allows only combinations of the documented flags.
    #[must_use]
    pub const fn flags<T: Open>(self) -> Self {
        Self { known: Some(T::KNOWN), names: T::NAMES, is_flags: true, ..self }
    }

    /// Forbids NaN.
    #[must_use]
    pub const fn not_nan(self) -> Self {
        Self { forbids_nan: true, ..self }
    }
}

impl Constraint<'_> {
    /// The bounds that a JSON Schema asserts for the ordinary values of a field with this type, or `None` for `bool`.
    /// The schema lists special and documented values as alternatives, and NaN as null.
    #[doc(hidden)]
    pub fn asserted(&self, scalar: Scalar) -> Option<Constraint<'static>> {
        let (min, max) = json_bounds(scalar)?;
        let low = self.low.filter(|low| *low > min).unwrap_or(min);
        let high = self.high.filter(|high| *high < max).unwrap_or(max);
        let count = self.count.map(|length| Number::Int(length.into()));
        let high = count.filter(|count| *count < high).unwrap_or(high);
        Some(Constraint { low: Some(low), high: Some(high), forbids_nan: true, ..Constraint::NONE })
    }

    /// True if all numbers between the bounds are valid.
    #[doc(hidden)]
    pub const fn is_interval(&self) -> bool {
        self.known.is_none()
    }

    /// The rules that a number can violate.
    pub fn rules(&self) -> impl Iterator<Item = ConstraintKind> + use<> {
        let rules = [
            (ConstraintKind::Count, self.count.is_some()),
            (ConstraintKind::Range, self.low.is_some() || self.high.is_some()),
            (ConstraintKind::Enum, self.known.is_some()),
            (ConstraintKind::Nan, self.forbids_nan),
        ];
        rules.into_iter().filter(|(_, is_stated)| *is_stated).map(|(rule, _)| rule)
    }

    /// The JSON Schema keywords that assert the bounds.
    #[doc(hidden)]
    pub fn keywords(&self) -> impl Iterator<Item = (&'static str, Number)> + use<> {
        let keywords = [("minimum", self.low), ("maximum", self.high)];
        keywords.into_iter().filter_map(|(keyword, number)| Some((keyword, number?)))
    }
}

/// The minimum and maximum of a type in JSON, or `None` for `bool`.
const fn json_bounds(scalar: Scalar) -> Option<(Number, Number)> {
    /// The shortest decimal that reads back as `f32::MAX`. Most programs write `f32::MAX` as this decimal, which is
    /// slightly greater than the exact value.
    const MAX_FLOAT32: f64 = 3.402_823_5e38;
    match (scalar, scalar.integer_bounds()) {
        (_, Some((min, max))) => Some((Number::Int(min), Number::Int(max))),
        (Scalar::Float32, None) => Some((Number::Float(-MAX_FLOAT32), Number::Float(MAX_FLOAT32))),
        // Bounds are needed, because some JSON parsers read 1e999 as infinity.
        (Scalar::Float64, None) => Some((Number::Float(f64::MIN), Number::Float(f64::MAX))),
        _ => None,
    }
}

/// A kind of constraint that a value can violate. Its [`id`](Self::id), the id of a rule, is permanent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ConstraintKind {
    /// A count must not exceed the length of its array.
    Count,
    /// A sequence or string must not exceed its bound.
    Bound,
    /// Text must be valid UTF-8. Fixed-size text ends at its first NUL.
    Text,
    /// A field with `@enum` or `@flags` must contain only documented values.
    Enum,
    /// A value must be within its `@range`, unless it is a special value such as `@invalid`.
    Range,
    /// A field with restricted values may be NaN only if its definition says what NaN means.
    Nan,
}

impl ConstraintKind {
    /// All kinds.
    pub const ALL: [Self; 6] = [Self::Count, Self::Bound, Self::Text, Self::Enum, Self::Range, Self::Nan];

    /// The permanent id, which also appears in reports of the conformance suite.
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

    /// Explains why `found` violates the rule, and appends the rule id. For a number, the explanation uses
    /// `constraint`. For a sequence or string, the explanation uses `bound`.
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
                write!(formatter, "{found} exceeds the array length {length}")
            }
            Self::Bound => {
                write!(formatter, "length {found} exceeds the bound {}", bound.unwrap_or_default())
            }
            Self::Text => write!(formatter, "invalid UTF-8 at byte {found}"),
            Self::Enum if is_flags => write!(formatter, "{found} has bits that are not documented"),
            Self::Enum => write!(formatter, "{found} is not a documented value"),
            Self::Range => match (low, high) {
                (Some(low), Some(high)) => write!(formatter, "{found} is outside the range {low} to {high}"),
                (Some(low), None) => write!(formatter, "{found} is below the minimum of {low}"),
                (None, high) => {
                    write!(formatter, "{found} is above the maximum of {}", high.unwrap_or(found))
                }
            },
            Self::Nan => formatter.write_str("NaN is not allowed here"),
        }?;
        write!(formatter, " ({})", self.id())
    }
}

/// Displays the rule id.
impl fmt::Display for ConstraintKind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.id())
    }
}

#[cfg(test)]
mod tests {
    use core::fmt;

    use super::{Constraint, ConstraintKind, Number, Open, Scalar};
    use crate::alloc::format;

    /// The explanation of a number that violates a rule.
    struct Explained(ConstraintKind, Constraint<'static>);

    impl fmt::Display for Explained {
        fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
            self.0.explain(Number::Int(7), Some(&self.1), Some(5), formatter)
        }
    }

    #[test]
    fn explains_each_violation() {
        let (low, high) = (Some(Number::Int(8)), Some(Number::Int(6)));
        let none = Constraint::NONE;
        for (rule, constraint, expected) in [
            (
                ConstraintKind::Count,
                Constraint { count: Some(6), ..none },
                "7 exceeds the array length 6 (PX-LEN-01)",
            ),
            (ConstraintKind::Bound, none, "length 7 exceeds the bound 5 (PX-CDR-02)"),
            (ConstraintKind::Text, none, "invalid UTF-8 at byte 7 (PX-STR-01)"),
            (ConstraintKind::Enum, none, "7 is not a documented value (PX-ENUM-01)"),
            (
                ConstraintKind::Enum,
                Constraint { is_flags: true, ..none },
                "7 has bits that are not documented (PX-ENUM-01)",
            ),
            (
                ConstraintKind::Range,
                Constraint { low, high, ..none },
                "7 is outside the range 8 to 6 (PX-RANGE-01)",
            ),
            (ConstraintKind::Range, Constraint { low, ..none }, "7 is below the minimum of 8 (PX-RANGE-01)"),
            (ConstraintKind::Range, Constraint { high, ..none }, "7 is above the maximum of 6 (PX-RANGE-01)"),
            (ConstraintKind::Nan, none, "NaN is not allowed here (PX-NAN-01)"),
        ] {
            assert_eq!(format!("{}", Explained(rule, constraint)), expected);
        }
    }

    #[test]
    fn numbers_are_floats_or_exact_integers() {
        for (number, is_nan, float) in [
            (Number::Int(7), false, 7.0),
            (Number::Int(i128::from(u64::MAX)), false, 18_446_744_073_709_551_616.0),
            (Number::Float(-0.5), false, -0.5),
        ] {
            assert_eq!((number.is_nan(), number.as_f64().to_bits()), (is_nan, f64::to_bits(float)));
        }
        assert!(Number::Float(f64::NAN).is_nan() && Number::Float(f64::NAN).as_f64().is_nan());
    }

    struct Mode;

    impl Open for Mode {
        const NAME: &'static str = "Mode";
        const SCALAR: Scalar = Scalar::UInt8;
        const KNOWN: &'static [i128] = &[1, 4];
        const NAMES: &'static [&'static str] = &["ON", "OFF"];
        const IS_FLAGS: bool = false;

        fn from_bits(_: u64) -> Self {
            Self
        }
    }

    #[test]
    fn each_method_adds_one_restriction() {
        let none = Constraint::NONE;
        let (known, names) = (Some(Mode::KNOWN), Mode::NAMES);
        for (found, expected) in [
            (none.from(Number::Int(2)), Constraint { low: Some(Number::Int(2)), ..none }),
            (none.to(Number::Int(2)), Constraint { high: Some(Number::Int(2)), ..none }),
            (none.or(&[Number::Int(9)]), Constraint { special: &[Number::Int(9)], ..none }),
            (none.counting(3), Constraint { count: Some(3), ..none }),
            (none.values::<Mode>(), Constraint { known, names, ..none }),
            (none.flags::<Mode>(), Constraint { known, names, is_flags: true, ..none }),
            (none.not_nan(), Constraint { forbids_nan: true, ..none }),
        ] {
            assert_eq!(found, expected);
            assert_eq!(found.to(Number::Int(5)).high, Some(Number::Int(5)));
            assert_eq!(found.is_interval(), found.known.is_none());
        }
    }

    #[test]
    fn schemas_bound_all_numbers_of_a_type() {
        let bounds = |scalar| {
            let asserted = Constraint::NONE.asserted(scalar)?;
            asserted.low.zip(asserted.high)
        };
        assert_eq!(bounds(Scalar::Bool), None);
        assert_eq!(bounds(Scalar::Int8), Some((Number::Int(-128), Number::Int(127))));
        assert_eq!(bounds(Scalar::UInt64), Some((Number::Int(0), Number::Int(u64::MAX.into()))));
        assert_eq!(bounds(Scalar::Float64), Some((Number::Float(f64::MIN), Number::Float(f64::MAX))));
        let single = Number::Float(3.402_823_5e38);
        assert_eq!(bounds(Scalar::Float32), Some((Number::Float(-3.402_823_5e38), single)));
    }
}
