//! The parser of expressions.

use std::ops::Range;

use uavspec_schema::span::Span;

use super::tree::{Binary, Name, Node, NodeKind, Side, Unary};
use crate::limits::{MAX_EXPRESSION, MAX_EXPRESSION_DEPTH};

/// The operators with two operands, from the lowest precedence to the highest.
const LEVELS: [&[(&str, Binary)]; 8] = [
    &[("or", Binary::Or)],
    &[("and", Binary::And)],
    &[
        ("==", Binary::Equal),
        ("!=", Binary::NotEqual),
        ("<", Binary::Less),
        ("<=", Binary::LessOrEqual),
        (">", Binary::Greater),
        (">=", Binary::GreaterOrEqual),
    ],
    &[("|", Binary::BitOr)],
    &[("^", Binary::BitXor)],
    &[("&", Binary::BitAnd)],
    &[("+", Binary::Add), ("-", Binary::Subtract)],
    &[("*", Binary::Multiply), ("/", Binary::Divide)],
];

/// The level of comparisons in [`LEVELS`]. Comparisons can't be chained. `not` applies to a whole
/// comparison.
const COMPARISON: usize = 2;

/// The words that can't be names.
const WORDS: [&str; 9] = ["and", "else", "false", "if", "nan", "not", "or", "then", "true"];

/// Parses `text`. `span` is the location of the text; an error consists of a location and a message.
pub(in crate::conversion) fn parse(text: &str, span: Span) -> Result<Node, (Span, String)> {
    // Without this check, positions in a string with escapes could lie outside the string.
    let place = |range: Range<usize>| {
        if span.end - span.start == uavspec_schema::span::offset(text.len()) {
            span.part(range)
        } else {
            span
        }
    };
    let fail = |(range, message): Error| (place(range), message);
    if text.len() > MAX_EXPRESSION {
        return Err((span, format!("the expression is longer than {MAX_EXPRESSION} bytes")));
    }
    let tokens = tokens(text).map_err(fail)?;
    let mut parser = Parser { text, tokens, at: 0, depth: 0, place: &place };
    let node = parser.expression().map_err(fail)?;
    match parser.peek() {
        None => Ok(node),
        Some(token) => Err(fail(parser.error(format!("expected an operator, found `{token}`")))),
    }
}

type Error = (Range<usize>, String);

/// Splits a text into names, numbers and operators.
fn tokens(text: &str) -> Result<Vec<Range<usize>>, Error> {
    let bytes = text.as_bytes();
    let mut tokens = Vec::new();
    let mut at = 0;
    while let Some(byte) = bytes.get(at) {
        let rest = &bytes[at..];
        let length = match byte {
            b' ' | b'\t' | b'\n' | b'\r' => {
                at += 1;
                continue;
            }
            b'0'..=b'9' => number_length(rest),
            byte if is_word(*byte) => {
                rest.iter().take_while(|byte| is_word(**byte) || **byte == b'.').count()
            }
            b'=' | b'!' | b'<' | b'>' if rest.get(1) == Some(&b'=') => 2,
            b'<' | b'>' | b'|' | b'^' | b'&' | b'+' | b'-' | b'*' | b'/' | b'~' | b'(' | b')' => 1,
            _ => {
                let found = text[at..].chars().next().unwrap_or_default();
                let end = at + found.len_utf8();
                return Err((at..end, format!("unexpected character `{}`", found.escape_debug())));
            }
        };
        tokens.push(at..at + length);
        at += length;
    }
    Ok(tokens)
}

fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

/// The length of a number at the start of `bytes`. The sign of an exponent belongs to the number.
fn number_length(bytes: &[u8]) -> usize {
    let is_hexadecimal = bytes.starts_with(b"0x") || bytes.starts_with(b"0b");
    let mut length = 0;
    while let Some(byte) = bytes.get(length) {
        let follows_exponent = length > 0 && matches!(bytes[length - 1], b'e' | b'E') && !is_hexadecimal;
        let is_sign = matches!(byte, b'+' | b'-') && follows_exponent;
        if !(is_word(*byte) || *byte == b'.' || is_sign) {
            break;
        }
        length += 1;
    }
    length
}

struct Parser<'t> {
    text: &'t str,
    tokens: Vec<Range<usize>>,
    at: usize,
    depth: usize,
    place: &'t dyn Fn(Range<usize>) -> Span,
}

