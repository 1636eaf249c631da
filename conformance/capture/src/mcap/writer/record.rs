//! Encodes records of MCAP files.

use std::collections::BTreeMap;

/// Appends a record. `body` appends its content.
pub(super) fn record(out: &mut Vec<u8>, opcode: u8, body: impl FnOnce(&mut Vec<u8>)) {
    out.push(opcode);
    prefixed::<8>(out, body);
}

/// Appends a text.
pub(super) fn text(out: &mut Vec<u8>, text: &str) {
    bytes(out, text.as_bytes());
}

/// Appends a map of texts.
pub(super) fn texts(out: &mut Vec<u8>, map: &BTreeMap<String, String>) {
    prefixed::<4>(out, |out| {
        for (key, value) in map {
            text(out, key);
            text(out, value);
        }
    });
}

/// Appends the length of these bytes, and then the bytes.
pub(super) fn bytes(out: &mut Vec<u8>, bytes: &[u8]) {
    prefixed::<4>(out, |out| out.extend_from_slice(bytes));
}

/// Appends the length of the content, in `N` bytes, and then the content.
pub(super) fn prefixed<const N: usize>(out: &mut Vec<u8>, content: impl FnOnce(&mut Vec<u8>)) {
    let start = out.len();
    out.extend_from_slice(&[0; N]);
    content(out);
    let length = (out.len() - start - N) as u64;
    out[start..start + N].copy_from_slice(&length.to_le_bytes()[..N]);
}
