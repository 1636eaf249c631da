//! Messages in [`defmt`] logs, for devices that can't afford to format text. The device sends only values and the index
//! of a format string. The host has the format strings and formats the log.
//!
//! ```text
//! defmt::info!("{}", event);    Event { timestamp: 0, id: 7, event_sequence: 0, … }
//! ```
//!
//! # Size of the log
//!
//! The generator puts the names of a message and of its fields into one format string, so the device never sends names.
//! Numbers are sent in binary, without their types. The overhead is:
//!
//! | value | bytes |
//! |---|---|
//! | message | 6 (format-string index, start and end) plus its values |
//! | array, except an array of bytes | 2 plus its elements |
//! | enum, shown by its name | 6 in total |
//! | flags, shown in hexadecimal | 8 plus the bytes of their number |
//! | fixed-size text | 10 plus its characters |
//!
//! `BatteryStatus`, which takes 167 bytes in memory, takes 198 bytes in the log.
//!
//! # Compile time
//!
//! Each format string needs one defmt macro call. `#[derive(defmt::Format)]` saves four bytes per message, because it
//! can use private functions of defmt. However, this derive adds 0.6 s to `cargo check` of PX4's 261 messages, whereas
//! this implementation adds 0.4 s. The derive also needs a feature and a dependency on defmt in the crate that
//! contains the messages.

use defmt::{Format, Formatter, write};

use crate::{Severity, Text};

/// Formats the text, or its bytes if it is not valid UTF-8.
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
        #[allow(clippy::match_same_arms)] // the format strings differ
        match self {
            Self::Informational => write!(formatter, "informational"),
            Self::Warning => write!(formatter, "warning"),
            Self::Error => write!(formatter, "error"),
            Self::Fatal => write!(formatter, "fatal"),
        }
    }
}

/// Implements `defmt::Format` for a message.
#[macro_export]
macro_rules! format_record {
    ($type:ident $text:literal; $($field:ident)*;) => {
        impl $crate::defmt::Format for $type {
            fn format(&self, formatter: $crate::defmt::Formatter<'_>) {
                // The expanded code of the macro refers to a crate with this name.
                use $crate::defmt;
                defmt::write!(formatter, $text $(, self.$field)*);
            }
        }
    };
}

/// Implements `defmt::Format` for an enum.
#[doc(hidden)]
#[macro_export]
macro_rules! __format_enum {
    ($type:ident; $($known:literal $name:literal;)*) => {
        impl $crate::defmt::Format for $type {
            fn format(&self, formatter: $crate::defmt::Formatter<'_>) {
                use $crate::defmt;
                #[allow(unreachable_patterns, clippy::match_same_arms)] // the first name of a value wins
                match self.0 {
                    $($known => defmt::write!(formatter, $name),)*
                    number => defmt::write!(formatter, "{}", number),
                }
            }
        }
    };
}

/// Implements `defmt::Format` for flags.
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

/// Implements `defmt::Format` for an error code.
#[doc(hidden)]
#[macro_export]
macro_rules! __format_error_code {
    ($type:ident; $($known:literal $name:literal;)*) => {
        impl $crate::defmt::Format for $type {
            fn format(&self, formatter: $crate::defmt::Formatter<'_>) {
                use $crate::defmt;
                #[allow(clippy::match_same_arms)] // the interned names differ
                match self.0 {
                    // A name may contain braces, so it can't be a format string.
                    $($known => defmt::write!(formatter, "{=u32} {=istr}", self.0, defmt::intern!($name)),)*
                    number => defmt::write!(formatter, "{=u32}", number),
                }
            }
        }
    };
}
