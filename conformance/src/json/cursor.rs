//! Goes through a text of JSON as programs write it, without keeping anything of it.
//!
//! It knows less than [`Tree`](super::Tree): no escapes in strings, no fractions but where they are asked for, no numbers of
//! more than 18 digits. What it doesn't know is none, and the tree says what that is; what it does know, it reads as the tree
//! does. What is called with each value is marked to be inlined: its callers are in other modules.

/// How many digits an integer has at most, so that each fits in 64 bits.
const MAX_DIGITS: usize = 18;

/// A place in a text.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cursor<'t> {
    text: &'t str,
    at: usize,
}

/// A value that holds no others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Token<'t> {
    /// `null`.
    Null,
    /// `true` or `false`.
    Bool(bool),
    /// An integer, written as one.
    Int(i64),
    /// A string.
    Text(&'t str),
}

/// A key of an object, without anything to escape, as it is looked for.
#[derive(Clone, Debug)]
pub(crate) struct Key {
    /// With its quotation marks and the colon.
    text: Box<[u8]>,
    /// The same as a number of 16 bytes, and which of them count; none where there are more.
    start: u128,
    mask: u128,
}

impl Key {
    /// The key of a member of this name.
    pub(crate) fn new(name: &str) -> Self {
        let text = format!("\"{name}\":").into_bytes();
        let mut start = [0; 16];
        let mut mask = [0; 16];
        if let (Some(start), Some(mask)) = (start.get_mut(..text.len()), mask.get_mut(..text.len())) {
            start.copy_from_slice(&text);
            mask.fill(u8::MAX);
        }
        Self { text: text.into(), start: u128::from_le_bytes(start), mask: u128::from_le_bytes(mask) }
    }
}

impl<'t> Cursor<'t> {
    /// At the beginning.
    pub(crate) fn new(text: &'t str) -> Self {
        Self { text, at: 0 }
    }

    /// The next byte that is no space. It isn't taken.
    #[inline]
    pub(crate) fn next(&mut self) -> Option<u8> {
        loop {
            let byte = *self.text.as_bytes().get(self.at)?;
            if !matches!(byte, b' ' | b'\t' | b'\n' | b'\r') {
                return Some(byte);
            }
            self.at += 1;
        }
    }

    /// Whether nothing follows.
    pub(crate) fn is_at_end(&mut self) -> bool {
        self.next().is_none()
    }

    /// Takes this byte, if it comes next.
    #[inline]
    pub(crate) fn takes(&mut self, byte: u8) -> bool {
        let is_next = self.next() == Some(byte);
        self.at += usize::from(is_next);
        is_next
    }

    /// Takes a comma, and says that more follows, or takes what closes the object or list.
    #[inline]
    pub(crate) fn goes_on(&mut self, close: u8) -> Option<bool> {
        let byte = self.next().filter(|byte| *byte == b',' || *byte == close)?;
        self.at += 1;
        Some(byte == b',')
    }

