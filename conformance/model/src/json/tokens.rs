//! The JSON tokenizer. Tokens borrow from the input text.
//!
//! In addition to the tokens of RFC 8259, the tokenizer accepts `NaN`, `Infinity` and `-Infinity`. Readers of known
//! structures call a function for the expected token ([`Tokens::integer`], [`Tokens::takes_key`]); other readers accept
//! any token. Functions that run for each value are marked `#[inline]`, because their callers are in other modules.

use std::borrow::Cow;

use super::error::SyntaxError;
use crate::limits::MAX_DEPTH;

/// The largest number of digits for which every integer fits into 64 bits.
const MAX_DIGITS: usize = 18;

/// The largest integer up to which all integers are exact in a 64-bit float.
const MAX_EXACT: u64 = 1 << 53;

/// The largest number of decimal places for which the power of ten is exact in a 64-bit float, and fits into 64 bits.
const MAX_PLACES: usize = 19;

/// The error at the end of an incomplete text.
pub const TRUNCATED: &str = "unexpected end";

/// The error for an unknown escape.
const INVALID_ESCAPE: &str = "an invalid escape in a string";

/// The error for half of a surrogate pair. The grammar allows it, but few parsers can read it.
const UNPAIRED_SURROGATE: &str = "a `\\u` escape of an unpaired surrogate, which encodes no character,";

/// The words of JSON, and the words that some programs write for numbers that JSON can't represent.
const WORDS: [(&str, Token<'static>); 6] = [
    ("null", Token::Null),
    ("true", Token::Bool(true)),
    ("false", Token::Bool(false)),
    ("NaN", Token::NotJson("NaN")),
    ("Infinity", Token::NotJson("Infinity")),
    ("-Infinity", Token::NotJson("-Infinity")),
];

/// A position in a JSON text.
#[derive(Clone, Copy, Debug)]
pub struct Tokens<'t> {
    text: &'t str,
    at: usize,
    depth: usize,
}

