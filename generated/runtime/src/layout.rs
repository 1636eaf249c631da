//! The memory layout of uORB messages. The payload of `ULog` data messages has the same layout.
//!
//! PX4's generator sorts the members of a message by the size of their element type, largest first. Members with the
//! same element size keep their declaration order. Nested messages come last, each aligned to 8 bytes. The message is
//! padded to a multiple of 8 bytes. uavspec-codegen computes layouts with [`place`], and generated code checks them at
//! compile time.
//!
//! ```
//! use uavspec_runtime::layout::{Member, Size, place};
//!
//! // The members `uint8 a` and `uint64 b`.
//! let members = [1, 8].map(|element_size| Member { element_size, count: 1, is_nested: false });
//! let mut offsets = [0; 2];
//! assert_eq!(place(&members, &mut offsets), Size { padded: 16, no_padding: 9 });
//! assert_eq!(offsets, [8, 0]);
//! ```

use crate::descriptor::{Element, FieldDescriptor, MessageDescriptor, Shape};

/// The alignment of nested messages, in bytes. Messages are padded to a multiple of this size.
pub const ALIGNMENT: usize = 8;

/// The layout properties of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Member {
    /// Size of one element in bytes. For a nested message, its padded size.
    pub element_size: usize,
    /// Number of elements: 1, or the length of the array.
    pub count: usize,
    /// True if the element is a message.
    pub is_nested: bool,
}

impl Member {
    /// Size of all elements in bytes. Saturates at `usize::MAX`.
    pub const fn size(self) -> usize {
        self.element_size.saturating_mul(self.count)
    }
}

/// The size of a message, in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Size including the trailing padding: the size of a subscriber's buffer.
    pub padded: usize,
    /// Size without the trailing padding: the size that PX4 registers, and the minimum payload size in a log.
    pub no_padding: usize,
}

/// Writes the offset of each member to `offsets`, in the order of `members`, and returns the size.
///
/// # Panics
///
/// Panics if `offsets` is shorter than `members`.
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

/// True if a message's field offsets and size follow the layout rules.
///
/// The algorithm differs from [`place`] on purpose, so the two functions verify each other. This function first adds up
/// the space for each element size, then checks the offset of each field in declaration order.
pub const fn is_consistent(message: &MessageDescriptor) -> bool {
    let Some(size) = message.size else { return false };
    // The offset of the next field for each element size (8, 4, 2 and 1 bytes), then of the next nested message.
    let mut next = [0; 5];
    let mut index = 0;
    while index < message.fields.len() {
        let (class, size) = class_and_size(&message.fields[index]);
        let mut later = class + 1;
        while later < next.len() {
            next[later] += size;
            later += 1;
        }
        index += 1;
    }
    next[4] = align(next[4]);
    let mut end = 0;
    index = 0;
    while index < message.fields.len() {
        let field = &message.fields[index];
        let (class, size) = class_and_size(field);
        if field.offset != next[class] {
            return false;
        }
        next[class] += size;
        if next[class] > end {
            end = next[class];
        }
        index += 1;
    }
    size.no_padding == end && size.padded == align(end)
}

/// The index of the field's element-size class, and the size of the whole field.
const fn class_and_size(field: &FieldDescriptor) -> (usize, usize) {
    let (class, element_size) = match field.element {
        Element::Scalar(scalar) => (3 - scalar.size().ilog2() as usize, scalar.size()),
        Element::Text => (3, 1),
        Element::Message(nested) => (4, nested.padded_size()),
        Element::String { .. } => (4, 0),
    };
    let count = match field.shape {
        Shape::Array(length) => length as usize,
        Shape::Single | Shape::Bounded(_) | Shape::Sequence => 1,
    };
    (class, element_size * count)
}

/// Checks the layouts of messages at compile time, to detect nested messages whose size has changed.
///
/// One assertion for a whole module compiles much faster than one assertion for each message.
#[macro_export]
macro_rules! assert_layouts {
    ($($type:ident;)*) => {
        const _: () = {
            let consistent = [$($crate::layout::is_consistent(<$type as $crate::record::Record>::DESCRIPTOR)),*];
            let mut index = 0;
            while index < consistent.len() {
                assert!(consistent[index], "the layout of a message doesn't match its fields");
                index += 1;
            }
        };
    };
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::descriptor::field;

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
    fn sorts_by_element_size_and_keeps_the_declared_order_within_a_size() {
        let found = placed([scalar(1, 1), scalar(8, 1), scalar(4, 3), scalar(1, 2), scalar(8, 1)]);
        assert_eq!(found, ([28, 0, 16, 29, 8], Size { padded: 32, no_padding: 31 }));
    }

    #[test]
    fn places_nested_messages_last_and_aligns_them_to_8_bytes() {
        let found = placed([nested(40, 5), scalar(8, 1), scalar(1, 3)]);
        assert_eq!(found, ([16, 0, 8], Size { padded: 216, no_padding: 216 }));
    }

    #[test]
    fn saturates_sizes() {
        assert_eq!(placed([scalar(8, usize::MAX), scalar(1, 1)]).1.padded, usize::MAX);
    }

    #[test]
    fn accepts_the_layout_of_place_and_rejects_others() {
        const NESTED: MessageDescriptor =
            MessageDescriptor { size: Some(Size { padded: 40, no_padding: 40 }), ..MessageDescriptor::NONE };
        fn is_consistent(offsets: [usize; 3], padded: usize, no_padding: usize) -> bool {
            let [a, b, c] = offsets;
            let nested = FieldDescriptor { element: Element::Message(&NESTED), ..field::byte("a", a) };
            let fields = alloc::vec![nested.array(5), field::uint64("b", b), field::byte("c", c).array(3)];
            let size = Some(Size { padded, no_padding });
            super::is_consistent(&MessageDescriptor {
                fields: fields.leak(),
                size,
                ..MessageDescriptor::NONE
            })
        }
        assert!(is_consistent([16, 0, 8], 216, 216));
        assert!(!is_consistent([11, 0, 8], 216, 216), "nested messages are aligned");
        assert!(!is_consistent([16, 3, 0], 216, 216), "scalars go from large to small");
        assert!(!is_consistent([16, 0, 8], 256, 256), "the size is wrong");
    }
}
