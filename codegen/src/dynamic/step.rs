//! Conversion steps between the memory form of a message and CDR.

use uavspec_runtime::Scalar;

/// The constraints of a string.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    /// True for a `wstring`.
    pub(super) is_wide: bool,
    /// Maximum number of characters.
    pub(super) bound: Option<u32>,
}

impl Bounds {
    /// True if UTF-8 `text` exceeds the maximum number of characters.
    pub(super) fn exceeded_by(self, text: &[u8]) -> bool {
        let is_start = |byte: &&u8| **byte & 0xc0 != 0x80;
        self.bound.is_some_and(|bound| {
            let bound = bound as usize;
            text.len() > bound && text.iter().filter(is_start).count() > bound
        })
    }
}

/// A conversion step between memory and CDR. Offsets are in bytes from the start of the message in memory.
#[derive(Clone, Copy, Debug)]
pub(super) enum Step {
    /// Numbers that are contiguous in both forms.
    Copy(Run),
    /// Strings.
    Strings { offset: usize, count: usize, bounds: Bounds },
    /// Messages.
    Messages { offset: usize, count: usize, plan: usize },
    /// A sequence.
    Sequence { offset: usize, bound: Option<u32>, element: Sequence },
    /// The placeholder byte of a message without fields.
    Empty,
}

/// Numbers of the same size.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    pub(super) offset: usize,
    /// Total size in bytes.
    pub(super) size: usize,
    pub(super) width: Width,
    pub(super) is_bool: bool,
}

/// Size of a number in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Width {
    One = 1,
    Two = 2,
    Four = 4,
    Eight = 8,
}

impl Width {
    pub(super) fn of(scalar: Scalar) -> Self {
        match scalar.size() {
            1 => Self::One,
            2 => Self::Two,
            4 => Self::Four,
            _ => Self::Eight,
        }
    }
}

/// The element type of a sequence.
#[derive(Clone, Copy, Debug)]
pub(super) enum Sequence {
    Numbers { width: Width, is_bool: bool },
    Strings(Bounds),
    Messages(usize),
}
