//! Annotations: bracketed statements at the start of a trailing comment, such as
//! `# [m/s] [@range 0, 20] [@invalid NaN] text`.
//!
//! A near miss is read as intended, with a warning. Any other text in brackets remains ordinary text. Descriptions in
//! the tables of a page allow different annotations: see `Vocabulary`.

use std::borrow::Cow;
use std::ops::RangeInclusive;

use super::attribute::ATTRIBUTES;
use super::constraint::{Argument, RANGE, Stated, read_range};
use super::statement::{self, Statement, Vocabulary, unknown};
use super::words::split_word;
use crate::diagnostic::{Diagnostic, Problem};
use crate::limits::{MAX_ANNOTATION_LEN, MAX_UNIT_LEN};
use crate::source::Span;
use crate::unit;
use crate::value::Value;

/// The start of an annotation that contains a regular expression.
const PATTERN: &str = "[@pattern ";

/// The number of pipes around seven parameters; the last pipe is optional.
pub const PARAMETER_BARS: RangeInclusive<usize> = 7..=8;

/// A comment, split into annotations and text.
#[derive(Debug, Default)]
pub struct Note<'s> {
    /// The annotations, in the order written.
    pub annotations: Vec<Annotation<'s>>,
    /// The rest of the comment.
    pub text: Cow<'s, str>,
    /// The parameters of a command: `text |p1|p2|…|p7|`.
    pub parameters: Vec<Note<'s>>,
}

/// An annotation and its location.
#[derive(Debug)]
pub struct Annotation<'s> {
    /// The meaning.
    pub statement: Statement<'s>,
    /// The location, with its brackets.
    pub span: Span,
    /// False if the text only resembles an annotation, such as `[enum X]`.
    pub is_exact: bool,
}

/// Reads the annotations of a comment. `text` is the text after the `#`, at `span`.
pub fn read<'s>(text: &'s str, span: Span, diagnostics: &mut Vec<Diagnostic>) -> Note<'s> {
    read_by(Vocabulary::Comment, text, span, diagnostics)
}

/// Reads the annotations of a description on a page.
pub(crate) fn read_description<'s>(text: &'s str, span: Span, diagnostics: &mut Vec<Diagnostic>) -> Note<'s> {
    read_by(Vocabulary::Page, text, span, diagnostics)
}

fn read_by<'s>(
    vocabulary: Vocabulary,
    text: &'s str,
    span: Span,
    diagnostics: &mut Vec<Diagnostic>,
) -> Note<'s> {
    let mut reader = Reader { vocabulary, text, span, at: 0, note: Note::default(), diagnostics };
    reader.head();
    reader.rest();
    reader.note
}

/// Reads a comment whose text may end with command parameters between pipes.
pub fn read_with_parameters<'s>(text: &'s str, span: Span, diagnostics: &mut Vec<Diagnostic>) -> Note<'s> {
    let bars: Vec<usize> = text.match_indices('|').map(|(at, _)| at).collect();
    if !PARAMETER_BARS.contains(&bars.len()) {
        return read(text, span, diagnostics);
    }
    let mut note = read(&text[..bars[0]], span.part(0..bars[0]), diagnostics);
    let ends = bars[1..].iter().copied().chain((bars.len() == 7).then_some(text.len()));
    for (bar, end) in bars.iter().zip(ends) {
        let range = bar + 1..end;
        note.parameters.push(read(&text[range.clone()], span.part(range), diagnostics));
    }
    note
}

struct Reader<'s, 'd> {
    vocabulary: Vocabulary,
    text: &'s str,
    span: Span,
    at: usize,
    note: Note<'s>,
    diagnostics: &'d mut Vec<Diagnostic>,
}

