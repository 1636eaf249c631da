//! JSON as it is written: keys may be repeated, numbers keep their text, and tokens that are no JSON but that
//! programs write have a place.

use std::borrow::Cow;
use std::fmt::{self, Write as _};

use super::error::SyntaxError;
use super::tokens::{Token, Tokens};

/// How many values a tree has at most: each takes some dozen times the room of its text.
const MAX_VALUES: usize = 1 << 20;

/// How much of a value is shown.
const MAX_SHOWN: usize = 40;

/// How long an excerpt gets before it ends, in bytes: about a line.
const MAX_EXCERPT: usize = 120;

/// A value of JSON.
#[derive(Clone, Debug, PartialEq)]
pub enum Tree<'t> {
    /// `null`.
    Null,
    /// `true` or `false`.
    Bool(bool),
    /// An integer of at most 64 bits.
    Int(i128),
    /// Any other number, and how it is written.
    Float(f64, &'t str),
    /// A number that no float of 64 bits holds, as it is written.
    Huge(&'t str),
    /// `NaN`, `Infinity` or `-Infinity`, which are no JSON.
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
    /// Reads a text.
    pub fn read(text: &'t str) -> Result<Self, SyntaxError> {
        let mut tokens = Tokens::new(text);
        let tree = value(&mut tokens, &mut 0)?;
        tokens.end()?;
        Ok(tree)
    }

    /// The value of a key, where this is an object; of a repeated one the first.
    pub fn get(&self, key: &str) -> Option<&Self> {
        let Self::Object(members) = self else { return None };
        members.iter().find(|(known, _)| known == key).map(|(_, value)| value)
    }

    /// As it is written, with what arrays and objects hold, cut short.
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

    /// Its text, where it is a string.
    pub fn as_str(&self) -> Option<&str> {
        if let Self::Text(text) = self { Some(text) } else { None }
    }
}

/// As it is written, cut short; arrays and objects in words.
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

/// Writes values between marks, as many as an excerpt has room for.
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

/// The start of a text that may be long.
pub(crate) fn shortened(text: &str) -> Cow<'_, str> {
    match text.char_indices().nth(MAX_SHOWN) {
        None => Cow::Borrowed(text),
        Some((end, _)) => Cow::Owned(format!("{}…", &text[..end])),
    }
}

/// Reads a value. `count` grows by the number of values in it.
fn value<'t>(tokens: &mut Tokens<'t>, count: &mut usize) -> Result<Tree<'t>, SyntaxError> {
    let first = tokens.peek();
    *count += 1;
    if *count > MAX_VALUES {
        return Err(tokens.error("too many values to say what is wrong with them"));
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
