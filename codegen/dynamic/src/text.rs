//! The text of strings in CDR and in memory.
//!
//! ROS 2 requires UTF-8 and UTF-16, but doesn't require implementations to enforce these encodings. Invalid text is
//! therefore kept in memory, and writers restore its bytes. A `string` is stored as its CDR bytes. A `wstring` is
//! converted to UTF-8. An unpaired surrogate takes the three bytes that UTF-8 would use for its number (WTF-8).

use uavspec_runtime::Fault;
use uavspec_runtime::cdr::{ByteOrder, wide_units};

/// The constraints of a string.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    /// True for a `wstring`.
    pub(super) is_wide: bool,
    /// Maximum number of characters.
    pub(super) bound: Option<u32>,
}

impl Bounds {
    /// The maximum and the actual number of characters, if `text` is too long.
    pub(super) fn exceeded_by(self, text: &[u8]) -> Option<(u32, usize)> {
        // A text never has more characters than bytes.
        let bound = self.bound.filter(|bound| text.len() > *bound as usize)?;
        let found = characters(text).count();
        (found > bound as usize).then_some((bound, found))
    }
}

/// Reads a `string` with its NUL. Some writers omit the NUL of an empty string. In strict mode, the text must be UTF-8.
pub(super) fn read_narrow(bytes: &[u8], is_strict: bool) -> Result<&[u8], Fault> {
    let text = match bytes.split_last() {
        None => return Ok(bytes),
        Some((0, text)) if !text.contains(&0) => text,
        Some(_) => return Err(Fault::Nul),
    };
    let is_accepted = !is_strict || std::str::from_utf8(text).is_ok();
    if is_accepted { Ok(text) } else { Err(Fault::NotUnicode) }
}

/// Reads the code units of a `wstring`. Each must have at most 16 bits. In strict mode, surrogates must be paired.
pub(super) fn read_wide(bytes: &[u8], order: ByteOrder, is_strict: bool) -> Result<Vec<u8>, Fault> {
    let units = wide_units(bytes, order).collect::<Result<Vec<u16>, Fault>>()?;
    let mut text = Vec::with_capacity(units.len());
    for character in char::decode_utf16(units) {
        match character {
            Ok(character) => text.extend_from_slice(character.encode_utf8(&mut [0; 4]).as_bytes()),
            Err(_) if is_strict => return Err(Fault::NotUnicode),
            Err(error) => text.extend(bytes_of_surrogate(error.unpaired_surrogate())),
        }
    }
    Ok(text)
}

/// The code units of a `wstring` in memory. `None` if there are bytes that UTF-16 can't represent.
pub(super) fn code_units(text: &[u8]) -> Option<Vec<u16>> {
    let mut units = Vec::with_capacity(text.len());
    for character in characters(text) {
        match surrogate(character) {
            Some(unit) => units.push(unit),
            None => units.extend(std::str::from_utf8(character).ok()?.encode_utf16()),
        }
    }
    Some(units)
}

/// The characters of a string in memory. An unpaired surrogate counts as one character, and so does each other byte of
/// invalid text.
pub(crate) fn characters(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut rest = text;
    std::iter::from_fn(move || {
        let (character, after) = rest.split_at_checked(first_size(rest)?)?;
        rest = after;
        Some(character)
    })
}

/// The size of the first character in bytes.
fn first_size(text: &[u8]) -> Option<usize> {
    let size = match text.first()? {
        0xc2..=0xdf => 2,
        0xe0..=0xef => 3,
        0xf0..=0xf4 => 4,
        _ => 1,
    };
    let is_character = |bytes: &[u8]| surrogate(bytes).is_some() || std::str::from_utf8(bytes).is_ok();
    Some(if text.get(..size).is_some_and(is_character) { size } else { 1 })
}

/// The unpaired surrogate that these bytes represent, if any.
fn surrogate(bytes: &[u8]) -> Option<u16> {
    match *bytes {
        [0xed, second @ 0xa0..=0xbf, third @ 0x80..=0xbf] => {
            Some(0xd000 | (u16::from(second & 0x3f) << 6) | u16::from(third & 0x3f))
        }
        _ => None,
    }
}

fn bytes_of_surrogate(unit: u16) -> [u8; 3] {
    let [high, low] = unit.to_be_bytes();
    [0xed, 0x80 | ((high & 0x0f) << 2) | (low >> 6), 0x80 | (low & 0x3f)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wide(units: &[u32]) -> Vec<u8> {
        units.iter().flat_map(|unit| unit.to_be_bytes()).collect()
    }

    #[test]
    fn keeps_each_unpaired_surrogate() {
        for unit in 0xd800..=0xdfff_u16 {
            let bytes = bytes_of_surrogate(unit);
            assert_eq!(surrogate(&bytes), Some(unit));
            assert_eq!(code_units(&bytes), Some(vec![unit]));
            assert!(std::str::from_utf8(&bytes).is_err(), "{unit:x}");
            let read = |is_strict| read_wide(&wide(&[unit.into()]), ByteOrder::BigEndian, is_strict);
            assert_eq!(read(false).as_deref(), Ok(&bytes[..]));
            assert_eq!(read(true), Err(Fault::NotUnicode));
        }
    }

    #[test]
    fn restores_the_code_units_of_valid_and_invalid_text() {
        let units = [0x61, 0xde81, 0xd83d, 0xde81, 0, 0xd83d];
        let text = read_wide(&wide(&units), ByteOrder::BigEndian, false).expect("a text");
        assert_eq!(text, b"a\xed\xba\x81\xf0\x9f\x9a\x81\0\xed\xa0\xbd");
        let restored = code_units(&text).expect("code units");
        assert_eq!(restored.into_iter().map(u32::from).collect::<Vec<_>>(), units);
        assert_eq!(read_wide(&wide(&[0x61, 0x1_0061]), ByteOrder::BigEndian, false), Err(Fault::NotUnicode));
    }

    #[test]
    fn counts_characters_and_the_bytes_of_invalid_text() {
        let cases: [(&[u8], usize); 7] = [
            (b"", 0),
            ("né🚁".as_bytes(), 3),
            (b"a\xff\xfe", 3),
            // An incomplete character.
            (b"\xf0\x9f\x9aa", 4),
            (b"\xf0\x9f\x9a", 3),
            // A lone continuation byte, and an encoding that is too long.
            (b"\x80\xc0\x80", 3),
            (b"\xed\xa0\xbd", 1),
        ];
        for (text, expected) in cases {
            assert_eq!(characters(text).count(), expected, "{text:?}");
            assert_eq!(characters(text).collect::<Vec<_>>().concat(), text);
        }
        assert_eq!(code_units(b"a\xff"), None);
    }
}
