//! Conversion steps between the memory form of a message and CDR.

use uavspec_runtime::Scalar;

use super::text::characters;

/// The constraints of a string.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    /// True for a `wstring`.
    pub(super) is_wide: bool,
    /// Maximum number of characters.
    pub(super) bound: Option<u32>,
}

impl Bounds {
    /// The maximum number of characters and the number in `text`, if `text` has more.
    pub(super) fn exceeded_by(self, text: &[u8]) -> Option<(u32, usize)> {
        // A text never has more characters than bytes.
        let bound = self.bound.filter(|bound| text.len() > *bound as usize)?;
        let found = characters(text).count();
        (found > bound as usize).then_some((bound, found))
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
