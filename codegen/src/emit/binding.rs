//! What TypeScript and Python have in common: declarations of the JSON that definitions describe.
//!
//! The model is lowered once to declarations with names and texts, and each language prints them. So the same things
//! bear the same names in both. Texts are plain here; whoever prints them escapes them.

mod declare;
mod json_type;
mod labels;
mod message;
mod names;
mod text;

use std::collections::BTreeSet;
use std::fmt::Write as _;

pub(super) use self::declare::modules;
pub(super) use self::labels::{LabelLanguage, Labels, labels};
pub(super) use self::names::{identifier, is_python_keyword};
use crate::prose;
use crate::value::Value;

/// The declarations of a package.
pub(super) struct Module {
    /// The name of its file, without an ending.
    pub(super) name: String,
    /// The package, as its definitions name it.
    pub(super) package: String,
    /// What is said of it.
    pub(super) text: String,
    /// Names of the modules that it refers to.
    pub(super) imports: BTreeSet<String>,
    /// What it declares, in order.
    pub(super) declarations: Vec<Declaration>,
    /// The error codes, by their number; empty where there are none.
    pub(super) error_codes: Vec<KnownCode>,
}

/// Something with a name.
pub(super) struct Declaration {
    pub(super) name: String,
    pub(super) text: String,
    pub(super) kind: Kind,
}

/// What is declared.
pub(super) enum Kind {
    /// A JSON object; where it is closed, it has no other fields.
    Record { properties: Vec<Property>, is_closed: bool },
    /// A name of another type.
    Alias(Type),
    /// Names of integers, which a field holds one of or, where they are flags, any set of.
    Enumeration { is_flags: bool, members: Vec<Named> },
    /// Names of values.
    Constants(Vec<Named>),
    /// The types of messages by the name of the message.
    Messages(Vec<(String, Type)>),
}

/// A name of a value.
pub(super) struct Named {
    pub(super) name: String,
    pub(super) value: Value,
    pub(super) text: String,
}

/// A field of an object, or an element of a tuple.
pub(super) struct Property {
    /// The name as JSON has it.
    pub(super) key: String,
    pub(super) is_required: bool,
    pub(super) ty: Type,
    pub(super) text: String,
}

/// What JSON a value is.
#[derive(Clone)]
pub(super) enum Type {
    Any,
    Null,
    Boolean,
    Integer,
    Number,
    String,
    /// Some strings, or any beside them.
    Strings {
        values: Vec<String>,
        is_open: bool,
    },
    /// Some integers, or any beside them.
    Integers {
        values: Vec<i64>,
        is_open: bool,
    },
    /// A declaration; `module` is that of another package.
    Named {
        module: Option<String>,
        name: String,
    },
    /// An enumeration, which is an integer in JSON.
    Enumeration {
        module: Option<String>,
        name: String,
    },
    List(Box<Type>),
    /// An object with any keys.
    Map(Box<Type>),
    /// An array with a meaning for each position: name, whether it has to be there, type.
    Tuple(Vec<(String, bool, Type)>),
    Either(Vec<Type>),
}

/// What the tables say of an error code.
pub(super) struct KnownCode {
    /// The name of its constant.
    pub(super) name: String,
    pub(super) code: u32,
    pub(super) abbreviation: Option<String>,
    pub(super) description: String,
    pub(super) alternatives: Vec<u32>,
    pub(super) see_also: Vec<u32>,
}

/// The type of error codes, in a package that has some.
pub(super) const ERROR_CODE: &str = "ErrorCode";

/// The type of what is known of a code.
pub(super) const ERROR_CODE_INFO: &str = "ErrorCodeInfo";

/// The type of severities.
pub(super) const SEVERITY: &str = "Severity";

/// A string literal, which JSON, TypeScript and Python read alike. What doesn't show is written as an escape.
pub(super) fn quoted(text: &str) -> String {
    let literal = serde_json::Value::from(text).to_string();
    let mut shown = String::with_capacity(literal.len());
    for character in literal.chars() {
        if prose::visible(character) == character {
            shown.push(character);
        } else {
            // Writing to a `String` can't fail.
            let _ = write!(shown, "\\u{:04x}", u32::from(character));
        }
    }
    shown
}

/// A float literal of both languages; none for what has no literal.
pub(super) fn float(value: f64) -> Option<String> {
    value.is_finite().then(|| format!("{value:?}"))
}
