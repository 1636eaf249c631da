//! The latest results of some work, for inputs that often repeat.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

/// The latest results of some work, up to a limit.
#[derive(Debug)]
pub struct Recent<T, const LIMIT: usize>(Mutex<VecDeque<Arc<T>>>);

impl<T, const LIMIT: usize> Recent<T, LIMIT> {
    /// The result that satisfies a predicate, or otherwise the result of `make`. Other threads wait until it is made, so that
    /// nothing is made twice.
    pub fn get(&self, is_wanted: impl Fn(&T) -> bool, make: impl FnOnce() -> T) -> Arc<T> {
        let mut results = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = results.iter().find(|known| is_wanted(known)) {
            return Arc::clone(known);
        }
        let result = Arc::new(make());
        results.push_front(Arc::clone(&result));
        results.truncate(LIMIT);
        result
    }
}

impl<T, const LIMIT: usize> Default for Recent<T, LIMIT> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    #[test]
    fn only_the_latest_results_are_stored() {
        let (recent, count) = (Recent::<_, 2>::default(), Cell::new(0));
        let get = |wanted: usize| {
            let make = || {
                count.set(count.get() + 1);
                wanted
            };
            assert_eq!(*recent.get(|known| *known == wanted, make), wanted);
            count.get()
        };
        assert_eq!([1, 2, 1, 2, 3, 2, 1].map(get), [1, 2, 2, 2, 3, 3, 4]);
    }
}
