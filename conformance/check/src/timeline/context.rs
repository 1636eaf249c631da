//! The things that all followers of records need.

use uavspec_rules::definitions::Definitions;

use super::label::Texts;
use super::lane::Lanes;

/// The context of a record.
pub(super) struct Context<'c> {
    pub(super) definitions: &'c Definitions,
    pub(super) texts: &'c Texts,
    pub(super) lanes: &'c mut Lanes,
    /// The time in µs, by the clock of the capture.
    pub(super) time: u64,
}
