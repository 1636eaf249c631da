//! Messages: a heading with the subheadings `Request`, `Response` and `Notification`.

use std::fmt;

use super::columns::{self, Columns, Header};
use super::reader::{Member, Reader, under};
use crate::diagnostic::{Diagnostic, Problem};
use crate::source::Span;
use crate::table::page::{Heading, Page, Table};
use crate::table::text::Text;

/// How the paragraph begins that names what answers a request.
const ANSWER: &str = "Answer:";

/// How the paragraph begins that stands in the place of a table without rows.
const NO_FIELDS: &str = "no fields beside";

/// Which way a message goes, and whether it is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Direction {
    /// From a client, which expects an answer.
    Request,
    /// The answer.
    Response,
    /// From a server that wasn't asked.
    Notification,
}

impl Direction {
    /// All of them, in the order in which they are listed.
    pub const ALL: [Self; 3] = [Self::Request, Self::Response, Self::Notification];

    /// Its name as files and identifiers bear it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Request => "request",
            Self::Response => "response",
            Self::Notification => "notification",
        }
    }

    /// Its name as headings bear it.
    pub fn title(self) -> &'static str {
        match self {
            Self::Request => "Request",
            Self::Response => "Response",
            Self::Notification => "Notification",
        }
    }
}

impl fmt::Display for Direction {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

/// A message as it is written.
#[derive(Debug)]
pub(crate) struct MessageDefinition<'p> {
    /// Its type, which the field `type` of its body holds.
    pub name: &'p str,
    /// The heading.
    pub span: Span,
    /// The paragraphs under the heading, but for that of the answers.
    pub paragraphs: Vec<&'p Text>,
    /// Its shape for each direction that it has.
    pub parts: Vec<PartDefinition<'p>>,
}

/// The shape of a message for a direction.
#[derive(Debug)]
pub(crate) struct PartDefinition<'p> {
    /// The direction.
    pub direction: Direction,
    /// The subheading.
    pub span: Span,
    /// The paragraphs under the subheading, but for that of the answers; where there is a table, those above it.
    pub paragraphs: Vec<&'p Text>,
    /// The paragraphs below the table.
    pub remarks: Vec<&'p Text>,
    /// The types of the responses to a request, where it says so.
    pub answers: Vec<(&'p str, Span)>,
    /// Its fields but for `type`.
    pub fields: Vec<Member<'p>>,
}

/// The headings of a message.
#[derive(Debug)]
pub(super) struct Headings {
    /// That of its type.
    message: usize,
    /// Those of its parts.
    parts: Vec<(Direction, usize)>,
}

impl Headings {
    /// The index of the heading of the type.
    pub(super) fn index(&self) -> usize {
        self.message
    }

    /// The indices of the headings of the parts.
    pub(super) fn parts(&self) -> impl Iterator<Item = usize> {
        self.parts.iter().map(|(_, part)| *part)
    }
}

/// The headings of all messages of a page. Without a table, or a word that there are no fields, under any of its
/// subheadings, a heading is none of a message: others ask and answer, too.
pub(super) fn headings(page: &Page) -> Vec<Headings> {
    let mut messages: Vec<Headings> = Vec::new();
    // The headings above, each of a lower level than the next.
    let mut above: Vec<usize> = Vec::new();
    for (index, heading) in page.headings.iter().enumerate() {
        while above.last().is_some_and(|last| page.headings[*last].level >= heading.level) {
            above.pop();
        }
        let direction = Direction::ALL
            .into_iter()
            .find(|known| heading.text.as_str().eq_ignore_ascii_case(known.title()));
        if let (Some(direction), Some(message)) = (direction, above.last().copied()) {
            match messages.iter_mut().rev().find(|known| known.message == message) {
                Some(known) => known.parts.push((direction, index)),
                None => messages.push(Headings { message, parts: vec![(direction, index)] }),
            }
        }
        above.push(index);
    }
    let mut says_fields = vec![false; page.headings.len()];
    for table in page.tables.iter().filter(|table| columns_of(table).is_some()) {
        if let Some(says) = table.heading.and_then(|heading| says_fields.get_mut(heading)) {
            *says = true;
        }
    }
    for paragraph in page.paragraphs.iter().filter(|paragraph| has_no_fields(&paragraph.text)) {
        if let Some(says) = paragraph.heading.and_then(|heading| says_fields.get_mut(heading)) {
            *says = true;
        }
    }
    messages.retain(|message| message.parts.iter().any(|(_, part)| says_fields[*part]));
    messages
}