/// The kind of a text in brackets.
enum Reading<'s> {
    Statement(Statement<'s>),
    /// The intended statement, and its correct spelling.
    NearMiss(Statement<'s>, String),
    Text(Option<Problem>),
}

impl<'s> Reader<'s, '_> {
    /// Reads the annotations before the first word.
    fn head(&mut self) {
        loop {
            let rest = &self.text[self.at..];
            let start = self.at + rest.len() - rest.trim_start().len();
            let Some((content, end)) = bracketed(self.text, start) else {
                return self.report_open_pattern(start);
            };
            match classify(self.vocabulary, content, self.text.as_bytes()[start] == b'(') {
                // A Markdown link, or a term that the text explains.
                Reading::Statement(Statement::Unit(symbol))
                    if !unit::is_known(symbol) && self.text[end..].starts_with(['(', ':']) =>
                {
                    return;
                }
                Reading::Statement(statement) => self.push(statement, start..end, true),
                Reading::NearMiss(statement, expected) => {
                    let found = self.text[start..end].to_owned();
                    self.report(Problem::AnnotationNearMiss { found, expected }, start..end);
                    self.push(statement, start..end, false);
                }
                Reading::Text(problem) => {
                    if let Some(problem) = problem {
                        self.report(problem, start..end);
                    }
                    return;
                }
            }
            self.at = end;
        }
    }

    /// Reports a regular expression whose end can't be determined, because its brackets are unbalanced.
    fn report_open_pattern(&mut self, start: usize) {
        if self.vocabulary == Vocabulary::Page && self.text[start..].starts_with(PATTERN) {
            let text = self.text[start + 1..].chars().take(MAX_UNIT_LEN).collect();
            let problem = Problem::MalformedAnnotation { text, form: "[@pattern REGEX]" };
            self.report(problem, start..start + 1);
        }
    }

    /// Reads the text, including misplaced annotations, which start with `@`.
    fn rest(&mut self) {
        let mut text = String::new();
        // After a pipe, the annotation may belong to a parameter.
        let head = self.text.len() - self.text[self.at..].trim_start().len();
        let head = (!self.text.contains('|')).then_some(head);
        let mut copied = self.at;
        let mut from = self.at;
        // No annotation can follow the last closing bracket.
        let last = self.text.rfind([']', ')']).unwrap_or(0);
        while let Some(start) =
            self.text[from..].find(['[', '(']).map(|at| from + at).filter(|start| *start < last)
        {
            from = start + 1;
            if !self.text[from..].starts_with('@') {
                continue;
            }
            let Some((content, end)) = bracketed(self.text, start) else { continue };
            match classify(self.vocabulary, content, self.text.as_bytes()[start] == b'(') {
                reading @ (Reading::Statement(_) | Reading::NearMiss(..)) => {
                    let found = self.text[start..end].to_owned();
                    let (statement, expected, is_exact) = match reading {
                        Reading::NearMiss(statement, expected) => (statement, expected, false),
                        Reading::Statement(statement) => (statement, found.clone(), true),
                        Reading::Text(_) => continue,
                    };
                    let head = head.map(|head| self.span.part(head..head));
                    self.report(Problem::AnnotationAfterText { found, expected, head }, start..end);
                    self.push(statement, start..end, is_exact);
                    text.push_str(self.text[copied..start].trim_end());
                    copied = end;
                    from = end;
                }
                // Skip an annotation at the start, which was already reported.
                Reading::Text(Some(problem)) if !self.text[self.at..start].trim().is_empty() => {
                    self.report(problem, start..end);
                }
                Reading::Text(_) => {}
            }
        }
        self.note.text = if text.is_empty() {
            Cow::Borrowed(self.text[copied..].trim())
        } else {
            text.push_str(self.text[copied..].trim_end());
            Cow::Owned(text.trim().to_owned())
        };
    }

    fn push(&mut self, statement: Statement<'s>, range: std::ops::Range<usize>, is_exact: bool) {
        if let Statement::Unit(symbol) = statement
            && !unit::is_known(symbol)
        {
            self.report(Problem::UnknownUnit { unit: symbol.to_owned() }, range.clone());
        }
        let mut statement = statement;
        if let Statement::Constraint(_, Argument::Stated(Stated::Range(bounds)), _) = &mut statement
            && bounds.is_reversed()
        {
            std::mem::swap(&mut bounds.low, &mut bounds.high);
            let text = |bound: &Option<Value>| {
                bound.as_ref().and_then(Value::as_f64).unwrap_or_default().to_string()
            };
            let problem = Problem::RangeReversed { low: text(&bounds.high), high: text(&bounds.low) };
            self.report(problem, range.clone());
        }
        self.note.annotations.push(Annotation { statement, span: self.span.part(range), is_exact });
    }

    fn report(&mut self, problem: Problem, range: std::ops::Range<usize>) {
        self.diagnostics.push(Diagnostic::new(problem, self.span.part(range)));
    }
}

