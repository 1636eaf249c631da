//! The subset of Socket.IO packets that Flockwave needs: one namespace, one event and no binary data.

use serde_json::value::RawValue;

/// The event for messages.
pub const EVENT: &str = "fw";

/// A received packet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Packet {
    /// Joins a namespace, or confirms that a client has joined it.
    Connect {
        /// The namespace; `/` always exists.
        namespace: String,
    },
    /// Leaves the namespace.
    Disconnect,
    /// A Flockwave message.
    Message {
        /// The text of the message.
        text: String,
        /// The number of the acknowledgement that the sender requests.
        receipt: Option<u64>,
    },
    /// The server refuses a namespace, for this reason.
    Refusal(String),
    /// An event with another name.
    OtherEvent {
        /// The text of the first argument.
        text: String,
    },
    /// Anything else: other namespaces, acknowledgements, binary data.
    Other,
}

impl Packet {
    /// Parses a packet. Returns `None` if it is invalid.
    pub fn parse(text: &str) -> Option<Self> {
        let (kind, rest) = text.split_at_checked(1)?;
        let (namespace, rest) = namespace(rest);
        match kind {
            "0" => Some(Self::Connect { namespace: namespace.to_owned() }),
            "1" if namespace == "/" => Some(Self::Disconnect),
            "2" => event(namespace, rest),
            "4" => Some(Self::Refusal(rest.to_owned())),
            "1" | "3" | "5" | "6" => Some(Self::Other),
            _ => None,
        }
    }
}

/// The packet for a message.
pub fn message(text: &str) -> String {
    message_as(EVENT, text)
}

/// The packet for a message in a given event.
pub fn message_as(event: &str, text: &str) -> String {
    format!("2[\"{event}\",{text}]")
}

/// The packet that acknowledges an event.
pub fn receipt(number: u64) -> String {
    format!("3{number}[]")
}

/// Splits off the namespace: `/name,` or nothing.
fn namespace(text: &str) -> (&str, &str) {
    if !text.starts_with('/') {
        return ("/", text);
    }
    let (name, rest) = text.split_once(',').unwrap_or((text, ""));
    // In revision 4, clients may append a query to the name.
    (name.split('?').next().unwrap_or(name), rest)
}

fn event(namespace: &str, text: &str) -> Option<Packet> {
    let digits = text.bytes().take_while(u8::is_ascii_digit).count();
    let (number, arguments) = text.split_at(digits);
    let receipt = if number.is_empty() { None } else { Some(number.parse().ok()?) };
    let arguments: Vec<&RawValue> = serde_json::from_str(arguments).ok()?;
    let name: String = serde_json::from_str(arguments.first()?.get()).ok()?;
    if namespace != "/" {
        return Some(Packet::Other);
    }
    let text = arguments.get(1).map_or("null", |message| message.get()).to_owned();
    Some(if name == EVENT { Packet::Message { text, receipt } } else { Packet::OtherEvent { text } })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parses_packets() {
        let connect = |namespace: &str| Some(Packet::Connect { namespace: namespace.to_owned() });
        let message = |text: &str, receipt| Some(Packet::Message { text: text.to_owned(), receipt });
        for (text, expected) in [
            ("0", connect("/")),
            ("0{\"token\":1}", connect("/")),
            ("0/fw,", connect("/fw")),
            ("0/fw?a=b", connect("/fw")),
            ("1", Some(Packet::Disconnect)),
            ("2[\"fw\", {\"id\": 1.50}]", message("{\"id\": 1.50}", None)),
            ("217[\"fw\",{}]", message("{}", Some(17))),
            ("2[\"fw\"]", message("null", None)),
            ("2[\"wind\",{}]", Some(Packet::OtherEvent { text: "{}".to_owned() })),
            ("2/fw,[\"fw\",{}]", Some(Packet::Other)),
            ("4{\"message\":\"no\"}", Some(Packet::Refusal("{\"message\":\"no\"}".to_owned()))),
            ("51-[\"fw\",{}]", Some(Packet::Other)),
            ("2", None),
            ("2[]", None),
            ("2[7]", None),
            ("299999999999999999999[\"fw\"]", None),
            ("7", None),
            ("", None),
            ("é", None),
        ] {
            assert_eq!(Packet::parse(text), expected, "{text}");
        }
    }
}
