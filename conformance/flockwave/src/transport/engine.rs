//! Packets of Engine.IO, the protocol below Socket.IO. Two revisions are in use. The revisions differ in which side
//! sends pings, and in how packets are combined for long polling.

use std::fmt::Write as _;

use crate::limits::PACKET_LIMIT;

/// The packet separator in revision 4 payloads.
const SEPARATOR: char = '\u{1e}';

/// The error for a payload with too many packets.
const TOO_MANY: &str = "a payload has too many packets";

/// The supported revisions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Revision {
    /// Engine.IO 3, which carries Socket.IO 4: for clients up to version 2 of the JavaScript library.
    Three,
    /// Engine.IO 4, which carries Socket.IO 5: for clients from version 3 on.
    Four,
}

impl Revision {
    /// The revision with this Engine.IO number.
    pub fn from_number(number: &str) -> Option<Self> {
        match number {
            "3" => Some(Self::Three),
            "4" => Some(Self::Four),
            _ => None,
        }
    }

    /// The Engine.IO number.
    pub(crate) fn engine_io(self) -> u8 {
        match self {
            Self::Three => 3,
            Self::Four => 4,
        }
    }

    /// The number of the corresponding Socket.IO revision.
    pub(crate) fn socket_io(self) -> u8 {
        self.engine_io() + 1
    }
}

/// The kind of a packet. The values are the first characters of packets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// Opens a session (sent by the server).
    Open = b'0',
    /// Ends the session.
    Close = b'1',
    /// Requests a pong.
    Ping = b'2',
    /// The answer to a ping.
    Pong = b'3',
    /// A packet of the higher-level protocol.
    Message = b'4',
    /// Switches to the WebSocket.
    Upgrade = b'5',
    /// No content; it ends a poll.
    Noop = b'6',
}

/// A packet. Only text is supported, since Flockwave has no binary messages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Packet {
    /// The kind.
    pub kind: Kind,
    /// The content.
    pub data: String,
}

impl Packet {
    /// Creates a packet.
    pub fn new(kind: Kind, data: impl Into<String>) -> Self {
        Self { kind, data: data.into() }
    }

    /// Parses a packet. Returns `None` if the packet is invalid or binary.
    pub fn parse(text: &str) -> Option<Self> {
        let kind = match text.as_bytes().first()? {
            b'0' => Kind::Open,
            b'1' => Kind::Close,
            b'2' => Kind::Ping,
            b'3' => Kind::Pong,
            b'4' => Kind::Message,
            b'5' => Kind::Upgrade,
            b'6' => Kind::Noop,
            _ => return None,
        };
        Some(Self::new(kind, &text[1..]))
    }

    /// The text of the packet as sent over a WebSocket.
    pub fn to_text(&self) -> String {
        format!("{}{}", char::from(self.kind as u8), self.data)
    }
}

/// Combines packets into a payload for long polling.
pub fn encode(revision: Revision, packets: &[Packet]) -> String {
    let mut payload = String::new();
    for (at, packet) in packets.iter().enumerate() {
        match revision {
            Revision::Three => {
                let text = to_ascii(&packet.to_text());
                let _ = write!(payload, "{}:{text}", text.len());
            }
            Revision::Four => {
                if at > 0 {
                    payload.push(SEPARATOR);
                }
                payload.push_str(&packet.to_text());
            }
        }
    }
    payload
}

/// Splits a long-polling payload into packets. Fails if any part is invalid.
pub fn decode(revision: Revision, payload: &[u8]) -> Result<Vec<Packet>, String> {
    let texts = match revision {
        Revision::Three if payload.first().is_some_and(|first| *first <= 1) => binary_lengths(payload)?,
        Revision::Three => {
            let text = utf8(payload)?;
            // JavaScript clients count UTF-16 code units, and Python clients count code points.
            text_lengths(text, |_| 1).or_else(|_| text_lengths(text, char::len_utf16))?
        }
        Revision::Four => {
            let texts = utf8(payload)?.split(SEPARATOR);
            texts.take(PACKET_LIMIT + 1).map(str::to_owned).collect()
        }
    };
    if texts.len() > PACKET_LIMIT {
        return Err(TOO_MANY.to_owned());
    }
    let packets = texts
        .iter()
        .map(|text| Packet::parse(text).ok_or_else(|| "a packet is binary or of an unknown kind".to_owned()));
    packets.collect()
}

fn utf8(bytes: &[u8]) -> Result<&str, String> {
    std::str::from_utf8(bytes).map_err(|error| format!("invalid UTF-8: {error}"))
}

/// Escapes the non-ASCII characters of JSON. Revision 3 counts characters, and clients disagree on what a character is.
fn to_ascii(json: &str) -> String {
    if json.is_ascii() {
        return json.to_owned();
    }
    let mut text = String::with_capacity(json.len() * 2);
    for character in json.chars() {
        if character.is_ascii() {
            text.push(character);
        } else {
            for unit in character.encode_utf16(&mut [0; 2]) {
                let _ = write!(text, "\\u{unit:04x}");
            }
        }
    }
    text
}

