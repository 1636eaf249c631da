//! Parses type expressions such as `list of Name or null`.
//!
//! ```text
//! expression = term { "or" term }
//! term = "list of" term | "map of" term | "one of" constant { "," constant } | "(" expression ")" | name
//! ```

use std::collections::BTreeSet;
use std::iter::Peekable;
use std::ops::Range;
use std::vec::IntoIter;

use crate::diagnostic::{Diagnostic, Problem};
use crate::json_type;
use crate::limits::{MAX_ALTERNATIVES, MAX_TYPE_DEPTH};
use crate::source::Span;
use crate::table::text::Text;

/// A parsed type expression.
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    /// The kind.
    pub kind: ExpressionKind,
    /// The location.
    pub span: Span,
}

/// The kind of a type expression.
#[derive(Clone, Debug, PartialEq)]
pub enum ExpressionKind {
    /// A built-in type.
    BuiltIn(json_type::Expression),
    /// A type of the package.
    Named(String),
    /// A JSON array of elements of one type.
    List(Box<Expression>),
    /// A JSON object whose keys are ids and whose values have one type.
    Map(Box<Expression>),
    /// One of several types.
    Either(Vec<Expression>),
    /// One of some strings.
    OneOf(Vec<String>),
}

/// The built-in types.
const BUILT_IN: [(&str, json_type::Expression); 6] = [
    ("any", json_type::Expression::Any),
    ("null", json_type::Expression::Null),
    ("boolean", json_type::Expression::Boolean),
    ("integer", json_type::Expression::Integer),
    ("number", json_type::Expression::Number),
    ("string", json_type::Expression::String),
];

/// The name of a built-in type; empty for other types.
pub(crate) fn built_in_name(ty: &json_type::Expression) -> &'static str {
    BUILT_IN.iter().find(|(_, known)| known == ty).map_or("", |(name, _)| name)
}

/// Characters that end the type at the start of a paragraph.
const ENDS: [char; 5] = [',', '.', ':', ';', '['];

/// Parses the expression in a cell.
pub(super) fn read(cell: &Text, diagnostics: &mut Vec<Diagnostic>) -> Option<Expression> {
    match parse(cell, 0..cell.as_str().len()) {
        Ok(expression) => Some(expression),
        Err(Failure { range, hint }) => {
            let problem = Problem::InvalidTypeExpression { text: cell.as_str().to_owned() };
            let diagnostic = Diagnostic::new(problem, cell.part(range));
            diagnostics.push(Diagnostic { hint: hint.map(str::to_owned), ..diagnostic });
            None
        }
    }
}

/// Parses the expression at the start of a paragraph, and returns the start of the description. Returns `None` for
/// prose.
pub(super) fn read_start(paragraph: &Text) -> Option<(Expression, usize)> {
    let text = paragraph.as_str();
    let end = text.find(ENDS).unwrap_or(text.len());
    let first = text.split(' ').next()?.trim_end_matches(ENDS).trim_start_matches('(');
    let is_type = BUILT_IN.iter().any(|(name, _)| *name == first) || matches!(first, "list" | "map");
    let expression = parse(paragraph, 0..end).ok().filter(|_| is_type)?;
    let is_bracket = text[end..].starts_with('[') || end == text.len();
    Some((expression, if is_bracket { end } else { end + 1 }))
}

/// True if a word is a JSON number. Rust also parses `inf` and `nan` as numbers, but they are not JSON numbers.
pub(crate) fn is_number(word: &str) -> bool {
    word.contains(|c: char| c.is_ascii_digit()) && word.parse::<f64>().is_ok()
}

struct Failure {
    range: Range<usize>,
    hint: Option<&'static str>,
}

#[derive(Clone, Debug, PartialEq)]
struct Token<'t> {
    text: &'t str,
    range: Range<usize>,
}

fn parse(text: &Text, range: Range<usize>) -> Result<Expression, Failure> {
    let whole = range.clone();
    let tokens = tokens(text.as_str(), range);
    let mut parser = Parser { text, tokens: tokens.into_iter().peekable(), end: whole.end };
    let expression = parser.expression(0)?;
    match parser.tokens.next() {
        None => Ok(expression),
        Some(token) => Err(Failure { range: token.range, hint: None }),
    }
}

