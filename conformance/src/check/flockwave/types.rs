//! The number of messages of each type.

use std::collections::HashMap;

use super::TypeCount;
use crate::check::coverage::Tally;

/// The maximum number of unknown types that are counted by name. Hostile input may contain any number of types.
const MAX_UNKNOWN: usize = 1_000;

/// The maximum length of an unknown type's name, in bytes.
const MAX_NAME: usize = 128;

/// The counts of all types.
#[derive(Default)]
pub(super) struct Types {
    all: Vec<(String, TypeCounts)>,
    /// The indices of the types, by name.
    indices: HashMap<String, usize>,
    num_unknown: usize,
    /// The index of the latest message's type.
    latest: usize,
}

/// The counts of a type.
#[derive(Default)]
pub(super) struct TypeCounts {
    /// True if the definitions contain the type.
    pub(super) is_known: bool,
    pub(super) messages: TypeCount,
    /// The messages from the server.
    pub(super) tally: Tally,
    /// The number of values in the messages from the server.
    pub(super) values: u64,
}

impl Types {
    /// The counts of a type. `is_known` is called for a new type. Returns `None` if the type isn't counted by name.
    pub(super) fn get(&mut self, name: &str, is_known: impl FnOnce() -> bool) -> Option<&mut TypeCounts> {
        // Consecutive messages usually have the same type.
        if self.all.get(self.latest).is_none_or(|(latest, _)| latest != name) {
            self.latest = match self.indices.get(name) {
                Some(index) => *index,
                None => self.add(name, is_known())?,
            };
        }
        self.all.get_mut(self.latest).map(|(_, counts)| counts)
    }

    fn add(&mut self, name: &str, is_known: bool) -> Option<usize> {
        if !is_known && (self.num_unknown == MAX_UNKNOWN || name.len() > MAX_NAME) {
            return None;
        }
        self.num_unknown += usize::from(!is_known);
        let index = self.all.len();
        self.indices.insert(name.to_owned(), index);
        self.all.push((name.to_owned(), TypeCounts { is_known, ..TypeCounts::default() }));
        Some(index)
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &(String, TypeCounts)> {
        self.all.iter()
    }
}
