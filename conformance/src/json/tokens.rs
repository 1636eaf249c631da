//! The JSON tokenizer: it reads one text and lends its tokens, without copying them.
//!
//! It accepts RFC 8259 plus `NaN`, `Infinity` and `-Infinity`, which get a token of their own. Readers of known shapes ask
//! for what they expect ([`Tokens::integer`], [`Tokens::takes_key`]); the others ask for any token. Functions that are called
//! for each value are marked `#[inline]` because their callers are in other modules.

use std::borrow::Cow;

use super::SyntaxError;
use super::scan::{digits, first_digits, plain_length};

/// The maximum nesting depth, equal to that of `serde_json`.
const MAX_DEPTH: usize = 127;

/// The maximum number of digits of an integer that fits in 64 bits whatever its digits are.
const MAX_DIGITS: usize = 18;

/// The error at the end of a text that stops too early.
pub(crate) const CUT_OFF: &str = "it is cut off";

/// The tokens that are not JSON although programs write them.
const NOT_JSON: [&str; 3] = ["NaN", "Infinity", "-Infinity"];

/// A position in a JSON text.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tokens<'t> {
    text: &'t [u8],
    at: usize,
    depth: usize,
}

/// A value that holds no other values.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Token<'t> {
    /// `null`.
    Null,
    /// `true` or `false`.
    Bool(bool),
    /// An integer of at most 64 bits.
    Int(i128),
    /// Any other number, and its text.
    Float(f64, &'t str),
    /// The text of a number that exceeds a 64-bit float.
    Huge(&'t str),
    /// `NaN`, `Infinity` or `-Infinity`, which are not JSON.
    NotJson(&'static str),
    /// A string.
    Text(Cow<'t, str>),
}

/// The error of a reader that only accepts what it expects. Another reader finds out what is wrong, if anything.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Unclear;

impl From<SyntaxError> for Unclear {
    fn from(_: SyntaxError) -> Self {
        Self
    }
}

impl<'t> Tokens<'t> {
    /// The start of a text.
    pub(crate) fn new(text: &'t str) -> Self {
        Self::of_bytes(text.as_bytes())
    }

    /// The start of a text that may not be UTF-8. A string that is not is an error.
    pub(crate) fn of_bytes(text: &'t [u8]) -> Self {
        Self { text, at: 0, depth: 0 }
    }

    /// The offset of the next byte.
    pub(crate) fn at(&self) -> usize {
        self.at
    }

    /// The text since an earlier position.
    pub(crate) fn since(&self, start: usize) -> &'t [u8] {
        &self.text[start..self.at]
    }

    /// An error at this position.
    pub(crate) fn error(&self, what: &'static str) -> SyntaxError {
        let what = if self.at >= self.text.len() { CUT_OFF } else { what };
        SyntaxError { at: self.at, what }
    }

    /// Skips spaces, and returns the next byte without taking it.
    #[inline]
    pub(crate) fn peek(&mut self) -> Option<u8> {
        loop {
            let byte = *self.text.get(self.at)?;
            if !matches!(byte, b' ' | b'\t' | b'\n' | b'\r') {
                return Some(byte);
            }
            self.at += 1;
        }
    }

    /// Takes this byte if it comes next.
    #[inline]
    pub(crate) fn takes(&mut self, byte: u8) -> bool {
        let is_next = self.peek() == Some(byte);
        self.at += usize::from(is_next);
        is_next
    }

    /// Checks that only spaces follow.
    pub(crate) fn end(mut self) -> Result<(), SyntaxError> {
        if self.peek().is_none() { Ok(()) } else { Err(self.error("something follows the value")) }
    }

    /// Reads an object, each of whose members `read` takes, key and all.
    #[inline]
    pub(crate) fn object<E: From<SyntaxError>>(
        &mut self,
        read: impl FnMut(&mut Self) -> Result<(), E>,
    ) -> Result<(), E> {
        self.enclosed([b'{', b'}'], "expected `,` or `}`", read)
    }

    /// Reads an object, of whose members `read` gets the keys and takes the values.
    #[inline]
    pub(crate) fn members<E: From<SyntaxError>>(
        &mut self,
        mut read: impl FnMut(&mut Self, Cow<'t, str>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.object(|tokens| {
            let key = tokens.key()?;
            read(tokens, key)
        })
    }

    /// Reads an array, each of whose elements `read` takes.
    #[inline]
    pub(crate) fn list<E: From<SyntaxError>>(
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
            return Err(self.error("expected another value").into());
        }
        if self.depth == MAX_DEPTH {
            return Err(self.error("values nest too deep").into());
        }
        self.at += 1;
        self.depth += 1;
        let mut goes_on = !self.takes(close);
        while goes_on {
            read(self)?;
            goes_on = self.goes_on(close, expected)?;
        }
        self.depth -= 1;
        Ok(())
    }

    /// Takes a comma, after which another item follows, or what closes the object or array.
    #[inline]
    fn goes_on(&mut self, close: u8, expected: &'static str) -> Result<bool, SyntaxError> {
        match self.peek() {
            Some(byte) if byte == b',' || byte == close => {
                self.at += 1;
                Ok(byte == b',')
            }
            _ => Err(self.error(expected)),
        }
    }

    /// A key and its colon.
    pub(crate) fn key(&mut self) -> Result<Cow<'t, str>, SyntaxError> {
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

    /// Takes this key and its colon if they come next, without escapes and spaces between them.
    #[inline]
    pub(crate) fn takes_key(&mut self, name: &str) -> bool {
        self.peek();
        let key =
            self.text[self.at..].strip_prefix(b"\"").and_then(|rest| rest.strip_prefix(name.as_bytes()));
        let is_next = key.is_some_and(|rest| rest.starts_with(b"\":"));
        if is_next {
            self.at += name.len() + 3;
        }
        is_next
    }

    /// Takes `null` if it comes next.
    #[inline]
    pub(crate) fn takes_null(&mut self) -> bool {
        let is_next = self.peek() == Some(b'n') && self.text[self.at..].starts_with(b"null");
        self.at += if is_next { 4 } else { 0 };
        is_next
    }

    /// A value that holds no other values.
    pub(crate) fn token(&mut self) -> Result<Token<'t>, SyntaxError> {
        match self.peek() {
            Some(b'"') => self.text().map(Token::Text),
            Some(b'-' | b'0'..=b'9') if !self.text[self.at..].starts_with(b"-I") => self.number(),
            _ => self.word(),
        }
    }

    /// A string.
    pub(crate) fn text(&mut self) -> Result<Cow<'t, str>, SyntaxError> {
        match self.plain_text() {
            Some(text) => Ok(Cow::Borrowed(text)),
            None => self.escaped_text(),
        }
    }

    /// A string without escapes. Takes nothing if it is something else.
    #[inline]
    pub(crate) fn plain_text(&mut self) -> Option<&'t str> {
        if self.peek() != Some(b'"') {
            return None;
        }
        let rest = &self.text[self.at + 1..];
        let length = plain_length(rest);
        if rest.get(length) != Some(&b'"') {
            return None;
        }
        let text = str::from_utf8(&rest[..length]).ok()?;
        self.at += length + 2;
        Some(text)
    }

    #[cold]
    fn escaped_text(&mut self) -> Result<Cow<'t, str>, SyntaxError> {
        let start = self.at;
        if self.peek() != Some(b'"') {
            return Err(self.error("expected a string"));
        }
        let written = self.quoted()?;
        let read = str::from_utf8(written).ok().and_then(unescaped);
        read.map(Cow::Owned).ok_or(SyntaxError { at: start, what: WRONG_STRING })
    }

    /// What stands between the quotation marks of a string, as it is written.
    fn quoted(&mut self) -> Result<&'t [u8], SyntaxError> {
        let start = self.at + 1;
        let mut end = start;
        loop {
            let rest = self.text.get(end..).unwrap_or_default();
            let Some(found) = memchr::memchr2(b'"', b'\\', rest) else {
                self.at = self.text.len();
                return Err(self.error(CUT_OFF));
            };
            end += found;
            if self.text[end] == b'"' {
                self.at = end + 1;
                return Ok(&self.text[start..end]);
            }
            // The escaped byte may be a quotation mark.
            end += 2;
        }
    }

    /// An integer of at most 18 digits, without a fraction and an exponent. A caller that expects a comma or a bracket next
    /// sees that the number is not longer.
    #[inline]
    pub(crate) fn integer(&mut self) -> Option<i64> {
        let is_negative = self.peek()? == b'-';
        let rest = &self.text[self.at + usize::from(is_negative)..];
        let (mut value, mut length) = rest.first_chunk().map_or((0, 0), |start| first_digits(*start));
        if length == 0 || length == 8 {
            for digit in
                rest[length..].iter().take(MAX_DIGITS - length).take_while(|byte| byte.is_ascii_digit())
            {
                value = value * 10 + u64::from(digit - b'0');
                length += 1;
            }
        }
        // Nothing may follow a leading 0; and -0 is a float.
        let is_plain = length > 0 && (rest[0] != b'0' || length == 1 && !is_negative);
        let value = i64::try_from(value).ok().filter(|_| is_plain)?;
        self.at += length + usize::from(is_negative);
        Some(if is_negative { -value } else { value })
    }

    /// A number.
    pub(crate) fn number(&mut self) -> Result<Token<'t>, SyntaxError> {
        let start = self.at;
        let is_part = |byte: &u8| matches!(byte, b'-' | b'+' | b'.' | b'0'..=b'9' | b'e' | b'E');
        if let Some(value) = self.integer() {
            if !self.text.get(self.at).is_some_and(is_part) {
                return Ok(Token::Int(value.into()));
            }
            self.at = start;
        }
        self.peek();
        let rest = &self.text[self.at..];
        let written = &rest[..rest.iter().position(|byte| !is_part(byte)).unwrap_or(rest.len())];
        let written = str::from_utf8(written).ok().filter(|text| is_number(text.as_bytes()));
        let written = written.ok_or_else(|| self.error("a number that isn't JSON's"))?;
        self.at += written.len();
        Ok(number(written))
    }

    /// An array of values that hold no brackets, as it is written. The values are not read.
    pub(crate) fn flat_list(&mut self) -> Option<&'t str> {
        if self.peek() != Some(b'[') {
            return None;
        }
        let rest = &self.text[self.at..];
        let list = str::from_utf8(&rest[..=memchr::memchr(b']', rest)?]).ok()?;
        self.at += list.len();
        Some(list)
    }

    /// A word. Part of one at the end of the text is cut off.
    fn word(&mut self) -> Result<Token<'t>, SyntaxError> {
        let rest = &self.text[self.at..];
        let json = [("null", Token::Null), ("true", Token::Bool(true)), ("false", Token::Bool(false))];
        for (word, token) in json.into_iter().chain(NOT_JSON.map(|word| (word, Token::NotJson(word)))) {
            if rest.starts_with(word.as_bytes()) {
                self.at += word.len();
                return Ok(token);
            }
            if !rest.is_empty() && word.as_bytes().starts_with(rest) {
                self.at = self.text.len();
                return Err(self.error(CUT_OFF));
            }
        }
        Err(self.error("expected a value"))
    }

    /// Takes any value of strict JSON, however deep it nests, and looks at nothing but its syntax.
    pub(crate) fn skip(&mut self) -> Result<(), Unclear> {
        let mut open = Vec::new();
        loop {
            match self.peek() {
                Some(byte @ (b'{' | b'[')) => {
                    self.at += 1;
                    // The closing brackets come two after the opening ones in ASCII.
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
                if !self.goes_on(close, "expected `,`")? {
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

    /// Takes any key and its colon.
    pub(crate) fn skip_key(&mut self) -> Result<(), Unclear> {
        self.skip_text()?;
        Ok(self.colon()?)
    }

    /// Takes a string, which may hold half a surrogate pair: RFC 8259 has them in its grammar.
    fn skip_text(&mut self) -> Result<(), Unclear> {
        if self.plain_text().is_some() {
            return Ok(());
        }
        if self.peek() != Some(b'"') {
            return Err(Unclear);
        }
        let mut written = self.quoted()?;
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

const WRONG_STRING: &str = "a string with a control character or a wrong escape";

/// The text that a string with escapes stands for.
fn unescaped(written: &str) -> Option<String> {
    if written.bytes().any(|byte| byte < b' ') {
        return None;
    }
    let mut text = String::with_capacity(written.len());
    let mut rest = written;
    while let Some((plain, escape)) = rest.split_once('\\') {
        text.push_str(plain);
        let letter = *escape.as_bytes().first()?;
        let (character, length) =
            if letter == b'u' { code_point(escape)? } else { (simple_escape(letter)?, 1) };
        text.push(character);
        rest = &escape[length..];
    }
    text.push_str(rest);
    Some(text)
}

/// The character that a letter behind a backslash stands for.
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

/// The character that `u` and four hex digits stand for, or two such with a backslash between them; and their length.
fn code_point(escape: &str) -> Option<(char, usize)> {
    let unit = |at: usize| {
        let digits =
            escape.get(at..at + 4).filter(|digits| digits.bytes().all(|byte| byte.is_ascii_hexdigit()))?;
        u16::from_str_radix(digits, 16).ok()
    };
    let first = unit(1)?;
    if let Some(character) = char::from_u32(first.into()) {
        return Some((character, 5));
    }
    let second = unit(7).filter(|_| escape[5..].starts_with("\\u"))?;
    let character = char::decode_utf16([first, second]).next()?.ok()?;
    Some((character, 11))
}

/// True if a text is a number by RFC 8259, section 6.
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

/// The number that a text stands for, which is one.
fn number(written: &str) -> Token<'_> {
    let is_integer = written != "-0" && !written.contains(['.', 'e', 'E']);
    let fits = |value: &i128| (i64::MIN.into()..=u64::MAX.into()).contains(value);
    if let Some(value) = written.parse().ok().filter(|value| is_integer && fits(value)) {
        return Token::Int(value);
    }
    match written.parse::<f64>() {
        Ok(value) if value.is_finite() => Token::Float(value, written),
        _ => Token::Huge(written),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use serde::de::IgnoredAny;
    use serde_json::{Number, Value};

    use super::super::Tree;
    use super::*;

    /// Texts that are nearly JSON, and often are.
    fn texts() -> impl Strategy<Value = String> {
        let leaf = prop_oneof![
            "[-0-9.eE+]{1,22}",
            "-?(0|[1-9][0-9]{0,20})(\\.[0-9]{1,3})?([eE][-+]?[0-9]{1,3})?",
            "\"[ -~\u{e4}\u{1F6F8}]{0,12}\"",
            "\"([ -!a-c\u{e4}]|\\\\[\"\\\\/bfnrtux]|\\\\u[0-9a-fA-F]{3,4}|\\\\ud[89cd]00){0,6}\"",
            prop::sample::select(
                &["null", "true", "false", "NaN", "-Infinity", "nul", "-Inf", "\"\u{1}\"", "\""][..]
            )
            .prop_map(str::to_owned),
        ];
        leaf.prop_recursive(4, 24, 4, |inner| {
            let separator = prop::sample::select(&[",", " , ", ",\t\n\r", ",,", ""][..]);
            let list = (prop::collection::vec(inner.clone(), 0..4), separator.clone())
                .prop_map(|(values, separator)| format!("[{}]", values.join(separator)));
            let member = ("\"[ab\\\\n]{0,3}\"", prop::sample::select(&[":", " : ", ""][..]), inner)
                .prop_map(|(key, colon, value)| key + colon + &value);
            let object = (prop::collection::vec(member, 0..4), separator)
                .prop_map(|(members, separator)| format!("{{{}}}", members.join(separator)));
            prop_oneof![list, object]
        })
    }

    /// The value that `serde_json` has for a tree; none if it has none.
    fn value(tree: &Tree<'_>) -> Option<Value> {
        Some(match tree {
            Tree::Null => Value::Null,
            Tree::Bool(value) => Value::Bool(*value),
            Tree::Int(value) => Value::Number(Number::from_i128(*value)?),
            Tree::Float(value, _) => Value::Number(Number::from_f64(*value)?),
            Tree::Huge(_) | Tree::Token(_) => return None,
            Tree::Text(text) => Value::String(text.to_string()),
            Tree::List(values) => Value::Array(values.iter().map(value).collect::<Option<_>>()?),
            Tree::Object(members) => {
                let members = members.iter().map(|(key, member)| Some((key.to_string(), value(member)?)));
                Value::Object(members.collect::<Option<_>>()?)
            }
        })
    }

    fn skips(text: &str) -> bool {
        let mut tokens = Tokens::new(text);
        tokens.skip().is_ok() && tokens.end().is_ok()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4_096))]

        #[test]
        fn accepts_the_same_texts_and_values_as_serde_json(
            text in texts(),
            cut in any::<prop::sample::Index>(),
            is_cut in prop::bool::weighted(0.2),
        ) {
            let ends: Vec<usize> = text.char_indices().map(|(at, _)| at).collect();
            let text = if is_cut { &text[..ends[cut.index(ends.len())]] } else { &text };
            let tree = Tree::read(text);
            prop_assert_eq!(tree.as_ref().ok().and_then(value), serde_json::from_str(text).ok(), "{}", text);
            prop_assert_eq!(skips(text), serde_json::from_str::<IgnoredAny>(text).is_ok(), "{}", text);
            if let Err(error) = tree {
                let is_at_end = error.at == text.len();
                prop_assert_eq!(error.what == CUT_OFF, is_at_end, "{}: {}", text, error);
                prop_assert!(text.is_char_boundary(error.at), "{}: {}", text, error);
            }
        }

        #[test]
        fn reads_an_integer_as_any_token(text in "-?[0-9]{1,20}[,.e ]?") {
            let mut tokens = Tokens::new(&text);
            if let Some(found) = tokens.integer().filter(|_| !matches!(tokens.peek(), Some(b'0'..=b'9' | b'.' | b'e'))) {
                prop_assert_eq!(Tokens::new(&text).token(), Ok(Token::Int(found.into())));
            }
        }
    }

    #[test]
    fn leaves_unusual_numbers_and_strings_to_other_readers() {
        for text in ["-0", "01", "-", "", "1234567890123456789x", "x"] {
            let mut tokens = Tokens::new(text);
            assert!(tokens.integer().is_none() || tokens.end().is_err(), "{text}");
        }
        for text in ["\"\\n\"", "\"", "\"\u{1}\"", "1"] {
            assert_eq!(Tokens::new(text).plain_text(), None, "{text}");
        }
        assert_eq!(Tokens::of_bytes(b"\"\xff\"").text().map_err(|error| error.what), Err(WRONG_STRING));
        assert_eq!(Tokens::new(" [1,\"a\"]]").flat_list(), Some("[1,\"a\"]"));
    }

    #[test]
    fn takes_a_key_only_if_it_is_the_whole_key() {
        for name in ["", "id", "velocityNED13", "a_longer_name_than_16_bytes"] {
            let text = format!(" \"{name}\":7}}");
            let mut tokens = Tokens::new(&text);
            assert!(tokens.takes_key(name) && tokens.integer() == Some(7), "{text}");
            for other in [format!("\"{name}x\":7"), format!("\"{name}\" :7"), format!("\"{name}")] {
                let mut tokens = Tokens::new(&other);
                assert!(!tokens.takes_key(name) && tokens.at() == 0, "{other}");
            }
        }
    }

    #[test]
    fn limits_the_depth_of_what_it_reads_but_not_of_what_it_skips() {
        for (depth, is_readable) in [(127, true), (128, false), (100_000, false)] {
            for [open, close] in [["[", "]"], ["{\"a\":[", "]}"]] {
                let levels = depth / open.bytes().filter(|byte| matches!(byte, b'{' | b'[')).count();
                let text = open.repeat(levels) + &close.repeat(levels);
                let is_too_deep = Tree::read(&text).is_err_and(|error| error.what == "values nest too deep");
                assert_eq!(is_too_deep, !is_readable, "{depth}");
                assert!(skips(&text), "{depth}");
            }
        }
    }
}
