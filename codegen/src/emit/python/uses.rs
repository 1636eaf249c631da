//! Names from elsewhere.

use std::collections::BTreeSet;

/// Names that a module takes from elsewhere.
#[derive(Default)]
pub(super) struct Uses {
    /// From `typing`.
    pub(super) typing: BTreeSet<&'static str>,
    /// From `typing`, of which earlier versions of Python have none.
    pub(super) recent: BTreeSet<&'static str>,
    pub(super) is_flags_used: bool,
    pub(super) is_open_enum_used: bool,
}
