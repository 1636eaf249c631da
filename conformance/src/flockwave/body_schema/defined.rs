//! Shapes that definitions give.

use std::fmt;

use regex_lite::Regex;
use uavspec_codegen::source::Span;

/// What a value has to be.
#[derive(Debug)]
pub(super) enum ValueSchema {
    /// Anything.
    Any,
    /// `null`.
    Null,
    /// `true` or `false`.
    Bool,
    /// An integer from the first to the second.
    Integer(i128, i128),
    /// A number within bounds, of which each may be absent.
    Number(Option<f64>, Option<f64>),
    /// A string.
    Text(Text),
    /// One of these strings.
    Constants(Vec<String>),
    /// One of these integers.
    Integers(Vec<i64>),
    /// An array of values of one shape.
    List(List),
    /// An object whose values have one shape.
    Map(Box<ValueSchema>),
    /// One of several shapes.
    Either(Vec<ValueSchema>),
    /// An object of [`super::DefinedSchemas`], by its index.
    Object(usize),
    /// A tuple of [`super::DefinedSchemas`], by its index.
    Tuple(usize),
}

/// A string.
#[derive(Debug)]
pub(super) struct Text {
    /// How many characters it has.
    pub(super) length: Length,
    /// What it matches.
    pub(super) patterns: Vec<Pattern>,
    /// Whether it is Base64.
    pub(super) is_base64: bool,
}

/// How many characters or elements there are, at least and at most.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Length {
    pub(super) least: usize,
    pub(super) most: usize,
}

/// What a string matches.
#[derive(Debug)]
pub(super) struct Pattern {
    /// As the definition has it.
    pub(super) written: String,
    /// What says so.
    pub(super) test: Test,
}

/// What says whether a string matches a pattern.
#[derive(Debug)]
pub(super) enum Test {
    /// It isn't empty, and has none of these characters: `^[^/]+$`, which ids match, by the million.
    Without(Vec<char>),
    /// Any other pattern.
    Regex(Regex),
}

/// An array of values of one shape.
#[derive(Debug)]
pub(super) struct List {
    /// That of its elements.
    pub(super) element: Box<ValueSchema>,
    /// How many there are.
    pub(super) length: Length,
    /// Whether no two are equal.
    pub(super) is_unique: bool,
}

/// An object with fields of its own.
#[derive(Debug, Default)]
pub(super) struct Object {
    /// The name of its type; empty where it is a body.
    pub(super) name: String,
    /// Its fields, as the definition has them.
    pub(super) fields: Vec<Field>,
    /// The indices of the fields, by name.
    pub(super) by_name: Vec<usize>,
    /// Whether there are no others.
    pub(super) is_closed: bool,
}

/// An array with a meaning for each position.
#[derive(Debug, Default)]
pub(super) struct Tuple {
    /// Its elements.
    pub(super) elements: Vec<Field>,
    /// How many of them are there at least.
    pub(super) required: usize,
}

/// A field of an object, or an element of a tuple.
#[derive(Debug)]
pub(super) struct Field {
    /// What it is called.
    pub(super) name: String,
    /// Whether it has to be there.
    pub(super) is_required: bool,
    /// What it has to be.
    pub(super) schema: ValueSchema,
    /// Where it is defined.
    pub(super) span: Span,
}

impl ValueSchema {
    /// Whether its values hold others of which each is worth a word, where several are wrong.
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
    /// The object with these fields.
    pub(super) fn new(name: &str, fields: Vec<Field>, is_closed: bool) -> Self {
        let mut by_name: Vec<usize> = (0..fields.len()).collect();
        by_name.sort_by(|one, other| fields[*one].name.cmp(&fields[*other].name));
        Self { name: name.to_owned(), fields, by_name, is_closed }
    }

    /// The index of the field of a name, which is likely to be `guess`: who writes an object mostly keeps to the order
    /// of the definition.
    pub(super) fn field(&self, name: &str, guess: usize) -> Option<usize> {
        if self.fields.get(guess).is_some_and(|field| field.name == name) {
            return Some(guess);
        }
        let by_name = |index: &usize| self.fields[*index].name.as_str().cmp(name);
        self.by_name.binary_search_by(by_name).ok().map(|at| self.by_name[at])
    }
}

impl Length {
    /// Any.
    pub(super) const ANY: Self = Self { least: 0, most: usize::MAX };

    /// Whether it is one of these.
    pub(super) fn accepts(self, length: usize) -> bool {
        (self.least..=self.most).contains(&length)
    }
}

/// As words: `of 1 to 64 characters`.
struct Counted(Length, &'static str);

impl fmt::Display for Counted {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(Length { least, most }, what) = self;
        match (least, most) {
            (0, &usize::MAX) => Ok(()),
            (least, &usize::MAX) => write!(formatter, " of {least} {what} or more"),
            (0, most) => write!(formatter, " of {most} {what} at most"),
            (least, most) if least == most => write!(formatter, " of {most} {what}"),
            (least, most) => write!(formatter, " of {least} to {most} {what}"),
        }
    }
}

impl Pattern {
    /// Whether a text matches.
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

/// In words.
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

/// A list in words.
impl fmt::Display for List {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let each = if self.is_unique { " that differ" } else { "" };
        write!(formatter, "a list{}{each}", Counted(self.length, "elements"))
    }
}

impl Tuple {
    /// How many elements there are.
    pub(super) fn length(&self) -> Length {
        Length { least: self.required, most: self.elements.len() }
    }
}

/// In words.
impl fmt::Display for Tuple {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.required, self.elements.len()) {
            (least, most) if least == most => write!(formatter, "a list of {most}"),
            (least, most) => write!(formatter, "a list of {least} to {most}"),
        }
    }
}
