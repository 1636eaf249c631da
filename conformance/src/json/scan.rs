//! Scans of text, eight bytes at a time.

/// One byte in each of eight.
const ONES: u64 = 0x0101_0101_0101_0101;

/// The number of bytes before the first that a string without escapes can't hold, or before its end.
#[inline]
pub(super) fn plain_length(text: &[u8]) -> usize {
    let mut length = 0;
    while let Some(chunk) = text[length..].first_chunk() {
        let plain = plain_bytes(*chunk);
        length += plain;
        if plain < 8 {
            return length;
        }
    }
    let rest = &text[length..];
    length + rest.iter().position(|byte| is_special(*byte)).unwrap_or(rest.len())
}

/// True if a byte ends a string, or can't be in a string without escapes.
fn is_special(byte: u8) -> bool {
    matches!(byte, b'"' | b'\\' | ..=0x1f)
}

/// The number of bytes before the first special one of eight. A subtraction carries over to the next byte only from a
/// byte that is searched for.
fn plain_bytes(bytes: [u8; 8]) -> usize {
    let word = u64::from_le_bytes(bytes);
    let below = |word: u64, least: u8| word.wrapping_sub(ONES * u64::from(least)) & !word;
    let is_byte = |byte: u8| below(word ^ (ONES * u64::from(byte)), 1);
    let found = (below(word, b' ') | is_byte(b'"') | is_byte(b'\\')) & (ONES * 0x80);
    found.trailing_zeros() as usize / 8
}

/// The number that the first digits of eight bytes make, and how many digits it has.
#[inline]
pub(super) fn first_digits(bytes: [u8; 8]) -> (u64, usize) {
    let digits = u64::from_le_bytes(bytes) ^ (ONES * u64::from(b'0'));
    // The upper half of other bytes is not 0, at least once 6 is added.
    let others = (digits | digits.wrapping_add(ONES * 6)) & (ONES * 0xf0);
    let length = others.trailing_zeros() as usize / 8;
    if length == 0 {
        return (0, 0);
    }
    // Zeros are put before the digits; then two become a number, then four, then eight. The first is the lowest byte.
    let digits = digits << (64 - 8 * length);
    let pairs = (digits & (ONES * 0x0f)) * 10 + (digits >> 8);
    let pairs = pairs & 0x00ff_00ff_00ff_00ff;
    let fours = (pairs * 100 + (pairs >> 16)) & 0x0000_ffff_0000_ffff;
    ((fours * 10_000 + (fours >> 32)) & 0xffff_ffff, length)
}

/// The number of digits at the start of a text.
pub(super) fn digits(text: &[u8]) -> usize {
    text.iter().position(|byte| !byte.is_ascii_digit()).unwrap_or(text.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scans_eight_bytes_as_one_by_one() {
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
}
