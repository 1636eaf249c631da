//! A memory of ids, with a bound: what was put in first is forgotten first.
//!
//! It does for the ids of connections what [`Remembered`](super::remembered::Remembered) does for any keys, which it could be
//! instead; but each message of a server brings an id, and each state of a UAV, and a table of hashes finds those in a
//! fraction of the time.

use std::collections::VecDeque;
use std::hash::BuildHasher;

use hashbrown::{DefaultHashBuilder, HashTable};

use super::remembered::OVERHEAD;

/// How many places of what was removed may stay, beside as many as there are entries.
const MAX_GAPS: usize = 64;

/// Values by the serial of a connection and an id, of which the oldest are forgotten where they would take too much room.
#[derive(Debug)]
pub(crate) struct Ids<V> {
    hasher: DefaultHashBuilder,
    /// The number of each entry, by the hash of its key.
    table: HashTable<u64>,
    /// The entries in the order in which they came; some are gone already.
    entries: VecDeque<Option<Entry<V>>>,
    /// The number of the first of them.
    first: u64,
    size: usize,
    limit: usize,
    has_forgotten: bool,
}

#[derive(Debug)]
struct Entry<V> {
    serial: u64,
    id: Box<str>,
    hash: u64,
    size: usize,
    value: V,
}

impl<V> Ids<V> {
    /// Nothing yet, and never more than so many bytes.
    pub(crate) fn new(limit: usize) -> Self {
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

    /// Whether something was forgotten for lack of room.
    pub(crate) fn has_forgotten(&self) -> bool {
        self.has_forgotten
    }

    pub(crate) fn contains(&self, serial: u64, id: &str) -> bool {
        !self.table.is_empty() && self.find(self.hash(serial, id), serial, id).is_some()
    }

    pub(crate) fn get_mut(&mut self, serial: u64, id: &str) -> Option<&mut V> {
        let at = self.find(self.hash(serial, id), serial, id)?;
        self.entries[at].as_mut().map(|entry| &mut entry.value)
    }

    /// Puts in a value that takes about so many bytes, in place of one with the same key.
    pub(crate) fn insert(&mut self, serial: u64, id: &str, value: V, size: usize) {
        self.remove(serial, id);
        let (hash, size) = (self.hash(serial, id), size + OVERHEAD);
        self.size += size;
        let number = self.first + self.entries.len() as u64;
        self.entries.push_back(Some(Entry { serial, id: id.into(), hash, size, value }));
        let (entries, first) = (&self.entries, self.first);
        self.table.insert_unique(hash, number, |number| hash_of(entries, first, *number));
        while self.size > self.limit {
            let Some(oldest) = self.entries.pop_front() else { break };
            if let Some(entry) = oldest {
                self.size -= entry.size;
                self.has_forgotten = true;
                self.unlist(entry.hash, self.first);
            }
            self.first += 1;
        }
        // Where something was takes room as well.
        if self.entries.len() > 2 * self.table.len() + MAX_GAPS {
            self.close_gaps();
        }
    }

    pub(crate) fn remove(&mut self, serial: u64, id: &str) -> Option<V> {
        if self.table.is_empty() {
            return None;
        }
        let at = self.find(self.hash(serial, id), serial, id)?;
        let entry = self.entries[at].take()?;
        self.size -= entry.size;
        self.unlist(entry.hash, self.first + at as u64);
        Some(entry.value)
    }

    /// Forgets all.
    pub(crate) fn clear(&mut self) {
        self.table.clear();
        self.entries.clear();
        self.size = 0;
    }

    fn hash(&self, serial: u64, id: &str) -> u64 {
        self.hasher.hash_one((serial, id))
    }

    /// The place of an entry.
    fn find(&self, hash: u64, serial: u64, id: &str) -> Option<usize> {
        let is_it = |number: &u64| {
            let entry = position(self.first, *number).and_then(|at| self.entries.get(at)?.as_ref());
            entry.is_some_and(|entry| entry.serial == serial && *entry.id == *id)
        };
        self.table.find(hash, is_it).and_then(|number| position(self.first, *number))
    }

    /// Takes the number of an entry out of the table.
    fn unlist(&mut self, hash: u64, number: u64) {
        if let Ok(listed) = self.table.find_entry(hash, |listed| *listed == number) {
            listed.remove();
        }
    }

    fn close_gaps(&mut self) {
        self.entries.retain(Option::is_some);
        self.table.clear();
        for at in 0..self.entries.len() as u64 {
            let hash = hash_of(&self.entries, 0, at);
            let (entries, first) = (&self.entries, self.first);
            self.table.insert_unique(hash, first + at, |number| hash_of(entries, first, *number));
        }
    }
}

/// The place of an entry with a number, where the first has another.
fn position(first: u64, number: u64) -> Option<usize> {
    usize::try_from(number.checked_sub(first)?).ok()
}

/// The hash of the key of an entry. Each that is listed is there.
fn hash_of<V>(entries: &VecDeque<Option<Entry<V>>>, first: u64, number: u64) -> u64 {
    let entry = position(first, number).and_then(|at| entries.get(at)?.as_ref());
    entry.map_or(0, |entry| entry.hash)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::remembered::Remembered;
    use super::*;

    /// What is done with an id: it is put in, taken out, or asked for; or all is forgotten.
    #[derive(Clone, Copy, Debug)]
    enum Step {
        Insert(usize),
        Remove,
        Get,
        Clear,
    }

    fn step() -> impl Strategy<Value = Step> {
        prop_oneof![
            20 => (0_usize..100).prop_map(Step::Insert),
            10 => Just(Step::Remove),
            10 => Just(Step::Get),
            1 => Just(Step::Clear),
        ]
    }

    #[test]
    fn what_comes_and_goes_takes_no_room() {
        let mut ids = Ids::new(1 << 20);
        for number in 0..10_000 {
            ids.insert(number, "kite", (), 10);
            ids.remove(number, "kite");
        }
        assert!(ids.entries.len() <= MAX_GAPS + 2 && ids.size == 0 && !ids.has_forgotten());
    }

    proptest! {
        #[test]
        fn it_remembers_as_any_memory_does(
            steps in prop::collection::vec((step(), 0_u64..3, "[a-f]{1,2}"), 0..300),
        ) {
            let limit = 20 * (OVERHEAD + 50);
            let (mut ids, mut other) = (Ids::new(limit), Remembered::new(limit));
            for (number, (step, serial, id)) in steps.into_iter().enumerate() {
                let key = (serial, id.clone());
                match step {
                    Step::Insert(size) => {
                        ids.insert(serial, &id, number, size);
                        other.insert(key, number, size);
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
