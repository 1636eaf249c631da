//! JSON as it is written: keys may be repeated, numbers keep their text, and tokens that are no JSON but that
//! programs write have a place. Strings and numbers are read by `serde_json`, so both readers take the same.

use std::borrow::Cow;
use std::fmt::{self, Write as _};

use serde::de::IgnoredAny;

/// How deep values may nest, as `serde_json` has it.
const MAX_DEPTH: usize = 127;

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

/// Why a text is no JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SyntaxError {
    /// The byte, from 0.
    pub at: usize,
    /// What is wrong there.
    pub what: &'static str,
}

impl fmt::Display for SyntaxError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "no JSON: {} at byte {}", self.what, self.at)
    }
}

impl std::error::Error for SyntaxError {}

/// What is said where a text ends too early.
pub(crate) const CUT_OFF: &str = "it is cut off";

impl<'t> Tree<'t> {
    /// Reads a text.
    pub fn read(text: &'t str) -> Result<Self, SyntaxError> {
        let mut parser = Parser { text, at: 0, values: 0 };
        let tree = parser.value(0)?;
        parser.space();
        if parser.at < text.len() { Err(parser.error("something follows the value")) } else { Ok(tree) }
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

/// An integer that fits in 64 bits for certain, by how many digits it has.
fn plain_integer(written: &[u8]) -> Option<i64> {
    let digits = written.strip_prefix(b"-").unwrap_or(written);
    // -0 is a float, and nothing may stand behind a leading 0.
    let is_plain = match digits {
        [b'0'] => written.len() == 1,
        [b'1'..=b'9', rest @ ..] => rest.len() < 18 && rest.iter().all(u8::is_ascii_digit),
        _ => false,
    };
    let value = || digits.iter().fold(0, |value, digit| value * 10 + i64::from(digit - b'0'));
    is_plain.then(|| if written.len() > digits.len() { -value() } else { value() })
}

struct Parser<'t> {
    text: &'t str,
    at: usize,
    values: usize,
}

impl<'t> Parser<'t> {
    fn error(&self, what: &'static str) -> SyntaxError {
        let what = if self.at >= self.text.len() { CUT_OFF } else { what };
        SyntaxError { at: self.at, what }
    }

    fn rest(&self) -> &'t [u8] {
        &self.text.as_bytes()[self.at..]
    }

    fn space(&mut self) {
        let is_space = |byte: &&u8| matches!(byte, b' ' | b'\t' | b'\n' | b'\r');
        self.at += self.rest().iter().take_while(is_space).count();
    }

    /// Takes a byte, if it comes next.
    fn takes(&mut self, byte: u8) -> bool {
        let is_next = self.rest().first() == Some(&byte);
        self.at += usize::from(is_next);
        is_next
    }

    fn value(&mut self, depth: usize) -> Result<Tree<'t>, SyntaxError> {
        self.space();
        self.values += 1;
        if self.values > MAX_VALUES {
            return Err(self.error("too many values to say what is wrong with them"));
        }
        match self.rest().first() {
            Some(b'{' | b'[') if depth >= MAX_DEPTH => Err(self.error("values nest too deep")),
            Some(b'{') => self.object(depth + 1),
            Some(b'[') => self.list(depth + 1),
            Some(b'"') => self.string().map(Tree::Text),
            Some(b'-' | b'0'..=b'9') if !self.rest().starts_with(b"-I") => self.number(),
            _ => self.word(),
        }
    }

    fn object(&mut self, depth: usize) -> Result<Tree<'t>, SyntaxError> {
        let mut members = Vec::new();
        self.at += 1;
        self.space();
        if self.takes(b'}') {
            return Ok(Tree::Object(members));
        }
        loop {
            self.space();
            if self.rest().first() != Some(&b'"') {
                return Err(self.error("expected a key"));
            }
            let key = self.string()?;
            self.space();
            if !self.takes(b':') {
                return Err(self.error("expected `:`"));
            }
            members.push((key, self.value(depth)?));
            self.space();
            if self.takes(b'}') {
                return Ok(Tree::Object(members));
            }
            if !self.takes(b',') {
                return Err(self.error("expected `,` or `}`"));
            }
        }
    }

    fn list(&mut self, depth: usize) -> Result<Tree<'t>, SyntaxError> {
        let mut values = Vec::new();
        self.at += 1;
        self.space();
        if self.takes(b']') {
            return Ok(Tree::List(values));
        }
        loop {
            values.push(self.value(depth)?);
            self.space();
            if self.takes(b']') {
                return Ok(Tree::List(values));
            }
            if !self.takes(b',') {
                return Err(self.error("expected `,` or `]`"));
            }
        }
    }

    fn string(&mut self) -> Result<Cow<'t, str>, SyntaxError> {
        let start = self.at;
        let mut end = start + 1;
        let mut is_escaped = false;
        loop {
            let Some(found) = memchr::memchr2(b'"', b'\\', &self.text.as_bytes()[end.min(self.text.len())..])
            else {
                self.at = self.text.len();
                return Err(self.error(CUT_OFF));
            };
            end += found + 1;
            if self.text.as_bytes()[end - 1] == b'"' {
                break;
            }
            // What is escaped, which may be a quotation mark.
            is_escaped = true;
            end += 1;
        }
        let written = &self.text[start..end];
        let is_control = |byte: u8| byte < b' ';
        if !is_escaped && !written.bytes().any(is_control) {
            self.at = end;
            return Ok(Cow::Borrowed(&written[1..written.len() - 1]));
        }
        let read = serde_json::from_str::<&str>(written).map(Cow::Borrowed);
        let read = read.or_else(|_| serde_json::from_str::<String>(written).map(Cow::Owned));
        let read = read.map_err(|_| self.error("a string with a control character or a wrong escape"))?;
        self.at = end;
        Ok(read)
    }

    fn number(&mut self) -> Result<Tree<'t>, SyntaxError> {
        let is_part = |byte: &&u8| matches!(byte, b'-' | b'+' | b'.' | b'0'..=b'9' | b'e' | b'E');
        let length = self.rest().iter().take_while(is_part).count();
        let written = &self.text[self.at..self.at + length];
        if let Some(value) = plain_integer(written.as_bytes()) {
            self.at += length;
            return Ok(Tree::Int(value.into()));
        }
        let tree = match serde_json::from_str::<serde_json::Number>(written) {
            Ok(number) => match (number.as_u64(), number.as_i64(), number.as_f64()) {
                (Some(value), ..) => Tree::Int(value.into()),
                (_, Some(value), _) => Tree::Int(value.into()),
                (.., value) => Tree::Float(value.unwrap_or(f64::NAN), written),
            },
            Err(_) if serde_json::from_str::<IgnoredAny>(written).is_ok() => Tree::Huge(written),
            Err(_) => return Err(self.error("a number that isn't JSON's")),
        };
        self.at += length;
        Ok(tree)
    }

    fn word(&mut self) -> Result<Tree<'t>, SyntaxError> {
        for (word, tree) in [
            ("null", Tree::Null),
            ("true", Tree::Bool(true)),
            ("false", Tree::Bool(false)),
            ("NaN", Tree::Token("NaN")),
            ("Infinity", Tree::Token("Infinity")),
            ("-Infinity", Tree::Token("-Infinity")),
        ] {
            if self.rest().starts_with(word.as_bytes()) {
                self.at += word.len();
                return Ok(tree);
            }
            if !self.rest().is_empty() && word.as_bytes().starts_with(self.rest()) {
                self.at = self.text.len();
                return Err(self.error(CUT_OFF));
            }
        }
        Err(self.error("expected a value"))
    }
}