/// The contents of the bracket or parenthesis that opens at `start`, and the position after its closing counterpart.
fn bracketed(text: &str, start: usize) -> Option<(&str, usize)> {
    let rest = &text[start..];
    let close = match rest.as_bytes().first()? {
        b'[' => ']',
        b'(' if rest.starts_with("(@") => ')',
        _ => return None,
    };
    if rest.starts_with(PATTERN) {
        return bracketed_pattern(rest).map(|end| (rest[1..end].trim(), start + end + 1));
    }
    // Brackets may contain labels in parentheses: `(@range -1 (Left), 1 (Right))`.
    let mut depth = 0_usize;
    for (at, character) in rest.char_indices().skip(1).take(MAX_ANNOTATION_LEN) {
        match character {
            '(' => depth += 1,
            ')' if depth > 0 => depth -= 1,
            _ if character == close => return Some((rest[1..at].trim(), start + at + 1)),
            _ => {}
        }
    }
    None
}

/// The position of the bracket that closes the bracket at the start of `text`. Brackets in a regular expression must be
/// balanced, except after a backslash.
fn bracketed_pattern(text: &str) -> Option<usize> {
    let mut depth = 0_usize;
    let mut is_escaped = false;
    for (at, character) in text.char_indices().take(MAX_ANNOTATION_LEN) {
        match character {
            _ if is_escaped => is_escaped = false,
            '\\' => is_escaped = true,
            '[' => depth += 1,
            ']' if depth == 1 => return Some(at),
            ']' => depth -= 1,
            _ => {}
        }
    }
    None
}

/// True if a single pair of brackets encloses all of `text`. False if the first bracket is closed before the end of
/// `text`.
pub fn is_bracketed(text: &str) -> bool {
    bracketed(text, 0).is_some_and(|(_, end)| end == text.len())
}

fn classify(vocabulary: Vocabulary, content: &str, in_parentheses: bool) -> Reading<'_> {
    if let Some(annotation) = content.strip_prefix('@') {
        let (name, argument) = split_word(annotation);
        return match (statement::read(vocabulary, name, argument), in_parentheses) {
            (Some(Ok(statement)), false) => Reading::Statement(statement),
            (Some(Ok(statement)), true) => Reading::NearMiss(statement, format!("[{content}]")),
            (Some(Err(problem)), _) => Reading::Text(Some(problem)),
            (None, true) => Reading::Text(None),
            (None, false) => Reading::Text(Some(unknown(name))),
        };
    }
    if let Some(unit) = unit::lookup(content) {
        return Reading::Statement(Statement::Unit(unit.symbol));
    }
    if vocabulary == Vocabulary::Comment
        && let Some(attribute) = ATTRIBUTES.iter().find(|attribute| attribute.bare.contains(&content))
    {
        let expected = format!("[@{} {content}]", attribute.name);
        return Reading::NearMiss(Statement::Attribute(attribute, content), expected);
    }
    let (name, argument) = split_word(content);
    if !argument.is_empty()
        && let Some(Ok(statement)) = statement::read(vocabulary, name, argument)
    {
        return Reading::NearMiss(statement, format!("[@{content}]"));
    }
    if let Some((low, high)) = content.split_once(',')
        && !low.trim().is_empty()
        && !high.trim().is_empty()
        && let Some(bounds) = read_range(content)
    {
        let statement = Statement::Constraint(&RANGE, Argument::Stated(Stated::Range(bounds)), "");
        return Reading::NearMiss(statement, format!("[@range {content}]"));
    }
    if looks_like_unit(content) {
        return Reading::Statement(Statement::Unit(content));
    }
    Reading::Text(None)
}