/// Splits the text into words, quoted texts, and the characters `(`, `)` and `,`.
fn tokens(text: &str, range: Range<usize>) -> Vec<Token<'_>> {
    let mut tokens = Vec::new();
    let mut at = range.start;
    while let Some(character) = text.get(at..range.end).and_then(|rest| rest.chars().next()) {
        let rest = &text[at..range.end];
        let len = match character {
            '(' | ')' | ',' => 1,
            '"' => rest[1..].find('"').map_or(rest.len(), |end| end + 2),
            _ => rest.find(|c: char| c.is_whitespace() || matches!(c, '(' | ')' | ',')).unwrap_or(rest.len()),
        };
        if len == 0 {
            at += character.len_utf8();
            continue;
        }
        tokens.push(Token { text: &rest[..len], range: at..at + len });
        at += len;
    }
    tokens
}

struct Parser<'t> {
    text: &'t Text,
    tokens: Peekable<IntoIter<Token<'t>>>,
    end: usize,
}

impl<'t> Parser<'t> {
    fn expression(&mut self, depth: usize) -> Result<Expression, Failure> {
        let first = self.term(depth)?;
        if self.take("or").is_none() {
            return Ok(first);
        }
        let start = first.span;
        let mut alternatives = vec![first];
        loop {
            let alternative = self.term(depth)?;
            if alternatives.len() >= MAX_ALTERNATIVES {
                let hint = "define some of the alternatives as separate types";
                return Err(Failure { range: 0..self.end, hint: Some(hint) });
            }
            alternatives.push(alternative);
            if self.take("or").is_none() {
                break;
            }
        }
        let span = alternatives.last().map_or(start, |last| start.to(last.span));
        Ok(Expression { kind: ExpressionKind::Either(alternatives), span })
    }

    fn term(&mut self, depth: usize) -> Result<Expression, Failure> {
        let token = self.next()?;
        if depth > MAX_TYPE_DEPTH {
            return Err(Failure { range: token.range, hint: Some("define the inner type separately") });
        }
        let start = self.text.part(token.range.clone());
        if token.text == "(" {
            let inner = self.expression(depth + 1)?;
            self.expect(")")?;
            return Ok(inner);
        }
        let is_followed = |parser: &mut Self| parser.take("of").is_some();
        let (kind, span) = match token.text {
            "list" if is_followed(self) => {
                let inner = self.term(depth + 1)?;
                let span = start.to(inner.span);
                (ExpressionKind::List(Box::new(inner)), span)
            }
            "map" if is_followed(self) => {
                let inner = self.term(depth + 1)?;
                let span = start.to(inner.span);
                (ExpressionKind::Map(Box::new(inner)), span)
            }
            "one" if is_followed(self) => {
                let (constants, last) = self.constants()?;
                (ExpressionKind::OneOf(constants), start.to(last))
            }
            name => match BUILT_IN.iter().find(|(known, _)| *known == name) {
                Some((_, ty)) => (ExpressionKind::BuiltIn(ty.clone()), start),
                None if is_type_name(name) => (ExpressionKind::Named(name.to_owned()), start),
                None => return Err(Failure { range: token.range, hint: None }),
            },
        };
        Ok(Expression { kind, span })
    }

    fn constants(&mut self) -> Result<(Vec<String>, Span), Failure> {
        let mut constants = Vec::new();
        let mut known = BTreeSet::new();
        loop {
            let token = self.next()?;
            let quoted = token.text.strip_prefix('"').and_then(|text| text.strip_suffix('"'));
            if quoted.is_none() && is_number(token.text) {
                let hint = "the constants of `one of` are strings; put numbers in quotes, or define a set";
                return Err(Failure { range: token.range, hint: Some(hint) });
            }
            let text = quoted.unwrap_or(token.text);
            if !known.insert(text) {
                return Err(Failure { range: token.range, hint: Some("remove the duplicate constant") });
            }
            constants.push(text.to_owned());
            if self.take(",").is_none() {
                return Ok((constants, self.text.part(token.range)));
            }
        }
    }

