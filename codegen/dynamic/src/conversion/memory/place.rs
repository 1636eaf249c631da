//! Locations of fields.

use uavspec_schema::Shape;

use crate::Field;

/// The location of a field in a message.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) at: usize,
    pub(super) stride: usize,
    pub(super) room: Room,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Room {
    /// An array stored among the fields.
    Fixed(usize),
    /// A sequence with its maximum length.
    Varying(Option<u32>),
}

impl Place {
    pub(super) fn of(field: &Field) -> Self {
        let room = match field.shape {
            Shape::Single => Room::Fixed(1),
            Shape::Array(length) => Room::Fixed(length as usize),
            Shape::Bounded(bound) => Room::Varying(Some(bound)),
            Shape::Sequence => Room::Varying(None),
        };
        Self { at: field.offset, stride: field.stride, room }
    }
}
