//! Text of fixed size: PX4's `char[N]`.

use core::fmt;
use core::str::FromStr;

/// Text in `N` bytes, ended by a NUL unless it fills them all: a PX4 field of type `char[N]`.
///
/// Firmware may send bytes that are no UTF-8: they are kept, and [`as_str`](Self::as_str) says so.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Text<const N: usize>(pub [u8; N]);

impl<const N: usize> Text<N> {
    /// The bytes before the first NUL.
    pub fn bytes(&self) -> &[u8] {
        self.0.split(|byte| *byte == 0).next().unwrap_or(&[])
    }

    /// The text before the first NUL; an error where it is no UTF-8.
    pub fn as_str(&self) -> Result<&str, core::str::Utf8Error> {
        core::str::from_utf8(self.bytes())
    }
}

impl<const N: usize> Default for Text<N> {
    fn default() -> Self {
        Self([0; N])
    }
}

/// The text in quotes, with bytes that are no UTF-8 as escapes.
impl<const N: usize> fmt::Debug for Text<N> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "\"{}\"", self.bytes().escape_ascii())
    }
}

/// Why a text doesn't become a [`Text`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextError {
    /// It has more bytes than there is room for.
    TooLong {
        /// Bytes of the text.
        len: usize,
        /// Bytes of the field.
        room: usize,
    },
    /// It holds a NUL, which would end it.
    Nul,
}

impl fmt::Display for TextError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLong { len, room } => write!(formatter, "a text of {len} bytes where {room} fit"),
            Self::Nul => formatter.write_str("a NUL in a text, which ends it"),
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
    fn text_ends_at_the_first_nul_or_fills_all() {
        assert_eq!(Text(*b"ab\0c").as_str(), Ok("ab"));
        assert_eq!(Text(*b"abcd").as_str(), Ok("abcd"));
        assert_eq!("ab".parse(), Ok(Text(*b"ab\0")));
        assert_eq!("abcd".parse::<Text<3>>(), Err(TextError::TooLong { len: 4, room: 3 }));
        assert_eq!("a\0".parse::<Text<3>>(), Err(TextError::Nul));
    }

    #[test]
    fn bytes_that_are_no_utf8_are_kept_and_shown() {
        let text = Text([b'a', 0xff, 0]);
        assert!(text.as_str().is_err());
        assert_eq!(format!("{text:?}"), r#""a\xff""#);
    }
}
