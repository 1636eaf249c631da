//! Schemas compiled from definitions.

use std::fmt;
use std::sync::Arc;

use regex_lite::Regex;
use uavspec_schema::source::Span;

/// The schema of a value.
#[derive(Debug)]
pub(super) enum ValueSchema {
    /// Anything.
    Any,
    /// `null`.
    Null,
    /// `true` or `false`.
    Bool,
    /// An integer between the first and the second value, inclusive.
    Integer(i128, i128),
    /// A number with optional bounds.
    Number(Option<f64>, Option<f64>),
    /// A string.
    Text(Text),
    /// One of these strings.
    Constants(Vec<String>),
    /// One of these integers.
    Integers(Vec<i64>),
    /// A list whose elements share one schema.
    List(List),
    /// An object whose values share one schema.
    Map(Box<ValueSchema>),
    /// A value that matches one of several schemas.
    Either(Vec<ValueSchema>),
    /// The index of an object in [`super::DefinedSchemas`].
    Object(usize),
    /// The index of a tuple in [`super::DefinedSchemas`].
    Tuple(usize),
}

/// The schema of a string.
#[derive(Debug)]
pub(super) struct Text {
    /// The number of characters.
    pub(super) length: Length,
    /// The patterns that the string must match.
    pub(super) patterns: Vec<Pattern>,
    /// True if the string must be Base64.
    pub(super) is_base64: bool,
}

/// The minimum and maximum number of characters or elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Length {
    pub(super) min: usize,
    pub(super) max: usize,
}

/// A pattern for strings.
#[derive(Debug)]
pub(super) struct Pattern {
    /// The pattern as written in the definition.
    pub(super) written: String,
    /// The compiled pattern.
    pub(super) test: Test,
}

/// A compiled pattern.
#[derive(Debug)]
pub(super) enum Test {
    /// A non-empty string without these characters. Ids use `^[^/]+$`, so this form must be fast.
    Without(Vec<char>),
    /// Any other pattern.
    Regex(Regex),
}

/// The schema of a list.
#[derive(Debug)]
pub(super) struct List {
    /// The schema of the elements.
    pub(super) element: Box<ValueSchema>,
    /// The number of elements.
    pub(super) length: Length,
    /// True if all elements must differ.
    pub(super) is_unique: bool,
}

/// The schema of an object with named fields.
#[derive(Debug, Default)]
pub(super) struct Object {
    /// The name of the object's type; empty for a body.
    pub(super) name: String,
    /// The fields, in the order of the definition.
    pub(super) fields: Vec<Field>,
    /// The indices of the fields, sorted by name.
    by_name: Vec<usize>,
    /// For each field, the index of the next field by name.
    next_by_name: Vec<usize>,
    /// True if undefined fields aren't allowed.
    pub(super) is_closed: bool,
}

/// The schema of a list with a separate schema for each position.
#[derive(Debug, Default)]
pub(super) struct Tuple {
    /// The elements.
    pub(super) elements: Vec<Field>,
    /// The minimum number of elements.
    pub(super) required: usize,
}

/// An object field or a tuple element.
#[derive(Debug)]
pub(super) struct Field {
    /// The name.
    pub(super) name: Arc<str>,
    /// True if the field or element is required.
    pub(super) is_required: bool,
    /// The schema.
    pub(super) schema: ValueSchema,
    /// The location of the definition.
    pub(super) span: Span,
}

impl ValueSchema {
    /// True if several deviations within a value of this schema are worth reporting.
    pub(super) fn is_structured(&self) -> bool {
        match self {
            Self::Object(_) => true,
            Self::Map(inner) => inner.is_structured(),
            Self::List(list) => list.element.is_structured(),
            Self::Either(all) => all.iter().any(Self::is_structured),
            _ => false,
        }
    }
}

impl Object {
    /// Creates an object with these fields.
    pub(super) fn new(name: &str, fields: Vec<Field>, is_closed: bool) -> Self {
        let mut by_name: Vec<usize> = (0..fields.len()).collect();
        by_name.sort_by(|one, other| fields[*one].name.cmp(&fields[*other].name));
        let mut next_by_name = vec![0; fields.len()];
        by_name.windows(2).for_each(|pair| next_by_name[pair[0]] = pair[1]);
        Self { name: name.to_owned(), fields, by_name, next_by_name, is_closed }
    }

    /// The index of a field. Most writers keep the order of the definition or sort the fields by name, so the fields that
    /// follow `previous` in these orders are tried first.
    pub(super) fn field(&self, name: &str, previous: Option<usize>) -> Option<usize> {
        let guesses = match previous {
            Some(previous) => [previous + 1, self.next_by_name[previous]],
            None => [0, self.by_name.first().copied().unwrap_or_default()],
        };
        let is_named = |index: &usize| self.fields.get(*index).is_some_and(|field| *field.name == *name);
        let by_name = |index: &usize| (*self.fields[*index].name).cmp(name);
        let search = || Some(self.by_name[self.by_name.binary_search_by(by_name).ok()?]);
        guesses.into_iter().find(is_named).or_else(search)
    }
}

impl Length {
    /// Any length.
    pub(super) const ANY: Self = Self { min: 0, max: usize::MAX };

    /// True if a length is within the limits.
    pub(super) fn accepts(self, length: usize) -> bool {
        (self.min..=self.max).contains(&length)
    }
}

/// A length with a noun: ` of 1 to 64 characters`.
struct Counted(Length, &'static str);

impl fmt::Display for Counted {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(Length { min, max }, noun) = self;
        match (min, max) {
            (0, &usize::MAX) => Ok(()),
            (min, &usize::MAX) => write!(formatter, " of at least {min} {noun}"),
            (0, max) => write!(formatter, " of at most {max} {noun}"),
            (min, max) if min == max => write!(formatter, " of {max} {noun}"),
            (min, max) => write!(formatter, " of {min} to {max} {noun}"),
        }
    }
}

impl Pattern {
    /// True if a text matches.
    pub(super) fn is_match(&self, text: &str) -> bool {
        match &self.test {
            Test::Without(excluded) => !text.is_empty() && !excluded.iter().any(|one| text.contains(*one)),
            Test::Regex(regex) => regex.is_match(text),
        }
    }
}

impl Text {
    /// Any string.
    pub(super) const ANY: Self = Self { length: Length::ANY, patterns: Vec::new(), is_base64: false };
}

impl fmt::Display for Text {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "a string{}", Counted(self.length, "characters"))?;
        if self.is_base64 {
            formatter.write_str(" in Base64")?;
        }
        for (at, pattern) in self.patterns.iter().enumerate() {
            formatter.write_str(if at == 0 { " " } else { ", and " })?;
            match &pattern.test {
                Test::Without(excluded) => {
                    let excluded: Vec<String> = excluded.iter().map(|one| format!("`{one}`")).collect();
                    write!(formatter, "without {}", excluded.join(" and "))?;
                }
                Test::Regex(_) => write!(formatter, "that matches `{}`", pattern.written)?,
            }
        }
        Ok(())
    }
}

impl fmt::Display for List {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let each = if self.is_unique { " without duplicates" } else { "" };
        write!(formatter, "a list{}{each}", Counted(self.length, "elements"))
    }
}

impl Tuple {
    /// The allowed number of elements, as a range.
    pub(super) fn length(&self) -> Length {
        Length { min: self.required, max: self.elements.len() }
    }
}

impl fmt::Display for Tuple {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.required, self.elements.len()) {
            (min, max) if min == max => write!(formatter, "a list of {max} elements"),
            (min, max) => write!(formatter, "a list of {min} to {max} elements"),
        }
    }
}