fn columns_of(table: &Table) -> Option<Columns> {
    match columns::header_of(table)? {
        Header::Known(columns) => Some(columns),
        Header::Near(_) => None,
    }
}

fn has_no_fields(text: &Text) -> bool {
    let start = text.as_str().get(..NO_FIELDS.len());
    start.is_some_and(|start| start.eq_ignore_ascii_case(NO_FIELDS))
}

/// Whether a text can be the type of a message: words of letters and digits, with hyphens between them.
fn is_message_name(text: &str) -> bool {
    let is_word = |word: &str| !word.is_empty() && word.bytes().all(|byte| byte.is_ascii_alphanumeric());
    text.starts_with(|c: char| c.is_ascii_alphabetic()) && text.split('-').all(is_word)
}

impl<'p> Reader<'p> {
    pub(super) fn message(&mut self, headings: &Headings) -> Option<MessageDefinition<'p>> {
        let heading: &'p Heading = &self.page.headings[headings.message];
        let (name, span) = (heading.text.as_str(), heading.text.span());
        let mut parts: Vec<PartDefinition<'p>> = Vec::new();
        for (direction, index) in &headings.parts {
            let part = self.part(name, *direction, *index);
            if let Some(first) = parts.iter().find(|known| known.direction == *direction) {
                let problem = Problem::DuplicateType { name: format!("{name}, {direction}") };
                self.diagnostics
                    .push(Diagnostic::new(problem, part.span).with_related(first.span, "the first one"));
                continue;
            }
            parts.push(part);
        }
        parts.sort_by_key(|part| part.direction);
        if !is_message_name(name) {
            let hint = "a message is called by letters and digits, with hyphens between words: `UAV-INF`";
            let problem = Problem::TypeName { heading: name.to_owned() };
            self.diagnostics.push(Diagnostic::new(problem, span).with_hint(hint));
            return None;
        }
        let (answer, paragraphs) = apart(self.paragraphs(headings.message));
        match parts.iter_mut().find(|part| part.direction == Direction::Request) {
            Some(request) => request.answers.extend(answer.into_iter().flat_map(answers)),
            None => {
                if let Some(answer) = answer.first() {
                    self.report(
                        Problem::MisplacedAnswer { what: "message without a request" },
                        answer.span(),
                    );
                }
            }
        }
        Some(MessageDefinition { name, span, paragraphs, parts })
    }

    fn part(&mut self, name: &str, direction: Direction, index: usize) -> PartDefinition<'p> {
        let page = self.page;
        let span = page.headings[index].text.span();
        let found = under(&page.tables, index, |table| table.heading);
        let mut tables = found.iter().filter_map(|table| Some((table, columns_of(table)?)));
        let table = tables.next();
        if let Some((second, _)) = tables.next() {
            let problem = Problem::DuplicateType { name: format!("{name}, {direction}") };
            self.diagnostics
                .push(Diagnostic::new(problem, second.span).with_hint("put all fields into one table"));
        }
        let (above, remarks) = match table {
            Some((table, _)) => self.around(index, table),
            None => (self.paragraphs(index), Vec::new()),
        };
        let (answer, paragraphs) = apart(above);
        let is_empty = paragraphs.iter().any(|text| has_no_fields(text));
        let fields = match table {
            Some((table, columns @ Columns::Object { .. })) => self.members(table, &columns),
            None if is_empty => Vec::new(),
            _ => {
                self.report(
                    Problem::MissingFields { name: name.to_owned(), direction: direction.name() },
                    span,
                );
                Vec::new()
            }
        };
        if let Some(answer) = answer.first().filter(|_| direction != Direction::Request) {
            self.report(Problem::MisplacedAnswer { what: direction.name() }, answer.span());
        }
        let answers = answer.into_iter().flat_map(answers).collect();
        PartDefinition { direction, span, paragraphs, remarks, answers, fields }
    }
}

/// The paragraphs that name what answers a request, and all others.
fn apart(paragraphs: Vec<&Text>) -> (Vec<&Text>, Vec<&Text>) {
    paragraphs.into_iter().partition(|text| text.as_str().starts_with(ANSWER))
}

/// The types that a paragraph names after its first word.
fn answers(text: &Text) -> Vec<(&str, Span)> {
    let mut found = Vec::new();
    let mut at = ANSWER.len();
    for name in text.as_str()[at..].split(',') {
        let start = at + name.len() - name.trim_start().len();
        let trimmed = name.trim().trim_end_matches('.');
        found.push((trimmed, text.part(start..start + trimmed.len())));
        at += name.len() + 1;
    }
    found
}
