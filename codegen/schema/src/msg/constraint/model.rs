//! Constraints and their kinds.

use std::fmt;

use uavspec_runtime::{Number, Scalar};

use crate::value::Value;

/// A kind of constraint. All stages handle constraints generically, using the data in this struct.
pub struct ConstraintKind {
    /// The name, as in `[@range 0, 1]`; also used in the printed model and in translation keys.
    pub name: &'static str,
    /// The syntax, as shown in messages.
    pub form: &'static str,
    /// The text in the documentation, in which `{value}` is a placeholder. Translations use the English text as their
    /// key.
    pub words: &'static str,
    /// The keyword in JSON Schemas.
    pub keyword: &'static str,
    /// Parses the text after the name into the argument and the explanation. Returns `None` if the text is malformed.
    pub(crate) read: for<'s> fn(&'s str) -> Option<(Argument<'s>, &'s str)>,
    /// Formats the text after the name.
    pub lay_out: fn(&str) -> String,
    /// The effect on valid values.
    pub effect: Effect,
}

impl fmt::Debug for ConstraintKind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name)
    }
}

impl PartialEq for ConstraintKind {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for ConstraintKind {}

/// The effect of a constraint on the values of a field.
pub enum Effect {
    /// The stated value is valid and has a special meaning, even if other constraints exclude it.
    Allows {
        /// The title of the value in JSON Schemas.
        title: &'static str,
        /// The name and description of the test case for the value.
        sample: (&'static str, &'static str),
    },
    /// Only some values are valid.
    Narrows {
        /// The requirements on values of a given type.
        demands: fn(&Stated, Scalar) -> Vec<Demand>,
        /// Numbers for test cases.
        samples: fn(&Stated, Scalar) -> Vec<Probe>,
    },
}

/// The runtime's constraint, without lists.
type Numbers = uavspec_runtime::Constraint<'static>;

/// A requirement on numbers: a method of the runtime's `Constraint` and its argument.
pub struct Demand {
    /// The name of the method, for generated code.
    pub(crate) method: &'static str,
    /// The method.
    pub(crate) apply: fn(Numbers, Number) -> Numbers,
    /// The argument.
    pub(crate) number: Number,
}

/// A number for a test case.
pub struct Probe {
    /// The suffix of the test case's id.
    pub name: &'static str,
    /// The description of the number.
    pub words: &'static str,
    /// The number, or the number whose neighbour is tested.
    pub number: Number,
    /// The neighbour to test, if any: the next greater value of the type for `Some(true)`, the next smaller value for
    /// `Some(false)`.
    pub up: Option<bool>,
}

/// The argument of a constraint as written.
#[derive(Debug, PartialEq)]
pub enum Argument<'s> {
    /// Values.
    Stated(Stated),
    /// The name of a constant.
    Name(&'s str),
}

/// Inclusive bounds; `None` means unbounded.
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    /// The minimum.
    pub low: Option<Value>,
    /// The maximum.
    pub high: Option<Value>,
}

impl Range {
    /// The bounds as text, or `None` if both are absent.
    pub fn to_text(&self) -> Option<String> {
        match (&self.low, &self.high) {
            (Some(low), Some(high)) => Some(format!("{low} to {high}")),
            (Some(low), None) => Some(format!("{low} or more")),
            (None, Some(high)) => Some(format!("at most {high}")),
            (None, None) => None,
        }
    }

    /// True if the lower bound is greater than the upper bound.
    pub(crate) fn is_reversed(&self) -> bool {
        let number = |bound: &Option<Value>| bound.as_ref().and_then(Value::as_f64);
        number(&self.low).zip(number(&self.high)).is_some_and(|(low, high)| low > high)
    }
}

/// The values that a constraint states.
#[derive(Clone, Debug, PartialEq)]
pub enum Stated {
    /// Bounds.
    Range(Range),
    /// One value.
    Value(Value),
    /// The empty string or array.
    Empty,
}

impl Stated {
    /// The stated value; `None` for a range or an empty value.
    pub fn value(&self) -> Option<&Value> {
        match self {
            Self::Value(value) => Some(value),
            Self::Range(_) | Self::Empty => None,
        }
    }

    /// All stated values.
    pub(crate) fn values(&self) -> impl Iterator<Item = &Value> {
        let (first, second) = match self {
            Self::Range(Range { low, high }) => (low.as_ref(), high.as_ref()),
            Self::Value(value) => (Some(value), None),
            Self::Empty => (None, None),
        };
        first.into_iter().chain(second)
    }
}

/// A constraint on the values of a field or a command parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraint {
    /// The kind.
    pub kind: &'static ConstraintKind,
    /// The stated values.
    pub stated: Stated,
    /// The explanation of when the constraint applies; may be empty.
    pub text: String,
}

impl Constraint {
    /// The requirements on values of a given type.
    pub(crate) fn demands(&self, scalar: Scalar) -> Vec<Demand> {
        match self.kind.effect {
            Effect::Narrows { demands, .. } => demands(&self.stated, scalar),
            Effect::Allows { .. } => Vec::new(),
        }
    }

    /// True if the constraint allows a value with a special meaning.
    pub fn is_special(&self) -> bool {
        matches!(self.kind.effect, Effect::Allows { .. })
    }

    /// True if the constraint excludes no value: a range without bounds, such as `[@range -inf, inf]`.
    pub fn is_unbounded(&self) -> bool {
        matches!(self.stated, Stated::Range(Range { low: None, high: None }))
    }

    /// The valid values as text, or `None` if all are valid.
    pub fn valid_values(&self) -> Option<String> {
        match &self.stated {
            Stated::Range(range) => range.to_text(),
            Stated::Value(value) => Some(self.kind.words.replace("{value}", &value.to_string())),
            Stated::Empty => Some(self.kind.words.to_owned()),
        }
    }

    /// The constraint as a fact in the documentation. `code` formats values, and `prose` formats text from the
    /// definition.
    pub fn fact(&self, code: fn(&str) -> String, prose: fn(&str) -> String) -> Option<String> {
        if !self.is_special() {
            let label = if matches!(self.stated, Stated::Range(_)) { "range: " } else { "" };
            return self.valid_values().map(|values| format!("{label}{values}"));
        }
        let value = self.stated.value().map_or_else(|| "empty".to_owned(), |value| code(&value.to_string()));
        let when = if self.text.is_empty() { String::new() } else { format!(" ({})", prose(&self.text)) };
        Some(format!("{}: {value}{when}", self.kind.words))
    }
}
