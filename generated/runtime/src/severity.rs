//! Severities and classes of error codes, as defined by the Flockwave specification.

use core::fmt;
use core::ops::RangeInclusive;

/// The severity of an error code, encoded in two bits of the code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Severity {
    /// Information only, no danger.
    Informational = 0,
    /// No danger yet, but action is needed to prevent it.
    Warning = 1,
    /// Normal operation can't continue.
    Error = 2,
    /// The vehicle lands immediately or shuts down.
    Fatal = 3,
}

impl Severity {
    /// All severities, least severe first.
    pub const ALL: [Self; 4] = [Self::Informational, Self::Warning, Self::Error, Self::Fatal];

    /// The severity of any code, known or not: `(code & 0xFF) >> 6`.
    ///
    /// The specification guarantees this formula for codes under 256 and recommends it for other codes.
    pub const fn of(code: u32) -> Self {
        match (code & 0xFF) >> 6 {
            0 => Self::Informational,
            1 => Self::Warning,
            2 => Self::Error,
            _ => Self::Fatal,
        }
    }

    /// The name in lower case.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Informational => "informational",
            Self::Warning => "warning",
            Self::Error => "error",
            Self::Fatal => "fatal",
        }
    }
}

impl fmt::Display for Severity {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

/// Methods for a list of error codes reported by a UAV.
pub trait ErrorList {
    /// True if the UAV is ready for takeoff: the list contains code 1 (on the ground) and no other code.
    ///
    /// An empty list means only that there is no error, not that the UAV is on the ground.
    fn is_ready_for_takeoff(&self) -> bool;

    /// The severity of the most severe code, or `None` for an empty list.
    fn severity(&self) -> Option<Severity>;
}

impl<C: Copy + Into<u32>> ErrorList for [C] {
    fn is_ready_for_takeoff(&self) -> bool {
        const ON_THE_GROUND: u32 = 1;
        !self.is_empty() && self.iter().all(|code| (*code).into() == ON_THE_GROUND)
    }

    fn severity(&self) -> Option<Severity> {
        self.iter().map(|code| Severity::of((*code).into())).max()
    }
}

/// A class of error codes: a range that the specification reserves for one purpose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ErrorClass {
    /// Code 0: no error. An empty list of codes also means that there is no error.
    NoError,
    /// Codes 1 to 63.
    Informational,
    /// Codes 64 to 127.
    Warning,
    /// Codes 128 to 191.
    Error,
    /// Codes 192 to 255, which some headings in the specification call critical.
    Fatal,
    /// Codes 256 to 32767, in blocks of 256, one block for each vehicle type.
    UavSpecific,
    /// Codes from 32768: available for any use.
    UserDefined,
}

impl ErrorClass {
    /// All classes, in the order of their codes.
    pub const ALL: [Self; 7] = [
        Self::NoError,
        Self::Informational,
        Self::Warning,
        Self::Error,
        Self::Fatal,
        Self::UavSpecific,
        Self::UserDefined,
    ];

    /// The class of `code`.
    pub const fn of(code: u32) -> Self {
        match code {
            0 => Self::NoError,
            1..=63 => Self::Informational,
            64..=127 => Self::Warning,
            128..=191 => Self::Error,
            192..=255 => Self::Fatal,
            256..=32_767 => Self::UavSpecific,
            32_768.. => Self::UserDefined,
        }
    }

    /// The codes of the class.
    pub const fn codes(self) -> RangeInclusive<u32> {
        match self {
            Self::NoError => 0..=0,
            Self::Informational => 1..=63,
            Self::Warning => 64..=127,
            Self::Error => 128..=191,
            Self::Fatal => 192..=255,
            Self::UavSpecific => 256..=32_767,
            Self::UserDefined => 32_768..=u32::MAX,
        }
    }

    /// The name in lower case.
    pub const fn name(self) -> &'static str {
        match self {
            Self::NoError => "no error",
            Self::Informational => "informational",
            Self::Warning => "warning",
            Self::Error => "error",
            Self::Fatal => "fatal",
            Self::UavSpecific => "UAV-specific",
            Self::UserDefined => "user-defined",
        }
    }
}

impl fmt::Display for ErrorClass {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::alloc;

    #[test]
    fn class_ranges_contain_their_codes_and_leave_no_gap() {
        let mut next = 0;
        for class in ErrorClass::ALL {
            let codes = class.codes();
            assert_eq!(*codes.start(), next, "{class} leaves a gap");
            assert_eq!(ErrorClass::of(*codes.start()), class);
            assert_eq!(ErrorClass::of(*codes.end()), class);
            next = codes.end().wrapping_add(1);
        }
        assert_eq!(next, 0, "the last class ends with the last code");
    }

    #[test]
    fn a_list_has_the_severity_of_its_most_severe_code() {
        for (codes, is_ready, severity) in [
            (&[][..], false, None),
            (&[1], true, Some("informational")),
            (&[1, 1], true, Some("informational")),
            (&[2], false, Some("informational")),
            (&[1, 65, 2], false, Some("warning")),
            (&[255, 129], false, Some("fatal")),
        ] {
            let codes: &[u8] = codes;
            assert_eq!(codes.is_ready_for_takeoff(), is_ready, "{codes:?}");
            let name = codes.severity().map(|severity| alloc::format!("{severity}"));
            assert_eq!(name.as_deref(), severity, "{codes:?}");
        }
        assert_eq!(alloc::format!("{:>9}", Severity::Error), "    error");
    }

    #[test]
    fn severity_comes_from_two_bits_of_the_code() {
        for code in 0..70_000_u32 {
            assert_eq!(Severity::of(code) as u32, (code & 0xFF) >> 6);
        }
    }

    #[test]
    fn two_bits_of_a_code_are_its_severity() {
        for (code, severity) in [
            (0, Severity::Informational),
            (0x3f, Severity::Informational),
            (0x40, Severity::Warning),
            (0xbf, Severity::Error),
            (0xc0, Severity::Fatal),
            (0x1ff, Severity::Fatal),
            (0x140, Severity::Warning),
        ] {
            assert_eq!(Severity::of(code), severity, "{code:#x}");
        }
    }
}
