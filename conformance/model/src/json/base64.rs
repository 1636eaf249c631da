//! Base64 in the form that rosbridge and testees write: the standard alphabet with padding (RFC 4648, section 4).

use std::sync::LazyLock;

use data_encoding::{BASE64, BASE64_NOPAD, Encoding};

/// Base64 without padding. When decoding, the unused bits of the last digit may have any value.
static DIGITS: LazyLock<Encoding> = LazyLock::new(|| {
    let mut form = BASE64_NOPAD.specification();
    form.check_trailing_bits = false;
    form.encoding().unwrap_or(BASE64_NOPAD)
});

/// Encodes bytes as base64.
pub fn encode(bytes: &[u8]) -> String {
    BASE64.encode(bytes)
}

/// Decodes base64, or returns `None` if the text is invalid. Unlike `BASE64`, this function rejects concatenated texts.
pub fn decode(text: &str) -> Option<Vec<u8>> {
    let bytes = text.as_bytes();
    let padding = bytes.iter().rev().take(2).take_while(|byte| **byte == b'=').count();
    let digits = bytes.get(..bytes.len() - padding).filter(|_| bytes.len().is_multiple_of(4))?;
    DIGITS.decode(digits).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decodes_the_test_vectors_of_the_rfc() {
        let vectors = [
            ("", ""),
            ("Zg==", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9vYg==", "foob"),
            ("Zm9vYmE=", "fooba"),
            ("Zm9vYmFy", "foobar"),
        ];
        for (text, bytes) in vectors {
            assert_eq!(decode(text).as_deref(), Some(bytes.as_bytes()), "{text}");
            assert_eq!(encode(bytes.as_bytes()), text);
        }
        assert_eq!(decode("Zn==").as_deref(), Some(&b"f"[..]), "unused bits");
        for text in ["Z", "Zg", "Zg=", "====", "Z===", "Zm8=Zm8=", "Zm 9", "Zm9\u{e9}", "Zm-_"] {
            assert_eq!(decode(text), None, "{text}");
        }
    }
}
