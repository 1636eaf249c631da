//! Reads messages: a heading with the subheadings `Request`, `Response` and `Notification`.

use std::fmt;

use super::columns::{self, Columns, Header};
use super::reader::{Member, Reader, under};
use crate::diagnostic::{Diagnostic, Problem};
use crate::source::Span;
use crate::table::page::{Heading, Page, Table};
use crate::table::text::Text;

/// The start of the paragraph that lists the possible answers to a request.
const ANSWER: &str = "Answer:";

/// The start of the paragraph that replaces an empty table.
const NO_FIELDS: &str = "no fields beside";

/// The kind of a message, by sender and purpose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Direction {
    /// From a client that expects an answer.
    Request,
    /// The answer to a request.
    Response,
    /// An unsolicited message from a server.
    Notification,
}

impl Direction {
    /// All directions, in the order used in lists.
    pub const ALL: [Self; 3] = [Self::Request, Self::Response, Self::Notification];

    /// The name in files and identifiers.
    pub fn name(self) -> &'static str {
        match self {
            Self::Request => "request",
            Self::Response => "response",
            Self::Notification => "notification",
        }
    }

    /// The name in headings.
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

/// A message as written.
#[derive(Debug)]
pub struct MessageDefinition<'p> {
    /// The message type, which is also the value of the `type` field in the body.
    pub name: &'p str,
    /// The heading.
    pub span: Span,
    /// The paragraphs under the heading, except the list of answers.
    pub paragraphs: Vec<&'p Text>,
    /// The parts, one for each direction.
    pub parts: Vec<PartDefinition<'p>>,
}

/// The part of a message for one direction.
#[derive(Debug)]
pub struct PartDefinition<'p> {
    /// The direction.
    pub direction: Direction,
    /// The subheading.
    pub span: Span,
    /// The paragraphs under the subheading and above the table, except the list of answers.
    pub paragraphs: Vec<&'p Text>,
    /// The paragraphs below the table.
    pub remarks: Vec<&'p Text>,
    /// The types of the responses to a request, if listed.
    pub answers: Vec<(&'p str, Span)>,
    /// The fields except `type`.
    pub fields: Vec<Member<'p>>,
}

/// The indices of the headings of a message.
#[derive(Debug)]
pub(super) struct Headings {
    /// The heading of the message.
    message: usize,
    /// The subheadings of its parts.
    parts: Vec<(Direction, usize)>,
}

impl Headings {
    /// The index of the message heading.
    pub(super) fn index(&self) -> usize {
        self.message
    }

    /// The indices of the part headings.
    pub(super) fn parts(&self) -> impl Iterator<Item = usize> {
        self.parts.iter().map(|(_, part)| *part)
    }
}

/// The headings of all messages of a page. A heading defines a message only if one of its subheadings has a table of
/// fields, or a paragraph saying that there are no fields. The subheadings alone don't suffice, because other pages use
/// the same subheadings for other purposes.
pub(super) fn headings(page: &Page) -> Vec<Headings> {
    let mut messages: Vec<Headings> = Vec::new();
    // The enclosing headings, from the outermost.
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
    let mut has_fields = vec![false; page.headings.len()];
    for table in page.tables.iter().filter(|table| columns_of(table).is_some()) {
        if let Some(has_fields) = table.heading.and_then(|heading| has_fields.get_mut(heading)) {
            *has_fields = true;
        }
    }
    for paragraph in page.paragraphs.iter().filter(|paragraph| has_no_fields(&paragraph.text)) {
        if let Some(has_fields) = paragraph.heading.and_then(|heading| has_fields.get_mut(heading)) {
            *has_fields = true;
        }
    }
    messages.retain(|message| message.parts.iter().any(|(_, part)| has_fields[*part]));
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

/// True if a text is a valid message type: words of letters and digits, separated by hyphens.
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
                    .push(Diagnostic::new(problem, part.span).with_related(first.span, "first definition"));
                continue;
            }
            parts.push(part);
        }
        parts.sort_by_key(|part| part.direction);
        if !is_message_name(name) {
            let hint = "use only letters and digits, with hyphens between words: `UAV-INF`";
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
                .push(Diagnostic::new(problem, second.span).with_hint("put all fields in one table"));
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

/// Separates the lists of answers, which are returned first, from the other paragraphs.
fn apart(paragraphs: Vec<&Text>) -> (Vec<&Text>, Vec<&Text>) {
    paragraphs.into_iter().partition(|text| text.as_str().starts_with(ANSWER))
}

/// The types in a list of answers, each with its location.
fn answers(text: &Text) -> Vec<(&str, Span)> {
    let mut found = Vec::new();
    let mut at = ANSWER.len();
    for name in text.as_str()[at..].split(',') {
        let start = at + name.len() - name.trim_start().len();
        let trimmed = name.trim().trim_end_matches('.').trim_end();
        found.push((trimmed, text.part(start..start + trimmed.len())));
        at += name.len() + 1;
    }
    found
}