/// True if the text looks like a unit: letters with exponents, slashes and parentheses, as in `(m/s^2)^2`, `°C` or `%`.
fn looks_like_unit(content: &str) -> bool {
    let starts = content.starts_with(|c: char| c.is_alphabetic() || matches!(c, '(' | '%' | '°'));
    let words = content.split_ascii_whitespace().count();
    starts
        && content.len() <= MAX_UNIT_LEN
        && words <= 3
        && content
            .chars()
            .all(|c| c.is_alphanumeric() || matches!(c, '/' | '^' | '(' | ')' | '%' | '°' | '*' | '-' | ' '))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::msg::attribute::FRAME;
    use crate::msg::constraint::{INVALID, Range};
    use crate::msg::statement::Prefix;

    fn statements(text: &str) -> (Vec<Statement<'_>>, String, Vec<&'static str>) {
        let mut diagnostics = Vec::new();
        let note = read(text, Span::default(), &mut diagnostics);
        let codes = diagnostics.iter().map(|diagnostic| diagnostic.problem.code()).collect();
        (
            note.annotations.into_iter().map(|annotation| annotation.statement).collect(),
            note.text.into_owned(),
            codes,
        )
    }

    fn range(low: Option<Value>, high: Option<Value>) -> Statement<'static> {
        Statement::Constraint(&RANGE, Argument::Stated(Stated::Range(Range { low, high })), "")
    }

    #[allow(clippy::unnecessary_wraps)] // bounds are optional
    fn int(value: i128) -> Option<Value> {
        Some(Value::Int(value))
    }

    #[test]
    fn any_number_at_the_head_in_any_order() {
        let (found, text, codes) =
            statements(" [@invalid NaN if lost] [meters/second] [@range -1 (Left), 1 (Right)] speed [up]");
        assert!(
            matches!(&found[0], Statement::Constraint(kind, Argument::Stated(Stated::Value(Value::Float(v))), "if lost")
                if **kind == INVALID && v.is_nan())
        );
        assert_eq!(found[1..], [Statement::Unit("m/s"), range(int(-1), int(1))]);
        assert_eq!((text.as_str(), codes.len()), ("speed [up]", 0));
    }

    #[test]
    fn bounds_may_be_absent_infinite_or_multiples_of_pi() {
        let read = |text| statements(text).0.remove(0);
        assert_eq!(read("[@range 1,]"), range(int(1), None));
        assert_eq!(read("[@range 0, INF]"), range(int(0), None));
        assert_eq!(read("[@range -inf (Backwards), inf (Forwards)]"), range(None, None));
        let pi = std::f64::consts::PI;
        let expected = range(Some(Value::Float(-pi)), Some(Value::Float(2.0 * pi)));
        assert_eq!(read("[@range -pi, 2PI]"), expected);
    }

    #[test]
    fn near_misses_are_read_as_meant() {
        for (text, expected) in [
            ("[enum MODE] x", Statement::Enum(vec![Prefix { message: None, prefix: "MODE" }])),
            ("(@range 1, ) x", range(int(1), None)),
            ("[FRD] x", Statement::Attribute(&FRAME, "FRD")),
            ("[0,1] x", range(int(0), int(1))),
        ] {
            assert_eq!(
                statements(text),
                (vec![expected], "x".into(), vec!["annotation-near-miss"]),
                "{text}"
            );
        }
        let (found, text, codes) = statements("Speed [@range 0, 2] of it");
        assert_eq!(found, [range(int(0), int(2))]);
        assert_eq!((text.as_str(), codes), ("Speed of it", vec!["annotation-after-text"]));
    }

    #[test]
    fn other_text_in_brackets_stays_text() {
        for text in [
            "[1-99]: reserved",
            "[-PI..PI) yaw",
            "(@see Other)",
            "x [0, 1]",
            "[",
            "[]",
            "x (",
            "[1..255] id",
            "[page](http://x.org) y",
        ] {
            assert_eq!(statements(text), (vec![], text.into(), vec![]), "{text}");
        }
        let (found, text, codes) = statements("[@todo later] x");
        assert_eq!((found.len(), text.as_str(), codes), (0, "[@todo later] x", vec!["unknown-annotation"]));
        let (found, text, codes) = statements("[@range wide] x");
        assert_eq!((found.len(), text.as_str(), codes), (0, "[@range wide] x", vec!["malformed-annotation"]));
    }

    #[test]
    fn commands_have_seven_parameters_between_pipes() {
        let mut diagnostics = Vec::new();
        let note = read_with_parameters(" Go |[m] Radius|a|b|c|d|e|f|", Span::default(), &mut diagnostics);
        assert_eq!((note.text.as_ref(), note.parameters.len()), ("Go", 7));
        assert_eq!(note.parameters[0].annotations[0].statement, Statement::Unit("m"));
        assert!(read_with_parameters("AUTO|LOITER", Span::default(), &mut diagnostics).parameters.is_empty());
        assert!(diagnostics.is_empty());
    }
}
