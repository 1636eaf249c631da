//! Messages of PX4: the values that they may have, in memory, as CDR and as JSON, and how definitions of them differ.

pub mod comparison;
pub mod json;
pub mod plan;

use crate::model::Rule;

/// The rules on single values, which the checks of values report violations of.
#[derive(Debug)]
pub struct ValueRules {
    /// A bool is 0 or 1.
    pub bool: &'static Rule,
    /// Text is UTF-8.
    pub text: &'static Rule,
    /// A field that counts the entries of an array is at most its length.
    pub count: &'static Rule,
    /// A sequence or a string keeps to its bound.
    pub bound: &'static Rule,
    /// A value lies in its range.
    pub range: &'static Rule,
    /// A value is one of those that the definition names.
    pub documented: &'static Rule,
    /// A value is NaN only where that has a meaning.
    pub nan: &'static Rule,
    /// A JSON object has each field of its message once, and no others.
    pub members: &'static Rule,
    /// A JSON value has the type of its field.
    pub json_type: &'static Rule,
    /// An array in JSON has the length of its field.
    pub length: &'static Rule,
}

impl ValueRules {
    /// The rule that states what a constraint demands.
    pub(crate) fn on(&self, broken: uavspec_runtime::Rule) -> &'static Rule {
        use uavspec_runtime::Rule;
        match broken {
            Rule::Text => self.text,
            Rule::Count => self.count,
            Rule::Bound => self.bound,
            Rule::Range => self.range,
            Rule::Enum => self.documented,
            Rule::Nan => self.nan,
        }
    }
}