    /// A string without escapes.
    pub(crate) fn text(&mut self) -> Option<&'t str> {
        if !self.takes(b'"') {
            return None;
        }
        let rest = &self.text.as_bytes()[self.at..];
        let mut length = 0;
        while let Some(chunk) = rest[length..].first_chunk() {
            let plain = plain_bytes(*chunk);
            length += plain;
            if plain < 8 {
                break;
            }
        }
        length += rest[length..].iter().position(|byte| is_special(*byte))?;
        let text = &self.text[self.at..self.at + length];
        self.at += length + 1;
        (rest[length] == b'"').then_some(text)
    }

    /// A key, and the colon behind it.
    pub(crate) fn key(&mut self) -> Option<&'t str> {
        let key = self.text()?;
        self.takes(b':').then_some(key)
    }

    /// Takes this key and the colon behind it, if they come next, and as closely as programs write them.
    #[inline]
    pub(crate) fn takes_key(&mut self, key: &Key) -> bool {
        self.next();
        let rest = &self.text.as_bytes()[self.at..];
        let is_next = match rest.first_chunk() {
            Some(start) if key.mask != 0 => u128::from_le_bytes(*start) & key.mask == key.start,
            _ => rest.starts_with(&key.text),
        };
        if is_next {
            self.at += key.text.len();
        }
        is_next
    }

    /// Each member of an object, whose value `read` takes.
    pub(crate) fn members(&mut self, mut read: impl FnMut(&mut Self, &'t str) -> Option<()>) -> Option<()> {
        if !self.takes(b'{') {
            return None;
        }
        if self.takes(b'}') {
            return Some(());
        }
        loop {
            let key = self.key()?;
            read(self, key)?;
            if !self.goes_on(b'}')? {
                return Some(());
            }
        }
    }

    /// Takes `null`, if it comes next.
    #[inline]
    pub(crate) fn takes_null(&mut self) -> bool {
        self.next() == Some(b'n') && self.word("null", Token::Null).is_some()
    }

    /// A value that holds no others.
    pub(crate) fn token(&mut self) -> Option<Token<'t>> {
        match self.next()? {
            b'"' => self.text().map(Token::Text),
            b'n' => self.word("null", Token::Null),
            b't' => self.word("true", Token::Bool(true)),
            b'f' => self.word("false", Token::Bool(false)),
            _ => self.integer().map(Token::Int),
        }
    }

    /// An integer, written as one. Who takes it sees by what follows that it isn't longer.
    #[inline]
    pub(crate) fn integer(&mut self) -> Option<i64> {
        let is_negative = self.next()? == b'-';
        let rest = &self.text.as_bytes()[self.at + usize::from(is_negative)..];
        let (mut value, mut length) = rest.first_chunk().map_or((0, 0), |start| first_digits(*start));
        if length == 0 || length == 8 {
            for digit in
                rest[length..].iter().take(MAX_DIGITS - length).take_while(|byte| byte.is_ascii_digit())
            {
                value = value * 10 + u64::from(digit - b'0');
                length += 1;
            }
        }
        // Nothing may stand behind a leading 0; and -0 is a float.
        let is_plain = length > 0 && (rest[0] != b'0' || length == 1 && !is_negative);
        let value = i64::try_from(value).ok().filter(|_| is_plain)?;
        self.at += length + usize::from(is_negative);
        Some(if is_negative { -value } else { value })
    }

    /// A list that holds no others, nor strings with brackets, as it is written.
    pub(crate) fn list(&mut self) -> Option<&'t str> {
        if self.next() != Some(b'[') {
            return None;
        }
        let rest = &self.text[self.at..];
        let (list, _) = rest.split_at(memchr::memchr(b']', rest.as_bytes())? + 1);
        self.at += list.len();
        Some(list)
    }

    /// A number without a sign and without an exponent.
    pub(crate) fn decimal(&mut self) -> Option<f64> {
        self.next()?;
        let rest = &self.text.as_bytes()[self.at..];
        let whole = digits(rest);
        let is_whole = whole > 0 && (rest[0] != b'0' || whole == 1);
        let fraction = if rest.get(whole) == Some(&b'.') { 1 + digits(&rest[whole + 1..]) } else { 0 };
        let length = whole + fraction;
        // A point has digits behind it.
        if !is_whole || fraction == 1 || rest.get(length).is_some_and(|byte| is_of_number(*byte)) {
            return None;
        }
        let number = self.text[self.at..self.at + length].parse().ok()?;
        self.at += length;
        Some(number)
    }

    /// Where it is.
    pub(crate) fn at(&self) -> usize {
        self.at
    }

    /// What lies between an earlier place and this one.
    pub(crate) fn since(&self, start: usize) -> &'t str {
        &self.text[start..self.at]
    }

    fn word(&mut self, word: &str, token: Token<'t>) -> Option<Token<'t>> {
        self.text.as_bytes()[self.at..].starts_with(word.as_bytes()).then(|| self.at += word.len())?;
        Some(token)
    }
}

/// One byte in each of eight.
const ONES: u64 = 0x0101_0101_0101_0101;

/// Whether a byte ends a string, or is none that a string without escapes can have.
fn is_special(byte: u8) -> bool {
    matches!(byte, b'"' | b'\\' | ..=0x1f)
}

/// How many of eight bytes stand before the first that is special in a string. All are looked at together: what is
/// subtracted from a byte carries over to the next one only where that byte is one that is looked for.
fn plain_bytes(bytes: [u8; 8]) -> usize {
    let word = u64::from_le_bytes(bytes);
    let below = |word: u64, least: u8| word.wrapping_sub(ONES * u64::from(least)) & !word;
    let is_byte = |byte: u8| below(word ^ (ONES * u64::from(byte)), 1);
    let found = (below(word, b' ') | is_byte(b'"') | is_byte(b'\\')) & (ONES * 0x80);
    found.trailing_zeros() as usize / 8
}

/// The number that the digits make with which eight bytes begin, and how many these are. All are looked at together.
fn first_digits(bytes: [u8; 8]) -> (u64, usize) {
    let digits = u64::from_le_bytes(bytes) ^ (ONES * u64::from(b'0'));
    // Of what is no digit, the upper half isn't 0, or isn't any more once 6 is added.
    let others = (digits | digits.wrapping_add(ONES * 6)) & (ONES * 0xf0);
    let length = others.trailing_zeros() as usize / 8;
    if length == 0 {
        return (0, 0);
    }
    // Zeros are put before them; then two become a number, then four, then eight. The first is in the lowest byte.
    let digits = digits << (64 - 8 * length);
    let pairs = (digits & (ONES * 0x0f)) * 10 + (digits >> 8);
    let pairs = pairs & 0x00ff_00ff_00ff_00ff;
    let fours = (pairs * 100 + (pairs >> 16)) & 0x0000_ffff_0000_ffff;
    ((fours * 10_000 + (fours >> 32)) & 0xffff_ffff, length)
}

