//! Declarations with names and texts.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use crate::prose;
use crate::value::Value;

/// The declarations of a package.
pub(in crate::emit) struct Module {
    /// The name of its file, without an ending.
    pub(in crate::emit) name: String,
    /// The package, as its definitions name it.
    pub(in crate::emit) package: String,
    /// What is said of it.
    pub(in crate::emit) text: String,
    /// Names of the modules that it refers to.
    pub(in crate::emit) imports: BTreeSet<String>,
    /// What it declares, in order.
    pub(in crate::emit) declarations: Vec<Declaration>,
    /// The error codes, by their number; empty where there are none.
    pub(in crate::emit) error_codes: Vec<KnownCode>,
}

/// Something with a name.
pub(in crate::emit) struct Declaration {
    pub(in crate::emit) name: String,
    pub(in crate::emit) text: String,
    pub(in crate::emit) kind: Kind,
}

/// What is declared.
pub(in crate::emit) enum Kind {
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
pub(in crate::emit) struct Named {
    pub(in crate::emit) name: String,
    pub(in crate::emit) value: Value,
    pub(in crate::emit) text: String,
}

/// A field of an object, or an element of a tuple.
pub(in crate::emit) struct Property {
    /// The name as JSON has it.
    pub(in crate::emit) key: String,
    pub(in crate::emit) is_required: bool,
    pub(in crate::emit) ty: Type,
    pub(in crate::emit) text: String,
}

/// What JSON a value is.
#[derive(Clone)]
pub(in crate::emit) enum Type {
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
pub(in crate::emit) struct KnownCode {
    /// The name of its constant.
    pub(in crate::emit) name: String,
    pub(in crate::emit) code: u32,
    pub(in crate::emit) abbreviation: Option<String>,
    pub(in crate::emit) description: String,
    pub(in crate::emit) alternatives: Vec<u32>,
    pub(in crate::emit) see_also: Vec<u32>,
}

/// The type of error codes, in a package that has some.
pub(in crate::emit) const ERROR_CODE: &str = "ErrorCode";

/// The type of what is known of a code.
pub(in crate::emit) const ERROR_CODE_INFO: &str = "ErrorCodeInfo";

/// The type of severities.
pub(in crate::emit) const SEVERITY: &str = "Severity";

/// A string literal, which JSON, TypeScript and Python read alike. What doesn't show is written as an escape.
pub(in crate::emit) fn quoted(text: &str) -> String {
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
pub(in crate::emit) fn float(value: f64) -> Option<String> {
    value.is_finite().then(|| format!("{value:?}"))
}
