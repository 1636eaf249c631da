//! Resolves the types and messages on all pages of a package.

mod endless;
mod kind;
mod set;

use std::collections::{BTreeMap, BTreeSet, HashMap};

use self::kind::{ByName, kinds};
use crate::diagnostic::{Diagnostic, Problem, has_errors};
use crate::json_type::{
    Definition, ERROR_CODE, ERROR_LIST, Expression, JsonMessage, JsonPart, JsonType, JsonTypeId, Limits,
    Member, Object, Set, TYPE_FIELD, Typed,
};
use crate::msg::annotation::Note;
use crate::msg::constraint::Argument;
use crate::msg::statement::Statement;
use crate::source::Span;
use crate::table::type_table::{
    self, Body, Definitions, Direction, Expression as Written, ExpressionKind, MessageDefinition,
    PartDefinition, TypeDefinition, built_in_name,
};
use crate::table::{Page, Text};
use crate::wording::similar;
use crate::{Docs, Stated};

/// Phrases that forbid further fields in an object.
const CLOSED: [&str; 2] = ["closed object", "object is closed"];

/// The phrase that allows further fields in an object.
const OPEN: &str = "further fields are allowed";

/// The maximum number of elements of a tuple.
const MAX_ELEMENTS: usize = 64;

/// The maximum number of errors that include a suggestion. The limit saves time, because each suggestion compares all
/// names.
const MAX_SUGGESTIONS: usize = 100;

/// The types and messages of a package.
#[derive(Debug, Default)]
pub(super) struct Resolved {
    /// The types, by name.
    pub(super) types: Vec<JsonType>,
    /// The messages, by name.
    pub(super) messages: Vec<JsonMessage>,
    /// True for each page that contains definitions, even if they are invalid.
    pub(super) has_definitions: Vec<bool>,
    /// The problems found.
    pub(super) diagnostics: Vec<Diagnostic>,
}

/// Resolves the types and messages of all `pages` of a package. `package` is its index and name. `first` is the id of
/// the first type. With `has_error_codes`, the type names for error codes are also available.
pub(super) fn resolve(pages: &[Page], package: (usize, &str), first: u32, has_error_codes: bool) -> Resolved {
    let mut resolved = Resolved::default();
    let mut written = Definitions::default();
    for page in pages {
        let (mut found, diagnostics) = type_table::read(page);
        let is_any = !found.types.is_empty() || !found.messages.is_empty() || !diagnostics.is_empty();
        resolved.has_definitions.push(is_any);
        resolved.diagnostics.extend(diagnostics);
        written.types.append(&mut found.types);
        written.messages.append(&mut found.messages);
    }
    let types =
        unique(written.types, has_error_codes, |found| (found.name, found.span), &mut resolved.diagnostics);
    let messages =
        unique(written.messages, false, |found| (found.name, found.span), &mut resolved.diagnostics);
    let mut context = Resolver {
        package: package.0,
        package_name: package.1,
        has_error_codes,
        ids: types.iter().zip(first..).map(|(found, id)| (found.name, JsonTypeId(id))).collect(),
        by_name: types.iter().map(|found| (found.name, found)).collect(),
        suggestions: 0,
        diagnostics: resolved.diagnostics,
    };
    resolved.types = types.iter().map(|found| context.json_type(found)).collect();
    let answering = messages
        .iter()
        .filter(|message| message.parts.iter().any(|part| part.direction == Direction::Response));
    let answering: BTreeSet<&str> = answering.map(|message| message.name).collect();
    resolved.messages = messages.iter().map(|found| context.message(found, &answering)).collect();
    resolved.diagnostics = context.diagnostics;
    if !has_errors(&resolved.diagnostics) {
        resolved.diagnostics.extend(endless::check(&resolved.types, first));
    }
    resolved
}

