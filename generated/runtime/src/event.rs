//! Events of PX4: their ids, arguments and texts.
//!
//! PX4 reports occurrences as *events*. An event consists of an id and up to 25 bytes of arguments. The names, texts
//! and argument types of the events are in *event metadata*, a JSON file that belongs to a build of the firmware. The
//! sources are libevents (<https://github.com/mavlink/libevents>) and `Event.msg` of PX4.
//!
//! ```
//! use uavspec_runtime::event::{Argument, Profile, Text};
//!
//! let text = Text::new("Battery {1}: {2:.1} V<profile name=\"dev\"> (see <param>BAT1_V_EMPTY</param>)</profile>");
//! let arguments = [Argument::Integer(1), Argument::Float(10.25)];
//! let shown = |profile| text.show(profile, &|index| arguments.get(index).copied()).to_string();
//! assert_eq!(shown(Profile::Normal), "Battery 1: 10.2 V");
//! assert_eq!(shown(Profile::Dev), "Battery 1: 10.2 V (see BAT1_V_EMPTY)");
//! ```

mod descriptor;
mod text;

use core::fmt;

pub use self::descriptor::{
    ArgumentDescriptor, ArgumentReader, ArgumentWriter, EnumLabels, Event, EventDescriptor, EventTexts,
    ShownEvent, log_levels,
};
pub use self::text::{Argument, Labels, Piece, Placeholder, Shown, Tag, Text, UNITS};

/// The number of bytes that an event reserves for its arguments.
pub const MAX_ARGUMENTS_SIZE: usize = 25;

/// The greatest sub id of an event. The bits above it contain the component id.
pub const MAX_SUB_ID: u32 = 0xFF_FFFF;

/// The sub id that PX4 derives from the name of an event: the lower 24 bits of the name's FNV-1a hash.
pub const fn sub_id(name: &str) -> u32 {
    let bytes = name.as_bytes();
    let (mut hash, mut at) = (0x811c_9dc5_u32, 0);
    while at < bytes.len() {
        hash = (hash ^ bytes[at] as u32).wrapping_mul(0x0100_0193);
        at += 1;
    }
    hash & MAX_SUB_ID
}

/// The intended readers of a part of a text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Profile {
    /// Users of vehicles.
    #[default]
    Normal,
    /// Developers.
    Dev,
}

impl Profile {
    /// All profiles.
    pub const ALL: [Self; 2] = [Self::Normal, Self::Dev];

    /// The name in texts.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::Dev => "dev",
        }
    }
}

/// The level of an event. A log and a ground station may receive the same event with different levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum LogLevel {
    /// The vehicle can't be used.
    Emergency = 0,
    /// Act immediately.
    Alert = 1,
    /// Critical.
    Critical = 2,
    /// An error.
    Error = 3,
    /// A warning.
    Warning = 4,
    /// Normal, but significant.
    Notice = 5,
    /// Informational.
    Info = 6,
    /// For developers.
    Debug = 7,
    /// Part of a protocol. Ground stations don't show the event.
    Protocol = 8,
    /// The event isn't logged or isn't sent.
    Disabled = 9,
}

impl LogLevel {
    /// All levels, most severe first.
    pub const ALL: [Self; 10] = [
        Self::Emergency,
        Self::Alert,
        Self::Critical,
        Self::Error,
        Self::Warning,
        Self::Notice,
        Self::Info,
        Self::Debug,
        Self::Protocol,
        Self::Disabled,
    ];

    /// The level for logs, from the field `log_levels` of an event. `None` if the value has no meaning.
    pub fn internal(levels: u8) -> Option<Self> {
        Self::ALL.get(usize::from(levels >> 4)).copied()
    }

    /// The level for ground stations, from the field `log_levels` of an event. `None` if the value has no meaning.
    pub fn external(levels: u8) -> Option<Self> {
        Self::ALL.get(usize::from(levels & 0x0F)).copied()
    }

    /// The name in lower case.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Emergency => "emergency",
            Self::Alert => "alert",
            Self::Critical => "critical",
            Self::Error => "error",
            Self::Warning => "warning",
            Self::Notice => "notice",
            Self::Info => "info",
            Self::Debug => "debug",
            Self::Protocol => "protocol",
            Self::Disabled => "disabled",
        }
    }
}

impl fmt::Display for LogLevel {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sub_ids_are_hashes_of_names() {
        // From the metadata of a log of PX4 1.15.
        for (name, id) in [
            ("commander_arming_check_summary", 27_825_120),
            ("check_estimator_gps_fix_too_low", 29_146_769),
            ("logger_open_file_time", 17_980_399),
        ] {
            assert_eq!(1 << 24 | sub_id(name), id, "{name}");
        }
    }

    #[test]
    fn levels_share_a_byte() {
        assert_eq!(LogLevel::internal(0x64), Some(LogLevel::Info));
        assert_eq!(LogLevel::external(0x64), Some(LogLevel::Warning));
        assert_eq!(LogLevel::internal(0xA0), None);
        for (number, level) in LogLevel::ALL.into_iter().enumerate() {
            assert_eq!(level as usize, number);
        }
    }
}
