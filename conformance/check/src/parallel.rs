//! Runs a job for several items in parallel.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Mutex, PoisonError, mpsc};
use std::thread;

/// The maximum number of results per thread that are kept while the result of an earlier item is missing.
const MAX_EARLY: usize = 64;

/// Runs `work` for each of `items` in parallel. Passes the results to `take` in item order, each as early as possible.
/// If an item takes long, only a limited number of later results are kept.
///
/// `jobs` is the number of threads; the default is the number of processors.
pub fn each<T: Sync, R: Send>(
    items: &[T],
    jobs: Option<NonZeroUsize>,
    work: impl Fn(&T) -> R + Sync,
    mut take: impl FnMut(&T, R),
) {
    let jobs = jobs.or_else(|| thread::available_parallelism().ok()).map_or(1, NonZeroUsize::get);
    let jobs = jobs.min(items.len());
    if jobs <= 1 {
        return items.iter().for_each(|item| take(item, work(item)));
    }
    // Two channels: the numbers of the items that threads may start, and the results of finished items. Threads end
    // when all items have been started.
    let (starting, started) = mpsc::channel();
    let (sender, done) = mpsc::channel();
    let (started, work) = (Mutex::new(started), &work);
    let run = |sender: mpsc::Sender<_>| {
        while let Ok(at) = next(&started) {
            let result = catch_unwind(AssertUnwindSafe(|| work(&items[at])));
            // After a panic, the results have no receiver.
            let _ = sender.send((at, result));
        }
    };
    thread::scope(|scope| {
        for _ in 0..jobs {
            let (run, sender) = (&run, sender.clone());
            scope.spawn(move || run(sender));
        }
        let starting = starting;
        let mut waiting = 0..items.len();
        let mut start = |count: usize| {
            // The receiver outlives the threads.
            waiting.by_ref().take(count).for_each(|at| _ = starting.send(at));
        };
        start(jobs.saturating_mul(MAX_EARLY));
        let mut early = BTreeMap::new();
        for (at, item) in items.iter().enumerate() {
            let result = loop {
                if let Some(result) = early.remove(&at) {
                    break result;
                }
                early.extend(done.recv());
            };
            take(item, result.unwrap_or_else(|panic| resume_unwind(panic)));
            start(1);
        }
    });
}

/// Waits for the number of the next item.
fn next(started: &Mutex<mpsc::Receiver<usize>>) -> Result<usize, mpsc::RecvError> {
    started.lock().unwrap_or_else(PoisonError::into_inner).recv()
}

#[cfg(test)]
mod tests {
    use std::sync::Condvar;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    #[test]
    fn returns_results_in_the_order_of_the_items() {
        let items: Vec<u64> = (0..50).collect();
        for jobs in [1, 3, 100] {
            let mut taken = Vec::new();
            let (finished, changed) = (Mutex::new(0), Condvar::new());
            let square = |item: &u64| {
                // The first item finishes only after each other thread has finished an item.
                let others = if *item == 0 { jobs.min(items.len()) - 1 } else { 0 };
                let finished = finished.lock().expect("no panic");
                *changed.wait_while(finished, |finished| *finished < others).expect("no panic") += 1;
                changed.notify_all();
                item * item
            };
            each(&items, NonZeroUsize::new(jobs), square, |item, result| taken.push((*item, result)));
            assert_eq!(taken, items.iter().map(|item| (*item, item * item)).collect::<Vec<_>>());
        }
        each(&[] as &[u8], None, |_| (), |_, ()| panic!("there are no items"));
    }

    #[test]
    fn keeps_a_limited_number_of_early_results() {
        let (items, jobs): (Vec<usize>, _) = ((0..2_000).collect(), 3);
        let (finished, max) = (Mutex::new(0), AtomicUsize::new(0));
        let changed = Condvar::new();
        let work = |item: &usize| {
            let mut finished = finished.lock().expect("no panic");
            if *item == 0 {
                // The other threads finish all items before the first item that must wait.
                let early = jobs.min(items.len()) * MAX_EARLY - 1;
                finished = changed.wait_while(finished, |finished| *finished < early).expect("no panic");
                max.store(*finished, Ordering::SeqCst);
            }
            *finished += 1;
            changed.notify_all();
        };
        let mut number = 0;
        each(&items, NonZeroUsize::new(jobs), work, |_, ()| number += 1);
        assert_eq!(number, items.len());
        assert_eq!(max.load(Ordering::SeqCst), jobs * MAX_EARLY - 1);
    }

    #[test]
    fn a_panic_ends_all_threads() {
        let items: Vec<usize> = (0..2_000).collect();
        let work = |item: &usize| assert_ne!(*item, 0, "the first item fails");
        let run = || each(&items, NonZeroUsize::new(3), work, |_, ()| ());
        assert!(std::panic::catch_unwind(run).is_err());
    }
}
