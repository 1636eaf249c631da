//! Work that is done several times at once.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

/// Does `work` with each of `items`, several at a time, and hands the results to `take` in the order of the
/// items, each as soon as it and all before it are there.
///
/// `jobs` is how many at a time: where nothing is said, as many as there are processors.
pub fn each<T: Sync, R: Send>(
    items: &[T],
    jobs: Option<NonZeroUsize>,
    work: impl Fn(&T) -> R + Sync,
    mut take: impl FnMut(&T, R),
) {
    let jobs = jobs.or_else(|| thread::available_parallelism().ok()).map_or(1, NonZeroUsize::get);
    let next = AtomicUsize::new(0);
    let (sender, results) = mpsc::channel();
    thread::scope(|scope| {
        for _ in 0..jobs.min(items.len()) {
            let (sender, next, work) = (sender.clone(), &next, &work);
            scope.spawn(move || {
                loop {
                    let at = next.fetch_add(1, Ordering::Relaxed);
                    let Some(item) = items.get(at) else { return };
                    // Who takes the results is there until all have come.
                    let _ = sender.send((at, work(item)));
                }
            });
        }
        drop(sender);
        let mut early = BTreeMap::new();
        let mut expected = 0;
        for (at, result) in results {
            early.insert(at, result);
            while let Some(result) = early.remove(&expected) {
                take(&items[expected], result);
                expected += 1;
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_the_order_of_the_items() {
        let items: Vec<u64> = (0..50).collect();
        for jobs in [1, 3, 100] {
            let mut taken = Vec::new();
            let square = |item: &u64| {
                // The first takes longest.
                thread::sleep(std::time::Duration::from_micros(50 - item));
                item * item
            };
            each(&items, NonZeroUsize::new(jobs), square, |item, result| taken.push((*item, result)));
            assert_eq!(taken, items.iter().map(|item| (*item, item * item)).collect::<Vec<_>>());
        }
        each(&[] as &[u8], None, |_| (), |_, ()| panic!("there is nothing"));
    }
}
