//! The limits on what this crate reads and stores. They bound the time and the memory that hostile input takes.

/// The maximum length of the name of a topic, a type or a node, in bytes. ROS 2 has the same limit.
pub const MAX_NAME: usize = 256;

// Findings.

/// The maximum number of groups of findings for each rule. Hostile input could produce any number of groups.
pub(crate) const MAX_GROUPS: usize = 1_000;

/// The maximum number of groups for all rules.
pub(crate) const MAX_ALL_GROUPS: usize = 10_000;

/// The maximum number of findings in a record that can be removed again.
pub(crate) const MAX_LATEST: usize = 10_000;

// JSON.

/// The maximum nesting depth, equal to the limit of `serde_json`.
pub(crate) const MAX_DEPTH: usize = 127;

/// The maximum number of values in a tree. Each value takes dozens of times as much memory as its text.
pub(crate) const MAX_VALUES: usize = 1 << 20;