/// Splits packets that are each preceded by a length and a colon.
fn text_lengths(mut text: &str, length_of: fn(char) -> usize) -> Result<Vec<String>, String> {
    let mut packets = Vec::new();
    while !text.is_empty() && packets.len() <= PACKET_LIMIT {
        let (length, rest) = text.split_once(':').ok_or("a packet has no length")?;
        let mut left: usize =
            length.parse().map_err(|_| "the length of a packet isn't a number".to_owned())?;
        let mut end = 0;
        for character in rest.chars() {
            if left == 0 {
                break;
            }
            left = left
                .checked_sub(length_of(character))
                .ok_or("a packet length ends in the middle of a character")?;
            end += character.len_utf8();
        }
        if left > 0 {
            return Err("a packet is shorter than its stated length".to_owned());
        }
        let (packet, after) = rest.split_at(end);
        packets.push(packet.to_owned());
        text = after;
    }
    Ok(packets)
}

/// Splits text packets in binary form. Each packet is preceded by a 0 byte, the decimal digits of its length (one byte
/// per digit), and a 255 byte.
fn binary_lengths(mut payload: &[u8]) -> Result<Vec<String>, String> {
    let mut packets = Vec::new();
    while packets.len() <= PACKET_LIMIT
        && let Some((kind, rest)) = payload.split_first()
    {
        if *kind != 0 {
            return Err("a packet is binary".to_owned());
        }
        let end = rest.iter().position(|byte| *byte == 255).ok_or("a packet length is not terminated")?;
        let (digits, rest) = (&rest[..end], &rest[end + 1..]);
        let length = digits.iter().try_fold(0_usize, |sum, digit| {
            sum.checked_mul(10)?.checked_add(usize::from(*digit)).filter(|_| *digit < 10)
        });
        let packet = length.and_then(|length| rest.get(..length));
        let packet = packet.ok_or("a packet is shorter than its stated length")?;
        packets.push(utf8(packet)?.to_owned());
        payload = &rest[packet.len()..];
    }
    Ok(packets)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn limits_the_packets_of_a_payload() {
        for revision in [Revision::Three, Revision::Four] {
            let packets = vec![Packet::new(Kind::Noop, ""); PACKET_LIMIT + 1];
            let longest = encode(revision, &packets[1..]);
            assert_eq!(decode(revision, longest.as_bytes()).map(|packets| packets.len()), Ok(PACKET_LIMIT));
            assert_eq!(decode(revision, encode(revision, &packets).as_bytes()), Err(TOO_MANY.to_owned()));
        }
        let binary = [0, 1, 255, b'6'].repeat(PACKET_LIMIT + 1);
        assert_eq!(decode(Revision::Three, &binary), Err(TOO_MANY.to_owned()));
    }

    #[test]
    fn encodes_payloads_for_each_revision() {
        let packets = [Packet::new(Kind::Message, "2[\"fw\"]"), Packet::new(Kind::Ping, "")];
        assert_eq!(encode(Revision::Three, &packets), "8:42[\"fw\"]1:2");
        assert_eq!(encode(Revision::Four, &packets), "42[\"fw\"]\u{1e}2");
    }

    #[test]
    fn accepts_all_ways_to_count_in_revision_3() {
        let glider = Packet::new(Kind::Message, "2[\"fw\",\"\u{1fa82}\"]");
        let text = glider.to_text();
        for length in [text.chars().count(), text.encode_utf16().count()] {
            let payload = format!("{length}:{text}1:2");
            let packets = decode(Revision::Three, payload.as_bytes()).expect("a payload");
            assert_eq!(packets, [glider.clone(), Packet::new(Kind::Ping, "")]);
        }
        assert_eq!(text.len(), 15);
        let mut binary = vec![0, 1, 5, 255];
        binary.extend(text.as_bytes());
        assert_eq!(decode(Revision::Three, &binary), Ok(vec![glider]));
    }

    #[test]
    fn reports_why_a_payload_is_invalid() {
        for payload in
            [&b"x"[..], b"9:4", b"1", b":4", b"99999999999999999999999:4", b"\x00\x09\xff4", b"\x01\x01\xffx"]
        {
            assert!(decode(Revision::Three, payload).is_err(), "{payload:?}");
        }
        for payload in [&b""[..], b"b4", b"4\x1e", b"\xff"] {
            assert!(decode(Revision::Four, payload).is_err(), "{payload:?}");
        }
    }

    proptest! {
        #[test]
        fn decodes_encoded_payloads(texts in prop::collection::vec("[ -~]{0,20}", 1..5)) {
            let packets: Vec<Packet> = texts.iter().map(|text| Packet::new(Kind::Message, text.as_str())).collect();
            for revision in [Revision::Three, Revision::Four] {
                prop_assert_eq!(decode(revision, encode(revision, &packets).as_bytes()), Ok(packets.clone()));
            }
        }

        #[test]
        fn no_payload_causes_a_panic(payload in prop::collection::vec(any::<u8>(), 0..100)) {
            let _ = decode(Revision::Three, &payload);
            let _ = decode(Revision::Four, &payload);
        }
    }
}