    fn next(&mut self) -> Result<Token<'t>, Failure> {
        let end = self.end;
        let token = self.tokens.next().ok_or(Failure { range: end..end, hint: None })?;
        let is_stray = matches!(token.text, ")" | ",");
        if is_stray { Err(Failure { range: token.range, hint: None }) } else { Ok(token) }
    }

    fn take(&mut self, text: &str) -> Option<Token<'t>> {
        self.tokens.next_if(|token| token.text == text)
    }

    fn expect(&mut self, text: &str) -> Result<(), Failure> {
        let end = self.end;
        self.take(text).map(|_| ()).ok_or(Failure { range: end..end, hint: Some("close the parenthesis") })
    }
}

/// True if a text is a valid type name: one word in `PascalCase`.
pub fn is_type_name(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_uppercase())
        && text.bytes().all(|byte| byte.is_ascii_alphanumeric())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::text::TextBuilder;

    fn text(source: &str) -> Text {
        let mut builder =
            TextBuilder::new(Span { start: 0, end: u32::try_from(source.len()).expect("short") });
        builder.push(source, 0);
        builder.finish(0..source.len())
    }

    /// The expression, fully parenthesized.
    fn shown(expression: &Expression) -> String {
        match &expression.kind {
            ExpressionKind::Named(name) => name.clone(),
            ExpressionKind::List(inner) => format!("list({})", shown(inner)),
            ExpressionKind::Map(inner) => format!("map({})", shown(inner)),
            ExpressionKind::Either(all) => {
                format!("({})", all.iter().map(shown).collect::<Vec<_>>().join("|"))
            }
            ExpressionKind::OneOf(constants) => format!("{constants:?}"),
            ExpressionKind::BuiltIn(ty) => built_in_name(ty).to_owned(),
        }
    }

    #[test]
    fn or_has_the_lowest_precedence() {
        for (source, expected) in [
            ("string", "string"),
            ("list of Mark or null", "(list(Mark)|null)"),
            ("list of (Mark or null)", "list((Mark|null))"),
            ("map of list of integer", "map(list(integer))"),
            ("integer or one of auto, inf", "(integer|[\"auto\", \"inf\"])"),
            ("one of a, \"b c\" or null", "([\"a\", \"b c\"]|null)"),
            ("((any))", "any"),
            ("integer or string or Mark", "(integer|string|Mark)"),
        ] {
            let mut diagnostics = Vec::new();
            let found = read(&text(source), &mut diagnostics);
            assert_eq!(found.as_ref().map(shown).as_deref(), Some(expected), "{source}");
            assert_eq!(diagnostics, []);
        }
    }

    #[test]
    fn rejects_invalid_types() {
        let deep = format!("{}string", "list of ".repeat(100));
        for source in [
            "",
            "strings",
            "list",
            "list of",
            "map string",
            "or",
            "string or",
            "(string",
            "string)",
            "a b",
            "one of",
            "one of 1, 2",
            "one of a, a",
            "string, integer",
            &deep,
            "\"",
            "list of ,",
        ] {
            let mut diagnostics = Vec::new();
            assert_eq!(read(&text(source), &mut diagnostics), None, "{source}");
            assert_eq!(diagnostics[0].problem.code(), "invalid-type-expression", "{source}");
        }
    }

    #[test]
    fn a_paragraph_starts_with_a_type_or_is_prose() {
        let end = |source: &str| read_start(&text(source)).map(|(found, end)| (shown(&found), end));
        assert_eq!(end("integer, [ms] Time"), Some(("integer".to_owned(), 8)));
        assert_eq!(end("string [@length 1, 2] Id"), Some(("string".to_owned(), 7)));
        assert_eq!(end("list of Mark"), Some(("list(Mark)".to_owned(), 12)));
        for prose in
            ["integer numbers, all of them", "Mark, the first", "any mark, any time", "", "list them, please"]
        {
            assert_eq!(end(prose), None, "{prose}");
        }
    }
}