/// A scalar value.
#[derive(Clone, Debug, PartialEq)]
pub enum Token<'t> {
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
    NotJson(&'static str),
    /// A string.
    Text(Cow<'t, str>),
}

/// The error from readers that accept only expected input. A slower reader then determines whether there is a problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unclear;

impl From<SyntaxError> for Unclear {
    fn from(_: SyntaxError) -> Self {
        Self
    }
}

impl<'t> Tokens<'t> {
    /// Creates a tokenizer at the start of a text.
    pub fn new(text: &'t str) -> Self {
        Self { text, at: 0, depth: 0 }
    }

    /// The offset of the next byte.
    pub fn at(&self) -> usize {
        self.at
    }

    /// The text since an earlier position.
    pub fn since(&self, start: usize) -> &'t str {
        &self.text[start..self.at]
    }

    fn rest(&self) -> &'t [u8] {
        &self.text.as_bytes()[self.at..]
    }

    /// An error at the current position.
    pub(crate) fn error(&self, problem: &'static str) -> SyntaxError {
        let problem = if self.at >= self.text.len() { TRUNCATED } else { problem };
        SyntaxError { at: self.at, problem }
    }

    /// Skips whitespace, and returns the next byte without consuming it.
    #[inline]
    pub fn peek(&mut self) -> Option<u8> {
        loop {
            let byte = *self.text.as_bytes().get(self.at)?;
            if !matches!(byte, b' ' | b'\t' | b'\n' | b'\r') {
                return Some(byte);
            }
            self.at += 1;
        }
    }

    /// Consumes this byte if it comes next.
    #[inline]
    pub(crate) fn takes(&mut self, byte: u8) -> bool {
        let is_next = self.peek() == Some(byte);
        self.at += usize::from(is_next);
        is_next
    }

    /// Checks that only whitespace follows.
    pub fn end(mut self) -> Result<(), SyntaxError> {
        if self.peek().is_none() { Ok(()) } else { Err(self.error("unexpected data after the value")) }
    }

    /// Reads an object. `read` consumes each member with its key.
    #[inline]
    pub fn object<E: From<SyntaxError>>(
        &mut self,
        read: impl FnMut(&mut Self) -> Result<(), E>,
    ) -> Result<(), E> {
        self.enclosed([b'{', b'}'], "expected `,` or `}`", read)
    }

    /// Reads an object. `read` gets each member's key and consumes the member's value.
    #[inline]
    pub fn members<E: From<SyntaxError>>(
        &mut self,
        mut read: impl FnMut(&mut Self, Cow<'t, str>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.object(|tokens| {
            let key = tokens.key()?;
            read(tokens, key)
        })
    }

    /// Reads an array. `read` consumes each element.
    #[inline]
    pub fn list<E: From<SyntaxError>>(
        &mut self,
        read: impl FnMut(&mut Self) -> Result<(), E>,
    ) -> Result<(), E> {
        self.enclosed([b'[', b']'], "expected `,` or `]`", read)
    }

    #[inline]
    fn enclosed<E: From<SyntaxError>>(
        &mut self,
        [open, close]: [u8; 2],
        expected: &'static str,
        mut read: impl FnMut(&mut Self) -> Result<(), E>,
    ) -> Result<(), E> {
        if self.peek() != Some(open) {
            return Err(self.error("unexpected value").into());
        }
        if self.depth == MAX_DEPTH {
            return Err(self.error("values are nested too deeply").into());
        }
        self.at += 1;
        self.depth += 1;
        let mut has_next = !self.takes(close);
        while has_next {
            read(self)?;
            has_next = self.has_next(close, expected)?;
        }
        self.depth -= 1;
        Ok(())
    }

    /// Consumes the separator after an item. Returns true for a comma, and false for the closing bracket.
    #[inline]
    fn has_next(&mut self, close: u8, expected: &'static str) -> Result<bool, SyntaxError> {
        match self.peek() {
            Some(byte) if byte == b',' || byte == close => {
                self.at += 1;
                Ok(byte == b',')
            }
            _ => Err(self.error(expected)),
        }
    }

    /// Reads a key and its colon.
    pub fn key(&mut self) -> Result<Cow<'t, str>, SyntaxError> {
        if self.peek() != Some(b'"') {
            return Err(self.error("expected a key"));
        }
        let key = self.text()?;
        self.colon()?;
        Ok(key)
    }

    fn colon(&mut self) -> Result<(), SyntaxError> {
        if self.takes(b':') { Ok(()) } else { Err(self.error("expected `:`")) }
    }

    /// Consumes this key and its colon if they come next, without escapes or whitespace.
    #[inline]
    pub fn takes_key(&mut self, name: &str) -> bool {
        self.peek();
        let key = self.rest().strip_prefix(b"\"").and_then(|rest| rest.strip_prefix(name.as_bytes()));
        let is_next = key.is_some_and(|rest| rest.starts_with(b"\":"));
        if is_next {
            self.at += name.len() + 3;
        }
        is_next
    }

    /// Consumes `null` if it comes next.
    #[inline]
    pub fn takes_null(&mut self) -> bool {
        let is_next = self.peek() == Some(b'n') && self.rest().starts_with(b"null");
        self.at += if is_next { 4 } else { 0 };
        is_next
    }

    /// Reads a scalar value.
    pub fn token(&mut self) -> Result<Token<'t>, SyntaxError> {
        match self.peek() {
            Some(b'"') => self.text().map(Token::Text),
            Some(b'-' | b'0'..=b'9') if !self.rest().starts_with(b"-I") => self.number(),
            _ => self.word(),
        }
    }

    /// Reads a string.
    pub fn text(&mut self) -> Result<Cow<'t, str>, SyntaxError> {
        match self.plain_text() {
            Some(text) => Ok(Cow::Borrowed(text)),
            None => self.escaped_text(),
        }
    }

    /// Reads a string without escapes. If any other value comes next, the position doesn't change.
    #[inline]
    pub fn plain_text(&mut self) -> Option<&'t str> {
        if self.peek() != Some(b'"') {
            return None;
        }
        let start = self.at + 1;
        let is_special = |byte: &u8| matches!(byte, b'"' | b'\\' | ..=0x1f);
        let end = start + self.text.as_bytes()[start..].iter().position(is_special)?;
        if self.text.as_bytes()[end] != b'"' {
            return None;
        }
        self.at = end + 1;
        Some(&self.text[start..end])
    }

    #[cold]
    fn escaped_text(&mut self) -> Result<Cow<'t, str>, SyntaxError> {
        let start = self.at;
        if self.peek() != Some(b'"') {
            return Err(self.error("expected a string"));
        }
        let text = unescaped(self.quoted()?);
        text.map(Cow::Owned).map_err(|error| SyntaxError { at: start + 1 + error.at, ..error })
    }

    /// Reads a string, without its quotation marks and with escapes unchanged.
    fn quoted(&mut self) -> Result<&'t str, SyntaxError> {
        let start = self.at + 1;
        let mut end = start;
        loop {
            let rest = self.text.as_bytes().get(end..).unwrap_or_default();
            let Some(found) = memchr::memchr2(b'"', b'\\', rest) else {
                self.at = self.text.len();
                return Err(self.error(TRUNCATED));
            };
            end += found;
            if self.text.as_bytes()[end] == b'"' {
                self.at = end + 1;
                return Ok(&self.text[start..end]);
            }
            // The escaped byte may be a quotation mark.
            end += 2;
        }
    }

    /// Reads an integer of at most 18 digits, without a fraction or exponent. Callers expect a comma or a bracket next,
    /// so they detect longer numbers.
    #[inline]
    pub fn integer(&mut self) -> Option<i64> {
        self.peek();
        let (value, length) = leading_integer(self.rest())?;
        self.at += length;
        Some(value)
    }

    /// Reads a number.
    pub(crate) fn number(&mut self) -> Result<Token<'t>, SyntaxError> {
        self.peek();
        let start = self.at;
        if let Some(whole) = self.integer() {
            if !self.rest().first().copied().is_some_and(is_part) {
                return Ok(Token::Int(whole.into()));
            }
            if let Some((value, length)) = short_decimal(whole, self.rest()) {
                self.at += length;
                return Ok(Token::Float(value, self.since(start)));
            }
            self.at = start;
        }
        let length = self.rest().iter().position(|byte| !is_part(*byte)).unwrap_or(self.rest().len());
        let written = &self.text[self.at..self.at + length];
        if !is_number(written.as_bytes()) {
            return Err(self.error("invalid number"));
        }
        self.at += written.len();
        Ok(number(written))
    }

    /// Reads an array without nested brackets, and returns its text. The values aren't checked.
    pub fn flat_list(&mut self) -> Option<&'t str> {
        if self.peek() != Some(b'[') {
            return None;
        }
        let start = self.at;
        self.at += memchr::memchr(b']', self.rest())? + 1;
        Some(self.since(start))
    }

    /// Reads a word. An incomplete word at the end of the text counts as truncated.
    fn word(&mut self) -> Result<Token<'t>, SyntaxError> {
        let rest = self.rest();
        for (word, token) in &WORDS {
            if rest.starts_with(word.as_bytes()) {
                self.at += word.len();
                return Ok(token.clone());
            }
            if !rest.is_empty() && word.as_bytes().starts_with(rest) {
                self.at = self.text.len();
                return Err(self.error(TRUNCATED));
            }
        }
        Err(self.error("expected a value"))
    }

    /// Skips any strict JSON value. Checks only the syntax, and doesn't limit the depth.
    pub fn skip(&mut self) -> Result<(), Unclear> {
        let mut open = Vec::new();
        loop {
            match self.peek() {
                Some(byte @ (b'{' | b'[')) => {
                    self.at += 1;
                    // In ASCII, the code of a closing bracket is the code of the opening bracket plus two.
                    if !self.takes(byte + 2) {
                        open.push(byte + 2);
                        if byte == b'{' {
                            self.skip_key()?;
                        }
                        continue;
                    }
                }
                Some(b'"') => self.skip_text()?,
                _ if matches!(self.token()?, Token::NotJson(_)) => return Err(Unclear),
                _ => {}
            }
            loop {
                let Some(close) = open.last().copied() else { return Ok(()) };
                if !self.has_next(close, "expected `,`")? {
                    open.pop();
                    continue;
                }
                if close == b'}' {
                    self.skip_key()?;
                }
                break;
            }
        }
    }

    /// Skips any key and its colon.
    pub fn skip_key(&mut self) -> Result<(), Unclear> {
        self.skip_text()?;
        Ok(self.colon()?)
    }

    /// Skips a string. The grammar of RFC 8259 allows unpaired surrogates.
    fn skip_text(&mut self) -> Result<(), Unclear> {
        if self.plain_text().is_some() {
            return Ok(());
        }
        if self.peek() != Some(b'"') {
            return Err(Unclear);
        }
        let mut written = self.quoted()?.as_bytes();
        if written.iter().any(|byte| *byte < b' ') {
            return Err(Unclear);
        }
        while let Some(at) = memchr::memchr(b'\\', written) {
            let (letter, rest) = written[at + 1..].split_first().ok_or(Unclear)?;
            let is_escape = match letter {
                b'u' => rest
                    .first_chunk()
                    .is_some_and(|digits: &[u8; 4]| digits.iter().all(u8::is_ascii_hexdigit)),
                letter => simple_escape(*letter).is_some(),
            };
            written = if is_escape { rest } else { return Err(Unclear) };
        }
        Ok(())
    }
}

