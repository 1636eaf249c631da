//! A bounded map. The map forgets the oldest entries first.

use std::collections::{BTreeMap, VecDeque};

/// The approximate overhead of an entry, in bytes.
pub(super) const OVERHEAD: usize = 128;

/// Values by connection serial and id.
pub type ById<V> = Remembered<(u64, String), V>;

/// Values by key. The oldest values are removed when the size limit is reached.
#[derive(Debug)]
pub struct Remembered<K, V> {
    values: BTreeMap<K, Entry<V>>,
    /// The keys with the numbers of their entries, in order of insertion. The list may include keys of removed entries.
    order: VecDeque<(u64, K)>,
    next: u64,
    size: usize,
    limit: usize,
    has_forgotten: bool,
}

#[derive(Debug)]
struct Entry<V> {
    number: u64,
    size: usize,
    value: V,
}

impl<K: Clone + Ord, V> Remembered<K, V> {
    /// Creates an empty map with a size limit in bytes.
    pub fn new(limit: usize) -> Self {
        Self {
            values: BTreeMap::new(),
            order: VecDeque::new(),
            next: 0,
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
    pub fn contains(&self, key: &K) -> bool {
        self.values.contains_key(key)
    }

    pub(crate) fn get(&self, key: &K) -> Option<&V> {
        self.values.get(key).map(|entry| &entry.value)
    }

    /// A value.
    pub fn get_mut(&mut self, key: &K) -> Option<&mut V> {
        self.values.get_mut(key).map(|entry| &mut entry.value)
    }

    /// Inserts a value of roughly this size in bytes, unless there is a value for the key. Returns true if the value was
    /// inserted.
    pub(crate) fn insert_new(&mut self, key: K, value: V, size: usize) -> bool {
        let is_new = !self.contains(&key);
        if is_new {
            self.insert(key, value, size);
        }
        is_new
    }

    /// Inserts a value of roughly this size in bytes, replacing any existing value for the key.
    pub fn insert(&mut self, key: K, value: V, size: usize) {
        self.remove(&key);
        let size = size + OVERHEAD;
        self.size += size;
        self.values.insert(key.clone(), Entry { number: self.next, size, value });
        self.order.push_back((self.next, key));
        self.next += 1;
        while self.size > self.limit {
            let Some((number, key)) = self.order.pop_front() else { break };
            if self.is_current(number, &key) {
                self.remove(&key);
                self.has_forgotten = true;
            }
        }
        // Keys of removed entries take memory as well.
        if self.order.len() > 2 * self.values.len() + 64 {
            let values = &self.values;
            self.order.retain(|(number, key)| values.get(key).is_some_and(|entry| entry.number == *number));
        }
    }

    /// Removes an entry.
    pub fn remove(&mut self, key: &K) -> Option<V> {
        let entry = self.values.remove(key)?;
        self.size -= entry.size;
        Some(entry.value)
    }

    /// Removes the values of consecutive keys, from `first` up to but excluding the first key that `is_wanted` rejects.
    /// Returns the values in order of insertion.
    pub(crate) fn take(&mut self, first: &K, mut is_wanted: impl FnMut(&K) -> bool) -> Vec<V> {
        let mut wanted: Vec<(u64, K)> = self
            .values
            .range(first..)
            .take_while(|(key, _)| is_wanted(key))
            .map(|(key, entry)| (entry.number, key.clone()))
            .collect();
        wanted.sort_unstable_by_key(|(number, _)| *number);
        wanted.iter().filter_map(|(_, key)| self.remove(key)).collect()
    }

    /// Removes all entries.
    pub fn clear(&mut self) {
        self.values.clear();
        self.order.clear();
        self.size = 0;
    }

    fn is_current(&self, number: u64, key: &K) -> bool {
        self.values.get(key).is_some_and(|entry| entry.number == number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forgets_the_oldest_entry_at_the_size_limit() {
        let mut memory = Remembered::new(3 * (OVERHEAD + 10));
        for number in 0..3 {
            memory.insert(number, number, 10);
        }
        assert!(!memory.has_forgotten());
        // Inserting a key again makes it the newest.
        memory.insert(0, 7, 10);
        memory.insert(3, 3, 10);
        assert!(memory.has_forgotten());
        assert_eq!((0..4).map(|key| memory.contains(&key)).collect::<Vec<_>>(), [true, false, true, true]);
        assert_eq!(memory.take(&0, |key| *key < 3), [2, 7]);
    }

    #[test]
    fn removed_entries_take_no_memory() {
        let mut memory = Remembered::new(1 << 20);
        for number in 0..10_000 {
            memory.insert(number, (), 10);
            memory.remove(&number);
        }
        assert!(memory.order.len() <= 66 && memory.size == 0 && !memory.has_forgotten());
    }
}
