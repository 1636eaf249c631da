//! The compiled formats of logs.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use uavspec_dynamic::{FormatError, Types};
use uavspec_lint::release::LayoutHashes;

/// The maximum total size of the sets in a cache, as text, in bytes. It is sufficient for eight real sets. Types take up
/// to fifty times as much memory.
const MAX_SIZE: usize = 256 << 10;

/// The compiled formats of a log.
#[derive(Debug)]
pub struct FormatSet {
    pub(super) types: Types,
    pub(super) errors: Vec<FormatError>,
    /// The hash of each type's layout.
    layouts: OnceLock<Vec<Option<u64>>>,
    /// True if the set is in a cache.
    pub is_shared: bool,
}

impl FormatSet {
    fn new<'f>(formats: impl Iterator<Item = (&'f str, &'f str)>, is_shared: bool) -> Self {
        let (types, errors) = Types::from_ulog_formats(formats);
        Self { types, errors, layouts: OnceLock::new(), is_shared }
    }

    /// The types, in [`ULOG_PACKAGE`](uavspec_dynamic::ULOG_PACKAGE).
    pub fn types(&self) -> &Types {
        &self.types
    }

    /// The hash of each type's layout, if its size is fixed.
    pub fn layouts(&self) -> &[Option<u64>] {
        self.layouts.get_or_init(|| {
            let mut layouts = LayoutHashes::default();
            self.types.iter().map(|format| layouts.get(format)).collect()
        })
    }
}

/// The formats of the logs in a run. Logs of the same firmware have the same formats, which are compiled only once.
#[derive(Debug, Default)]
pub struct FormatCache(Mutex<Sets>);

#[derive(Debug, Default)]
struct Sets {
    /// The sets, by the text of their formats.
    by_text: HashMap<String, Arc<FormatSet>>,
    /// The total size of the texts.
    size: usize,
}

impl FormatCache {
    /// The compiled set of these formats.
    pub(super) fn get<'f>(
        &self,
        formats: impl Iterator<Item = (&'f str, &'f str)> + Clone,
    ) -> Arc<FormatSet> {
        let mut text = String::new();
        for (name, fields) in formats.clone() {
            // The lengths separate the formats. Names and fields may contain any character.
            let _ = write!(text, "{} {} {name}{fields}", name.len(), fields.len());
        }
        if text.len() > MAX_SIZE {
            return Arc::new(FormatSet::new(formats, false));
        }
        let sets = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = sets().by_text.get(&text) {
            return Arc::clone(known);
        }
        let set = Arc::new(FormatSet::new(formats, true));
        let mut sets = sets();
        // Another thread may have compiled the same set.
        if let Some(known) = sets.by_text.get(&text) {
            return Arc::clone(known);
        }
        if sets.size + text.len() > MAX_SIZE {
            *sets = Sets::default();
        }
        sets.size += text.len();
        sets.by_text.insert(text, Arc::clone(&set));
        set
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_formats_share_a_set() {
        let cache = FormatCache::default();
        let formats = [("wind", "uint64_t timestamp;float speed;"), ("gust", "wind wind;")];
        let first = cache.get(formats.into_iter());
        assert!(Arc::ptr_eq(&first, &cache.get(formats.into_iter())));
        assert!(!Arc::ptr_eq(&first, &cache.get(formats[..1].iter().copied())));
        assert!(!Arc::ptr_eq(&first, &cache.get(formats.into_iter().rev())));
        assert_eq!((first.types.iter().len(), first.layouts().len()), (2, 2));
        // The same characters, but other formats.
        assert!(!Arc::ptr_eq(&cache.get([("ab", "c")].into_iter()), &cache.get([("a", "bc")].into_iter())));
    }

    #[test]
    fn the_size_of_sets_is_limited() {
        let cache = FormatCache::default();
        let fields = format!("uint64_t {};", "a".repeat(MAX_SIZE / 4));
        for number in 0..20 {
            let name = format!("wind_{number}");
            cache.get([(name.as_str(), fields.as_str())].into_iter());
            let sets = cache.0.lock().expect("no panic");
            let size: usize = sets.by_text.keys().map(String::len).sum();
            assert!(sets.size == size && size <= MAX_SIZE && size > 0, "{size}");
        }
        let long = fields.repeat(5);
        let long = [("wind", long.as_str())];
        assert!(!Arc::ptr_eq(&cache.get(long.into_iter()), &cache.get(long.into_iter())));
    }
}