/// The integer at the start of a text, and its length. See [`Tokens::integer`].
#[inline]
fn leading_integer(text: &[u8]) -> Option<(i64, usize)> {
    let is_negative = *text.first()? == b'-';
    let digits = &text[usize::from(is_negative)..];
    let (mut value, mut length) = (0, 0);
    for digit in digits.iter().take(MAX_DIGITS).take_while(|byte| byte.is_ascii_digit()) {
        value = value * 10 + i64::from(digit - b'0');
        length += 1;
    }
    // A leading 0 must not be followed by digits, and -0 is a float.
    if length == 0 || digits[0] == b'0' && (length > 1 || is_negative) {
        return None;
    }
    let value = if is_negative { -value } else { value };
    Some((value, length + usize::from(is_negative)))
}

/// True for bytes that may appear in a number.
fn is_part(byte: u8) -> bool {
    matches!(byte, b'-' | b'+' | b'.' | b'0'..=b'9' | b'e' | b'E')
}

/// Parses a decimal number: `whole` is its integer part, and its fraction is at the start of `text`. Returns the number
/// and the length of the fraction. `None` if the general parser must read the number, for example because of an
/// exponent or too many digits. The number is the quotient of the integer of all digits and a power of ten. Both are
/// exact in 64 bits, so the quotient is correctly rounded.
fn short_decimal(whole: i64, text: &[u8]) -> Option<(f64, usize)> {
    let fraction = text.strip_prefix(b".")?;
    let (mut digits, mut power, mut places) = (whole.unsigned_abs(), 1_u64, 0);
    for digit in fraction.iter().take(MAX_PLACES).take_while(|byte| byte.is_ascii_digit()) {
        digits = digits * 10 + u64::from(digit - b'0');
        power *= 10;
        places += 1;
        if digits > MAX_EXACT {
            return None;
        }
    }
    let length = 1 + places;
    if places == 0 || text.get(length).copied().is_some_and(is_part) {
        return None;
    }
    #[allow(clippy::cast_precision_loss)] // both are exact
    let value = digits as f64 / power as f64;
    Some((if whole < 0 { -value } else { value }, length))
}

