//! Reads JSON with the location of each value.

use jsonc_parser::ast::{ObjectProp, Value};
use jsonc_parser::common::{Range, Ranged};
use jsonc_parser::{CollectOptions, ParseOptions, parse_to_ast};

use crate::diagnostic::{Diagnostic, Problem};
use crate::limits::{MAX_EVENT_VALUES, MAX_EVENTS_LEN, MAX_MISTAKES};
use crate::span::Span;

/// A string with its location.
#[derive(Clone, Debug)]
pub(crate) struct Located {
    pub(crate) text: String,
    pub(crate) span: Span,
}

/// Parses event metadata to locate its values. Returns `None` if the text is invalid JSON or too
/// long.
pub fn syntax(text: &str) -> Option<Value<'_>> {
    Reader::new(Span::default()).parse(text)
}

/// Reads the values of a JSON text, and collects the mistakes.
pub(super) struct Reader {
    source: Span,
    pub(super) diagnostics: Vec<Diagnostic>,
}

/// An object with a fixed set of members.
pub(super) struct Members<'v, 's> {
    /// A description of the object.
    what: &'static str,
    span: Span,
    /// The known members. There are few, so a list is sufficient.
    found: Vec<(&'v str, &'v Value<'s>)>,
}

impl<'v, 's> Members<'v, 's> {
    /// The value of a member, if it exists.
    pub(super) fn get(&self, name: &str) -> Option<&'v Value<'s>> {
        self.found.iter().find(|(found, _)| *found == name).map(|(_, value)| *value)
    }
}

impl Reader {
    pub(super) fn new(source: Span) -> Self {
        Self { source, diagnostics: Vec::new() }
    }

    /// Parses a text, without the extensions of other JSON dialects.
    pub(super) fn parse<'s>(&mut self, text: &'s str) -> Option<Value<'s>> {
        if text.len() > MAX_EVENTS_LEN {
            let problem = Problem::SourceTooLong { len: text.len(), max: MAX_EVENTS_LEN };
            self.report(problem, self.source.part(0..0));
            return None;
        }
        // Each value follows one of these characters, so their count is an upper bound. Some of them may
        // be in strings.
        if text.bytes().filter(|byte| matches!(byte, b'{' | b'[' | b',')).count() > MAX_EVENT_VALUES {
            self.report(Problem::TooManyEventValues { max: MAX_EVENT_VALUES }, self.source.part(0..0));
            return None;
        }
        let options = ParseOptions {
            allow_comments: false,
            allow_loose_object_property_names: false,
            allow_trailing_commas: false,
            allow_missing_commas: false,
            allow_single_quoted_strings: false,
            allow_hexadecimal_numbers: false,
            allow_unary_plus_numbers: false,
            allow_bare_decimal_point_numbers: false,
            allow_non_finite_numbers: false,
            allow_extended_string_escapes: false,
        };
        let (what, span) = match parse_to_ast(text, &CollectOptions::default(), &options) {
            Ok(result) if result.value.is_some() => return result.value,
            Ok(_) => ("the file is empty".to_owned(), self.source.part(0..0)),
            Err(error) => (error.kind().to_string().to_lowercase(), self.span(error.range())),
        };
        self.report(Problem::InvalidJson { what }, span);
        None
    }

    pub(super) fn report(&mut self, problem: Problem, span: Span) {
        if self.diagnostics.len() < MAX_MISTAKES {
            self.diagnostics.push(Diagnostic::new(problem, span));
        }
    }

    pub(super) fn span(&self, range: Range) -> Span {
        self.source.part(range.start..range.end)
    }

    fn wrong_type<T>(&mut self, value: &Value<'_>, what: &str, expected: &'static str) -> Option<T> {
        // Only quote names of members, which contain no spaces.
        let what = if what.contains(' ') { what.to_owned() } else { format!("`{what}`") };
        self.report(Problem::MemberType { what, expected }, self.span(value.range()));
        None
    }

    /// Returns the members of an object, in order. Reports a value of another type.
    pub(super) fn object<'v, 's>(
        &mut self,
        value: &'v Value<'s>,
        what: &str,
    ) -> Option<&'v [ObjectProp<'s>]> {
        match value {
            Value::Object(object) => Some(&object.properties),
            _ => self.wrong_type(value, what, "an object"),
        }
    }

    /// Returns the elements of a list. Reports a value of another type.
    pub(super) fn list<'v, 's>(&mut self, value: &'v Value<'s>, what: &str) -> Option<&'v [Value<'s>]> {
        match value {
            Value::Array(list) => Some(&list.elements),
            _ => self.wrong_type(value, what, "a list"),
        }
    }

    pub(super) fn string(&mut self, value: &Value<'_>, what: &str) -> Option<Located> {
        match value {
            Value::StringLit(string) => {
                Some(Located { text: string.value.clone().into_owned(), span: self.span(string.range) })
            }
            _ => self.wrong_type(value, what, "a string"),
        }
    }

    pub(super) fn number(&mut self, value: &Value<'_>, what: &str) -> Option<u32> {
        let number = value.as_number_lit().and_then(|number| number.value.parse().ok());
        number.or_else(|| self.wrong_type(value, what, "an integer from 0 to 4294967295"))
    }

    pub(super) fn flag(&mut self, value: &Value<'_>, what: &str) -> Option<bool> {
        match value {
            Value::BooleanLit(flag) => Some(flag.value),
            _ => self.wrong_type(value, what, "true or false"),
        }
    }

    /// Reads an object with the given members. Reports unknown and duplicate members.
    pub(super) fn members<'v, 's>(
        &mut self,
        value: &'v Value<'s>,
        what: &'static str,
        known: &[&str],
    ) -> Option<Members<'v, 's>> {
        let mut found: Vec<(&str, &Value<'_>)> = Vec::new();
        for member in self.object(value, what)? {
            let name = member.name.as_str();
            if !known.contains(&name) {
                let Located { text: name, span } = self.key(member);
                self.report(Problem::UnknownMember { name, what, known: known.join(", ") }, span);
            } else if found.iter().any(|(known, _)| *known == name) {
                let Located { text: name, span } = self.key(member);
                self.report(Problem::DuplicateMember { name, what }, span);
            } else {
                found.push((name, &member.value));
            }
        }
        Some(Members { what, span: self.span(value.range()), found })
    }

    /// The name of a member.
    pub(super) fn key(&self, member: &ObjectProp<'_>) -> Located {
        Located { text: member.name.as_str().to_owned(), span: self.span(member.name.range()) }
    }

    /// Returns the value of a member. Reports a missing member.
    pub(super) fn require<'v, 's>(
        &mut self,
        members: &Members<'v, 's>,
        name: &'static str,
    ) -> Option<&'v Value<'s>> {
        let found = members.get(name);
        if found.is_none() {
            self.report(Problem::MissingMember { name, what: members.what }, members.span.part(0..1));
        }
        found
    }

    /// Returns the text of a member. Reports a missing member, and a value of another type.
    pub(super) fn required_text(&mut self, members: &Members<'_, '_>, name: &'static str) -> Option<Located> {
        let value = self.require(members, name)?;
        self.string(value, name)
    }

    /// Returns the text of an optional member. Reports a value of another type.
    pub(super) fn text(&mut self, members: &Members<'_, '_>, name: &'static str) -> Option<Located> {
        members.get(name).and_then(|value| self.string(value, name))
    }
}
