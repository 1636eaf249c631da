//! A bounded map of remembered ids. The map forgets the oldest entries first.
//!
//! This is a version of [`Remembered`](super::remembered::Remembered) for the ids of a connection. This version uses a
//! hash table, which is several times faster. Speed matters here because every server message and every UAV state has
//! an id.

use std::collections::VecDeque;
use std::hash::BuildHasher;

use hashbrown::{DefaultHashBuilder, HashTable};

use super::remembered::OVERHEAD;

/// The maximum number by which gaps left by removed entries may outnumber the remaining entries.
const MAX_GAPS: usize = 64;

/// Values by connection serial and id. The oldest values are removed when the size limit is reached.
#[derive(Debug)]
pub struct Ids<V> {
    hasher: DefaultHashBuilder,
    /// The entry numbers, by the hash of the entry's key. Numbers restart from 0 when they overflow.
    table: HashTable<u32>,
    /// The entries in order of insertion; `None` if an entry was removed.
    entries: VecDeque<Option<Entry<V>>>,
    /// The number of the first entry.
    first: u32,
    size: usize,
    limit: usize,
    has_forgotten: bool,
}

#[derive(Debug)]
struct Entry<V> {
    serial: u64,
    id: Box<str>,
    hash: u64,
    size: u32,
    value: V,
}

impl<V> Ids<V> {
    /// Creates an empty map with a size limit in bytes.
    pub fn new(limit: usize) -> Self {
        Self {
            hasher: DefaultHashBuilder::default(),
            table: HashTable::new(),
            entries: VecDeque::new(),
            first: 0,
            size: 0,
            limit,
            has_forgotten: false,
        }
    }

    /// True if an entry was removed because of the limit.
    pub(crate) fn has_forgotten(&self) -> bool {
        self.has_forgotten
    }

    /// True if there is a value.
    pub fn contains(&self, serial: u64, id: &str) -> bool {
        !self.table.is_empty() && self.find(self.hash(serial, id), serial, id).is_some()
    }

    /// A value.
    pub fn get_mut(&mut self, serial: u64, id: &str) -> Option<&mut V> {
        let at = self.find(self.hash(serial, id), serial, id)?;
        self.entries[at].as_mut().map(|entry| &mut entry.value)
    }

    /// Inserts a value of roughly this size in bytes, replacing any existing value for the key.
    pub fn insert(&mut self, serial: u64, id: &str, value: V, size: usize) {
        let hash = self.hash(serial, id);
        self.remove_hashed(hash, serial, id);
        self.insert_hashed(hash, serial, id, value, size);
    }

    /// Inserts a value of roughly this size in bytes, unless there is a value for the key. Returns true if the value was
    /// inserted.
    pub(crate) fn insert_new(&mut self, serial: u64, id: &str, value: V, size: usize) -> bool {
        let hash = self.hash(serial, id);
        let is_new = self.find(hash, serial, id).is_none();
        if is_new {
            self.insert_hashed(hash, serial, id, value, size);
        }
        is_new
    }

    fn insert_hashed(&mut self, hash: u64, serial: u64, id: &str, value: V, size: usize) {
        let size = u32::try_from(size + OVERHEAD).unwrap_or(u32::MAX);
        self.size += size as usize;
        let number = self.number(self.entries.len());
        self.entries.push_back(Some(Entry { serial, id: id.into(), hash, size, value }));
        let (entries, first) = (&self.entries, self.first);
        self.table.insert_unique(hash, number, |number| hash_of(entries, first, *number));
        while self.size > self.limit {
            let Some(oldest) = self.entries.pop_front() else { break };
            if let Some(entry) = oldest {
                self.size -= entry.size as usize;
                self.has_forgotten = true;
                self.unlist(entry.hash, self.first);
            }
            self.first = self.first.wrapping_add(1);
        }
        // Gaps take memory as well.
        if self.entries.len() > 2 * self.table.len() + MAX_GAPS {
            self.close_gaps();
        }
    }

    /// Removes a value.
    pub fn remove(&mut self, serial: u64, id: &str) -> Option<V> {
        if self.table.is_empty() {
            return None;
        }
        self.remove_hashed(self.hash(serial, id), serial, id)
    }

    fn remove_hashed(&mut self, hash: u64, serial: u64, id: &str) -> Option<V> {
        let at = self.find(hash, serial, id)?;
        let entry = self.entries[at].take()?;
        self.size -= entry.size as usize;
        self.unlist(entry.hash, self.number(at));
        Some(entry.value)
    }