/// Resolves the escapes of a string. The location of an error is relative to the start of the string.
fn unescaped(written: &str) -> Result<String, SyntaxError> {
    if let Some(at) = written.bytes().position(|byte| byte < b' ') {
        return Err(SyntaxError { at, problem: "a control character in a string" });
    }
    let mut text = String::with_capacity(written.len());
    let mut rest = written;
    while let Some((plain, escape)) = rest.split_once('\\') {
        text.push_str(plain);
        let letter = escape.as_bytes().first().copied().unwrap_or_default();
        let decoded = if letter == b'u' {
            code_point(escape)
        } else {
            simple_escape(letter).map(|character| (character, 1)).ok_or(INVALID_ESCAPE)
        };
        let at = written.len() - escape.len() - 1;
        let (character, length) = decoded.map_err(|problem| SyntaxError { at, problem })?;
        text.push(character);
        rest = &escape[length..];
    }
    text.push_str(rest);
    Ok(text)
}

/// The character of a single-letter escape.
fn simple_escape(letter: u8) -> Option<char> {
    Some(match letter {
        b'"' | b'\\' | b'/' => letter.into(),
        b'b' => '\u{8}',
        b'f' => '\u{c}',
        b'n' => '\n',
        b'r' => '\r',
        b't' => '\t',
        _ => return None,
    })
}

