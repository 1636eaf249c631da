//! The encodings of flights.

use super::Flight;

/// An encoding of a flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// A log of PX4.
    Ulog,
    /// MCAP with messages as CDR.
    Mcap,
    /// JSON Lines that name the type of each message.
    Lines,
    /// JSON Lines of rosbridge, which name the topic of each message.
    Rosbridge,
}

impl Encoding {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Ulog, Self::Mcap, Self::Lines, Self::Rosbridge];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ulog => "ULog",
            Self::Mcap => "MCAP",
            Self::Lines => "JSON Lines",
            Self::Rosbridge => "rosbridge",
        }
    }

    /// The capture of a flight; none if the encoding can't hold one of its messages.
    pub fn write(self, flight: &Flight<'_>) -> Option<Vec<u8>> {
        let is_whole = |written: usize| written == flight.messages.len();
        match self {
            Self::Ulog => Some(flight.log()).filter(|log| is_whole(log.messages())).map(|log| log.to_bytes()),
            Self::Mcap => {
                Some(flight.bag()).filter(|bag| is_whole(bag.messages.len())).map(|bag| bag.to_bytes())
            }
            Self::Lines => Some(flight.lines().to_bytes()),
            Self::Rosbridge => Some(flight.rosbridge().to_bytes()),
        }
    }

    /// The capture of a changed flight; none if the encoding doesn't show the change.
    pub(in crate::rules) fn write_change(self, flight: &Flight<'_>, changed: &Flight<'_>) -> Option<Vec<u8>> {
        let is_shown = self != Self::Lines || flight.messages != changed.messages;
        if is_shown { self.write(changed) } else { None }
    }
}
