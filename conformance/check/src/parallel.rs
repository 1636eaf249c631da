//! Runs a job for several items in parallel.

use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, PoisonError, mpsc};
use std::thread;

/// The maximum number of results for each thread that wait for the result of an earlier item.
const MAX_EARLY: usize = 64;

/// The number of items whose results have been taken. Threads wait if they are too far ahead.
#[derive(Default)]
struct Taken {
    number: Mutex<usize>,
    changed: Condvar,
}

impl Taken {
    /// Raises the number. It never decreases, so results taken after a panic don't make threads wait again.
    fn set(&self, number: usize) {
        let mut taken = self.number.lock().unwrap_or_else(PoisonError::into_inner);
        *taken = number.max(*taken);
        drop(taken);
        self.changed.notify_all();
    }

    /// Waits until more than `number` results minus `max_early` have been taken.
    fn wait(&self, number: usize, max_early: usize) {
        let taken = self.number.lock().unwrap_or_else(PoisonError::into_inner);
        let is_ahead = |taken: &mut usize| number >= taken.saturating_add(max_early);
        drop(self.changed.wait_while(taken, is_ahead).unwrap_or_else(PoisonError::into_inner));
    }
}

/// Ends the waiting of all threads if one of them panics.
struct EndOnPanic<'t>(&'t Taken);

impl Drop for EndOnPanic<'_> {
    fn drop(&mut self) {
        if thread::panicking() {
            self.0.set(usize::MAX);
        }
    }
}

/// Runs `work` for each of `items` in parallel. Passes the results to `take` in item order, each as early as possible.
/// If an item takes long, the results of only a limited number of later items are kept.
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
    // The results are boxed: the list has a place for each item until the end, but most results are taken soon.
    let results: Vec<Mutex<Option<Box<R>>>> = items.iter().map(|_| Mutex::default()).collect();
    let result = |at: usize| results[at].lock().unwrap_or_else(PoisonError::into_inner);
    let work = |at: usize| {
        let found = work(&items[at]);
        *result(at) = Some(Box::new(found));
    };
    in_order(items.len(), jobs, &work, &mut |at| {
        let Some(found) = result(at).take() else { return false };
        take(&items[at], *found);
        true
    });
}

/// Runs `work` for all numbers below `count` in parallel, and `take` for the same numbers in order, each as early as
/// possible. `take` returns false if the work for its number isn't done.
///
/// Not generic, because the compiler would copy all code of the threads for each type of results.
fn in_order(count: usize, jobs: usize, work: &(dyn Fn(usize) + Sync), take: &mut dyn FnMut(usize) -> bool) {
    let max_early = jobs.saturating_mul(MAX_EARLY);
    let (next, taken) = (AtomicUsize::new(0), Taken::default());
    let (sender, done) = mpsc::channel();
    thread::scope(|scope| {
        for _ in 0..jobs {
            let (sender, next, taken) = (sender.clone(), &next, &taken);
            scope.spawn(move || {
                let _end = EndOnPanic(taken);
                loop {
                    let at = next.fetch_add(1, Ordering::Relaxed);
                    if at >= count {
                        return;
                    }
                    taken.wait(at, max_early);
                    work(at);
                    // The receiver outlives all senders.
                    let _ = sender.send(());
                }
            });
        }
        drop(sender);
        let _end = EndOnPanic(&taken);
        let mut expected = 0;
        for () in done {
            while expected < count && take(expected) {
                expected += 1;
                taken.set(expected);
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
            let (finished, changed) = (Mutex::new(0), Condvar::new());
            let square = |item: &u64| {
                // The other threads finish an item each before the first one.
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
                // The other threads finish as many items as they may: all before the first that must wait.
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
        // Results that are taken after the panic don't make threads wait again.
        let taken = Taken::default();
        taken.set(usize::MAX);
        taken.set(1);
        taken.wait(2_000, 1);
    }
}