/// How many digits a text begins with.
fn digits(text: &[u8]) -> usize {
    text.iter().position(|byte| !byte.is_ascii_digit()).unwrap_or(text.len())
}

/// Whether a byte can be part of a number.
fn is_of_number(byte: u8) -> bool {
    matches!(byte, b'0'..=b'9' | b'.' | b'e' | b'E' | b'+' | b'-')
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::Tree;
    use super::*;

    /// What a tree says of a text that is one token.
    fn read(text: &str) -> Option<Token<'_>> {
        let mut cursor = Cursor::new(text);
        cursor.token().filter(|_| cursor.is_at_end())
    }

    fn is_same(token: Token<'_>, tree: &Tree<'_>) -> bool {
        match (token, tree) {
            (Token::Null, Tree::Null) => true,
            (Token::Bool(one), Tree::Bool(other)) => one == *other,
            (Token::Int(one), Tree::Int(other)) => i128::from(one) == *other,
            (Token::Text(one), Tree::Text(other)) => one == other,
            _ => false,
        }
    }

    #[test]
    fn what_programs_write_is_read() {
        assert_eq!(read("-1790000000000"), Some(Token::Int(-1_790_000_000_000)));
        assert_eq!(read(" 0 "), Some(Token::Int(0)));
        assert_eq!(read("true"), Some(Token::Bool(true)));
        assert_eq!(read("\"Möwe\""), Some(Token::Text("Möwe")));
        assert_eq!(Cursor::new("1790000000.25,").decimal(), Some(1_790_000_000.25));
    }

    #[test]
    fn eight_bytes_are_looked_at_as_one_by_one() {
        for text in [
            "12345678",
            "1234567,",
            "7,------",
            "00000009",
            "9e999999",
            "/0123456",
            ":0123456",
            "\u{e4}123456",
        ] {
            let bytes: [u8; 8] = text.as_bytes().try_into().expect("eight bytes");
            let length = digits(&bytes);
            let value = text[..length].parse().unwrap_or(0);
            assert_eq!(first_digits(bytes), (value, length), "{text}");
        }
        for at in 0..8 {
            for byte in 0..=u8::MAX {
                for other in [b'a', 0xff, b'#', b']', b' '] {
                    let mut bytes = [other; 8];
                    bytes[at] = byte;
                    let expected = if is_special(byte) { at } else { 8 };
                    assert_eq!(plain_bytes(bytes), expected, "{bytes:?}");
                }
            }
        }
    }

    #[test]
    fn keys_are_told_apart_whatever_their_length() {
        for name in ["", "id", "velocityNED13", "velocityNED_14", "a_longer_name_than_16_bytes"] {
            let key = Key::new(name);
            let text = format!(" \"{name}\":7}}");
            for text in [text.clone(), text.clone() + "                "] {
                let mut cursor = Cursor::new(&text);
                assert!(cursor.takes_key(&key) && cursor.integer() == Some(7), "{text}");
            }
            for other in
                [format!("\"{name}x\":7"), format!("\"{name}\" :7               "), format!("\"{name}")]
            {
                assert!(!Cursor::new(&other).takes_key(&key), "{other}");
            }
        }
    }

    #[test]
    fn what_is_seldom_is_left_to_the_tree() {
        let seldom =
            ["-0", "01", "1.0", "1e3", "-", "", "1234567890123456789", "\"\\n\"", "\"", "nul", "[1]", "{}"];
        assert_eq!(seldom.map(read), [None; 12]);
        let seldom = ["01", ".5", "5.", "-1", "1e9", "1.5e3", "x", ""];
        assert_eq!(seldom.map(|text| Cursor::new(text).decimal()), [None; 8]);
    }

    proptest! {
        #[test]
        fn what_is_read_is_what_the_tree_has(text in "[-0-9.eE]{1,20}|\"[ -~\u{e4}\\\\]{0,8}\"|[a-z]{3,5}| ?-?[0-9]{1,20} ?") {
            if let Some(token) = read(&text) {
                prop_assert!(is_same(token, &Tree::read(&text).expect("JSON")), "{text}");
            }
            let mut cursor = Cursor::new(&text);
            if let Some(number) = cursor.decimal().filter(|_| cursor.is_at_end()) {
                let tree = Tree::read(&text).expect("JSON");
                let is_same = match tree {
                    #[allow(clippy::cast_precision_loss)] // as both do
                    Tree::Int(value) => (value as f64).to_bits() == number.to_bits(),
                    Tree::Float(value, _) => value.to_bits() == number.to_bits(),
                    _ => false,
                };
                prop_assert!(is_same, "{text}");
            }
        }
    }
}
