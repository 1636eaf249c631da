//! A memory with a bound: what was put in first is forgotten first.

use std::collections::{BTreeMap, VecDeque};

/// What an entry takes beside its contents, in bytes; a rough guess.
pub(super) const OVERHEAD: usize = 128;

/// Values by key, of which the oldest are forgotten where they would take too much room.
#[derive(Debug)]
pub(crate) struct Remembered<K, V> {
    values: BTreeMap<K, Entry<V>>,
    /// The keys in the order in which they came, with the number of the entry; some are gone already.
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
    /// Nothing yet, and never more than so many bytes.
    pub(crate) fn new(limit: usize) -> Self {
        Self {
            values: BTreeMap::new(),
            order: VecDeque::new(),
            next: 0,
            size: 0,
            limit,
            has_forgotten: false,
        }
    }

    /// Whether something was forgotten for lack of room.
    pub(crate) fn has_forgotten(&self) -> bool {
        self.has_forgotten
    }

    pub(crate) fn contains(&self, key: &K) -> bool {
        self.values.contains_key(key)
    }

    /// Puts in a value that takes about so many bytes, in place of one with the same key.
    pub(crate) fn insert(&mut self, key: K, value: V, size: usize) {
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
        // Keys of what was removed take room as well.
        if self.order.len() > 2 * self.values.len() + 64 {
            let values = &self.values;
            self.order.retain(|(number, key)| values.get(key).is_some_and(|entry| entry.number == *number));
        }
    }

    pub(crate) fn remove(&mut self, key: &K) -> Option<V> {
        let entry = self.values.remove(key)?;
        self.size -= entry.size;
        Some(entry.value)
    }

    /// Takes out what is wanted from this key on, up to the first that isn't, in the order in which it came.
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

    /// Forgets all.
    pub(crate) fn clear(&mut self) {
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
    fn the_oldest_is_forgotten_where_room_is_short() {
        let mut memory = Remembered::new(3 * (OVERHEAD + 10));
        for number in 0..3 {
            memory.insert(number, number, 10);
        }
        assert!(!memory.has_forgotten());
        // What is put in anew is no longer the oldest.
        memory.insert(0, 7, 10);
        memory.insert(3, 3, 10);
        assert!(memory.has_forgotten());
        assert_eq!((0..4).map(|key| memory.contains(&key)).collect::<Vec<_>>(), [true, false, true, true]);
        assert_eq!(memory.take(&0, |key| *key < 3), [2, 7]);
    }

    #[test]
    fn what_comes_and_goes_takes_no_room() {
        let mut memory = Remembered::new(1 << 20);
        for number in 0..10_000 {
            memory.insert(number, (), 10);
            memory.remove(&number);
        }
        assert!(memory.order.len() <= 66 && memory.size == 0 && !memory.has_forgotten());
    }
}
