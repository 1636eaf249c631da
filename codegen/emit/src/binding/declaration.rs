//! Declarations with names and texts.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use uavspec_schema::prose;
use uavspec_schema::value::Value;

use super::event::KnownEvents;

/// The module of a package.
pub(crate) struct Module {
    /// File name without extension.
    pub(crate) name: String,
    /// Name of the package in its definitions.
    pub(crate) package: String,
    /// Documentation.
    pub(crate) text: String,
    /// Names of the imported modules.
    pub(crate) imports: BTreeSet<String>,
    /// Declarations in order.
    pub(crate) declarations: Vec<Declaration>,
    /// Error codes in ascending order.
    pub(crate) error_codes: Vec<KnownCode>,
    /// Events, if the package has any.
    pub(crate) events: Option<KnownEvents>,
}

/// A named declaration.
pub(crate) struct Declaration {
    pub(crate) name: String,
    pub(crate) text: String,
    pub(crate) kind: Kind,
}

/// The content of a declaration.
pub(crate) enum Kind {
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
pub(crate) struct Named {
    pub(crate) name: String,
    pub(crate) value: Value,
    pub(crate) text: String,
}

/// A field of an object, or an element of a tuple.
pub(crate) struct Property {
    /// Name of the field in JSON.
    pub(crate) key: String,
    pub(crate) is_required: bool,
    pub(crate) ty: Type,
    pub(crate) text: String,
}

/// A JSON type.
#[derive(Clone)]
pub(crate) enum Type {
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
pub(crate) struct KnownCode {
    /// Name of the code's constant.
    pub(crate) name: String,
    pub(crate) code: u32,
    pub(crate) abbreviation: Option<String>,
    pub(crate) description: String,
    pub(crate) alternatives: Vec<u32>,
    pub(crate) see_also: Vec<u32>,
}

/// Name of the error-code type, which is declared for packages with error codes.
pub(crate) const ERROR_CODE: &str = "ErrorCode";

/// Name of the type that describes an error code.
pub(crate) const ERROR_CODE_INFO: &str = "ErrorCodeInfo";

/// Name of the severity type.
pub(crate) const SEVERITY: &str = "Severity";

/// Formats a string literal that is valid in JSON, TypeScript and Python. Invisible characters are escaped.
pub(crate) fn quoted(text: &str) -> String {
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
pub(crate) fn float(value: f64) -> Option<String> {
    value.is_finite().then(|| format!("{value:?}"))
}