    /// Removes all entries.
    pub fn clear(&mut self) {
        self.table.clear();
        self.entries.clear();
        self.size = 0;
    }

    fn hash(&self, serial: u64, id: &str) -> u64 {
        self.hasher.hash_one((serial, id))
    }

    /// The index of an entry.
    fn find(&self, hash: u64, serial: u64, id: &str) -> Option<usize> {
        let is_match = |number: &u32| {
            let entry = self.entries.get(position(self.first, *number)).and_then(Option::as_ref);
            entry.is_some_and(|entry| entry.hash == hash && entry.serial == serial && *entry.id == *id)
        };
        self.table.find(hash, is_match).map(|number| position(self.first, *number))
    }

    /// Removes an entry's number from the table.
    fn unlist(&mut self, hash: u64, number: u32) {
        if let Ok(listed) = self.table.find_entry(hash, |listed| *listed == number) {
            listed.remove();
        }
    }

    fn close_gaps(&mut self) {
        self.entries.retain(Option::is_some);
        self.table.clear();
        for at in 0..self.entries.len() {
            let number = self.number(at);
            let (entries, first) = (&self.entries, self.first);
            let hash = hash_of(entries, first, number);
            self.table.insert_unique(hash, number, |number| hash_of(entries, first, *number));
        }
    }

    /// The number of the entry at an index. The size limit allows far fewer entries than there are numbers.
    #[allow(clippy::cast_possible_truncation)]
    fn number(&self, at: usize) -> u32 {
        self.first.wrapping_add(at as u32)
    }
}

/// The index of an entry, from its number and the first entry's number.
fn position(first: u32, number: u32) -> usize {
    number.wrapping_sub(first) as usize
}

/// The hash of an entry's key. The entry must exist.
fn hash_of<V>(entries: &VecDeque<Option<Entry<V>>>, first: u32, number: u32) -> u64 {
    let entry = entries.get(position(first, number)).and_then(Option::as_ref);
    entry.map_or(0, |entry| entry.hash)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use uavspec_test_support::extent;

    use super::super::remembered::Remembered;
    use super::*;

    /// An operation on an id.
    #[derive(Clone, Copy, Debug)]
    enum Step {
        Insert(usize),
        InsertNew(usize),
        Remove,
        Get,
        Clear,
    }

    fn step() -> impl Strategy<Value = Step> {
        prop_oneof![
            10 => (0_usize..100).prop_map(Step::Insert),
            10 => (0_usize..100).prop_map(Step::InsertNew),
            10 => Just(Step::Remove),
            10 => Just(Step::Get),
            1 => Just(Step::Clear),
        ]
    }

    #[test]
    fn removed_entries_take_no_memory() {
        let mut ids = Ids::new(1 << 20);
        for number in 0..10_000 {
            ids.insert(number, "kite", (), 10);
            ids.remove(number, "kite");
        }
        assert!(ids.entries.len() <= MAX_GAPS + 2 && ids.size == 0 && !ids.has_forgotten());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(extent(256, 48)))]

        #[test]
        fn behaves_like_the_general_memory(
            steps in prop::collection::vec((step(), 0_u64..3, "[a-f]{1,2}"), 0..300),
        ) {
            let limit = 20 * (OVERHEAD + 50);
            let (mut ids, mut other) = (Ids::new(limit), Remembered::new(limit));
            // Numbers overflow.
            ids.first = u32::MAX - 20;
            for (number, (step, serial, id)) in steps.into_iter().enumerate() {
                let key = (serial, id.clone());
                match step {
                    Step::Insert(size) => {
                        ids.insert(serial, &id, number, size);
                        other.insert(key, number, size);
                    }
                    Step::InsertNew(size) => {
                        let is_new = !other.contains(&key);
                        prop_assert_eq!(ids.insert_new(serial, &id, number, size), is_new);
                        if is_new {
                            other.insert(key, number, size);
                        }
                    }
                    Step::Remove => prop_assert_eq!(ids.remove(serial, &id), other.remove(&key)),
                    Step::Get => {
                        prop_assert_eq!(ids.contains(serial, &id), other.contains(&key));
                        prop_assert_eq!(ids.get_mut(serial, &id).is_some(), other.contains(&key));
                    }
                    Step::Clear => {
                        ids.clear();
                        other.clear();
                    }
                }
                prop_assert_eq!(ids.has_forgotten(), other.has_forgotten());
            }
        }
    }
}