/// Sorts the definitions by name and removes duplicates. Names that differ only in case are duplicates, because some
/// file systems treat them as the same file name.
fn unique<'p, T>(
    mut written: Vec<T>,
    has_error_codes: bool,
    name_of: impl Fn(&T) -> (&'p str, Span),
    diagnostics: &mut Vec<Diagnostic>,
) -> Vec<T> {
    let mut known: BTreeMap<String, (&str, Span)> = BTreeMap::new();
    // Sort by location, so the first definition wins.
    written.sort_by_key(|found| name_of(found).1);
    written.retain(|found| {
        let (name, span) = name_of(found);
        let problem = Problem::DuplicateType { name: name.to_owned() };
        if has_error_codes && matches!(name, ERROR_CODE | ERROR_LIST) {
            let hint = "this name is reserved for error codes";
            diagnostics.push(Diagnostic::new(problem, span).with_hint(hint));
            return false;
        }
        let Some((earlier, place)) = known.get(&name.to_ascii_lowercase()).copied() else {
            known.insert(name.to_ascii_lowercase(), (name, span));
            return true;
        };
        let mut diagnostic = Diagnostic::new(problem, span).with_related(place, "first definition");
        if earlier != name {
            let hint = format!(
                "`{earlier}` and `{name}` are the same name on some file systems; rename one of them"
            );
            diagnostic = diagnostic.with_hint(hint);
        }
        diagnostics.push(diagnostic);
        false
    });
    written.sort_by_key(|found| name_of(found).0);
    written
}

struct Resolver<'t, 'p> {
    package: usize,
    package_name: &'t str,
    has_error_codes: bool,
    ids: HashMap<&'p str, JsonTypeId>,
    by_name: ByName<'t, 'p>,
    suggestions: usize,
    diagnostics: Vec<Diagnostic>,
}

impl Resolver<'_, '_> {
    fn report(&mut self, problem: Problem, span: Span) {
        self.diagnostics.push(Diagnostic::new(problem, span));
    }

    fn json_type(&mut self, written: &TypeDefinition<'_>) -> JsonType {
        let name = written.name;
        let mut docs = with_remarks(docs(texts(&written.paragraphs)), &written.remarks);
        let definition = match &written.body {
            Body::Object(fields) => {
                let is_closed = self.is_closed(name, &written.paragraphs, written.span);
                Definition::Object(Object { fields: self.members(fields), is_closed })
            }
            Body::Tuple(elements) => {
                self.check_has_rows(name, elements.is_empty(), written.span);
                if elements.len() > MAX_ELEMENTS {
                    let (name, max) = (name.to_owned(), MAX_ELEMENTS);
                    self.report(Problem::TooManyParts { name, what: "elements", max }, written.span);
                }
                self.check_order(elements);
                Definition::Tuple(self.members(elements))
            }
            Body::Set(entries) => {
                self.check_has_rows(name, entries.is_empty(), written.span);
                let is_open = self.is_open(name, &written.paragraphs, written.span);
                let values = set::values(name, entries, written.span, &mut self.diagnostics);
                Definition::Set(Set { values, is_open })
            }
            Body::Named { ty, notes } => {
                docs = self::docs(notes.iter().map(|note| note.text.as_ref()));
                let mut limits = Limits::default();
                for note in notes {
                    self.limit(&mut limits, note, Some(ty));
                }
                Definition::Named(Typed { ty: self.expression(ty), limits })
            }
        };
        JsonType { package: self.package, name: name.to_owned(), docs, definition, span: written.span }
    }

    fn check_has_rows(&mut self, name: &str, is_empty: bool, span: Span) {
        if is_empty {
            self.report(Problem::EmptyType { name: name.to_owned() }, span);
        }
    }