impl<'t> Parser<'t> {
    fn peek(&self) -> Option<&'t str> {
        self.tokens.get(self.at).map(|range| &self.text[range.clone()])
    }

    /// An error at the current token.
    fn error(&self, message: impl Into<String>) -> Error {
        let end = self.text.len();
        (self.tokens.get(self.at).cloned().unwrap_or(end..end), message.into())
    }

    fn expect(&mut self, token: &str) -> Result<(), Error> {
        if self.peek() == Some(token) {
            self.at += 1;
            return Ok(());
        }
        let found = self.peek().map_or_else(|| "the end".to_owned(), |found| format!("`{found}`"));
        Err(self.error(format!("expected `{token}`, found {found}")))
    }

    /// Reads a node with `parse`, and adds its location.
    fn node(&mut self, parse: impl FnOnce(&mut Self) -> Result<NodeKind, Error>) -> Result<Node, Error> {
        let start = self.tokens.get(self.at).map_or(self.text.len(), |range| range.start);
        let kind = parse(self)?;
        Ok(Node { kind, span: self.span_from(start) })
    }

    fn span_from(&self, start: usize) -> Span {
        let end = self.at.checked_sub(1).map_or(start, |last| self.tokens[last].end);
        (self.place)(start..end.max(start))
    }

    fn expression(&mut self) -> Result<Node, Error> {
        if self.depth >= MAX_EXPRESSION_DEPTH {
            return Err(
                self.error(format!("the expression is nested more than {MAX_EXPRESSION_DEPTH} levels deep"))
            );
        }
        self.depth += 1;
        let node = if self.peek() == Some("if") { self.conditional() } else { self.level(0) };
        self.depth -= 1;
        node
    }

    fn conditional(&mut self) -> Result<Node, Error> {
        self.node(|parser| {
            parser.at += 1;
            let condition = parser.expression()?;
            parser.expect("then")?;
            let yes = parser.expression()?;
            parser.expect("else")?;
            let no = parser.expression()?;
            Ok(NodeKind::If(Box::new([condition, yes, no])))
        })
    }

    fn level(&mut self, level: usize) -> Result<Node, Error> {
        if level == COMPARISON && self.peek() == Some("not") {
            return self.prefixed(Unary::Not, |parser| parser.level(COMPARISON));
        }
        let Some(operators) = LEVELS.get(level) else { return self.unary() };
        let start = self.tokens.get(self.at).map_or(self.text.len(), |range| range.start);
        let mut left = self.level(level + 1)?;
        let mut count = 0;
        while let Some((_, operator)) = operators.iter().find(|(text, _)| self.peek() == Some(text)) {
            count += 1;
            if level == COMPARISON && count > 1 {
                return Err(self.error("comparisons can't be chained; combine them with `and`"));
            }
            if count > MAX_EXPRESSION_DEPTH {
                return Err(self.error(format!("more than {MAX_EXPRESSION_DEPTH} operands; use parentheses")));
            }
            self.at += 1;
            let right = self.level(level + 1)?;
            let kind = NodeKind::Binary(*operator, Box::new(left), Box::new(right));
            left = Node { kind, span: self.span_from(start) };
        }
        Ok(left)
    }

    fn prefixed(
        &mut self,
        operator: Unary,
        operand: impl FnOnce(&mut Self) -> Result<Node, Error>,
    ) -> Result<Node, Error> {
        if self.depth >= MAX_EXPRESSION_DEPTH {
            return Err(
                self.error(format!("the expression is nested more than {MAX_EXPRESSION_DEPTH} levels deep"))
            );
        }
        self.depth += 1;
        let node = self.node(|parser| {
            parser.at += 1;
            Ok(NodeKind::Unary(operator, Box::new(operand(parser)?)))
        });
        self.depth -= 1;
        node
    }

    fn unary(&mut self) -> Result<Node, Error> {
        match self.peek() {
            Some("-") => self.prefixed(Unary::Negate, Self::unary),
            Some("~") => self.prefixed(Unary::Invert, Self::unary),
            Some("(") => {
                self.at += 1;
                let inner = self.expression()?;
                self.expect(")")?;
                Ok(inner)
            }
            Some("if") => self.conditional(),
            _ => self.node(Self::operand),
        }
    }

    fn operand(&mut self) -> Result<NodeKind, Error> {
        let Some(token) = self.peek() else { return Err(self.error("expected a value")) };
        let kind = match token {
            "true" => NodeKind::Bool(true),
            "false" => NodeKind::Bool(false),
            "nan" => NodeKind::Float(f64::NAN),
            _ if token.starts_with(|first: char| first.is_ascii_digit()) => {
                number(token).ok_or_else(|| self.error(format!("`{token}` is not a number")))?
            }
            _ if token.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_')
                && !WORDS.contains(&token) =>
            {
                self.name(token)?
            }
            _ => return Err(self.error(format!("expected a value, found `{token}`"))),
        };
        self.at += 1;
        Ok(kind)
    }

    fn name(&self, token: &str) -> Result<NodeKind, Error> {
        let (side, text) = match token.split_once('.') {
            None => (None, token),
            Some(("old", text)) if !text.contains('.') => (Some(Side::Old), text),
            Some(("new", text)) if !text.contains('.') => (Some(Side::New), text),
            Some(_) => {
                return Err(self.error(format!(
                    "`{token}`: expected a field, or a constant such as `NAME`, `old.NAME` or `new.NAME`"
                )));
            }
        };
        let range = self.tokens[self.at].clone();
        Ok(NodeKind::Name(Name { side, text: text.to_owned(), span: (self.place)(range) }))
    }
}

/// Parses a decimal, hexadecimal or binary integer, or a float.
fn number(token: &str) -> Option<NodeKind> {
    let integer = match (token.strip_prefix("0x"), token.strip_prefix("0b")) {
        (Some(digits), _) => i128::from_str_radix(digits, 16).ok(),
        (_, Some(digits)) => i128::from_str_radix(digits, 2).ok(),
        _ => token.parse().ok(),
    };
    let float = || token.contains(['.', 'e', 'E']).then(|| token.parse().ok())?.map(NodeKind::Float);
    integer.map(NodeKind::Int).or_else(float)
}
