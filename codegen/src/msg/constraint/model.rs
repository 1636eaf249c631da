//! Constraints and their kinds.

use std::fmt;

use uavspec_runtime::{Number, Scalar};

use crate::value::Value;

/// A kind of constraint. All stages treat constraints alike, by the contents of this row.
pub struct ConstraintKind {
    /// The name, as in `[@range 0, 1]`. The printed model and the keys of translations use it, too.
    pub name: &'static str,
    /// The form, as messages show it.
    pub form: &'static str,
    /// The words of the documentation, with `{value}` for a stated value. Translations of the generator's words have
    /// an entry for them.
    pub words: &'static str,
    /// The keyword of JSON Schemas.
    pub keyword: &'static str,
    /// Reads the text after the name: the stated values, and the words that follow. None if it is malformed.
    pub(crate) read: for<'s> fn(&'s str) -> Option<(Argument<'s>, &'s str)>,
    /// Lays out the text after the name.
    pub(crate) lay_out: fn(&str) -> String,
    /// The effect on the values.
    pub(crate) effect: Effect,
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
pub(crate) enum Effect {
    /// The stated value is valid even if other constraints exclude it. It has a special meaning.
    Allows {
        /// The title of the value in JSON Schemas.
        title: &'static str,
        /// The name and the words of its test case.
        sample: (&'static str, &'static str),
    },
    /// Only some values are valid.
    Narrows {
        /// The demands on values of a type.
        demands: fn(&Stated, Scalar) -> Vec<Demand>,
        /// Numbers that are worth a test case.
        samples: fn(&Stated, Scalar) -> Vec<Probe>,
    },
}

/// The runtime's form of constraints, without lists.
type Numbers = uavspec_runtime::Constraint<'static>;

/// A demand on numbers: a method of the runtime's `Constraint` and its argument.
pub(crate) struct Demand {
    /// The name of the method, for generated code.
    pub(crate) method: &'static str,
    /// The method.
    pub(crate) apply: fn(Numbers, Number) -> Numbers,
    /// The argument.
    pub(crate) number: Number,
}

/// A number that is worth a test case.
pub(crate) struct Probe {
    /// The end of the id of the case.
    pub(crate) name: &'static str,
    /// The number in words.
    pub(crate) words: &'static str,
    /// The number, or its neighbour.
    pub(crate) number: Number,
    /// True for the next value of the type above the number, false for the one below.
    pub(crate) up: Option<bool>,
}

/// The argument of a constraint as written.
#[derive(Debug, PartialEq)]
pub enum Argument<'s> {
    /// Values.
    Stated(Stated),
    /// The name of a constant.
    Name(&'s str),
}

/// Inclusive bounds; an absent one is none.
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    /// Least value.
    pub low: Option<Value>,
    /// Greatest value.
    pub high: Option<Value>,
}

impl Range {
    /// The bounds in words; none if there are none.
    pub(crate) fn said(&self) -> Option<String> {
        match (&self.low, &self.high) {
            (Some(low), Some(high)) => Some(format!("{low} to {high}")),
            (Some(low), None) => Some(format!("{low} or more")),
            (None, Some(high)) => Some(format!("at most {high}")),
            (None, None) => None,
        }
    }

    /// True if it ends before it starts.
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
    /// The value, if it is one.
    pub fn value(&self) -> Option<&Value> {
        match self {
            Self::Value(value) => Some(value),
            Self::Range(_) | Self::Empty => None,
        }
    }

    /// All values that it names.
    pub(crate) fn values(&self) -> impl Iterator<Item = &Value> {
        let (first, second) = match self {
            Self::Range(Range { low, high }) => (low.as_ref(), high.as_ref()),
            Self::Value(value) => (Some(value), None),
            Self::Empty => (None, None),
        };
        first.into_iter().chain(second)
    }
}

/// A constraint on the values of a field, or of a parameter of a command.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraint {
    /// The kind.
    pub kind: &'static ConstraintKind,
    /// The stated values.
    pub stated: Stated,
    /// The words on when it applies; may be empty.
    pub text: String,
}

impl Constraint {
    /// The demands on values of a type.
    pub(crate) fn demands(&self, scalar: Scalar) -> Vec<Demand> {
        match self.kind.effect {
            Effect::Narrows { demands, .. } => demands(&self.stated, scalar),
            Effect::Allows { .. } => Vec::new(),
        }
    }

    /// True if it allows a value that has a special meaning.
    pub(crate) fn is_special(&self) -> bool {
        matches!(self.kind.effect, Effect::Allows { .. })
    }

    /// The valid values in words; none if all are valid.
    pub fn said(&self) -> Option<String> {
        match &self.stated {
            Stated::Range(range) => range.said(),
            Stated::Value(value) => Some(self.kind.words.replace("{value}", &value.to_string())),
            Stated::Empty => Some(self.kind.words.to_owned()),
        }
    }

    /// A fact for documentation; `code` marks up values and `prose` the words of the definition.
    pub(crate) fn fact(&self, code: fn(&str) -> String, prose: fn(&str) -> String) -> Option<String> {
        if !self.is_special() {
            let label = if matches!(self.stated, Stated::Range(_)) { "range: " } else { "" };
            return self.said().map(|said| format!("{label}{said}"));
        }
        let value = self.stated.value().map_or_else(|| "empty".to_owned(), |value| code(&value.to_string()));
        let when = if self.text.is_empty() { String::new() } else { format!(" ({})", prose(&self.text)) };
        Some(format!("{}: {value}{when}", self.kind.words))
    }
}
