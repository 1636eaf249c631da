//! Types from the formats in a `ULog` file: `name:type field;type[4] field;…`.
//!
//! Fields are in memory order, and padding is declared as fields. The type names come from C++:
//! <https://docs.px4.io/main/en/dev_log/ulog_file_format.html>, section "F: Format Message".

use std::collections::{HashMap, HashSet};
use std::fmt;

use uavspec_runtime::Scalar;
use uavspec_schema::source::Span;
use uavspec_schema::{Element, MessageId, Shape};

use super::compile::{Draft, Placement, compile};
use super::error::Defect;
use super::plan::Field;
use super::types::Types;

/// Name of the package that contains all types of a log.
pub const ULOG_PACKAGE: &str = "ulog";

/// Maximum size of a message in bytes. The size of a data message is a `uint16` and includes two bytes for the id.
const MAX_SIZE: u16 = u16::MAX - 2;

/// An unusable format.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FormatError {
    /// Index of the format in the input.
    pub index: usize,
    /// Name of the format.
    pub name: String,
    /// The cause.
    pub problem: FormatProblem,
}

/// The reason why a format is unusable.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FormatProblem {
    /// An earlier format has the same name and is used instead.
    Repeated,
    /// The format has no fields.
    Empty,
    /// A part between semicolons is not a type followed by a name.
    NotAField(String),
    /// The length of an array isn't a number from 1 to 65533.
    ArrayLength(String),
    /// Two fields have the same name.
    RepeatedField(String),
    /// A field has a type that is neither basic nor defined by a format.
    UnknownType {
        /// Name of the field.
        field: String,
        /// Type of the field.
        ty: String,
    },
    /// The format is readable, but its type is unusable.
    Defect(Defect),
}

impl fmt::Display for FormatError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "format `{}` ", self.name.escape_debug())?;
        match &self.problem {
            FormatProblem::Repeated => formatter.write_str("is repeated; the first definition is used"),
            FormatProblem::Empty => formatter.write_str("has no fields"),
            FormatProblem::NotAField(text) => {
                write!(
                    formatter,
                    "has the field declaration `{}`, expected a type and a name",
                    text.escape_debug()
                )
            }
            FormatProblem::ArrayLength(text) => {
                write!(
                    formatter,
                    "has an array of length `{}`, expected 1 to {MAX_SIZE}",
                    text.escape_debug()
                )
            }
            FormatProblem::RepeatedField(field) => {
                write!(formatter, "has two `{}` fields", field.escape_debug())
            }
            FormatProblem::UnknownType { field, ty } => write!(
                formatter,
                "has the field `{}` with the unknown type `{}`",
                field.escape_debug(),
                ty.escape_debug()
            ),
            FormatProblem::Defect(defect) => defect.fmt(formatter),
        }
    }
}

impl std::error::Error for FormatError {}

impl Types {
    /// Creates the types of a `ULog` file from the names and fields of its formats. Usable types are in the package
    /// [`ULOG_PACKAGE`]. Each unusable format causes an error.
    ///
    /// As in the `px4` package, `char[N]` is text. Values can violate only one rule: text must be valid UTF-8. Fields
    /// whose names start with `_padding` are skipped.
    ///
    /// The [`MessageId`](uavspec_schema::MessageId) of a type is the index of its format, not counting formats with a
    /// repeated name. Adding formats at the end doesn't change existing ids.
    ///
    /// ```
    /// use uavspec_dynamic::{Types, ULOG_PACKAGE};
    ///
    /// let formats = [("gust", "uint64_t timestamp;wind[2] winds;"), ("wind", "float speed;uint8_t[4] _padding0;")];
    /// let (types, errors) = Types::from_ulog_formats(formats);
    /// assert!(errors.is_empty());
    /// let gust = types.find(ULOG_PACKAGE, "gust").unwrap();
    /// let message = gust.view_uorb(&[0; 24])?;
    /// assert_eq!(message.to_json_text()?, r#"{"timestamp":0,"winds":[{"speed":0.0},{"speed":0.0}]}"#);
    /// # Ok::<(), uavspec_dynamic::Error>(())
    /// ```
    pub fn from_ulog_formats<'f>(
        formats: impl IntoIterator<Item = (&'f str, &'f str)>,
    ) -> (Self, Vec<FormatError>) {
        let mut errors = Vec::new();
        let mut refuse = |index, name: &str, problem| {
            errors.push(FormatError { index, name: name.to_owned(), problem });
        };
        let mut unique: Vec<(usize, &str, &str)> = Vec::new();
        let mut plans = HashMap::new();
        for (index, (name, fields)) in formats.into_iter().enumerate() {
            if plans.contains_key(name) {
                refuse(index, name, FormatProblem::Repeated);
            } else {
                plans.insert(name, MessageId(u32::try_from(unique.len()).unwrap_or(u32::MAX)));
                unique.push((index, name, fields));
            }
        }
        let mut is_reported = vec![false; unique.len()];
        let mut drafts = Vec::with_capacity(unique.len());
        for (plan, (index, name, fields)) in unique.iter().enumerate() {
            let fields = read_fields(fields, &plans).unwrap_or_else(|problem| {
                refuse(*index, name, problem);
                is_reported[plan] = true;
                Vec::new()
            });
            drafts.push(draft(name, fields));
        }
        let plans = compile(drafts);
        for (plan, (index, name, _)) in unique.iter().enumerate().filter(|(plan, _)| !is_reported[*plan]) {
            if let Some(defect) = &plans[plan].defect {
                refuse(*index, name, FormatProblem::Defect(defect.clone()));
            }
        }
        errors.sort_by_key(|error| error.index);
        (Self::of(plans), errors)
    }
}

