//! Binary forms of messages: either encoded from JSON, or modified into bytes that no encoder produces.

use uavspec_dynamic::MessageType;
use uavspec_runtime::cdr::ByteOrder;

use super::case::GROWTH;

/// The binary forms of a message.
#[derive(Clone, Debug, Default)]
pub(super) struct Bytes {
    /// uORB payload, if the message has this form.
    pub(super) uorb: Option<Vec<u8>>,
    /// Little-endian CDR payload.
    pub(super) cdr: Option<Vec<u8>>,
}

/// Encoder for messages of one type.
pub(super) struct Codec<'t> {
    message: MessageType<'t>,
    is_uorb: bool,
}

impl<'t> Codec<'t> {
    pub(super) fn new(message: MessageType<'t>, is_uorb: bool) -> Self {
        Self { message, is_uorb }
    }

    /// Encodes the JSON message `json`. The result is empty if the message is invalid.
    pub(super) fn encode(&self, json: &str) -> Bytes {
        let Ok(message) = self.message.from_json_text(json) else { return Bytes::default() };
        Bytes {
            uorb: self.is_uorb.then(|| message.to_uorb().ok()).flatten(),
            cdr: message.to_cdr(ByteOrder::LittleEndian).ok(),
        }
    }

    /// Encodes the JSON message `json` as big-endian CDR.
    pub(super) fn big_endian(&self, json: &str) -> Option<Vec<u8>> {
        self.message.from_json_text(json).ok()?.to_cdr(ByteOrder::BigEndian).ok()
    }
}

/// Finds the first byte in which `after` differs from `before`, and replaces this byte of `after` with `byte`.
pub(super) fn replaced(before: &[u8], mut after: Vec<u8>, byte: u8) -> Option<Vec<u8>> {
    let at = difference(before, &after)?;
    *after.get_mut(at)? = byte;
    Some(after)
}

/// Adds [`GROWTH`] elements to a sequence in the CDR payload `after`. In the payload `before`, this sequence is empty,
/// and everything else is equal.
pub(super) fn grown(before: &[u8], after: &[u8], size: usize, filler: u8) -> Option<Vec<u8>> {
    // Lengths are aligned to four bytes, which is also the size of the header.
    let at = difference(before, after)? / 4 * 4;
    let (head, rest) = after.split_at_checked(at)?;
    let (length, rest) = rest.split_first_chunk()?;
    let length = u32::from_le_bytes(*length).saturating_add(GROWTH);
    let mut element = vec![0; size];
    *element.first_mut()? = filler;
    Some([head, &length.to_le_bytes(), &element.repeat(GROWTH as usize), rest].concat())
}

fn difference(before: &[u8], after: &[u8]) -> Option<usize> {
    before.iter().zip(after).position(|(before, after)| before != after)
}
