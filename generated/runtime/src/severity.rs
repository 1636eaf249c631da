//! Severities and classes of error codes, as the Flockwave specification divides them.

use core::fmt;
use core::ops::RangeInclusive;

/// How grave an error code is. The specification keeps it in two bits of the code itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Severity {
    /// Worth knowing, no danger.
    Informational = 0,
    /// No danger now, but one to come if nothing is done.
    Warning = 1,
    /// Normal operation can't go on.
    Error = 2,
    /// The vehicle lands at once or shuts down.
    Fatal = 3,
}

impl Severity {
    /// All severities, from harmless to grave.
    pub const ALL: [Self; 4] = [Self::Informational, Self::Warning, Self::Error, Self::Fatal];

    /// The severity of any code, known or not: `(code & 0xFF) >> 6`.
    ///
    /// For codes under 256 the specification guarantees it; for all others it recommends it.
    pub const fn of(code: u32) -> Self {
        match (code & 0xFF) >> 6 {
            0 => Self::Informational,
            1 => Self::Warning,
            2 => Self::Error,
            _ => Self::Fatal,
        }
    }

    /// Its name in lower case.
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

/// What a list of error codes says of a UAV. For slices of codes of any type.
pub trait ErrorList {
    /// Whether the UAV is ready for takeoff: the list holds code 1 (on the ground) and no other.
    ///
    /// An empty list says that nothing is wrong, but not that the UAV stands on the ground.
    fn is_ready_for_takeoff(&self) -> bool;

    /// The severity of the gravest code; none of an empty list.
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

/// A range of error codes that the specification sets apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ErrorClass {
    /// Code 0: nothing is wrong. An empty list of codes says the same.
    NoError,
    /// Codes 1 to 63.
    Informational,
    /// Codes 64 to 127.
    Warning,
    /// Codes 128 to 191.
    Error,
    /// Codes 192 to 255; some headings call them critical.
    Fatal,
    /// Codes 256 to 32767, in blocks of 256, one for each type of vehicle.
    UavSpecific,
    /// Codes from 32768: free for any use.
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

    /// The class that `code` belongs to.
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

    /// First and last code of the class.
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

    /// Its name in lower case.
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

    #[test]
    fn every_code_is_in_the_range_of_its_class_and_no_range_leaves_a_gap() {
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
    fn severity_is_in_two_bits() {
        for code in 0..70_000_u32 {
            assert_eq!(Severity::of(code) as u32, (code & 0xFF) >> 6);
        }
    }
}
