//! Declarations with names and texts.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use crate::prose;
use crate::value::Value;

/// The module of a package.
pub(in crate::emit) struct Module {
    /// File name without extension.
    pub(in crate::emit) name: String,
    /// Name of the package in its definitions.
    pub(in crate::emit) package: String,
    /// Documentation.
    pub(in crate::emit) text: String,
    /// Names of the imported modules.
    pub(in crate::emit) imports: BTreeSet<String>,
    /// Declarations in order.
    pub(in crate::emit) declarations: Vec<Declaration>,
    /// Error codes in ascending order.
    pub(in crate::emit) error_codes: Vec<KnownCode>,
}

/// A named declaration.
pub(in crate::emit) struct Declaration {
    pub(in crate::emit) name: String,
    pub(in crate::emit) text: String,
    pub(in crate::emit) kind: Kind,
}

/// The content of a declaration.
pub(in crate::emit) enum Kind {
    /// A JSON object. A closed object must not have other fields.
    Record { properties: Vec<Property>, is_closed: bool },
    /// An alias of another type.
    Alias(Type),
    /// Named integers. A field contains one of these integers or, for flags, any combination. `is_signed` is true if
    /// the type of the field has negative values.
    Enumeration { is_flags: bool, is_signed: bool, members: Vec<Named> },
    /// Named values.
    Constants(Vec<Named>),
    /// Message types by message name.
    Messages(Vec<(String, Type)>),
}

/// A named value.
pub(in crate::emit) struct Named {
    pub(in crate::emit) name: String,
    pub(in crate::emit) value: Value,
    pub(in crate::emit) text: String,
}

/// A field of an object, or an element of a tuple.
pub(in crate::emit) struct Property {
    /// Name of the field in JSON.
    pub(in crate::emit) key: String,
    pub(in crate::emit) is_required: bool,
    pub(in crate::emit) ty: Type,
    pub(in crate::emit) text: String,
}

/// A JSON type.
#[derive(Clone)]
pub(in crate::emit) enum Type {
    Any,
    Null,
    Boolean,
    Integer,
    Number,
    String,
    /// String literals. An open set also allows other strings.
    Strings {
        values: Vec<String>,
        is_open: bool,
    },
    /// Integer literals. An open set also allows other integers.
    Integers {
        values: Vec<i64>,
        is_open: bool,
    },
    /// A reference to a declaration. `module` is set if the declaration is in another package.
    Named {
        module: Option<String>,
        name: String,
    },
    /// A reference to the declaration of a set of strings or integers in the same package.
    Set(String),
    /// A reference to an enumeration, which is an integer in JSON.
    Enumeration {
        module: Option<String>,
        name: String,
    },
    List(Box<Type>),
    /// An object with arbitrary keys.
    Map(Box<Type>),
    /// An array with named elements. Each entry contains the name, a flag that is true if the element is required, and
    /// the type.
    Tuple(Vec<(String, bool, Type)>),
    Either(Vec<Type>),
}

/// An error code from a table.
pub(in crate::emit) struct KnownCode {
    /// Name of the code's constant.
    pub(in crate::emit) name: String,
    pub(in crate::emit) code: u32,
    pub(in crate::emit) abbreviation: Option<String>,
    pub(in crate::emit) description: String,
    pub(in crate::emit) alternatives: Vec<u32>,
    pub(in crate::emit) see_also: Vec<u32>,
}

/// Name of the error-code type, which is declared for packages with error codes.
pub(in crate::emit) const ERROR_CODE: &str = "ErrorCode";

/// Name of the type that describes an error code.
pub(in crate::emit) const ERROR_CODE_INFO: &str = "ErrorCodeInfo";

/// Name of the severity type.
pub(in crate::emit) const SEVERITY: &str = "Severity";

/// Formats a string literal that is valid in JSON, TypeScript and Python. Invisible characters are escaped.
pub(in crate::emit) fn quoted(text: &str) -> String {
    let literal = serde_json::Value::from(text).to_string();
    let mut escaped = String::with_capacity(literal.len());
    for character in literal.chars() {
        // Python reads a surrogate pair as two characters, so characters beyond U+FFFF have no common escape.
        if prose::visible(character) == character || character > '\u{ffff}' {
            escaped.push(character);
        } else {
            // Writing to a `String` never fails.
            let _ = write!(escaped, "\\u{:04x}", u32::from(character));
        }
    }
    escaped
}

/// Formats a float literal that is valid in TypeScript and Python. Returns `None` if the value is not finite.
pub(in crate::emit) fn float(value: f64) -> Option<String> {
    value.is_finite().then(|| format!("{value:?}"))
}
