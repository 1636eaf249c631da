//! Fixed-size text: PX4's `char[N]`.

use core::fmt;
use core::str::FromStr;

/// Text of at most `N` bytes: a PX4 field of type `char[N]`. Shorter text ends with a NUL.
///
/// Firmware may send invalid UTF-8. The bytes are preserved, and [`as_str`](Self::as_str) returns an error.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Text<const N: usize>(pub [u8; N]);

impl<const N: usize> Text<N> {
    /// The bytes before the first NUL.
    pub fn bytes(&self) -> &[u8] {
        self.0.split(|byte| *byte == 0).next().unwrap_or(&[])
    }

    /// The text before the first NUL, or an error if it is not valid UTF-8.
    pub fn as_str(&self) -> Result<&str, core::str::Utf8Error> {
        core::str::from_utf8(self.bytes())
    }

    /// The text with space for `M` bytes. A longer text is cut before the first character that doesn't fit.
    pub fn resized<const M: usize>(&self) -> Text<M> {
        let bytes = self.bytes();
        let is_start = |at: usize| bytes.get(at).is_none_or(|byte| byte & 0xC0 != 0x80);
        // A character has at most four bytes. If no character starts within these bytes, the text isn't UTF-8 and is
        // cut anywhere.
        let room = bytes.len().min(M);
        let end = (room.saturating_sub(3)..=room).rev().find(|at| is_start(*at)).unwrap_or(room);
        let mut resized = [0; M];
        for (to, from) in resized.iter_mut().zip(&bytes[..end]) {
            *to = *from;
        }
        Text(resized)
    }
}

impl<const N: usize> Default for Text<N> {
    fn default() -> Self {
        Self([0; N])
    }
}

/// Formats the text in quotes. Bytes other than printable ASCII are escaped.
impl<const N: usize> fmt::Debug for Text<N> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "\"{}\"", self.bytes().escape_ascii())
    }
}

/// An error while converting a string to a [`Text`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextError {
    /// The string doesn't fit.
    TooLong {
        /// Size of the string in bytes.
        len: usize,
        /// Size of the field in bytes.
        room: usize,
    },
    /// The string contains a NUL, which would end the text.
    Nul,
}

impl fmt::Display for TextError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLong { len, room } => {
                write!(formatter, "expected at most {room} bytes of text, found {len}")
            }
            Self::Nul => formatter.write_str("expected text without NUL"),
        }
    }
}

#[cfg(feature = "std")]
impl std::error::Error for TextError {}

impl<const N: usize> FromStr for Text<N> {
    type Err = TextError;

    fn from_str(text: &str) -> Result<Self, TextError> {
        let bytes = text.as_bytes();
        if bytes.contains(&0) {
            return Err(TextError::Nul);
        }
        let mut field = [0; N];
        let too_long = TextError::TooLong { len: bytes.len(), room: N };
        field.get_mut(..bytes.len()).ok_or(too_long)?.copy_from_slice(bytes);
        Ok(Self(field))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::format;

    #[test]
    fn text_ends_at_the_first_nul_or_at_the_end_of_the_field() {
        assert_eq!(Text(*b"ab\0c").as_str(), Ok("ab"));
        assert_eq!(Text(*b"abcd").as_str(), Ok("abcd"));
        assert_eq!("ab".parse(), Ok(Text(*b"ab\0")));
        assert_eq!("abcd".parse::<Text<3>>(), Err(TextError::TooLong { len: 4, room: 3 }));
        assert_eq!("a\0".parse::<Text<3>>(), Err(TextError::Nul));
    }

    #[test]
    fn a_text_is_cut_between_characters() {
        assert_eq!(Text(*b"ab\0c").resized::<6>(), Text(*b"ab\0\0\0\0"));
        let text: Text<8> = "aäö".parse().expect("a text");
        assert_eq!(text.resized::<5>().as_str(), Ok("aäö"));
        assert_eq!(text.resized::<4>().as_str(), Ok("aä"));
        assert_eq!(text.resized::<3>().as_str(), Ok("aä"));
        assert_eq!(text.resized::<2>().as_str(), Ok("a"));
        assert_eq!(Text([0x80; 6]).resized::<4>(), Text([0x80; 4]));
        let wide: Text<4> = "😀".parse().expect("a text");
        assert_eq!(wide.resized::<3>().as_str(), Ok(""));
    }

    #[test]
    fn invalid_utf8_is_preserved_and_displayed() {
        let text = Text([b'a', 0xff, 0]);
        assert!(text.as_str().is_err());
        assert_eq!(format!("{text:?}"), r#""a\xff""#);
    }
}
