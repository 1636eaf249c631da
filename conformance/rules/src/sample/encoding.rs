//! The encodings of flights.

use super::Flight;

/// An encoding of a flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// `ULog`.
    Ulog,
    /// MCAP with CDR messages.
    Mcap,
    /// JSON Lines with the type of each message.
    Lines,
    /// JSON Lines in rosbridge format, with the topic of each message.
    Rosbridge,
}

impl Encoding {
    /// All encodings.
    pub const ALL: [Self; 4] = [Self::Ulog, Self::Mcap, Self::Lines, Self::Rosbridge];

    /// The name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ulog => "ULog",
            Self::Mcap => "MCAP",
            Self::Lines => "JSON Lines",
            Self::Rosbridge => "rosbridge",
        }
    }

    /// Encodes a flight. `None` if the encoding can't represent one of its messages.
    pub fn write(self, flight: &Flight<'_>) -> Option<Vec<u8>> {
        let is_complete = |written: usize| written == flight.messages.len();
        match self {
            Self::Ulog => {
                Some(flight.log()).filter(|log| is_complete(log.messages())).map(|log| log.to_bytes())
            }
            Self::Mcap => {
                Some(flight.bag()).filter(|bag| is_complete(bag.messages.len())).map(|bag| bag.to_bytes())
            }
            Self::Lines => Some(flight.lines().to_bytes()),
            Self::Rosbridge => Some(flight.rosbridge().to_bytes()),
        }
    }

    /// Encodes a changed flight. `None` if the encoding can't represent the change.
    pub(crate) fn write_change(self, flight: &Flight<'_>, changed: &Flight<'_>) -> Option<Vec<u8>> {
        let is_changed = self != Self::Lines || flight.messages != changed.messages;
        if is_changed { self.write(changed) } else { None }
    }
}
