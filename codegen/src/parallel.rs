//! Parallel execution.

use std::num::NonZero;
use std::thread::{self, ScopedJoinHandle};

#[cfg(feature = "files")]
use crate::failure::Failure;

/// The number of items from which several threads work on them.
const MIN_ITEMS: usize = 32;

/// Calls `work` for consecutive parts of `items` in several threads, and returns the results in order. The number of
/// parts depends on the system, so the results together must not depend on it.
pub(crate) fn in_parts<'i, T: Sync, R: Send>(items: &'i [T], work: impl Fn(&'i [T]) -> R + Sync) -> Vec<R> {
    let threads = thread::available_parallelism().map_or(1, NonZero::get);
    if threads == 1 || items.len() < MIN_ITEMS {
        return vec![work(items)];
    }
    thread::scope(|scope| {
        let work = &work;
        let parts = items.chunks(items.len().div_ceil(threads));
        let threads: Vec<_> = parts.map(|part| scope.spawn(move || work(part))).collect();
        threads.into_iter().map(join).collect()
    })
}

/// The result of a thread. A panic in a thread is a bug, which is propagated.
fn join<R>(thread: ScopedJoinHandle<'_, R>) -> R {
    thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

/// Calls `work` for each of `items` in a separate thread, and returns the results in order.
#[cfg(feature = "files")]
pub(crate) fn in_parallel<'i, T: Sync, R: Send>(
    items: &'i [T],
    work: impl Fn(&'i T) -> Result<R, Failure> + Sync,
) -> Result<Vec<R>, Failure> {
    thread::scope(|scope| {
        let work = &work;
        let threads: Vec<_> = items.iter().map(|item| scope.spawn(move || work(item))).collect();
        threads.into_iter().map(join).collect()
    })
}
