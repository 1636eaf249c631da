//! Imported names.

use std::collections::BTreeSet;

/// The names that a module imports.
#[derive(Default)]
pub(super) struct Uses {
    /// Names from `typing`.
    pub(super) typing: BTreeSet<&'static str>,
    /// Names that `typing` lacks in older Python versions.
    pub(super) recent: BTreeSet<&'static str>,
    pub(super) is_flags_used: bool,
    pub(super) is_open_enum_used: bool,
}