    /// Reports required elements after optional ones.
    fn check_order(&mut self, elements: &[type_table::Member<'_>]) {
        let Some(optional) = elements.iter().position(|element| !element.is_required) else { return };
        for element in elements[optional..].iter().filter(|element| element.is_required) {
            let problem = Problem::RequiredAfterOptional { name: element.name.to_owned() };
            let diagnostic = Diagnostic::new(problem, element.span)
                .with_related(elements[optional].span, "this element is optional");
            self.diagnostics.push(diagnostic);
        }
    }

    /// True if the paragraphs above a set declare it as open. Reports an error unless the paragraphs declare the set
    /// either as open or as closed.
    fn is_open(&mut self, name: &str, paragraphs: &[&Text], span: Span) -> bool {
        let says = |word: &str| {
            let mut words =
                paragraphs.iter().flat_map(|text| text.as_str().split(|c: char| !c.is_alphanumeric()));
            words.any(|found| found.eq_ignore_ascii_case(word))
        };
        let (is_open, is_closed) = (says("open"), says("closed"));
        if is_open == is_closed {
            let found = if is_open { "both open and closed" } else { "neither open nor closed" };
            self.report(Problem::Openness { name: name.to_owned(), found }, span);
        }
        is_open
    }

    /// True if the paragraphs above an object declare it as closed. Reports contradictions.
    fn is_closed(&mut self, name: &str, paragraphs: &[&Text], span: Span) -> bool {
        let says =
            |phrase: &str| paragraphs.iter().any(|text| text.as_str().to_ascii_lowercase().contains(phrase));
        let (is_closed, is_open) = (CLOSED.iter().any(|phrase| says(phrase)), says(OPEN));
        if is_closed && is_open {
            let found = "both closed and open to further fields";
            self.report(Problem::Openness { name: name.to_owned(), found }, span);
        }
        is_closed
    }

    fn members(&mut self, written: &[type_table::Member<'_>]) -> Vec<Member> {
        let mut first: BTreeMap<&str, Span> = BTreeMap::new();
        let mut members = Vec::with_capacity(written.len());
        for member in written {
            if let Some(earlier) = first.get(member.name) {
                let problem = Problem::DuplicateField { name: member.name.to_owned() };
                self.diagnostics
                    .push(Diagnostic::new(problem, member.span).with_related(*earlier, "first definition"));
                continue;
            }
            first.insert(member.name, member.span);
            let mut limits = Limits::default();
            self.limit(&mut limits, &member.note, member.ty.as_ref());
            members.push(Member {
                name: member.name.to_owned(),
                is_required: member.is_required,
                typed: Typed {
                    ty: member.ty.as_ref().map_or(Expression::Any, |ty| self.expression(ty)),
                    limits,
                },
                description: member.note.text.to_string(),
                span: member.span,
            });
        }
        members
    }

    /// Applies the annotations of `note`. Reports annotations that don't apply to the type.
    fn limit(&mut self, limits: &mut Limits, note: &Note<'_>, ty: Option<&Written>) {
        // An invalid type has already been reported.
        let Some(ty) = ty else { return };
        let (outer, inner) = (kinds(ty, &self.by_name, false), kinds(ty, &self.by_name, true));
        for annotation in &note.annotations {
            let (name, is_applicable) = match &annotation.statement {
                Statement::Unit(_) => ("[unit]", inner.has_number),
                Statement::Constraint(..) => ("[@range]", inner.has_number),
                Statement::Length { .. } => ("[@length]", outer.has_list || outer.has_string),
                Statement::Unique => ("[@unique]", outer.has_list),
                Statement::Pattern(_) => ("[@pattern]", inner.has_string),
                Statement::Format(_) => ("[@format]", inner.has_string),
                _ => continue,
            };
            if !is_applicable {
                let type_name = shown(ty);
                self.report(Problem::MisplacedAnnotation { annotation: name, type_name }, annotation.span);
                continue;
            }
            match &annotation.statement {
                Statement::Unit(unit) => limits.unit = Some((*unit).to_owned()),
                Statement::Constraint(_, Argument::Stated(Stated::Range(range)), _) => {
                    limits.range = Some(range.clone());
                }
                Statement::Length { min, max } => (limits.min, limits.max) = (*min, *max),
                Statement::Unique => limits.is_unique = true,
                Statement::Pattern(pattern) => limits.pattern = Some((*pattern).to_owned()),
                Statement::Format(format) => limits.format = Some((*format).to_owned()),
                _ => {}
            }
        }
    }

    fn expression(&mut self, written: &Written) -> Expression {
        match &written.kind {
            ExpressionKind::BuiltIn(ty) => ty.clone(),
            ExpressionKind::Named(name) => self.named(name, written.span),
            ExpressionKind::List(inner) => Expression::List(Box::new(self.expression(inner))),
            ExpressionKind::Map(inner) => Expression::Map(Box::new(self.expression(inner))),
            ExpressionKind::Either(all) => {
                let mut alternatives = Vec::with_capacity(all.len());
                for found in all.iter().map(|inner| self.expression(inner)) {
                    // Flatten nested alternatives, and remove duplicates.
                    match found {
                        Expression::Either(inner) => alternatives.extend(inner),
                        other => alternatives.push(other),
                    }
                }
                let mut seen = Vec::new();
                alternatives.retain(|found| {
                    !seen.contains(found) && {
                        seen.push(found.clone());
                        true
                    }
                });
                Expression::Either(alternatives)
            }
            ExpressionKind::OneOf(constants) => Expression::OneOf(constants.clone()),
        }
    }

    fn named(&mut self, name: &str, span: Span) -> Expression {
        if let Some(id) = self.ids.get(name) {
            return Expression::Named(*id);
        }
        match name {
            ERROR_CODE if self.has_error_codes => return Expression::ErrorCode,
            ERROR_LIST if self.has_error_codes => return Expression::ErrorList,
            _ => {}
        }
        let problem = Problem::UndefinedType { name: name.to_owned(), package: self.package_name.to_owned() };
        let hint = self.similar(name).map(|similar| format!("did you mean `{similar}`?"));
        self.diagnostics.push(Diagnostic { hint, ..Diagnostic::new(problem, span) });
        Expression::Any
    }

    /// A type with a name similar to `name`.
    fn similar(&mut self, name: &str) -> Option<&str> {
        self.suggestions += 1;
        if self.suggestions > MAX_SUGGESTIONS {
            return None;
        }
        similar(name, self.ids.keys().copied())
    }

    fn message(&mut self, written: &MessageDefinition<'_>, answering: &BTreeSet<&str>) -> JsonMessage {
        let parts: Vec<JsonPart> = written.parts.iter().map(|part| self.part(written.name, part)).collect();
        for (name, span) in written.parts.iter().flat_map(|part| &part.answers) {
            if !answering.contains(name) {
                self.report(Problem::UnknownAnswer { name: (*name).to_owned() }, *span);
            }
        }
        let request = written.parts.iter().find(|part| part.direction == Direction::Request);
        if let Some(request) = request.filter(|part| part.answers.is_empty())
            && !answering.contains(written.name)
        {
            self.report(Problem::MissingAnswer { name: written.name.to_owned() }, request.span);
        }
        JsonMessage {
            package: self.package,
            name: written.name.to_owned(),
            docs: docs(texts(&written.paragraphs)),
            parts,
            span: written.span,
        }
    }

    fn part(&mut self, message: &str, written: &PartDefinition<'_>) -> JsonPart {
        let name = format!("{message}.{}", written.direction.name());
        let is_closed = self.is_closed(&name, &written.paragraphs, written.span);
        let mut fields = vec![Member {
            name: TYPE_FIELD.to_owned(),
            is_required: true,
            typed: Typed { ty: Expression::OneOf(vec![message.to_owned()]), limits: Limits::default() },
            description: "The type of the message.".to_owned(),
            span: written.span,
        }];
        let rest = self.members(&written.fields);
        for field in rest {
            if field.name == TYPE_FIELD {
                let problem = Problem::DuplicateField { name: field.name.clone() };
                let hint = "remove the row; the heading of the message defines this field";
                self.diagnostics.push(Diagnostic::new(problem, field.span).with_hint(hint));
            } else {
                fields.push(field);
            }
        }
        let own = [message.to_owned()].into_iter().filter(|_| written.direction == Direction::Request);
        let named = written.answers.iter().map(|(name, _)| (*name).to_owned());
        JsonPart {
            direction: written.direction,
            name,
            docs: with_remarks(docs(texts(&written.paragraphs)), &written.remarks),
            answers: if written.answers.is_empty() { own.collect() } else { named.collect() },
            body: Object { fields, is_closed },
            span: written.span,
        }
    }
}

/// Converts paragraphs to documentation. The first paragraph is the summary.
fn docs<'t>(paragraphs: impl Iterator<Item = &'t str>) -> Docs {
    let mut paragraphs = paragraphs.filter(|text| !text.is_empty());
    let summary = paragraphs.next().unwrap_or_default().to_owned();
    Docs { summary, description: paragraphs.collect::<Vec<_>>().join("\n\n") }
}

/// Adds the paragraphs below the table to the description.
fn with_remarks(docs: Docs, remarks: &[&Text]) -> Docs {
    let description = [docs.description.as_str()].into_iter().chain(texts(remarks));
    let description: Vec<&str> = description.filter(|text| !text.is_empty()).collect();
    Docs { description: description.join("\n\n"), ..docs }
}

fn texts<'t>(paragraphs: &[&'t Text]) -> impl Iterator<Item = &'t str> {
    paragraphs.iter().map(|text| text.as_str())
}

/// An expression as text, for messages.
fn shown(expression: &Written) -> String {
    match &expression.kind {
        ExpressionKind::BuiltIn(ty) => built_in_name(ty).to_owned(),
        ExpressionKind::Named(name) => name.clone(),
        ExpressionKind::List(inner) => format!("list of {}", shown(inner)),
        ExpressionKind::Map(inner) => format!("map of {}", shown(inner)),
        ExpressionKind::Either(all) => all.iter().map(shown).collect::<Vec<_>>().join(" or "),
        ExpressionKind::OneOf(_) => "a constant".to_owned(),
    }
}