fn draft(name: &str, fields: Vec<Field>) -> Draft {
    Draft {
        package: ULOG_PACKAGE.into(),
        name: name.into(),
        span: Span::default(),
        // Reject a type without fields. It takes no space, so arrays of any length would otherwise be accepted.
        defect: fields.is_empty().then_some(Defect::Unreadable),
        fields,
        placement: Placement::AsGiven,
        limit: MAX_SIZE.into(),
    }
}

fn read_fields(text: &str, plans: &HashMap<&str, MessageId>) -> Result<Vec<Field>, FormatProblem> {
    let mut names = HashSet::new();
    let mut fields = Vec::new();
    for part in text.split(';').map(str::trim).filter(|part| !part.is_empty()) {
        let (name, element, shape) = read_field(part, plans)?;
        if !names.insert(name) {
            return Err(FormatProblem::RepeatedField(name.to_owned()));
        }
        fields.push(Field::new(name, element, shape));
    }
    if fields.is_empty() { Err(FormatProblem::Empty) } else { Ok(fields) }
}

/// Parses a field: its name, element type and shape.
fn read_field<'t>(
    part: &'t str,
    plans: &HashMap<&str, MessageId>,
) -> Result<(&'t str, Element, Shape), FormatProblem> {
    let not_a_field = || FormatProblem::NotAField(part.to_owned());
    let (ty, name) = part.split_once(' ').ok_or_else(not_a_field)?;
    let (ty, length) = match ty.split_once('[') {
        None => (ty, None),
        Some((ty, length)) => {
            (ty, Some(length.strip_suffix(']').ok_or_else(not_a_field).and_then(array_length)?))
        }
    };
    let is_word = |word: &str| {
        !word.is_empty()
            && !word.contains(|c: char| c.is_whitespace() || c.is_control() || "[].;:".contains(c))
    };
    if !is_word(ty) || !is_word(name) {
        return Err(not_a_field());
    }
    let element = match basic(ty) {
        Some(scalar) => Element::Scalar(scalar),
        None => Element::Message(
            *plans
                .get(ty)
                .ok_or_else(|| FormatProblem::UnknownType { field: name.to_owned(), ty: ty.to_owned() })?,
        ),
    };
    let (element, shape) = match (element, length) {
        (Element::Scalar(Scalar::Char), Some(length)) => (Element::Text(length), Shape::Single),
        (element, Some(length)) => (element, Shape::Array(length)),
        (element, None) => (element, Shape::Single),
    };
    Ok((name, element, shape))
}

fn array_length(text: &str) -> Result<u32, FormatProblem> {
    let length = text.parse().ok().filter(|length| (1..=u32::from(MAX_SIZE)).contains(length));
    length.ok_or_else(|| FormatProblem::ArrayLength(text.to_owned()))
}

/// The basic type of `ULog` with this name.
fn basic(name: &str) -> Option<Scalar> {
    Some(match name {
        "int8_t" => Scalar::Int8,
        "uint8_t" => Scalar::UInt8,
        "int16_t" => Scalar::Int16,
        "uint16_t" => Scalar::UInt16,
        "int32_t" => Scalar::Int32,
        "uint32_t" => Scalar::UInt32,
        "int64_t" => Scalar::Int64,
        "uint64_t" => Scalar::UInt64,
        "float" => Scalar::Float32,
        "double" => Scalar::Float64,
        "bool" => Scalar::Bool,
        "char" => Scalar::Char,
        _ => return None,
    })
}
