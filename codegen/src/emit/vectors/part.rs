//! Messages as parts of others.

use super::case::Sample;
use crate::schema::MessageId;

/// All messages that vectors can be made for.
pub(super) struct Parts(pub(super) Vec<Option<Part>>);

/// A message as a part of others.
pub(super) struct Part {
    /// The valid message nearest to zero.
    pub(super) zero: String,
    /// What may stand in its place: one value for each rule.
    pub(super) samples: Vec<Sample>,
}

impl Parts {
    pub(super) fn get(&self, id: MessageId) -> Option<&Part> {
        self.0.get(id.0 as usize)?.as_ref()
    }
}