/// Decodes a `\u` escape, or two escapes that form a surrogate pair. Returns the character and the length of the
/// escapes in bytes, or a problem.
fn code_point(escape: &str) -> Result<(char, usize), &'static str> {
    let unit = |at: usize| {
        let digits =
            escape.get(at..at + 4).filter(|digits| digits.bytes().all(|byte| byte.is_ascii_hexdigit()))?;
        u16::from_str_radix(digits, 16).ok()
    };
    let first = unit(1).ok_or(INVALID_ESCAPE)?;
    if let Some(character) = char::from_u32(first.into()) {
        return Ok((character, 5));
    }
    let second = unit(7).filter(|_| escape[5..].starts_with("\\u"));
    let units = [Some(first), second].into_iter().flatten();
    let character = char::decode_utf16(units).next().and_then(Result::ok).ok_or(UNPAIRED_SURROGATE)?;
    Ok((character, 11))
}

/// The number of digits at the start of a text.
fn digits(text: &[u8]) -> usize {
    text.iter().position(|byte| !byte.is_ascii_digit()).unwrap_or(text.len())
}

/// True if a text is a number according to RFC 8259, section 6.
fn is_number(text: &[u8]) -> bool {
    let text = text.strip_prefix(b"-").unwrap_or(text);
    let (whole, mut rest) = text.split_at(digits(text));
    if let Some(fraction) = rest.strip_prefix(b".") {
        let length = digits(fraction);
        rest = if length > 0 { &fraction[length..] } else { rest };
    }
    if let [b'e' | b'E', exponent @ ..] = rest {
        let exponent = exponent.strip_prefix(b"+").or(exponent.strip_prefix(b"-")).unwrap_or(exponent);
        let length = digits(exponent);
        rest = if length > 0 { &exponent[length..] } else { rest };
    }
    !whole.is_empty() && (whole == b"0" || whole[0] != b'0') && rest.is_empty()
}

/// The value of a number.
fn number(written: &str) -> Token<'_> {
    let is_integer = written != "-0" && !written.bytes().any(|byte| matches!(byte, b'.' | b'e' | b'E'));
    let fits = |value: &i128| (i64::MIN.into()..=u64::MAX.into()).contains(value);
    if is_integer && let Some(value) = written.parse().ok().filter(fits) {
        return Token::Int(value);
    }
    match written.parse::<f64>() {
        Ok(value) if value.is_finite() => Token::Float(value, written),
        _ => Token::Huge(written),
    }
}

#[cfg(test)]
mod tests;
