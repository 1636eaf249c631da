//! A JSON tree that preserves the text. The tree keeps repeated keys, the digits of numbers, and the non-JSON tokens
//! that some programs write.

use std::borrow::Cow;
use std::fmt::{self, Write as _};
use std::ops::Range;

use uavspec_dynamic::whole;

use super::error::SyntaxError;
use super::tokens::{Token, Tokens};
use crate::limits::MAX_VALUES;
use crate::text::start_of;

/// The maximum length of a displayed value, in characters.
const MAX_SHOWN: usize = 40;

/// The maximum length of an excerpt, in bytes: about one line.
const MAX_EXCERPT: usize = 120;

/// A JSON value.
#[derive(Clone, Debug, PartialEq)]
pub enum Tree<'t> {
    /// `null`.
    Null,
    /// `true` or `false`.
    Bool(bool),
    /// An integer of at most 64 bits.
    Int(i128),
    /// Any other number, with its text.
    Float(f64, &'t str),
    /// The text of a number beyond the range of a 64-bit float.
    Huge(&'t str),
    /// `NaN`, `Infinity` or `-Infinity`, which aren't JSON.
    Token(&'t str),
    /// A string.
    Text(Cow<'t, str>),
    /// An array.
    List(Vec<Tree<'t>>),
    /// An object; keys may be repeated.
    Object(Vec<(Cow<'t, str>, Tree<'t>)>),
}

impl<'t> From<Token<'t>> for Tree<'t> {
    fn from(token: Token<'t>) -> Self {
        match token {
            Token::Null => Self::Null,
            Token::Bool(value) => Self::Bool(value),
            Token::Int(value) => Self::Int(value),
            Token::Float(value, text) => Self::Float(value, text),
            Token::Huge(text) => Self::Huge(text),
            Token::NotJson(text) => Self::Token(text),
            Token::Text(text) => Self::Text(text),
        }
    }
}

impl<'t> Tree<'t> {
    /// Parses a text.
    pub fn read(text: &'t str) -> Result<Self, SyntaxError> {
        let mut tokens = Tokens::new(text);
        let tree = value(&mut tokens, &mut 0)?;
        tokens.end()?;
        Ok(tree)
    }

    /// Parses a text. If it is an object, also returns the positions of its members' values.
    pub fn read_with_places(text: &'t str) -> Result<(Self, Vec<Range<usize>>), SyntaxError> {
        let mut tokens = Tokens::new(text);
        if tokens.peek() != Some(b'{') {
            return Ok((Self::read(text)?, Vec::new()));
        }
        let (mut members, mut places, mut count) = (Vec::new(), Vec::new(), 1);
        tokens.members(|tokens, key| {
            tokens.peek();
            let start = tokens.at();
            members.push((key, value(tokens, &mut count)?));
            places.push(start..tokens.at());
            Ok::<(), SyntaxError>(())
        })?;
        tokens.end()?;
        Ok((Self::Object(members), places))
    }

    /// The value of a key, if this is an object. For a repeated key, returns the first value.
    pub fn get(&self, key: &str) -> Option<&Self> {
        let Self::Object(members) = self else { return None };
        members.iter().find(|(known, _)| known == key).map(|(_, value)| value)
    }

    /// True if an object in this value repeats a key. Parsers disagree about which value applies.
    pub fn repeats_a_key(&self) -> bool {
        match self {
            Self::List(values) => values.iter().any(Self::repeats_a_key),
            Self::Object(members) => {
                let mut keys: Vec<&str> = members.iter().map(|(key, _)| &**key).collect();
                keys.sort_unstable();
                keys.windows(2).any(|pair| pair[0] == pair[1])
                    || members.iter().any(|(_, value)| value.repeats_a_key())
            }
            _ => false,
        }
    }

    /// The shortened text, including the contents of arrays and objects.
    pub fn excerpt(&self) -> String {
        let mut text = String::new();
        self.write(&mut text);
        text
    }

    fn write(&self, text: &mut String) {
        match self {
            Self::List(values) => enclosed(text, ['[', ']'], values, |text, value| value.write(text)),
            Self::Object(members) => enclosed(text, ['{', '}'], members, |text, (key, value)| {
                // Writing to a string can't fail.
                let _ = write!(text, "{:?}: ", shortened(key));
                value.write(text);
            }),
            Self::Token(token) => text.push_str(token),
            // Writing to a string can't fail.
            other => _ = write!(text, "{other}"),
        }
    }

    /// The value as an integer, if it is an integer in any notation, such as `5.0`. Beyond 2^53, integers written with a
    /// fraction or an exponent are rounded.
    pub fn as_integer(&self) -> Option<i128> {
        match self {
            Self::Int(value) => Some(*value),
            Self::Float(value, _) => whole(*value),
            _ => None,
        }
    }

    /// The text of a string.
    pub fn as_str(&self) -> Option<&str> {
        if let Self::Text(text) = self { Some(text) } else { None }
    }
}

/// Displays the shortened text. Arrays and objects are only described.
impl fmt::Display for Tree<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Null => formatter.write_str("null"),
            Self::Bool(value) => value.fmt(formatter),
            Self::Int(value) => value.fmt(formatter),
            Self::Float(_, text) | Self::Huge(text) => formatter.write_str(&shortened(text)),
            Self::Token(text) => write!(formatter, "a bare {text}"),
            Self::Text(text) => write!(formatter, "{:?}", shortened(text)),
            Self::List(values) => write!(formatter, "an array of {}", values.len()),
            Self::Object(_) => formatter.write_str("an object"),
        }
    }
}

/// Writes values in brackets, as many as fit into an excerpt.
fn enclosed<T>(text: &mut String, [open, close]: [char; 2], values: &[T], write: impl Fn(&mut String, &T)) {
    text.push(open);
    for (at, value) in values.iter().enumerate() {
        let comma = if at > 0 { ", " } else { "" };
        text.push_str(comma);
        if text.len() >= MAX_EXCERPT {
            text.push('…');
            break;
        }
        write(text, value);
    }
    text.push(close);
}

/// The text, or only its start if it is long.
pub fn shortened(text: &str) -> Cow<'_, str> {
    start_of(text, MAX_SHOWN)
}

/// Parses a value. Increases `count` by one for this value and for each nested value.
fn value<'t>(tokens: &mut Tokens<'t>, count: &mut usize) -> Result<Tree<'t>, SyntaxError> {
    let first = tokens.peek();
    *count += 1;
    if *count > MAX_VALUES {
        return Err(tokens.error("too many values"));
    }
    match first {
        Some(b'{') => {
            let mut members = Vec::new();
            tokens.members(|tokens, key| {
                members.push((key, value(tokens, count)?));
                Ok::<(), SyntaxError>(())
            })?;
            Ok(Tree::Object(members))
        }
        Some(b'[') => {
            let mut values = Vec::new();
            tokens.list(|tokens| {
                values.push(value(tokens, count)?);
                Ok::<(), SyntaxError>(())
            })?;
            Ok(Tree::List(values))
        }
        _ => tokens.token().map(Tree::from),
    }
}
