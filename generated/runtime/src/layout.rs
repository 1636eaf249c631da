//! The memory layout of uORB messages, which is also the payload of ULog data messages.
//!
//! PX4's generator orders the members of a message by the size of their element type, largest first
//! and otherwise as declared; nested messages come last, each aligned to 8 bytes; the whole is
//! padded to a multiple of 8. The generator computes layouts with [`place`], and generated code has
//! the compiler compute them again and compare.

/// Alignment of nested messages and of the end of each message, in bytes.
pub const ALIGNMENT: usize = 8;

/// What the layout needs to know of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Member {
    /// Size of one element in bytes; of a nested message, its padded size.
    pub element_size: usize,
    /// Number of elements: 1, or the length of the array.
    pub count: usize,
    /// Whether the element is a message.
    pub is_nested: bool,
}

impl Member {
    /// A member that holds `count` scalars of `element_size` bytes each.
    pub const fn scalar(element_size: usize, count: usize) -> Self {
        Self { element_size, count, is_nested: false }
    }

    /// A member that holds `count` messages of `element_size` bytes each, padding included.
    pub const fn nested(element_size: usize, count: usize) -> Self {
        Self { element_size, count, is_nested: true }
    }

    /// Size of the whole member in bytes, or `usize::MAX` where that doesn't fit.
    pub const fn size(self) -> usize {
        self.element_size.saturating_mul(self.count)
    }
}

/// The size of a message, in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// With the padding at its end: what a subscriber's buffer holds.
    pub padded: usize,
    /// Without the padding at its end: what PX4 registers, and the least that a log may hold.
    pub no_padding: usize,
}

/// Writes the offset of each member to `offsets`, in the order of `members`, and returns the size.
///
/// # Panics
///
/// Where `offsets` is shorter than `members`.
pub const fn place(members: &[Member], offsets: &mut [usize]) -> Size {
    const SCALAR_SIZES: [usize; 4] = [8, 4, 2, 1];
    let mut end = 0_usize;
    let mut class = 0;
    while class < SCALAR_SIZES.len() {
        let mut index = 0;
        while index < members.len() {
            let member = members[index];
            if !member.is_nested && member.element_size == SCALAR_SIZES[class] {
                offsets[index] = end;
                end = end.saturating_add(member.size());
            }
            index += 1;
        }
        class += 1;
    }
    let mut index = 0;
    while index < members.len() {
        let member = members[index];
        if member.is_nested {
            end = align(end);
            offsets[index] = end;
            end = end.saturating_add(member.size());
        }
        index += 1;
    }
    Size { padded: align(end), no_padding: end }
}

const fn align(offset: usize) -> usize {
    match offset.checked_next_multiple_of(ALIGNMENT) {
        Some(aligned) => aligned,
        None => usize::MAX,
    }
}

/// Whether `members` are laid out at `offsets` and give `size`: generated code asserts it while it
/// compiles, so that a nested message of another size can't go unnoticed.
pub const fn is<const N: usize>(members: [Member; N], offsets: [usize; N], size: Size) -> bool {
    let mut placed = [0; N];
    let found = place(&members, &mut placed);
    let mut index = 0;
    while index < N {
        if placed[index] != offsets[index] {
            return false;
        }
        index += 1;
    }
    found.padded == size.padded && found.no_padding == size.no_padding
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_by_element_size_and_keeps_the_declared_order_within_a_size() {
        let members = [
            Member::scalar(1, 1),
            Member::scalar(8, 1),
            Member::scalar(4, 3),
            Member::scalar(1, 2),
            Member::scalar(8, 1),
        ];
        assert!(is(members, [28, 0, 16, 29, 8], Size { padded: 32, no_padding: 31 }));
    }

    #[test]
    fn nested_messages_come_last_aligned_to_eight() {
        let members = [Member::nested(40, 5), Member::scalar(8, 1), Member::scalar(1, 3)];
        assert!(is(members, [16, 0, 8], Size { padded: 216, no_padding: 216 }));
    }

    #[test]
    fn sizes_saturate() {
        let mut offsets = [0; 2];
        let size = place(&[Member::scalar(8, usize::MAX), Member::scalar(1, 1)], &mut offsets);
        assert_eq!(size.padded, usize::MAX);
    }

    #[test]
    fn a_wrong_offset_is_noticed() {
        assert!(!is([Member::scalar(1, 1)], [1], Size { padded: 8, no_padding: 1 }));
        assert!(!is([Member::scalar(1, 1)], [0], Size { padded: 8, no_padding: 2 }));
    }
}
