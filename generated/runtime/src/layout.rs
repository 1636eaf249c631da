//! The memory layout of uORB messages, which is also the payload of `ULog` data messages.
//!
//! PX4's generator orders the members of a message by the size of their element type, largest first
//! and otherwise as declared; nested messages come last, each aligned to 8 bytes; the whole is
//! padded to a multiple of 8. The generator computes layouts with [`place`], and generated code has
//! the compiler compute them again and compare.

use crate::UorbMessage;

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

/// A field in memory: its name, its offset, the size of an element in bytes, and the number of elements.
pub type Placed = (&'static str, usize, usize, usize);

/// Whether fields lie where they should and give `size`: first `scalars` scalar ones, then nested
/// messages, all in the order of their offsets.
pub const fn is_laid_out(fields: &[Placed], scalars: usize, size: Size) -> bool {
    let mut end = 0;
    let mut greatest = ALIGNMENT;
    let mut index = 0;
    while index < fields.len() {
        let (_, offset, element_size, count) = fields[index];
        if index >= scalars {
            end = align(end);
        } else if element_size > greatest {
            return false;
        } else {
            greatest = element_size;
        }
        if offset != end {
            return false;
        }
        end += element_size * count;
        index += 1;
    }
    size.no_padding == end && size.padded == align(end)
}

/// Whether the layout of a message follows from its fields, with the sizes that nested messages have.
pub const fn is_consistent<T: UorbMessage>() -> bool {
    is_laid_out(T::LAYOUT, T::SCALARS, Size { padded: T::SIZE, no_padding: T::SIZE_NO_PADDING })
}

/// Implements [`UorbMessage`](crate::UorbMessage) for a message from its size, its size without the
/// padding at its end, the number of its scalar fields, and its fields as [`Placed`], nested messages
/// last.
#[macro_export]
macro_rules! uorb_message {
    ($type:ident, $size:literal, $no_padding:literal, $scalars:literal;
        $($field:literal $offset:literal $element:literal $count:literal;)*
        $(nested $nested:literal $nested_offset:literal $message:ty, $nested_count:literal;)*) => {
        impl $crate::UorbMessage for $type {
            const SIZE: usize = $size;
            const SIZE_NO_PADDING: usize = $no_padding;
            const SCALARS: usize = $scalars;
            const LAYOUT: &'static [$crate::layout::Placed] = &[
                $(($field, $offset, $element, $count),)*
                $(($nested, $nested_offset, <$message as $crate::UorbMessage>::SIZE, $nested_count),)*
            ];
        }
    };
}

/// Has the compiler check the layouts of messages, so that a nested one of another size can't go
/// unnoticed. One assertion for a whole module costs the compiler far less than one for each message.
#[macro_export]
macro_rules! assert_layouts {
    ($($type:ident;)*) => {
        const _: () = {
            let consistent = [$($crate::layout::is_consistent::<$type>()),*];
            let mut index = 0;
            while index < consistent.len() {
                assert!(consistent[index], "the layout of a message doesn't follow from its fields");
                index += 1;
            }
        };
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn scalar(element_size: usize, count: usize) -> Member {
        Member { element_size, count, is_nested: false }
    }

    const fn nested(element_size: usize, count: usize) -> Member {
        Member { element_size, count, is_nested: true }
    }

    fn placed<const N: usize>(members: [Member; N]) -> ([usize; N], Size) {
        let mut offsets = [0; N];
        let size = place(&members, &mut offsets);
        (offsets, size)
    }

    #[test]
    fn orders_by_element_size_and_keeps_the_declared_order_within_a_size() {
        let found = placed([scalar(1, 1), scalar(8, 1), scalar(4, 3), scalar(1, 2), scalar(8, 1)]);
        assert_eq!(found, ([28, 0, 16, 29, 8], Size { padded: 32, no_padding: 31 }));
    }

    #[test]
    fn nested_messages_come_last_aligned_to_eight() {
        let found = placed([nested(40, 5), scalar(8, 1), scalar(1, 3)]);
        assert_eq!(found, ([16, 0, 8], Size { padded: 216, no_padding: 216 }));
    }

    #[test]
    fn sizes_saturate() {
        assert_eq!(placed([scalar(8, usize::MAX), scalar(1, 1)]).1.padded, usize::MAX);
    }

    #[test]
    fn what_is_placed_is_laid_out_and_nothing_else_is() {
        let size = Size { padded: 216, no_padding: 216 };
        let fields = |nested_offset, nested_size| {
            [("a", 0, 8, 1), ("b", 8, 1, 3), ("c", nested_offset, nested_size, 5)]
        };
        assert!(is_laid_out(&fields(16, 40), 2, size));
        assert!(!is_laid_out(&fields(11, 40), 2, size), "nested messages are aligned");
        assert!(!is_laid_out(&fields(16, 48), 2, size), "a nested message has grown");
        let size = Size { padded: 16, no_padding: 9 };
        assert!(!is_laid_out(&[("a", 0, 1, 1), ("b", 1, 8, 1)], 2, size), "scalars go from large to small");
        assert!(!is_laid_out(&[("a", 1, 8, 1)], 1, size), "no gap at the start");
    }
}
