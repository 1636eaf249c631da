//! Runs a job for several items in parallel.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

/// Runs `work` for each of `items` in parallel. Passes the results to `take` in item order, each as early as possible.
///
/// `jobs` is the number of threads; the default is the number of processors.
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
                    // The receiver outlives all senders.
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
    fn returns_results_in_the_order_of_the_items() {
        let items: Vec<u64> = (0..50).collect();
        for jobs in [1, 3, 100] {
            let mut taken = Vec::new();
            let square = |item: &u64| {
                // The first item takes longest.
                thread::sleep(std::time::Duration::from_micros(50 - item));
                item * item
            };
            each(&items, NonZeroUsize::new(jobs), square, |item, result| taken.push((*item, result)));
            assert_eq!(taken, items.iter().map(|item| (*item, item * item)).collect::<Vec<_>>());
        }
        each(&[] as &[u8], None, |_| (), |_, ()| panic!("there are no items"));
    }
}
