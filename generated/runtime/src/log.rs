//! Messages in logs of [`defmt`], for devices that can't afford to make text: they send values and the
//! number of a text that stays on the host, which puts both together.
//!
//! ```text
//! defmt::info!("{}", event);    Event { timestamp: 0, id: 7, event_sequence: 0, … }
//! ```
//!
//! # What is sent
//!
//! The names of a message and of its fields are one text, made by the generator. Numbers of known type go
//! out as they are. So a message takes six bytes more than the values in it: the number of the text, and a
//! start and an end. An array of anything but bytes takes two more; an enum, shown by its name, six bytes,
//! flags, shown in hexadecimal, eight and those of their number; text of fixed size ten and its characters.
//! `BatteryStatus`, 167 bytes in memory, takes 198.
//! No name of a field is ever sent: a single implementation in this crate that went over the description
//! of a message would have to send each of them, several times the size of the values.
//!
//! # What it costs to compile
//!
//! Each text needs one call of a macro of defmt. `#[derive(defmt::Format)]` saves four bytes a message, for
//! it may use what defmt keeps for itself. But it adds 0.9 s to the check of PX4's 261 messages, where this adds
//! 0.4 to 0.6 s, and it needs a feature and defmt itself in the manifest of the crate that holds the messages.

use defmt::{Format, Formatter, write};

use crate::{Severity, Text};

/// The text, or its bytes where it is no UTF-8.
impl<const N: usize> Format for Text<N> {
    fn format(&self, formatter: Formatter<'_>) {
        if let Ok(text) = self.as_str() {
            write!(formatter, "{=str:?}", text);
        } else {
            write!(formatter, "{=[u8]:a}", self.bytes());
        }
    }
}

impl Format for Severity {
    fn format(&self, formatter: Formatter<'_>) {
        #[allow(clippy::match_same_arms)] // their texts differ
        match self {
            Self::Informational => write!(formatter, "informational"),
            Self::Warning => write!(formatter, "warning"),
            Self::Error => write!(formatter, "error"),
            Self::Fatal => write!(formatter, "fatal"),
        }
    }
}

/// Gives a message its `defmt::Format`.
#[macro_export]
macro_rules! format_record {
    ($type:ident $text:literal; $($field:ident)*;) => {
        impl $crate::defmt::Format for $type {
            fn format(&self, formatter: $crate::defmt::Formatter<'_>) {
                // What the macro makes looks for a crate of this name.
                use $crate::defmt;
                defmt::write!(formatter, $text $(, self.$field)*);
            }
        }
    };
}

/// Gives an enum its `defmt::Format`.
#[doc(hidden)]
#[macro_export]
macro_rules! __format_enum {
    ($type:ident; $($known:literal $name:literal;)*) => {
        impl $crate::defmt::Format for $type {
            fn format(&self, formatter: $crate::defmt::Formatter<'_>) {
                use $crate::defmt;
                #[allow(unreachable_patterns, clippy::match_same_arms)] // of several names of a value, the first
                match self.0 {
                    $($known => defmt::write!(formatter, $name),)*
                    number => defmt::write!(formatter, "{}", number),
                }
            }
        }
    };
}

/// Gives flags their `defmt::Format`.
#[doc(hidden)]
#[macro_export]
macro_rules! __format_flags {
    ($type:ident) => {
        impl $crate::defmt::Format for $type {
            fn format(&self, formatter: $crate::defmt::Formatter<'_>) {
                use $crate::defmt;
                defmt::write!(formatter, "{:#x}", self.0);
            }
        }
    };
}

/// Gives an error code its `defmt::Format`.
#[doc(hidden)]
#[macro_export]
macro_rules! __format_error_code {
    ($type:ident; $($known:literal $name:literal;)*) => {
        impl $crate::defmt::Format for $type {
            fn format(&self, formatter: $crate::defmt::Formatter<'_>) {
                use $crate::defmt;
                defmt::write!(formatter, "{=u32}", self.0);
                #[allow(clippy::match_same_arms)] // their texts differ
                match self.0 {
                    $($known => {
                        defmt::write!(formatter, " ");
                        defmt::write!(formatter, $name);
                    })*
                    _ => {}
                }
            }
        }
    };
}
