//! Statements: annotations parsed by name and argument.

use super::attribute::{ATTRIBUTES, Attribute};
use super::constraint::{self, Argument, CONSTRAINTS, ConstraintKind, RANGE};
use crate::diagnostic::Problem;
use crate::name::is_identifier;

/// The meaning of an annotation.
#[derive(Debug, PartialEq)]
pub enum Statement<'s> {
    /// `[m/s]`: the unit. Known units have their canonical spelling.
    Unit(&'s str),
    /// `[@enum PREFIX …]`: the value is one of the constants with this prefix.
    Enum(Vec<Prefix<'s>>),
    /// `[@flags PREFIX …]`: the value is a mask of the constants with this prefix.
    Flags(Vec<Prefix<'s>>),
    /// `[@range low, high]` and similar: a constraint, and the explanation that follows.
    Constraint(&'static ConstraintKind, Argument<'s>, &'s str),
    /// `[@frame name]` and similar: an attribute and its text.
    Attribute(&'static Attribute, &'s str),
    /// `[@count field]`: the value is the number of used elements in the array `field`.
    Count(&'s str),
    /// The length of a string (in characters) or list (in elements) on a page, from `[@length least, most]`.
    Length {
        /// The minimum, if bounded.
        min: Option<u32>,
        /// The maximum, if bounded.
        max: Option<u32>,
    },
    /// A requirement that the elements of a list on a page are distinct, from `[@unique]`.
    Unique,
    /// The regular expression that a string on a page must match, from `[@pattern REGEX]`.
    Pattern(&'s str),
    /// The encoding of a string on a page, from `[@format base64]`.
    Format(&'s str),
}

impl Statement<'_> {
    /// The position in the order of annotations. Of several annotations with the same rank, only the last one applies.
    pub fn rank(&self) -> (u8, Option<usize>) {
        match self {
            Self::Unit(_) => (0, None),
            Self::Enum(_) | Self::Flags(_) => (1, None),
            Self::Constraint(kind, ..) => (2, constraint::rank(kind)),
            Self::Attribute(attribute, _) => (3, ATTRIBUTES.iter().position(|known| known == attribute)),
            Self::Count(_) => (4, None),
            Self::Length { .. } => (5, None),
            Self::Unique => (6, None),
            Self::Pattern(_) => (7, None),
            Self::Format(_) => (8, None),
        }
    }
}

/// The set of known annotations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Vocabulary {
    /// Comments of `.msg`, `.srv` and `.action` files.
    Comment,
    /// Descriptions of types on pages.
    Page,
}

/// The known string formats on pages.
pub(crate) const FORMATS: [&str; 1] = ["base64"];

/// A prefix of constant names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Prefix<'s> {
    /// The message that defines the constants, as in `Message.PREFIX`. `None` for the message with
    /// the annotation.
    pub message: Option<&'s str>,
    /// The prefix, without the `_` that follows it.
    pub prefix: &'s str,
}

/// The problem to report for an unknown annotation.
pub(super) fn unknown(name: &str) -> Problem {
    let constraints = CONSTRAINTS.iter().map(|kind| kind.name);
    let attributes = ATTRIBUTES.iter().map(|attribute| attribute.name);
    let known: Vec<&str> = ["enum", "flags"].into_iter().chain(constraints).chain(attributes).collect();
    Problem::UnknownAnnotation { name: name.to_owned(), known: format!("{} and count", known.join(", ")) }
}

/// Parses the annotation `name`. Returns `None` if the name is unknown.
pub(super) fn read<'s>(
    vocabulary: Vocabulary,
    name: &str,
    argument: &'s str,
) -> Option<Result<Statement<'s>, Problem>> {
    let (form, read) = match vocabulary {
        Vocabulary::Comment => statement_of_comment(name, argument)?,
        Vocabulary::Page => statement_of_page(name, argument)?,
    };
    let text = || format!("@{name} {argument}").trim_end().to_owned();
    Some(read.ok_or_else(|| Problem::MalformedAnnotation { text: text(), form }))
}

/// The syntax of an annotation, and the statement if the annotation is well-formed.
type Read<'s> = (&'static str, Option<Statement<'s>>);

fn statement_of_comment<'s>(name: &str, argument: &'s str) -> Option<Read<'s>> {
    Some(match name {
        "enum" => ("[@enum PREFIX]", prefixes(argument).map(Statement::Enum)),
        "flags" => ("[@flags PREFIX]", prefixes(argument).map(Statement::Flags)),
        "count" => ("[@count field]", is_identifier(argument).then_some(Statement::Count(argument))),
        _ => {
            if let Some(kind) = CONSTRAINTS.iter().find(|kind| kind.name == name) {
                return Some((kind.form, constraint(kind, argument)));
            }
            let attribute = ATTRIBUTES.iter().find(|attribute| attribute.name == name)?;
            let statement = Statement::Attribute(attribute, argument);
            (attribute.form, (!argument.is_empty()).then_some(statement))
        }
    })
}

fn statement_of_page<'s>(name: &str, argument: &'s str) -> Option<Read<'s>> {
    let known_format = || FORMATS.contains(&argument).then_some(Statement::Format(argument));
    Some(match name {
        "range" => (RANGE.form, constraint(&RANGE, argument)),
        "length" => ("[@length least, most]", length(argument)),
        "unique" => ("[@unique]", argument.is_empty().then_some(Statement::Unique)),
        "pattern" => ("[@pattern REGEX]", is_pattern(argument).then_some(Statement::Pattern(argument))),
        "format" => ("[@format base64]", known_format()),
        _ => return None,
    })
}

fn constraint<'s>(kind: &'static ConstraintKind, argument: &'s str) -> Option<Statement<'s>> {
    (kind.read)(argument).map(|(argument, text)| Statement::Constraint(kind, argument, text))
}

/// True if all JSON Schema validators interpret the regular expression in the same way. Back references and look-around
/// are therefore not allowed.
fn is_pattern(text: &str) -> bool {
    !text.is_empty() && regex_lite::Regex::new(text).is_ok() && crate::pattern::is_known(text)
}

/// Parses a length: either one exact length, or two bounds separated by a comma. Either bound may be absent.
fn length(argument: &str) -> Option<Statement<'_>> {
    let bound = |text: &str| match text.trim() {
        "" => Some(None),
        digits => digits.parse().ok().map(Some),
    };
    let (min, max) = argument.split_once(',').unwrap_or((argument, argument));
    let (min, max): (Option<u32>, Option<u32>) = (bound(min)?, bound(max)?);
    let is_ordered = min.zip(max).is_none_or(|(min, max)| min <= max);
    (is_ordered && (min.is_some() || max.is_some())).then_some(Statement::Length { min, max })
}

fn prefixes(argument: &str) -> Option<Vec<Prefix<'_>>> {
    let words = argument.split([' ', '\t', ',']).filter(|word| !word.is_empty());
    let prefixes: Option<Vec<Prefix>> = words
        .map(|word| {
            let (message, prefix) = match word.split_once('.') {
                Some((message, prefix)) => (Some(message), prefix),
                None => (None, word),
            };
            let prefix = prefix.trim_end_matches('*').trim_end_matches('_');
            (is_identifier(prefix) && message.is_none_or(is_identifier)).then_some(Prefix { message, prefix })
        })
        .collect();
    // All prefixes of an enum must refer to the same message.
    prefixes.filter(|prefixes| {
        prefixes.first().is_some_and(|first| prefixes.iter().all(|prefix| prefix.message == first.message))
    })
}
