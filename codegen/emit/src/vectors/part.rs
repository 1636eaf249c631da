//! Messages nested in other messages.

use uavspec_schema::MessageId;

use super::case::Sample;

/// The messages for which vectors can be created, indexed by message id.
pub(super) struct Parts(pub(super) Vec<Option<Part>>);

/// A message nested in other messages.
pub(super) struct Part {
    /// The valid message nearest to zero.
    pub(super) zero: String,
    /// Sample values, one for each rule.
    pub(super) samples: Vec<Sample>,
}

impl Parts {
    pub(super) fn get(&self, id: MessageId) -> Option<&Part> {
        self.0.get(id.0 as usize)?.as_ref()
    }
}
