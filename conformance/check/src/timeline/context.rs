//! The context that all followers of records need.

use uavspec_px4::event::EventMetadata;
use uavspec_rules::definitions::Definitions;

use super::label::Texts;
use super::lane::{Lane, LaneKind, Lanes};

/// The context of a record.
pub(super) struct Context<'c> {
    pub(super) definitions: &'c Definitions,
    pub(super) texts: &'c Texts,
    pub(super) metadata: &'c EventMetadata,
    pub(super) lanes: &'c mut Lanes,
    /// The time in µs, by the clock of the capture.
    pub(super) time: u64,
}

impl Context<'_> {
    /// Returns the index of the lane with this topic, subject and name. If the lane doesn't exist, creates it without a
    /// label, unless there are too many lanes.
    pub(super) fn lane(&mut self, key: (&str, &str, &str), rank: usize, kind: LaneKind) -> Option<usize> {
        let (topic, _, name) = key;
        self.lanes.get(key, || Lane { rank, ..Lane::new(topic, name, kind) })
    }
}
